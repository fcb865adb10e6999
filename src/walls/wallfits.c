/*
  Least-squares fits that extend the velocity of the fluid to dummies, see extension.c. A dummy x_w
  at depth d has the wall point s = x_w + d n and the mirror point m = x_w + 2 d n. A fit uses the
  fluid within a radius of s or m, the reach. Its weights are the kernel, with the reach as the
  radius of the support. Behind an edge of the box s and m can lie outside the box; then the fit
  uses the fluid nearest to the edge.
*/
#include "extension.h"

#define FIT_MAX_TERMS MLS_QUADRATIC_TERMS

/* Computes the basis of a fit at s; returns the number of its terms. */
typedef PetscInt (*FitBasis)(const Extension *ext, PetscReal reach, const PetscReal s[],
                             PetscReal phi[]);

/* Collects the fluid particles within reach of a centre: their kernel weights, and their positions
   s = (x_j - origin)/reach. */
static PetscErrorCode Gather(const PetscReal centre[], const PetscReal origin[], PetscReal reach,
                             Extension *ext)
{
  const Particles *p = ext->particles;
  PetscInt         found, n = 0;

  PetscFunctionBegin;
  PetscCall(
      CellsFind(ext->cells, centre, reach + 0.5 * ext->margin, ext->cells->n, ext->j, &found));
  for (PetscInt k = 0; k < found; k++) {
    const PetscInt j = ext->j[k];
    PetscReal      q = 0.0, w[3];

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < ext->dim; a++) {
      ext->s[a][n] = (p->x[a][j] - origin[a]) / reach;
      q += PetscSqr((p->x[a][j] - centre[a]) / reach);
    }
    q = PetscSqrtReal(q);
    if (q >= 1.0) continue;
    KernelEvaluate(ext->kernel, ext->dim, 1.0 / ext->kernel->support, q, w);
    ext->q[n]      = q;
    ext->weight[n] = w[0];
    ext->j[n++]    = j;
  }
  ext->n = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Fit - Computes the row e of a functional of a weighted least-squares fit to the collected points

    sum_t functional_t c_t = sum_j e_j f_j,   c: coefficients of the fit sum_t c_t phi_t(s),
    e_j = w_j phi(s_j).M^-1 functional,       M = sum_j w_j phi(s_j) phi(s_j)^T

  Returns: PETSC_FALSE, without a row, if the points do not determine the fit: orthogonalisation to
  the terms before it leaves less than 0.1 % of the sum of squares of a term
*/
static PetscBool Fit(FitBasis basis, PetscReal reach, const PetscReal functional[], Extension *ext)
{
  PetscReal M[FIT_MAX_TERMS * FIT_MAX_TERMS] = {0.0}, square[FIT_MAX_TERMS], c[FIT_MAX_TERMS],
                              phi[FIT_MAX_TERMS], s[ISPH_MAX_DIM] = {0.0};
  const PetscInt terms = basis(ext, reach, s, phi);

  for (PetscInt k = 0; k < ext->n; k++) {
    for (PetscInt a = 0; a < ext->dim; a++) s[a] = ext->s[a][k];
    (void)basis(ext, reach, s, phi);
    for (PetscInt t = 0; t < terms; t++) {
      for (PetscInt q = 0; q <= t; q++) M[t * terms + q] += ext->weight[k] * phi[t] * phi[q];
    }
  }
  for (PetscInt t = 0; t < terms; t++) square[t] = M[t * terms + t];
  if (DenseCholesky(terms, M)) return PETSC_FALSE;
  for (PetscInt t = 0; t < terms; t++) { /* the factor holds the inverse of its diagonal */
    if (1e-3 * square[t] * PetscSqr(M[t * terms + t]) > 1.0) return PETSC_FALSE;
    c[t] = functional[t];
  }
  DenseCholeskySolve(terms, M, c);
  for (PetscInt k = 0; k < ext->n; k++) {
    for (PetscInt a = 0; a < ext->dim; a++) s[a] = ext->s[a][k];
    (void)basis(ext, reach, s, phi);
    ext->e[k] = 0.0;
    for (PetscInt t = 0; t < terms; t++) ext->e[k] += ext->weight[k] * phi[t] * c[t];
  }
  return PETSC_TRUE;
}

/* ---- bases ---- */

static PetscInt Basis_Constant(const Extension *ext, PetscReal reach, const PetscReal s[],
                               PetscReal phi[])
{
  phi[0] = 1.0;
  return 1;
}

static PetscInt Basis_Full(const Extension *ext, PetscReal reach, const PetscReal s[],
                           PetscReal phi[])
{
  phi[0] = 1.0;
  for (PetscInt a = 0; a < ext->dim; a++) phi[1 + a] = s[a];
  return 1 + ext->dim;
}

/* Computes the height above the tangent plane of the wall. */
static PetscInt Basis_Slope(const Extension *ext, PetscReal reach, const PetscReal s[],
                            PetscReal phi[])
{
  phi[0] = 0.0;
  for (PetscInt a = 0; a < ext->dim; a++) phi[0] += s[a] * ext->normal[a];
  return 1;
}

static PetscInt Basis_Linear(const Extension *ext, PetscReal reach, const PetscReal s[],
                             PetscReal phi[])
{
  for (PetscInt a = 0; a < ext->dim; a++) phi[a] = s[a];
  return ext->dim;
}

static PetscInt Basis_Quadratic(const Extension *ext, PetscReal reach, const PetscReal s[],
                                PetscReal phi[])
{
  const PetscInt d = ext->dim == 2 ? 2 : 3;
  PetscInt       t = d;

  for (PetscInt a = 0; a < d; a++) {
    phi[a] = s[a];
    for (PetscInt b = 0; b <= a; b++) phi[t++] = s[a] * s[b];
  }
  return t;
}

/* Computes xi (1 - xi/H), which vanishes on both walls of a channel; xi: height above the
   wall, H: distance between the walls. */
static PetscInt Basis_Channel(const Extension *ext, PetscReal reach, const PetscReal s[],
                              PetscReal phi[])
{
  const PetscInt  axis = ext->side / 2;
  const PetscReal H    = (ext->scene->hi[axis] - ext->scene->lo[axis]) / reach;

  (void)Basis_Slope(ext, reach, s, phi);
  phi[0] *= 1.0 - phi[0] / H;
  return 1;
}

/* ---- rows ---- */

/* A fit: its basis, and the distance up to which fluid enters it [m]. */
typedef struct {
  FitBasis  basis;
  PetscReal reach;
} FitTry;

/*
  Divides weights by q^2, q the distance from the centre over the reach, so that a particle at the
  centre determines the value of the fit there: P. Lancaster, K. Salkauskas, Math. Comput. 37
  (1981). The term 1e-8 keeps weights finite.
*/
static void WeighInterpolating(Extension *ext)
{
  for (PetscInt k = 0; k < ext->n; k++) ext->weight[k] /= PetscSqr(ext->q[k]) + 1e-8;
}

/*
  FitFirst - Tries n fits and computes the row of the first fit that its points determine; the row
  is empty if there is no such fit

    sum_j e_j f_j = sign fit(origin + at),   fit: to the fluid around the centre

  ext->regularised counts an empty row, and a fit with another basis than the first fit.
*/
static PetscErrorCode FitFirst(const FitTry tries[], size_t n, const PetscReal centre[],
                               const PetscReal origin[], const PetscReal at[], PetscReal sign,
                               PetscBool interpolating, Extension *ext)
{
  PetscFunctionBegin;
  for (size_t k = 0; k < n; k++) {
    const PetscReal reach = tries[k].reach;
    PetscReal       s[ISPH_MAX_DIM], functional[FIT_MAX_TERMS];
    PetscInt        terms;

    for (PetscInt a = 0; a < ext->dim; a++) s[a] = at[a] / reach;
    terms = tries[k].basis(ext, reach, s, functional);
    for (PetscInt t = 0; t < terms; t++) functional[t] *= sign;
    PetscCall(Gather(centre, origin, reach, ext));
    if (interpolating) WeighInterpolating(ext);
    if (!Fit(tries[k].basis, reach, functional, ext)) continue;
    if (tries[k].basis != tries[0].basis) ext->regularised++;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ext->n = 0;
  ext->regularised++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fits u - u_wall, which vanishes at the wall point, to the fluid around this point, and evaluates
   the fit at the wall particle. */
static PetscErrorCode FitAtWall(const FitTry tries[], size_t n, Extension *ext)
{
  PetscReal at[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < ext->dim; a++) at[a] = -ext->depth * ext->normal[a];
  PetscCall(FitFirst(tries, n, ext->edge, ext->wall_point, at, 1.0, PETSC_FALSE, ext));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallExtend_Mirror - Computes the velocity of the mirror point m, reflected about the wall velocity

    u_w = 2 u_wall - u(m)

  u(m) comes from a linear least-squares fit over fluid within 2 dx of m. It is exact for linear
  fields, and a particle at m determines it alone. If these points do not determine the fit, fluid
  within 3 dx is used. If this does not suffice either, u(m) is the mean velocity of this fluid.

  References: mirrored particles, M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60
  (2009); fixed dummies, S. Marrone et al., Comput. Methods Appl. Mech. Eng. 200 (2011)
*/
PetscErrorCode WallExtend_Mirror(Extension *ext)
{
  const FitTry tries[] = {
      {Basis_Full, 2.0 * ext->dx}, {Basis_Full, 3.0 * ext->dx}, {Basis_Constant, 3.0 * ext->dx}};
  PetscReal centre[ISPH_MAX_DIM], at[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < ext->dim; a++) {
    centre[a] = ext->edge[a] + ext->depth * ext->normal[a];
    at[a]     = ext->wall_point[a] - ext->edge[a];
  }
  PetscCall(
      FitFirst(tries, PETSC_STATIC_ARRAY_LENGTH(tries), centre, centre, at, -1.0, PETSC_TRUE, ext));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallExtend_Linear - Extends the velocity by a line through the wall velocity and the fluid nearest
  to the wall

    u_w = u_wall - d g.n,   u_j - u_wall = g.(x_j - s) over fluid within 2 dx of s

  d is the depth of the dummy, s its wall point, and g a fitted velocity gradient. Exact for linear
  fields, also on curved walls and on walls with varying velocity. If the points do not determine g,
  fluid within 3 dx is used. If this does not suffice either, only the normal derivative g.n is
  fitted. Without fluid the dummy has the wall velocity.

  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), section 6.1.2
*/
PetscErrorCode WallExtend_Linear(Extension *ext)
{
  const FitTry tries[] = {
      {Basis_Linear, 2.0 * ext->dx}, {Basis_Linear, 3.0 * ext->dx}, {Basis_Slope, 3.0 * ext->dx}};

  PetscFunctionBegin;
  PetscCall(FitAtWall(tries, PETSC_STATIC_ARRAY_LENGTH(tries), ext));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallExtend_Quadratic - Extends the velocity by a parabola through the wall velocity and the fluid
  nearest to the wall

    u_w = u_wall - d g.n + d^2 n.H n/2,   u_j - u_wall = g.X + X.H X/2 over fluid within 3 dx of s

  d is the depth of the dummy, s its wall point, X = x_j - s, and g and H are fitted. Exact for
  quadratic fields. If the points do not determine the fit, fluid within 4 dx is used. If this does
  not suffice either, the fits of WallExtend_Linear() follow.

  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), section 6.1.2
*/
PetscErrorCode WallExtend_Quadratic(Extension *ext)
{
  const FitTry tries[] = {{Basis_Quadratic, 3.0 * ext->dx},
                          {Basis_Quadratic, 4.0 * ext->dx},
                          {Basis_Linear, 2.0 * ext->dx},
                          {Basis_Linear, 3.0 * ext->dx},
                          {Basis_Slope, 3.0 * ext->dx}};

  PetscFunctionBegin;
  PetscCall(FitAtWall(tries, PETSC_STATIC_ARRAY_LENGTH(tries), ext));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallExtend_GlobalQuadratic - Extends the velocity by a parabola through both walls of a channel
  and the fluid nearest to the wall

    u_w - u_wall = -c d (H + d),   u_j - u_wall = c xi_j (H - xi_j) over fluid within 2 dx of s

  d is the depth of the dummy, s its wall point, H the distance between the walls, and xi_j the
  distance of the fluid from the wall; c is fitted. Without fluid within 2 dx, fluid within 3 dx is
  used.

  Reference: S. J. Watkins et al., Astron. Astrophys. Suppl. Ser. 119 (1996) 177-187, cited after M.
  Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)
*/
PetscErrorCode WallExtend_GlobalQuadratic(Extension *ext)
{
  const FitTry tries[] = {{Basis_Channel, 2.0 * ext->dx}, {Basis_Channel, 3.0 * ext->dx}};

  PetscFunctionBegin;
  PetscCall(FitAtWall(tries, PETSC_STATIC_ARRAY_LENGTH(tries), ext));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallExtend_Adami - Computes the mean velocity of the fluid in the dummy's support, reflected about
  the wall velocity

    u_w = 2 u_wall - sum_j W_wj u_j / sum_j W_wj

  Without fluid in the support the row is empty; such a dummy is no neighbour of any fluid particle.

  Reference: S. Adami, X. Y. Hu, N. A. Adams, J. Comput. Phys. 231 (2012) 7057-7075
*/
PetscErrorCode WallExtend_Adami(Extension *ext)
{
  const PetscReal functional = -1.0;

  PetscFunctionBegin;
  PetscCall(Gather(ext->x, ext->x, ext->radius, ext));
  if (!Fit(Basis_Constant, ext->radius, &functional, ext)) ext->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallCheck_Channel - Refuses scenes other than a channel between two flat walls of the same
   constant velocity; collective */
PetscErrorCode WallCheck_Channel(const Scene *scene)
{
  PetscReal u[2][ISPH_MAX_DIM], x[ISPH_MAX_DIM];
  PetscInt  walled = 0, axis = 0;
  PetscBool varies = PETSC_FALSE;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) {
    x[a] = 0.5 * (scene->lo[a] + scene->hi[a]);
    if (SceneIsPeriodic(scene, a)) continue;
    walled++;
    axis = a;
  }
  UserCheck(walled == 1 && !scene->n_bodies,
            "-wall global_quadratic: it needs a channel between two flat walls, and case %s has "
            "none; use quadratic",
            scene->problem->name);
  for (PetscInt end = 0; end < 2; end++) {
    x[axis] = end ? scene->hi[axis] : scene->lo[axis];
    if (ExpressionUses(&scene->boundary[2 * axis + end].velocity, EXPRESSION_PLACE))
      varies = PETSC_TRUE;
    SceneWallVelocity(scene, 2 * axis + end, 0.0, x, u[end]);
  }
  for (PetscInt a = 0; a < scene->dim; a++) {
    UserCheck(u[0][a] == u[1][a] && !scene->unsteady_walls && !varies,
              "-wall global_quadratic: both walls must have the same constant velocity, and in "
              "case %s they differ or vary; use quadratic",
              scene->problem->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
