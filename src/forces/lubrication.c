/*
  Lubrication: the pressure between a body and another boundary whose gap is too narrow for the
  particles in it. At a gap h0 below LEAST spacings, the leading term of the pressure in a gap h
  between surfaces that approach each other with the velocity V,

    p(h) - p(H) = 6 mu V/k (1/h^2 - 1/H^2),   k = div n + div n',

  takes the place of the computed one where h < H. It is exact for a paraboloid: h^3 grad p is
  -6 mu V/k 2 grad h, whose divergence is -12 mu V. k is the curvature of h, the sum of those of
  both surfaces. p(H) is the computed pressure around.

  References: O. Reynolds, Phil. Trans. R. Soc. 177 (1886) 157-234; H. Brenner, Chem. Eng. Sci. 16
  (1961) 242-251; D. J. Jeffrey & Y. Onishi, Q. J. Mech. Appl. Math. 34 (1981) 129-137
*/
#include "layer.h"

#define LEAST 2.0  /* gap from which on the flow in it is resolved [spacings] */
#define FLAT  1e-3 /* least curvature of a gap: flatter ones are no paraboloids [1/H] */

/* A narrow gap between a body and another boundary. */
typedef struct {
  PetscInt  side, other;
  PetscReal least, most;          /* h0, H [m] */
  PetscReal factor;               /* 6 mu V/k [Pa m^2] */
  PetscReal reach2;               /* square of the distance up to which h can be below 2 H [m^2] */
  PetscReal x[ISPH_MAX_DIM];      /* point of the body at the least gap [m] */
  PetscReal normal[ISPH_MAX_DIM]; /* there, from the other boundary to the body */
} Gap;

/* Returns the distance of x from a boundary [m], and the normal into the fluid. */
static PetscReal DistanceOf(const Scene *scene, PetscInt side, const PetscReal x[],
                            PetscReal normal[])
{
  const Body *body = BoundaryBody(scene, side);

  if (body) return BodyDistance(scene, body, x, normal);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = 0.0;
  normal[side / 2] = side % 2 ? -1.0 : 1.0;
  return SceneSideDistance(scene, side, x);
}

/* Returns div n of the distance from a boundary at x [1/m]: the sum of the curvatures of its
   surface there. */
static PetscReal Curvature(const Scene *scene, PetscInt side, const PetscReal x[], PetscReal step)
{
  PetscReal sum = 0.0, y[ISPH_MAX_DIM] = {0.0}, n[2][ISPH_MAX_DIM];

  for (PetscInt a = 0; a < scene->dim; a++) y[a] = x[a];
  for (PetscInt a = 0; a < scene->dim; a++) {
    for (PetscInt end = 0; end < 2; end++) {
      y[a] = x[a] + (end ? step : -step);
      (void)DistanceOf(scene, side, y, n[end]);
    }
    y[a] = x[a];
    sum += (n[1][a] - n[0][a]) / (2.0 * step);
  }
  return sum;
}

/* Returns the least distance of the middles of facets from a boundary [m], and the facet. */
static PetscReal LeastDistance(const Scene *scene, PetscInt side, const Facets *s, PetscInt *at)
{
  PetscReal least = PETSC_INFINITY, n[ISPH_MAX_DIM];

  for (PetscInt k = 0; k < s->n; k++) {
    const PetscReal d = DistanceOf(scene, side, &s->x[k * s->dim], n);

    if (d >= least) continue;
    least = d;
    *at   = k;
  }
  return least;
}

/* Finds the least gap between a boundary with facets s, and finer ones, and another one. Returns
   true if it is narrow and opens on all sides. */
static PetscBool FindGap(const Flow *flow, const Facets *s, const Facets *fine, Gap *gap)
{
  const Scene    *scene = flow->scene;
  const PetscInt  dim   = scene->dim;
  const PetscReal t     = flow->clock->t;
  PetscReal       y[ISPH_MAX_DIM], u[2][ISPH_MAX_DIM], speed = 0.0, k, unit;
  PetscInt        at = -1;

  gap->least = LeastDistance(scene, gap->other, s, &at);
  if (at < 0) return PETSC_FALSE;
  unit      = FacetHeight(scene, gap->side, &s->x[at * dim]);
  gap->most = LEAST * unit;
  if (gap->least >= gap->most + unit) return PETSC_FALSE;
  gap->least = LeastDistance(scene, gap->other, fine, &at);
  if (gap->least >= gap->most || gap->least <= 0.0) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) gap->x[a] = fine->x[at * dim + a];
  k = Curvature(scene, gap->side, gap->x, 0.5 * unit) +
      Curvature(scene, gap->other, gap->x, 0.5 * unit);
  if (k * gap->most < FLAT) return PETSC_FALSE;
  (void)DistanceOf(scene, gap->other, gap->x, gap->normal);
  for (PetscInt a = 0; a < dim; a++) y[a] = gap->x[a] - gap->least * gap->normal[a];
  SceneWallVelocity(scene, gap->side, t, gap->x, u[0]);
  SceneWallVelocity(scene, gap->other, t, y, u[1]);
  for (PetscInt a = 0; a < dim; a++) speed += (u[1][a] - u[0][a]) * gap->normal[a];
  gap->factor = 6.0 * speed / k;
  gap->reach2 = 8.0 * (2.0 * gap->most - gap->least) / k;
  return PETSC_TRUE;
}

/* Returns the pressure in the gap less that at H [Pa]; 0 without viscosity. */
static PetscReal GapPressure(const Gap *gap, PetscReal h)
{
  return gap->factor * (1.0 / PetscSqr(h) - 1.0 / PetscSqr(gap->most));
}

/* Sets h to the gaps at facets s that face the other boundary near the least gap, otherwise to
   infinity: elsewhere there may be another gap. */
static void SetGaps(const Scene *scene, const Gap *gap, const Facets *s, PetscReal h[])
{
  const PetscInt dim = s->dim;
  PetscReal      n[ISPH_MAX_DIM];

  for (PetscInt k = 0; k < s->n; k++) {
    PetscReal facing = 0.0, r2 = 0.0;

    for (PetscInt a = 0; a < dim; a++) r2 += PetscSqr(s->x[k * dim + a] - gap->x[a]);
    h[k] = PETSC_INFINITY;
    if (r2 > gap->reach2) continue;
    h[k] = DistanceOf(scene, gap->other, &s->x[k * dim], n);
    for (PetscInt a = 0; a < dim; a++) facing -= n[a] * s->normal[k * dim + a];
    if (facing < 0.5) h[k] = PETSC_INFINITY;
  }
}

/* Returns the part of facet k across the gap [m^(dim-1)]. */
static PetscReal Across(const Gap *gap, const Facets *s, PetscInt k)
{
  PetscReal across = 0.0;

  for (PetscInt a = 0; a < s->dim; a++) across -= gap->normal[a] * s->normal[k * s->dim + a];
  return s->area[k] * across;
}

/* Adds the force of GapPressure() across the gap on fine facets, less that of the computed pressure
   on facets s relative to p(H), its mean around the gap less GapPressure() [N]. */
static PetscErrorCode GapForce(const Flow *flow, const Gap *gap, const Facets *s,
                               const Facets *fine, PetscReal *force)
{
  const PetscInt dim = s->dim;
  PetscReal     *h, *p, *u, around = 0.0, area = 0.0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(PetscMax(s->n, fine->n), &h, s->n, &p, s->n * dim, &u));
  SetGaps(flow->scene, gap, s, h);
  PetscCall(ProbePoints(flow, s->n, s->x, u, p));
  for (PetscInt k = 0; k < s->n; k++) {
    if (h[k] < gap->most || h[k] > 2.0 * gap->most || PetscIsNanReal(p[k])) continue;
    around += s->area[k] * (p[k] - GapPressure(gap, h[k]));
    area += s->area[k];
  }
  for (PetscInt k = 0; k < s->n && area > 0.0; k++)
    if (h[k] < gap->most && !PetscIsNanReal(p[k]))
      *force -= Across(gap, s, k) * (p[k] - around / area);
  SetGaps(flow->scene, gap, fine, h);
  for (PetscInt k = 0; k < fine->n && area > 0.0; k++)
    if (h[k] < gap->most) *force += Across(gap, fine, k) * GapPressure(gap, h[k]);
  PetscCall(PetscFree3(h, p, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* LubricationAdd - Adds the lubrication in narrow gaps between a boundary with facets s, and finer
   ones, and all others, less the force of the computed pressure there, to force and torque [N], [N
   m]: along the normal at the least gap; collective. Notes: of gaps with the same boundary the
   least counts; sliding and rolling have the computed stress alone, and so has the fluid; fluids
   whose viscosity follows the strain rate have none. */
PetscErrorCode LubricationAdd(const Flow *flow, PetscInt side, const Facets *s, const Facets *fine,
                              const PetscReal centre[], PetscReal F[], PetscReal T[])
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (!SceneHas(scene, PHYSICS_VISCOSITY) || !SceneIsNewtonian(scene) || !flow->particles->p)
    PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt other = 0; other < SceneBoundaries(scene); other++) {
    Gap             gap  = {.side = side, .other = other};
    const PetscReal rate = 0.0; /* the viscosity of the fluid follows no strain */
    PetscReal       nu, force = 0.0, load[ISPH_MAX_DIM];

    if (other == side || !BoundaryIs(scene, other, BOUNDARY_NO_SLIP)) continue;
    if (!FindGap(flow, s, fine, &gap)) continue;
    PetscCall(PointViscosity(flow, 1, gap.x, &rate, &nu));
    gap.factor *= scene->rho * nu;
    PetscCall(GapForce(flow, &gap, s, fine, &force));
    for (PetscInt a = 0; a < scene->dim; a++) {
      load[a] = force * gap.normal[a];
      F[a] += load[a];
    }
    AddTorque(scene->dim, centre, gap.x, load, T);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
