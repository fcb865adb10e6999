/* Quantities that cases share: errors at the particles against an exact solution, and integrals
   that every case reports. */
#include "isph/io.h"

/* Sums over all fluid particles, weighted by volume, for a single MPI reduction. The exact velocity
   is u_e, the exact pressure p_e. */
typedef struct {
  PetscReal u2, exact2;      /* of |u - u_e|^2 and |u_e|^2 [m^2/s^2] */
  PetscReal p, p_exact, n_p; /* of p and p_e [Pa]; weight of the particles with a p_e [-] */
  PetscReal missing;         /* number of particles without a p_e */
} ExactSums;
typedef struct {
  PetscReal u, exact; /* of |u - u_e| and |u_e| [m/s] */
} ExactMaxima;

/* Computes the sums and the maxima; sets exact_p[i] to the exact pressure of own fluid particle i,
   NaN if there is none. */
static PetscErrorCode NormsCompare(const Flow *flow, PetscReal exact_p[], ExactSums *sums,
                                   ExactMaxima *maxima)
{
  const Particles *p = flow->particles;
  const PetscReal  t = ClockMoment(flow->clock);

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sums, sizeof(*sums)));
  PetscCall(PetscMemzero(maxima, sizeof(*maxima)));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal weight          = ParticlesWeight(p, i);
    PetscReal       x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM] = {0.0}, d2 = 0.0, e2 = 0.0;
    PetscReal       y[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    exact_p[i] = NAN;
    flow->scene->problem->Exact(flow->scene, t, SceneLaboratoryPlace(flow->scene, t, x, y), u,
                                &exact_p[i]);
    SceneIntoFrame(flow->scene, t, u);
    for (PetscInt c = 0; c < p->dim; c++) {
      d2 += PetscSqr(p->u[c][i] - u[c]);
      e2 += PetscSqr(u[c]);
    }
    sums->u2 += weight * d2;
    sums->exact2 += weight * e2;
    if (!(PetscSqrtReal(d2) <= maxima->u)) maxima->u = PetscSqrtReal(d2); /* NaN is kept */
    maxima->exact = PetscMax(maxima->exact, PetscSqrtReal(e2));
    if (PetscIsNanReal(exact_p[i]) || !p->p) {
      sums->missing += 1.0;
      continue;
    }
    sums->p += weight * p->p[i];
    sums->p_exact += weight * exact_p[i];
    sums->n_p += weight;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, (PetscMPIInt)(sizeof(*sums) / sizeof(PetscReal)),
                             MPIU_REAL, MPIU_SUM, p->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, maxima,
                             (PetscMPIInt)(sizeof(*maxima) / sizeof(PetscReal)), MPIU_REAL,
                             MPIU_MAX, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the relative L2 error of the pressure, after subtraction of the means if the constant is
   undetermined. */
static PetscErrorCode NormsPressure(const Flow *flow, const PetscReal exact_p[],
                                    const ExactSums *sums, Report *report)
{
  const Particles *p          = flow->particles;
  const Scene     *scene      = flow->scene;
  const PetscBool  floats     = ScenePressureFloats(scene);
  const PetscReal  mean       = floats ? sums->p / sums->n_p : 0.0;
  const PetscReal  mean_exact = floats ? sums->p_exact / sums->n_p : 0.0;
  PetscReal        square[2]  = {0.0, 0.0}, scale;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal exact = exact_p[i] - mean_exact;

    square[0] += ParticlesWeight(p, i) * PetscSqr(p->p[i] - mean - exact);
    square[1] += ParticlesWeight(p, i) * PetscSqr(exact);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, square, 2, MPIU_REAL, MPIU_SUM, p->comm));
  scale = PetscSqrtReal(square[1] / p->weight);
  if (scale < 1e-12 * scene->rho * PetscSqr(scene->speed))
    scale = scene->rho * PetscSqr(scene->speed);
  PetscCall(ReportAddError(report, "pressure_l2", PetscSqrtReal(square[0] / p->weight) / scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  NormsExact - Computes relative errors against the exact solution of the case, over all particles

    velocity_l2   = (sum V |u - u_e|^2 / sum V |u_e|^2)^1/2
    velocity_linf = max |u - u_e| / max |u_e|

  Collective. See theory.md, (forces:norms). V is the volume of a particle, u_e the exact velocity.
  Adds nothing if the case has no exact solution. Adds pressure_l2 if the run has a pressure and the
  exact solution gives it. The means of both pressures are subtracted unless a boundary gives the
  pressure. Input: flow - the flow at clock->t. Output: report - receives the quantities. Note: if
  the exact field vanishes, errors are relative to U and rho U^2
*/
PetscErrorCode NormsExact(const Flow *flow, Report *report)
{
  const Particles *p = flow->particles;
  PetscReal       *exact_p, scale;
  ExactSums        sums;
  ExactMaxima      maxima;

  PetscFunctionBegin;
  if (!flow->scene->problem->Exact) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(p->n_fluid, &exact_p));
  PetscCall(NormsCompare(flow, exact_p, &sums, &maxima));
  scale = PetscSqrtReal(sums.exact2 / p->weight);
  if (scale < 1e-12 * flow->scene->speed) scale = maxima.exact = flow->scene->speed;
  PetscCall(ReportAddError(report, "velocity_l2", PetscSqrtReal(sums.u2 / p->weight) / scale));
  PetscCall(ReportAddError(report, "velocity_linf", maxima.u / maxima.exact));
  if (SceneHas(flow->scene, PHYSICS_PRESSURE) && sums.missing == 0.0) {
    PetscCall(NormsPressure(flow, exact_p, &sums, report));
  }
  PetscCall(PetscFree(exact_p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports the errors of the motion of graded particles: graded_volume, the sum of their volumes by
   place before it is scaled to that of the fluid, its reference [m^dim]; graded_momentum [kg m/s]
   and graded_energy [J], the sums over the run that vanish in the continuum (per metre of depth in
   2D). */
static PetscErrorCode MeasureGraded(const Flow *flow, Report *report)
{
  const Particles *p      = flow->particles;
  const Graded    *graded = &flow->state->graded;
  const PetscReal  start  = p->weight_start * p->cell_volume;
  PetscReal        square = 0.0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) square += PetscSqr(graded->momentum[a]);
  PetscCall(ReportAddReference(report, "graded_volume", p->weight_resized * p->cell_volume, start,
                               start));
  PetscCall(ReportAdd(report, "graded_momentum", PetscSqrtReal(square)));
  PetscCall(ReportAdd(report, "graded_energy", graded->energy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the momentum of fluids of several densities, over rho and the volume of a cell [m/s]. */
static PetscErrorCode SumMomentum(const Flow *flow, PetscReal momentum[])
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++)
    for (PetscInt a = 0; a < p->dim; a++)
      momentum[a] += ParticlesDensity(flow->scene, p, i) / flow->scene->rho *
                     ParticlesWeight(p, i) * p->u[a][i];
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, momentum, (PetscMPIInt)p->dim, MPIU_REAL, MPIU_SUM, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MeasureCommon - Computes the quantities that every case reports

    kinetic_energy [J], linear_momentum = |sum_i rho V_i u_i| [kg m/s], both per metre of depth in
    2D, theory.md, (forces:energy), with the weights (motion:mean) in a periodic box without forces
  and bodies, unless pair forces keep the sum itself; divergence_max = max |div u| [1/s], if the run
  has a pressure; graded_volume, graded_momentum and graded_energy, if graded particles move; those
  of MeasureFree() with a free surface

  Collective. Input: flow - the flow, with the statistics of the last step; energy - reference of
  the kinetic energy, NaN without reference [J]. Output: report - receives the quantities.
*/
PetscErrorCode MeasureCommon(const Flow *flow, PetscReal energy, Report *report)
{
  const Particles *p                      = flow->particles;
  const PetscReal  mass                   = flow->scene->rho * p->cell_volume;
  PetscReal        momentum[ISPH_MAX_DIM] = {0.0}, square = 0.0;

  PetscFunctionBegin;
  if (SceneMixes(flow->scene)) {
    PetscCall(SumMomentum(flow, momentum));
  } else if (SceneKeepsMomentum(flow->scene) && !(flow->ops->needs & NEED_STREAMS)) {
    PetscCall(FlowMeanVelocity(flow, flow->state->u, momentum));
    for (PetscInt c = 0; c < p->dim; c++) momentum[c] *= p->weight;
  } else {
    for (PetscInt c = 0; c < p->dim; c++)
      PetscCall(FluidSum(p, flow->state->u[c], PETSC_FALSE, &momentum[c]));
  }
  for (PetscInt c = 0; c < p->dim; c++) square += PetscSqr(mass * momentum[c]);
  PetscCall(ReportAddReference(report, "kinetic_energy", flow->scheme->stats.kinetic_energy, energy,
                               energy));
  if (SceneHas(flow->scene, PHYSICS_PRESSURE)) {
    PetscCall(ReportAdd(report, "divergence_max", flow->scheme->stats.divergence));
  }
  PetscCall(ReportAdd(report, "linear_momentum", PetscSqrtReal(square)));
  if (SceneMovesGraded(flow->scene)) PetscCall(MeasureGraded(flow, report));
  PetscCall(MeasureFree(flow, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}
