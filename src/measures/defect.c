/*
  Defects of a computed flow: the residuals of its momentum and its mass in a discretisation that
  shares no row with the operators of the run,

    r = a + ((u - w).grad) u - div S - f,   S = -p/rho I + 2 nu E,   d = div u

  a is Du/Dt by the formula of the step (src/flow/acceleration.c), w the velocity of particles, and
  nu the law of the fluid at the gradients found here. All derivatives are those of cubic fits:
  those of u have the conditions of boundaries, those of S none. With a uniform viscosity the
  Laplacian of the fit of u stands for its part of div S, because one fit has less noise than two.
  On a lattice with few neighbours it would be blind: by symmetry a cubic fit has there the
  Laplacian of a quadratic fit. See theory.md, (forces:defect).
*/
#include "defect.h"
#include "isph/strain.h"
#include "monitors.h"

#define SLAB    512  /* particles whose rows of neighbours are kept at once */
#define DEGREE  3    /* of the fits */
#define SURE    1e-3 /* pivot of a fit that its points determine well [-] */
#define TANGENT 1e-3 /* relative distance of the secant that stands for a tangent [-] */
#define WIDE    2.4  /* radius in which a lattice determines fits of degree 4 [dx] */

/* Returns true if the viscous force is nu lap u of one fit. */
static PetscBool FitsLaplacian(const Flow *flow)
{
  const OperatorForms *forms = &flow->ops->forms;

  if (!SceneIsNewtonian(flow->scene) || flow->particles->nu) return PETSC_FALSE;
  return SceneMoves(flow->scene) || forms->kernel->support * forms->h_over_dx >= WIDE;
}

/* Returns true if sound is part of the pressure. A compact gradient stands then for that of the
   fits: the projection of the residual removes all of it, and finds the pressure of the
   incompressible flow. */
static PetscBool HasSound(const Flow *flow)
{
  return flow->scheme->density ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns the slope of the stress over the strain rate, d(nu g)/dg, by which the stress follows an
   error of the velocity [m^2/s]. */
static PetscReal TangentViscosity(const Rheology *rheology, const FluidPlace *at, PetscReal rate)
{
  const PetscReal low = (1.0 - TANGENT) * rate, high = (1.0 + TANGENT) * rate;

  if (!(rate > 0.0)) return RheologyViscosity(rheology, at, rate);
  return (high * RheologyViscosity(rheology, at, high) -
          low * RheologyViscosity(rheology, at, low)) /
         (high - low);
}

/* Sets stress S and tangent viscosity at own particle i from the gradient A of its velocity; S
   without the viscous part if it is not needed. */
static void SetStress(const Flow *flow, PetscInt i, const PetscReal A[], PetscBool viscous,
                      PetscReal *const S[], PetscReal *nu)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  const PetscInt   dim   = p->dim;
  const PetscReal  rate  = StrainRate(dim, A);
  PetscReal        own;

  *nu = own = 0.0;
  if (SceneHas(scene, PHYSICS_VISCOSITY)) {
    own = p->nu ? p->nu[i] : scene->nu;
    *nu = own;
    if (!SceneIsNewtonian(scene)) {
      const FluidPlace at = RheologyAt(scene, p->x, i);

      own = RheologyViscosity(&scene->rheology, &at, rate);
      *nu = TangentViscosity(&scene->rheology, &at, rate);
    }
  }
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; viscous && b < dim; b++)
      S[a][i * dim + b] = own * (A[a * dim + b] + A[b * dim + a]);
    if (p->p && !HasSound(flow)) S[a][i * dim + a] -= p->p[i] / scene->rho;
  }
}

/* Adds all but div S to the residual of own particle i, which begins with its acceleration. */
static void AddTerms(const Flow *flow, PetscInt i, const PetscReal A[], const PetscReal *lap,
                     Defect *d)
{
  const Scene     *scene   = flow->scene;
  const Particles *p       = flow->particles;
  const PetscReal  density = ParticlesDensity(scene, p, i) / scene->rho;
  PetscReal        x[ISPH_MAX_DIM], f[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM], N[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < p->dim; a++) {
    x[a] = p->x[a][i];
    u[a] = p->u[a][i];
  }
  FlowConvective(flow, x, u, A, N);
  if (SceneHas(scene, PHYSICS_BODY_FORCE)) SceneBodyForce(scene, ClockMoment(flow->clock), x, f);
  d->mass[i] = 0.0;
  for (PetscInt a = 0; a < p->dim; a++) {
    d->momentum[a][i] = density * (d->momentum[a][i] - f[a]);
    if (lap) d->momentum[a][i] -= d->nu[i] * lap[a];
    d->momentum[a][i] += N[a];
    d->mass[i] += A[a * p->dim + a];
  }
}

/* Computes viscosities, stresses, compact rows, and the residuals but for div S. */
static PetscErrorCode FitVelocity(const Flow *flow, PetscReal *const S[], Defect *d)
{
  const Particles *p       = flow->particles;
  const PetscInt   dim     = p->dim;
  const PetscBool  uniform = FitsLaplacian(flow);
  PetscReal       *lap;
  FieldGradients   of = {.kind =
                           SceneIsNewtonian(flow->scene) ? FIELD_VELOCITY : FIELD_WHOLE_VELOCITY,
                         .degree   = DEGREE,
                         .stride   = 1,
                         .weak     = SURE,
                         .n_fields = dim};

  PetscFunctionBegin;
  for (PetscInt c = 0; c < dim; c++) of.value[c] = p->u[c];
  PetscCall(PetscMalloc2(SLAB * dim * dim, &of.gradient, SLAB * dim, &lap));
  if (uniform) of.laplacian = lap;
  for (; of.first < p->n_fluid; of.first += SLAB) {
    of.count = PetscMin(SLAB, p->n_fluid - of.first);
    PetscCall(NeighborsFindRows(p, of.first, of.count, flow->neighbors));
    PetscCall(OperatorsFitGradients(flow->scene, p, flow->neighbors, flow->ops, &of));
    for (PetscInt l = 0; l < of.count; l++) {
      const PetscInt   i = of.first + l;
      const PetscReal *A = of.gradient + l * dim * dim;

      SetStress(flow, i, A, uniform ? PETSC_FALSE : PETSC_TRUE, S, &d->nu[i]);
      AddTerms(flow, i, A, uniform ? lap + l * dim : NULL, d);
      PetscCall(CompactRowAdd(flow, i, &d->rows));
    }
  }
  PetscCall(PetscFree2(of.gradient, lap));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Subtracts div S from the residuals. */
static PetscErrorCode FitStress(const Flow *flow, PetscReal *const S[], Defect *d)
{
  const Particles *p   = flow->particles;
  const PetscInt   dim = p->dim;
  FieldGradients   of  = {.kind     = FIELD_STRESS,
                          .degree   = DEGREE,
                          .stride   = dim,
                          .weak     = SURE,
                          .n_fields = dim * dim,
                          .first    = 0};

  PetscFunctionBegin;
  for (PetscInt f = 0; f < of.n_fields; f++) of.value[f] = S[f / dim] + f % dim;
  PetscCall(PetscMalloc1(SLAB * of.n_fields * dim, &of.gradient));
  for (; of.first < p->n_fluid; of.first += SLAB) {
    of.count = PetscMin(SLAB, p->n_fluid - of.first);
    PetscCall(NeighborsFindRows(p, of.first, of.count, flow->neighbors));
    PetscCall(OperatorsFitGradients(flow->scene, p, flow->neighbors, flow->ops, &of));
    for (PetscInt q = 0; q < of.count * of.n_fields; q++) {
      const PetscInt l = q / of.n_fields, a = q / dim % dim, b = q % dim;

      d->momentum[a][of.first + l] -= of.gradient[q * dim + b];
    }
  }
  PetscCall(PetscFree(of.gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the compact gradient of p/rho to the residuals. */
static PetscErrorCode AddCompactPressure(const Flow *flow, Defect *d)
{
  const Particles   *p    = flow->particles;
  const CompactRows *rows = &d->rows;
  PetscReal         *all;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(ParticlesAll(p), &all));
  PetscCall(PetscArraycpy(all, p->p, p->n_fluid));
  PetscCall(ParticlesHaloField(p, all));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt k = rows->row[i]; k < rows->row[i + 1]; k++) {
      const PetscReal y = (all[rows->col[k]] - all[i]) / flow->scene->rho;

      for (PetscInt a = 0; a < p->dim; a++) d->momentum[a][i] += rows->slope[a][k] * y;
    }
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces the residuals by those of the viscous force of a weak form: fits of cubic degree see
   forces at a jump of the viscosity, and at a yield surface, that the flow has not. The divergence
   of cells is zero. */
static PetscErrorCode WeakDefect(const Flow *flow, Defect *d)
{
  PetscFunctionBegin;
  PetscCall(StrainForceError(flow->scene, flow->particles, flow->neighbors, flow->ops->forms.degree,
                             flow->ops->strain, d->momentum));
  PetscCall(PetscArrayzero(d->mass, flow->particles->n_fluid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* DefectCreate - Computes the defect of the present flow. Collective. Free with DefectDestroy().
   Note: finds the rows of neighbours; those of fixed particles are not kept. */
PetscErrorCode DefectCreate(const Flow *flow, Defect *d)
{
  const Particles *p = flow->particles;
  PetscReal       *S[ISPH_MAX_DIM];

  PetscFunctionBegin;
  *d = (Defect){.mass = NULL};
  if (SceneMoves(flow->scene)) PetscCall(NeighborsUpdate(p, 0.0, flow->neighbors));
  else PetscCall(NeighborsSearch(p, flow->neighbors));
  PetscCall(PetscMalloc4(p->n_fluid, &d->mass, ParticlesAll(p), &d->nu, p->n_fluid + 1,
                         &d->rows.row, p->n_fluid, &d->rows.wall));
  d->rows.row[0] = 0;
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(ParticlesHaloField(p, p->u[a]));
    PetscCall(PetscMalloc1(p->n_fluid, &d->momentum[a]));
    PetscCall(PetscCalloc1(ParticlesAll(p) * p->dim, &S[a]));
  }
  PetscCall(AccelerationGet(flow, d->momentum));
  PetscCall(FitVelocity(flow, S, d));
  PetscCall(ParticlesHaloField(p, d->nu));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(ParticlesHaloVectors(p, S[a]));
  if (flow->ops->strain) PetscCall(WeakDefect(flow, d));
  else PetscCall(FitStress(flow, S, d));
  if (HasSound(flow)) PetscCall(AddCompactPressure(flow, d));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(PetscFree(S[a]));
  if (!SceneMoves(flow->scene)) PetscCall(NeighborsRelease(flow->neighbors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* DefectDestroy - Frees the defect */
PetscErrorCode DefectDestroy(Defect *d)
{
  PetscFunctionBegin;
  PetscCall(PetscFree4(d->mass, d->nu, d->rows.row, d->rows.wall));
  PetscCall(FreeAll(&d->rows.col, &d->rows.conductance));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(FreeAll(&d->momentum[a], &d->rows.slope[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
