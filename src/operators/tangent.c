/*
  The tangent of a rheology, for Newton's iteration. With S = grad u + grad u^T, g^2 = S:S/2 and the
  kinematic stress tau = nu(g) S, an iteration from u_k to u solves the equations of flow with

    s = nu_k S + theta_k nu'(g_k)/g_k (S_k:(S - S_k)/2) S_k,   nu_k = nu(g_k)

  in place of tau. theta = 1 is Newton's iteration, theta = 0 Picard's. Newton's goes round in
  circles where a law that softens is linearised at a stress above the one that the flow balances.
  That one is s of the solve before, and for such a law

    theta_k = s:tau(S_k)/|tau(S_k)|^2, at least 0 and at most 1

  is Newton's iteration for a stress of its own, S = s/nu(g), restricted to the direction of S_k.
  Stresses are bounded where viscosities are not, so |s - tau(u)| is the error of the iteration: it
  cannot hide beside the viscosity of a rigid part.

  References: M. Hintermueller, G. Stadler, SIAM J. Sci. Comput. 28 (2006) 1-23; A. Aposporidis, E.
  Haber, M. A. Olshanskii, A. Veneziani, Comput. Methods Appl. Mech. Eng. 200 (2011) 2434-2446
*/
#include "isph/operators.h"
#include "isph/strain.h"

#define OVERSHOOT   1.0  /* most work of errors after a change over that before it [-] */
#define SHARE_LEAST 1e-3 /* of a change */

/* Computes S of each own fluid particle [1/s]. Input: u - velocity components; walls - components
   of the wall velocity, NULL: zero. */
static PetscErrorCode Strain(const Operators *ops, const Particles *p, const Vec u[],
                             const Vec walls[], PetscReal S[])
{
  const PetscInt     dim = p->dim, parts = dim * (dim + 1) / 2;
  const PetscScalar *s;
  Vec                slope;
  PetscInt           part = 0;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(u[0], &slope));
  for (PetscInt c = 0; c < dim; c++) {
    for (PetscInt a = 0; a <= c; a++, part++) {
      const AffineOperator *of_c = &OperatorsOfVelocity(ops, c)->grad_u[a],
                           *of_a = &OperatorsOfVelocity(ops, a)->grad_u[c];

      PetscCall(AffineApply(of_c, u[c], walls ? walls[c] : NULL, slope));
      PetscCall(AffineApplyAdd(of_a, u[a], walls ? walls[a] : NULL, slope));
      PetscCall(VecGetArrayRead(slope, &s));
      for (PetscInt i = 0; i < p->n_fluid; i++) S[i * parts + part] = s[i];
      PetscCall(VecRestoreArrayRead(slope, &s));
    }
  }
  PetscCall(VecDestroy(&slope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns A:B/2 of symmetric tensors. */
static PetscReal HalfProduct(PetscInt dim, const PetscReal A[], const PetscReal B[])
{
  PetscReal sum = 0.0;

  for (PetscInt c = 0, part = 0; c < dim; c++)
    for (PetscInt a = 0; a <= c; a++, part++) sum += (a == c ? 0.5 : 1.0) * A[part] * B[part];
  return sum;
}

/*
  OperatorsStrainRate - Computes the strain rate of each fluid particle [1/s]

    g = sqrt(2 E:E),   E = (grad u + grad u^T)/2

  Collective. Input: u - velocity components over the fluid; walls - components of the wall
  velocity, NULL entries without walls. Output: g - n_fluid numbers.
*/
PetscErrorCode OperatorsStrainRate(const Operators *ops, const Particles *p, const Vec u[],
                                   const Vec walls[], PetscReal g[])
{
  const PetscInt parts = p->dim * (p->dim + 1) / 2;
  PetscReal     *S;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n_fluid * parts, &S));
  PetscCall(Strain(ops, p, u, walls, S));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    g[i] = PetscSqrtReal(HalfProduct(p->dim, &S[i * parts], &S[i * parts]));
  PetscCall(PetscFree(S));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsFollowStrain - Computes the viscosities of a rheology from the strain rate, and updates
   the viscous operator. Collective on the particles' communicator. Input: u - velocity components
   over the fluid; walls - wall velocity. Output: p->nu with its halo, ops->velocity[0].visc. */
PetscErrorCode OperatorsFollowStrain(const Scene *scene, Particles *p, const WallValues *walls,
                                     const Vec u[], Operators *ops)
{
  PetscFunctionBegin;
  if (ops->strain) {
    PetscCall(StrainOfVelocity(p, u, walls->u, ops->strain));
    StrainRheology(scene, ops->strain);
    PetscCall(StrainSpread(p, ops->strain));
    PetscCall(OperatorsScaleViscosity(scene, p, ops));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(OperatorsStrainRate(ops, p, u, walls->u, p->nu));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const FluidPlace at = RheologyAt(scene, p->x, i);

    p->nu[i] = RheologyViscosity(&scene->rheology, &at, p->nu[i]);
  }
  PetscCall(ParticlesHaloField(p, p->nu));
  PetscCall(OperatorsScaleViscosity(scene, p, ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TangentCreate - Creates the tangent of a rheology for the present operators, with Picard's matrix
   of the present viscosities until the first TangentFollow(). Collective. To be called only if
   ops->forms.components_coupled. The tangent is valid until the particles or operators change. */
PetscErrorCode TangentCreate(const Scene *scene, Particles *p, Operators *ops,
                             StressTangent **tangent)
{
  StressTangent *t;

  PetscFunctionBegin;
  PetscCall(PetscNew(&t));
  t->scene = scene;
  t->p     = p;
  t->ops   = ops;
  t->n     = ops->strain ? ops->strain->all : p->n_fluid;
  PetscCall(PetscCalloc3(t->n, &t->point, ParticlesAll(p) * p->dim, &t->u,
                         PetscMax(t->n, ParticlesAll(p)), &t->change));
  for (PetscInt i = 0; i < t->n; i++) {
    t->point[i].nu    = ops->strain ? ops->strain->nu[i] : p->nu[i];
    t->point[i].place = RheologyAt(scene, ops->strain ? ops->strain->centre : p->x, i);
  }
  *tangent = t;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TangentDestroy - Frees the tangent */
PetscErrorCode TangentDestroy(StressTangent **tangent)
{
  PetscFunctionBegin;
  if (!*tangent) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree3((*tangent)->point, (*tangent)->u, (*tangent)->change));
  PetscCall(PetscFree(*tangent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the place of the component (a, b) of a symmetric tensor. */
static PetscInt Component(PetscInt a, PetscInt b)
{
  const PetscInt c = PetscMax(a, b);

  return c * (c + 1) / 2 + PetscMin(a, b);
}

/* Computes S at the points: the cells of a weak form, or the particles. Input: as Strain(). */
static PetscErrorCode StrainAtPoints(const StressTangent *t, const Vec u[], const Vec walls[],
                                     PetscReal S[])
{
  const PetscInt dim = t->p->dim, parts = dim * (dim + 1) / 2;
  StrainCells   *cells = t->ops->strain;

  PetscFunctionBegin;
  if (!cells) {
    PetscCall(Strain(t->ops, t->p, u, walls, S));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(StrainOfVelocity(t->p, u, walls, cells));
  for (PetscInt c = 0; c < t->n; c++)
    for (PetscInt a = 0; a < dim; a++)
      for (PetscInt b = 0; b <= a; b++)
        S[c * parts + Component(a, b)] = 2.0 * cells->strain[(c * dim + a) * dim + b];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Linearises the stress of a point about S, and adds |s - tau(S)|^2/2 and
   |tau(S)|^2/2 to sum, s: stress at S of the linearisation before. */
static void StressFollow(const Rheology *law, PetscInt dim, const PetscReal S[], StressPoint *at,
                         PetscReal sum[2])
{
  const PetscInt  parts  = dim * (dim + 1) / 2;
  const PetscReal square = HalfProduct(dim, S, S), rate = PetscSqrtReal(square);
  const PetscReal nu = RheologyViscosity(law, &at->place, rate), *old = at->strain;
  const PetscReal d = at->slope * (HalfProduct(dim, old, S) - HalfProduct(dim, old, old));
  PetscReal       error[STRAIN_MOST], theta = 1.0;

  for (PetscInt e = 0; e < parts; e++) error[e] = at->nu * S[e] + d * old[e] - nu * S[e];
  sum[0] += HalfProduct(dim, error, error);
  sum[1] += PetscSqr(nu) * square;
  at->slope = rate > 0.0 ? RheologySlope(law, &at->place, rate) / rate : 0.0;
  if (at->slope < 0.0) theta = 1.0 + HalfProduct(dim, error, S) / (nu * square);
  at->slope *= PetscMin(PetscMax(theta, 0.0), 1.0);
  at->nu = nu;
  for (PetscInt e = 0; e < parts; e++) at->strain[e] = S[e];
}

/* Returns the work (tau - s):(S - S_k)/2 at a point, with the stress tau at S_k +
   share (S - S_k) and the stress s that the solve for S has balanced. */
static PetscReal StressWork(const Rheology *law, PetscInt dim, const PetscReal S[], PetscReal share,
                            const StressPoint *point)
{
  const PetscInt   parts = dim * (dim + 1) / 2;
  const PetscReal *old   = point->strain;
  PetscReal        change[STRAIN_MOST], at[STRAIN_MOST], error[STRAIN_MOST], d, nu;

  for (PetscInt e = 0; e < parts; e++) change[e] = S[e] - old[e];
  for (PetscInt e = 0; e < parts; e++) at[e] = old[e] + share * change[e];
  d  = point->slope * HalfProduct(dim, old, change);
  nu = RheologyViscosity(law, &point->place, PetscSqrtReal(HalfProduct(dim, at, at)));
  for (PetscInt e = 0; e < parts; e++) error[e] = nu * at[e] - point->nu * S[e] - d * old[e];
  return HalfProduct(dim, error, change);
}

/* TangentShare - Returns the share of an iteration's change of velocity that should be taken: the
   largest of 1, 1/2, 1/4, ... at which the error of the stresses does at most OVERSHOOT times the
   work that it did before the change, with the other sign. Collective. The work increases with the
   share, from a negative number to zero at the least potential along the change. A whole change
   goes far beyond if the viscosity before it is too small, as in a fluid that thickens from rest.
   Input: u - velocity components after the change. */
PetscErrorCode TangentShare(const StressTangent *t, const Vec u[], const WallValues *walls,
                            PetscReal *share)
{
  const Rheology *law = &t->scene->rheology;
  const PetscInt  dim = t->p->dim, parts = dim * (dim + 1) / 2;
  PetscReal      *S, work[2];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(t->n * parts, &S));
  PetscCall(StrainAtPoints(t, u, walls->u, S));
  for (*share = 1.0; *share > SHARE_LEAST; *share *= 0.5) {
    work[0] = work[1] = 0.0;
    for (PetscInt i = 0; i < t->n; i++) {
      work[0] += StressWork(law, dim, &S[i * parts], 0.0, &t->point[i]);
      work[1] += StressWork(law, dim, &S[i * parts], *share, &t->point[i]);
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, work, 2, MPIU_REAL, MPIU_SUM, t->p->comm));
    if (work[1] <= OVERSHOOT * PetscAbsReal(work[0])) break;
  }
  PetscCall(PetscFree(S));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* TangentFollow - Linearises the stress about a velocity, and updates viscosities and viscous
   operator. Collective. Input: u - velocity components, most often of a solve with the
   linearisation before. Output: p->nu with its halo, ops->velocity[0].visc, and t->error and
   stress. */
PetscErrorCode TangentFollow(StressTangent *t, const Vec u[], const WallValues *walls)
{
  const Particles *p     = t->p;
  const Rheology  *law   = &t->scene->rheology;
  StrainCells     *cells = t->ops->strain;
  const PetscInt   dim = p->dim, parts = dim * (dim + 1) / 2;
  PetscReal       *S, sum[3]           = {0.0, 0.0, (PetscReal)t->n};

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(t->n * parts, &S));
  PetscCall(StrainAtPoints(t, u, walls->u, S));
  for (PetscInt i = 0; i < t->n; i++) {
    StressFollow(law, dim, &S[i * parts], &t->point[i], sum);
    if (cells) cells->nu[i] = RheologyViscosity(law, &t->point[i].place, cells->rate[i]);
    else t->p->nu[i] = t->point[i].nu;
  }
  PetscCall(PetscFree(S));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, p->comm));
  t->error  = sum[0] > 0.0 ? PetscSqrtReal(sum[0] / sum[1]) : 0.0;
  t->stress = PetscSqrtReal(sum[1] / PetscMax(sum[2], 1.0));
  for (PetscInt c = 0; c < dim; c++) PetscCall(LocalValues(p, u[c], walls->u[c], dim, t->u + c));
  PetscCall(ParticlesHaloVectors(p, t->u));
  if (cells) PetscCall(StrainSpread(t->p, cells));
  else PetscCall(ParticlesHaloField(p, t->p->nu));
  PetscCall(OperatorsScaleViscosity(t->scene, p, t->ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds scale times the weights w of a slot of particle i times f to its components of y. */
static void AddSlot(PetscInt dim, PetscInt width, PetscReal scale, const PetscReal w[],
                    const PetscReal f[], PetscReal y[])
{
  for (PetscInt a = 0; a < dim; a++) {
    if (width == 1) y[a] += scale * w[0] * f[a];
    for (PetscInt b = 0; width > 1 && b < dim; b++) y[a] += scale * w[a * dim + b] * f[b];
  }
}

/* Computes the term sum_j dnu_ij w_ij (u_j - u_i) of particle i, whose row is that of
   OperatorsScaleViscosity(); dnu_ij = nu_ij^2/2 (dnu_i/nu_i^2 + dnu_j/nu_j^2). */
static void TermOfChanges(const StressTangent *t, PetscInt i, PetscReal y[])
{
  const Particles      *p    = t->p;
  const AffineOperator *op   = &t->ops->velocity[0].visc;
  const Pattern        *of[] = {&t->ops->rows.fluid, &t->ops->rows.walls};
  const PetscReal      *w[] = {op->a, t->ops->forms.wall ? op->b : NULL}, *own = &t->u[p->dim * i];
  PetscReal             difference[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < p->dim; a++) y[a] = 0.0;
  for (PetscInt k = 0; k < 2 && w[k]; k++) {
    for (PetscInt s = of[k]->row[i]; s < of[k]->row[i + 1]; s++) {
      const PetscInt  j      = of[k]->local[s];
      const PetscReal pair   = k ? p->nu[i] : PairViscosity(p->nu[i], p->nu[j]);
      PetscReal       change = t->change[i];

      if (!k)
        change = 0.5 * PetscSqr(pair / p->nu[i]) * change +
                 0.5 * PetscSqr(pair / p->nu[j]) * t->change[j];
      for (PetscInt a = 0; a < p->dim; a++) difference[a] = t->u[p->dim * j + a] - own[a];
      if (!k && of[k]->col[s] == p->row[i])
        AddSlot(p->dim, op->width, change, &op->a[s * op->width], own, y);
      else AddSlot(p->dim, op->width, change, &w[k][s * op->width], difference, y);
    }
  }
}

/* Computes the term -1/M_i sum_c V_c dnu_c S_c g_i of particle i, from the cells of a weak form. */
static void TermOfCells(const StressTangent *t, PetscInt i, PetscReal y[])
{
  const StrainCells *s = t->ops->strain;

  for (PetscInt a = 0; a < t->p->dim; a++) {
    const PetscInt q = s->sets == 1 ? 0 : a;

    y[a] = 0.0;
    for (PetscInt k = s->of[q][i]; k < s->of[q][i + 1]; k++) {
      const PetscInt  c = s->cell[q][k];
      const PetscReal w = s->volume[c] * t->change[c] / s->mass[q][i];

      for (PetscInt b = 0; b < t->p->dim; b++)
        y[a] -= w * t->point[c].strain[Component(a, b)] * s->g[q][b][s->at[q][k]];
    }
  }
}

/*
  TangentApplyAdd - Adds scale times the viscous term of the changes of the viscosity by v,

    y += scale sum_j dnu_ij w_ij (u_j - u_i),   dnu = theta nu'(g)/g S:dS/2,   dS = S(v) - S(0)

  at the velocity u of the last TangentFollow(). Collective. Input: v - velocity components, without
  wall data. Output: y [scale times m/s^2].
*/
PetscErrorCode TangentApplyAdd(StressTangent *t, PetscReal scale, const Vec v[], const Vec y[])
{
  const Particles *p   = t->p;
  const PetscInt   dim = p->dim, parts = dim * (dim + 1) / 2;
  PetscReal       *S, term[ISPH_MAX_DIM];
  PetscScalar     *to[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(t->n * parts, &S));
  PetscCall(StrainAtPoints(t, v, NULL, S));
  for (PetscInt i = 0; i < t->n; i++) {
    const StressPoint *at = &t->point[i];

    t->change[i] = at->slope * HalfProduct(dim, at->strain, &S[i * parts]);
  }
  PetscCall(PetscFree(S));
  if (!t->ops->strain) PetscCall(ParticlesHaloField(p, t->change));
  for (PetscInt c = 0; c < dim; c++) PetscCall(VecGetArray(y[c], &to[c]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    if (t->ops->strain) TermOfCells(t, i, term);
    else TermOfChanges(t, i, term);
    for (PetscInt c = 0; c < dim; c++) to[c][i] += scale * term[c];
  }
  for (PetscInt c = 0; c < dim; c++) PetscCall(VecRestoreArray(y[c], &to[c]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
