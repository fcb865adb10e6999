/* Viscosity that varies in space: fluids in regions of the scene, or a function of place. A
   particle takes the viscosity at its first position and keeps it. */
#include "isph/scene.h"

#define SAMPLES 8    /* along each side of a particle's cell */
#define BESIDE  1e-4 /* distance at which both sides of a border are looked at [dx] */

/* SceneViscosityVaries - Returns true if each particle has its own viscosity */
PetscBool SceneViscosityVaries(const Scene *scene)
{
  return scene->n_regions || scene->nu_field.n || !SceneIsNewtonian(scene);
}

/* SceneFluids - Returns the number of fluids with interfaces between them */
PetscInt SceneFluids(const Scene *scene)
{
  return scene->n_regions + 1;
}

/* SceneFluidAt - Returns the number of the fluid at a place at the start: k of -scene_fluid_k, 0
   outside their regions */
PetscInt SceneFluidAt(const Scene *scene, const PetscReal x[])
{
  PetscReal normal[ISPH_MAX_DIM];

  for (PetscInt k = scene->n_regions; k > 0; k--)
    if (BodyDistance(scene, &scene->region[k - 1], x, normal) <= 0.0) return k;
  return 0;
}

/* SceneFluidViscosity - Returns the kinematic viscosity of a fluid by its number, at a place x at
   the start, its reference if x is NULL [m^2/s] */
PetscReal SceneFluidViscosity(const Scene *scene, PetscInt fluid, const PetscReal x[])
{
  if (fluid) return scene->region_nu[fluid - 1];
  return scene->nu_field.n && x ? ExpressionValue(&scene->nu_field, 0, 0.0, x) : scene->nu;
}

/* SceneViscosityAt - Returns the kinematic viscosity at a place at the start [m^2/s] */
PetscReal SceneViscosityAt(const Scene *scene, const PetscReal x[])
{
  return SceneFluidViscosity(scene, SceneFluidAt(scene, x), x);
}

/* Returns true if x lies in the fluid at the start, or on its boundary or free surface. */
static PetscBool IsInFluid(const Scene *scene, const PetscReal x[])
{
  PetscInt side;

  if (SceneFluidDistance(scene, x, &side) < 0.0) return PETSC_FALSE;
  for (PetscInt k = 0; k < scene->n_filled; k++)
    if (SceneFilledDistance(scene, k, x) >= 0.0) return PETSC_TRUE;
  return scene->n_filled ? PETSC_FALSE : PETSC_TRUE;
}

/* Contents of both sides of a point on the border of a region. */
typedef enum { BORDER_OF_FLUID, BORDER_COVERED, BORDER_INTERFACE } BorderKind;

/* Returns the kind of a point on the border of a region: one side of it is outside the fluid; both
   sides have one fluid, because a later region covers them; or it is on an interface. */
static BorderKind ClassifyBorder(const Scene *scene, const PetscReal x[], const PetscReal normal[])
{
  PetscInt fluid[2];

  for (PetscInt side = 0; side < 2; side++) {
    PetscReal y[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < scene->dim; a++)
      y[a] = x[a] + (side ? BESIDE : -BESIDE) * scene->dx * normal[a];
    if (!IsInFluid(scene, y)) return BORDER_OF_FLUID;
    fluid[side] = SceneFluidAt(scene, y);
  }
  return fluid[0] != fluid[1] ? BORDER_INTERFACE : BORDER_COVERED;
}

/* InterfacePointsCreate - Lists points on the interfaces at the start, a spacing apart */
PetscErrorCode InterfacePointsCreate(const Scene *scene, InterfacePoints *points)
{
  const PetscInt dim  = scene->dim;
  PetscInt       room = 0;

  PetscFunctionBegin;
  *points = (InterfacePoints){.n = 0};
  for (PetscInt k = 0; k < scene->n_regions; k++) {
    const Body     *region  = &scene->region[k];
    const PetscReal spacing = BodySpacing(scene, region);

    for (PetscInt q = 0; q < BodyPoints(region, spacing); q++) {
      PetscReal x[ISPH_MAX_DIM] = {0.0}, normal[ISPH_MAX_DIM];

      (void)BodyPoint(region, q, spacing, x, normal);
      if (ClassifyBorder(scene, x, normal) != BORDER_INTERFACE) continue;
      if (points->n == room) {
        room = 2 * room + 256;
        PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)room, &points->region));
        PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(room * dim), &points->x));
        PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(room * dim), &points->normal));
      }
      for (PetscInt a = 0; a < dim; a++) {
        points->x[points->n * dim + a]      = x[a];
        points->normal[points->n * dim + a] = normal[a];
      }
      points->region[points->n++] = k;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* InterfacePointsDestroy - Frees the points */
PetscErrorCode InterfacePointsDestroy(InterfacePoints *points)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&points->region, &points->x, &points->normal));
  points->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the point on the interface of region k nearest to x: X - from the point to x, of the
   nearest periodic image [m]; n - its normal; returns the distance, infinite if there is none. */
static PetscReal NearestPoint(const Scene *scene, const InterfacePoints *points, PetscInt k,
                              const PetscReal x[], PetscReal X[], PetscReal n[])
{
  PetscReal best = PETSC_INFINITY;

  for (PetscInt q = 0; q < points->n; q++) {
    PetscReal d[ISPH_MAX_DIM], r2 = 0.0;

    if (points->region[q] != k) continue;
    for (PetscInt a = 0; a < scene->dim; a++) {
      const PetscReal period = scene->hi[a] - scene->lo[a];

      d[a] = x[a] - points->x[q * scene->dim + a];
      if (SceneIsPeriodic(scene, a)) d[a] -= period * PetscFloorReal(d[a] / period + 0.5);
      r2 += PetscSqr(d[a]);
    }
    if (r2 >= best) continue;
    best = r2;
    for (PetscInt a = 0; a < scene->dim; a++) {
      X[a] = d[a];
      n[a] = points->normal[q * scene->dim + a];
    }
  }
  return PetscSqrtReal(best);
}

/* Returns the distance of x from the interface on the border of region k, at most `most` [m].
   Output: normal - from the interface to x. The nearest point of the border need not be on an
   interface. If it is at a boundary of the fluid or beyond, the interface is continued there: round
   shapes themselves, others by their planes. If a later region covers it, the nearest point of the
   rest counts. */
static PetscReal RegionInterface(const Scene *scene, const InterfacePoints *points, PetscInt k,
                                 const PetscReal x[], PetscReal most, PetscReal normal[])
{
  const PetscInt  dim             = scene->dim;
  const PetscBool round           = scene->region[k].shape->round;
  const PetscReal d               = BodyDistance(scene, &scene->region[k], x, normal);
  PetscReal       y[ISPH_MAX_DIM] = {0.0}, X[ISPH_MAX_DIM], n[ISPH_MAX_DIM], same = 0.0, h = 0.0;
  PetscReal       r, ignored[ISPH_MAX_DIM];
  BorderKind      kind;

  if (PetscAbsReal(d) >= most) return most;
  for (PetscInt a = 0; a < dim; a++) y[a] = x[a] - d * normal[a];
  kind = ClassifyBorder(scene, y, normal);
  r    = kind == BORDER_INTERFACE ? 0.0 : NearestPoint(scene, points, k, x, X, n);
  if (r >= most + scene->dx) return most;
  for (PetscInt a = 0; a < dim && r > 0.0; a++) {
    same += n[a] * normal[a];
    h += n[a] * X[a];
  }
  if (kind == BORDER_INTERFACE || (kind == BORDER_OF_FLUID && same > 0.5 && round)) {
    for (PetscInt a = 0; a < dim; a++) normal[a] = d > 0.0 ? normal[a] : -normal[a];
    return PetscAbsReal(d);
  }
  for (PetscInt a = 0; a < dim; a++) {
    normal[a] = h > 0.0 ? n[a] : -n[a];
    y[a]      = x[a] - h * n[a];
  }
  if (kind == BORDER_OF_FLUID ||
      (ClassifyBorder(scene, y, n) == BORDER_INTERFACE &&
       PetscAbsReal(BodyDistance(scene, &scene->region[k], y, ignored)) < BESIDE * scene->dx))
    return PetscAbsReal(h);
  for (PetscInt a = 0; a < dim; a++) normal[a] = X[a] / r;
  return r;
}

/* SceneInterface - Returns the distance of x from the nearest interface of two fluids at the start,
   at most `most` [m]. Interfaces are where SceneFluidAt() changes; beyond walls and free surfaces
   they are continued, so that distances beside a straight interface are those from its plane.
   Input: points - of InterfacePointsCreate(). Output: normal - unit, from the interface to x, into
   the fluid of x; zero if there is no interface within `most`. */
PetscReal SceneInterface(const Scene *scene, const InterfacePoints *points, const PetscReal x[],
                         PetscReal most, PetscReal normal[])
{
  PetscReal best = most;

  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) normal[a] = 0.0;
  for (PetscInt k = 0; k < scene->n_regions; k++) {
    PetscReal       n[ISPH_MAX_DIM];
    const PetscReal distance = RegionInterface(scene, points, k, x, best, n);

    if (distance >= best) continue;
    best = distance;
    for (PetscInt a = 0; a < scene->dim; a++) normal[a] = n[a];
  }
  return best;
}

/* Returns true if the border of a region may cut the lattice cell around x. */
static PetscBool InterfaceCuts(const Scene *scene, const PetscReal x[])
{
  PetscReal square = 0.0, normal[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < scene->dim; a++) square += PetscSqr(0.5 * SceneCellSide(scene, a));
  for (PetscInt k = 0; k < scene->n_regions; k++) {
    if (PetscSqr(BodyDistance(scene, &scene->region[k], x, normal)) < square) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Computes sample s of the lattice cell around x. */
static void SampleOf(const Scene *scene, const PetscReal x[], PetscInt s, PetscReal y[])
{
  for (PetscInt a = 0; a < scene->dim; a++) {
    y[a] = x[a] + SceneCellSide(scene, a) * ((s % SAMPLES + 0.5) / SAMPLES - 0.5);
    s /= SAMPLES;
  }
}

/* SceneShare - Returns the share of the fluid at x in the fluid part of the lattice cell around x.
   Output: other - the fluid that has the largest part of the rest. */
PetscReal SceneShare(const Scene *scene, const PetscReal x[], PetscInt *other)
{
  const PetscInt samples                     = SAMPLES * SAMPLES * (scene->dim == 3 ? SAMPLES : 1);
  const PetscInt own                         = SceneFluidAt(scene, x);
  PetscInt       count[SCENE_MAX_FLUIDS + 1] = {0};

  *other = own;
  if (!InterfaceCuts(scene, x)) return 1.0;
  for (PetscInt s = 0; s < samples; s++) {
    PetscReal y[ISPH_MAX_DIM];

    SampleOf(scene, x, s, y);
    if (IsInFluid(scene, y)) count[SceneFluidAt(scene, y)]++;
  }
  for (PetscInt k = 0; k < SceneFluids(scene); k++)
    if (k != own && count[k] > (*other == own ? 0 : count[*other])) *other = k;
  if (*other == own) return 1.0;
  return (PetscReal)count[own] / (PetscReal)(count[own] + count[*other]);
}

/*
  SceneViscosity - Returns the kinematic viscosity of a particle that starts at x [m^2/s]

    1/nu = mean of 1/nu over the fluid part of the lattice cell around x

  The harmonic mean gives layers the right shear resistance wherever an interface cuts the lattice,
  because resistances in series add. In other cells the viscosity is that at x. For a fluid that is
  not Newtonian the result is the viscosity at the strain rate U/L, the first guess of the
  iteration. Reference: S. V. Patankar, Numerical Heat Transfer and Fluid Flow (1980), section 4.2-3
*/
PetscReal SceneViscosity(const Scene *scene, const PetscReal x[])
{
  const PetscInt samples = SAMPLES * SAMPLES * (scene->dim == 3 ? SAMPLES : 1);
  PetscReal      sum     = 0.0;
  PetscInt       n       = 0;

  if (!SceneIsNewtonian(scene)) {
    PetscReal        y[]  = {x[0], x[1], scene->dim > 2 ? x[2] : 0.0};
    const FluidPlace here = RheologyAt(scene, (PetscReal *const[]){y, y + 1, y + 2}, 0);

    return RheologyViscosity(&scene->rheology, &here, scene->speed / scene->length);
  }
  if (!InterfaceCuts(scene, x)) return SceneViscosityAt(scene, x);
  for (PetscInt s = 0; s < samples; s++) {
    PetscReal y[ISPH_MAX_DIM];

    SampleOf(scene, x, s, y);
    if (!IsInFluid(scene, y)) continue;
    sum += 1.0 / SceneViscosityAt(scene, y);
    n++;
  }
  return n ? n / sum : SceneViscosityAt(scene, x);
}

/* SceneBoundViscosity - Finds the least and largest viscosity at the centres of lattice cells; for
   a fluid that is not Newtonian, copies the bounds of its rheology. Collective. The viscosity of a
   particle may lie outside these bounds, because it is a mean over a cell and because the particle
   may start at another place; SceneBoundGivenViscosity() corrects the bounds. Output:
   scene->nu_low, scene->nu_high. Errors: a field that is not positive ends the run. */
PetscErrorCode SceneBoundViscosity(Scene *scene)
{
  PetscInt cells;

  PetscFunctionBegin;
  scene->nu_low = scene->nu_high = scene->nu;
  if (!SceneIsNewtonian(scene)) {
    scene->nu_low  = scene->rheology.low;
    scene->nu_high = scene->rheology.high;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!SceneViscosityVaries(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  scene->nu_low  = PETSC_MAX_REAL;
  scene->nu_high = 0.0;
  PetscCall(SceneCountCells(scene->dim, scene->cells, &cells));
  for (PetscInt c = 0; c < cells; c++) {
    PetscReal x[ISPH_MAX_DIM], nu;
    PetscInt  index = c;
    char      place[PLACE_TEXT];

    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a] = scene->lo[a] + ((PetscReal)(index % scene->cells[a]) + 0.5) * SceneCellSide(scene, a);
      index /= scene->cells[a];
    }
    if (!IsInFluid(scene, x)) continue;
    nu = SceneViscosityAt(scene, x);
    if (nu <= 0.0) PetscCall(ExpressionScopeCheck(scene->scope)); /* 0 may stand for NaN */
    UserCheck(nu > 0.0, "-viscosity_field: it is %.6g at (%s), and must be positive", (double)nu,
              ScenePlaceText(scene, x, place));
    scene->nu_low  = PetscMin(scene->nu_low, nu);
    scene->nu_high = PetscMax(scene->nu_high, nu);
  }
  if (scene->nu_high == 0.0) { /* no centre is in the fluid */
    scene->nu_low  = scene->nu;
    scene->nu_high = scene->nu;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneBoundGivenViscosity - Finds the least and largest viscosity of the particles at the start.
   Collective. Input: nu - viscosities of the n particles of this rank [m^2/s]; if n is 0 on all
   ranks, the bounds stay. Output: scene->nu_low, scene->nu_high. Errors: a viscosity that is not
   positive ends the run. */
PetscErrorCode SceneBoundGivenViscosity(PetscInt n, const PetscReal nu[], Scene *scene)
{
  PetscReal bound[2] = {-PETSC_MAX_REAL, 0.0};

  PetscFunctionBegin;
  for (PetscInt i = 0; i < n; i++) {
    bound[0] = PetscMax(bound[0], -nu[i]);
    bound[1] = PetscMax(bound[1], nu[i]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bound, 2, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  if (bound[0] == -PETSC_MAX_REAL) PetscFunctionReturn(PETSC_SUCCESS);
  if (bound[0] >= 0.0) PetscCall(ExpressionScopeCheck(scene->scope));
  UserCheck(bound[0] < 0.0,
            "-viscosity_field: it is %.6g where a particle starts, and must be positive",
            (double)-bound[0]);
  scene->nu_low  = -bound[0];
  scene->nu_high = bound[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}
