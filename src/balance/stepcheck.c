/* The check of a step: measures energy, largest speed and divergence of the new velocity, and
   compares the velocity with the bound that follows from driving forces and walls. */
#include "isph/balance.h"

#define UNEVEN 0.15 /* unevenness above which the run prints a note [-] */
#define FIRST  1.5  /* share of a first step in later velocities, 1 + 1/3 + 1/9 + ... [-] */

/* Returns the larger of the speeds at which particle i moves and at which the fluid passes it, over
   the speed of the fluid: 1 without graded spacing. */
static PetscReal PaceFactor(const Scene *scene, const Particles *p, PetscInt i)
{
  PetscReal factor;

  if (!SceneMovesGraded(scene)) return 1.0;
  factor = ParticlesMotionFactor(scene, p, i);
  return PetscMax(factor, PetscAbsReal(1.0 - factor));
}

/* Computes the largest |div u| of a velocity u [1/s]. */
static PetscErrorCode MeasureDivergence(Flow *flow, const Vec u[], PetscReal *largest)
{
  Vec div;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &div));
  PetscCall(FlowDivergence(flow, u, div));
  PetscCall(VecNorm(div, NORM_INFINITY, largest));
  PetscCall(FlowRestoreWork(flow, &div));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Measures kinetic energy, largest speed, the largest speed to which walls can have driven the
   fluid, the unevenness and, with a pressure, the largest divergence. Collective. Input: u -
   velocity components. Output: scheme->stats, bound.walls. */
static PetscErrorCode MeasureFlow(Flow *flow, const Vec u[])
{
  const Scene       *scene  = flow->scene;
  const Particles   *p      = flow->particles;
  Scheme            *s      = flow->scheme;
  const PetscReal   *C      = flow->ops->concentration.value;
  PetscReal          sum[3] = {0.0}, most[3] = {0.0, flow->walls.speed_bound, 0.0};
  const PetscScalar *v[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(u[a], &v[a]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal speed2 = 0.0, stretched2 = 0.0, speed, x[ISPH_MAX_DIM], pass[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < scene->dim; a++) {
      x[a]    = p->x[a][i];
      pass[a] = v[a][i];
    }
    ScenePassing(scene, flow->clock->t, x, pass);
    for (PetscInt a = 0; a < scene->dim; a++) {
      speed2 += PetscSqr(v[a][i]);
      stretched2 += PetscSqr(ParticlesStretch(p, a, i) * pass[a]);
    }
    sum[0] += ParticlesWeight(p, i) * ParticlesDensity(scene, p, i) * speed2;
    sum[2] += ParticlesWeight(p, i) * ParticlesDensity(scene, p, i);
    if (C) sum[1] += ParticlesWeight(p, i) * PetscSqr(C[i] - 1.0);
    speed   = PetscSqrtReal(speed2);
    most[0] = PetscMax(most[0], speed);
    most[2] = PetscMax(most[2], PetscSqrtReal(stretched2) * (scene->dx / p->dx[i]) *
                                    PaceFactor(scene, p, i));
  }
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(u[a], &v[a]));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, most, 3, MPIU_REAL, MPIU_MAX, p->comm));
  s->stats.kinetic_energy = 0.5 * SceneVolume(scene) * sum[0];
  s->stats.density        = sum[2] / p->weight;
  s->stats.unevenness     = PetscMax(s->stats.unevenness, PetscSqrtReal(sum[1] / p->weight));
  s->stats.speed_max      = most[0];
  s->stats.pace_max       = most[2];
  s->bound.walls          = PetscMax(s->bound.walls, most[1]);
  if (s->Divergence) PetscCall(s->Divergence(flow, u, &s->stats.divergence));
  else if (p->p) PetscCall(MeasureDivergence(flow, u, &s->stats.divergence));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the option that gives the velocities at the start. */
static const char *StartOption(const Flow *flow)
{
  if (flow->particles->velocity_given) return "-particles";
  return flow->scene->velocity.n ? "-scene_velocity" : "-scene_exact";
}

/* FlowMeasureStart - Measures energy, speed, divergence and body force of the flow at the start of
   a run. Collective. Errors: a speed whose square is not finite ends the run. */
PetscErrorCode FlowMeasureStart(Flow *flow)
{
  Scheme *s = flow->scheme;

  PetscFunctionBegin;
  PetscCall(MeasureFlow(flow, flow->state->u));
  UserCheck(s->stats.speed_max <= PETSC_MAX_REAL,
            "%s: the square of a speed at the start is not finite; allowed are speeds up to %.2g",
            StartOption(flow), (double)PetscSqrtReal(PETSC_MAX_REAL));
  if (SceneHas(flow->scene, PHYSICS_BODY_FORCE)) PetscCall(AddBodyForce(flow, 0.0, NULL));
  for (PetscInt k = 0; k < 3; k++) s->stats.change[k] = PETSC_INFINITY;
  s->bound.start = PetscSqrtReal(PetscSqr(FlowRmsSpeed(flow)) + flow->state->tension_energy);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Adds the force of the present step to the bound on the root mean square velocity |u|, and returns
  the bound plus 5 % for discretisation and 1e-6 U for rounding

    |u| <= |u|(0) + min(int F dt, max F/r) + max wall speed bound + sound,  F = max |f|

  A step of backward Euler before steps of BDF2 counts FIRST times in the integral: they carry half
  of its change on.
  |u|(0)^2 includes twice the energy of the surface at the start. f is the body force, and r the
  rate at which walls at rest slow the flow (SceneDecayRate()). All terms of forces and of the start
  follow from the energy balance, for steps of any length. The wall term is SceneWallSpeedBound().
  The speed stays below it in all flows with a known solution; a cavity reaches a third of it. The
  sound is zero unless the scheme is weakly compressible. See theory.md, (forces:bound). Moving
  fluids with a free surface have EnergyBound() instead. Input: before - |u| at the start of the
  step.
*/
static PetscErrorCode BoundSpeed(Flow *flow, PetscReal before, PetscReal *bound)
{
  const Clock    *clock = flow->clock;
  const PetscReal rate  = SceneDecayRate(flow->scene);
  const PetscReal first = clock->order > 1 && ClockRatio(clock) == 0.0 ? FIRST : 1.0;
  SpeedBound     *b     = &flow->scheme->bound;
  PetscReal       forced;

  PetscFunctionBegin;
  if (b->force_step > 0.0)
    b->impulse += clock->steady_solve ? PETSC_INFINITY : first * b->force_step * clock->dt;
  b->force      = PetscMax(b->force, b->force_step);
  b->force_step = 0.0;
  forced        = b->impulse;
  if (rate > 0.0) forced = PetscMin(forced, b->force / rate);
  *bound = b->start + forced + b->walls;
  if (SceneHasFreeSurface(flow->scene) && SceneMoves(flow->scene))
    PetscCall(EnergyBound(flow, before, bound));
  *bound = 1.05 * *bound + b->sound + 1e-6 * flow->scene->speed;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fails the step because the velocity exceeds its bound. Input: pace - largest speed in cells
   before the step, times the reference spacing [m/s]. */
static PetscErrorCode FailSpeed(Flow *flow, PetscReal pace, PetscReal rms, PetscReal bound)
{
  const Scene *scene = flow->scene;
  const Clock *clock = flow->clock;
  char where[CLOCK_WHERE], advice[128] = "try a smaller -coupled_ksp_rtol, or advance in time";
  char most[64] = "";

  PetscFunctionBegin;
  PetscCall(ClockWhere(clock, where));
  if (!clock->steady_solve) {
    PetscCall(
        PetscSNPrintf(advice, sizeof(advice),
                      "the flow is unstable at dt = %.6g (CFL %.2g); try a smaller -dt or -cfl",
                      (double)clock->dt, (double)(clock->dt * pace / scene->dx)));
  }
  if (rms <= bound) {
    FailureSet(
        &flow->scheme->failure, PETSC_ERR_FP,
        "%s: a velocity is %.6g, a hundred times the reference speed %.6g: if the flow is so "
        "fast, give its -speed; otherwise %s",
        where, (double)flow->scheme->stats.speed_max, (double)scene->speed, advice);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (bound < PETSC_INFINITY)
    PetscCall(
        PetscSNPrintf(most, sizeof(most), "at most %.6g by forces and walls; ", (double)bound));
  FailureSet(&flow->scheme->failure, PETSC_ERR_FP,
             "%s: the velocity has left every bound (root mean square %.6g, %slargest %.6g, "
             "reference %.6g): %s",
             where, (double)rms, most, (double)flow->scheme->stats.speed_max, (double)scene->speed,
             advice);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes the share of own and other fluid particles that are in a solid, if bodies move. */
static PetscErrorCode CheckSolids(Flow *flow)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  BalanceSheet    *sheet = &flow->scheme->sheet;
  PetscInt         in    = 0, side;

  PetscFunctionBegin;
  if (!scene->pose) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    if (SceneFluidDistance(scene, x, &side) < 0.0) in++;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &in, 1, MPIU_INT, MPI_SUM, p->comm));
  sheet->applies[BALANCE_SOLID] = 1;
  if (in > sheet->value[BALANCE_SOLID] * (PetscReal)p->N_fluid) {
    const PetscReal share = (PetscReal)in / (PetscReal)p->N_fluid;

    BalanceSet(BALANCE_SOLID, share, share, flow->clock->t + flow->clock->dt, sheet);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowCheck - Measures the velocity u_next at the end of a step, and fails the step if the flow is
   invalid. Collective. Sets scheme->failure if the root mean square velocity is not finite or
   exceeds its bound, or if a particle has at least a hundred times the reference speed. */
PetscErrorCode FlowCheck(Flow *flow)
{
  const Clock    *clock  = flow->clock;
  const PetscReal before = FlowRmsSpeed(flow);
  Scheme         *s      = flow->scheme;
  const PetscReal pace   = s->stats.pace_max;
  PetscReal       bound, rms;

  PetscFunctionBegin;
  PetscCall(
      WallValuesSetVelocity(flow->scene, flow->particles, clock->t + clock->dt, 0.0, &flow->walls));
  PetscCall(MeasureFlow(flow, flow->state->u_next));
  PetscCall(BoundSpeed(flow, before, &bound));
  rms = FlowRmsSpeed(flow);
  if (!(rms <= bound) || s->stats.speed_max >= 100.0 * flow->scene->speed) {
    PetscCall(FailSpeed(flow, PetscMax(pace, flow->scene->speed), rms, bound));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < s->n_solves; k++) s->solve[k]->iterations_sum += s->solve[k]->iterations;
  PetscCall(CheckSolids(flow));
  PetscCall(SteadyMeasure(flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FlowRemember - Adds what steps measure to the memory of the run, which undo and checkpoints
   save */
PetscErrorCode FlowRemember(Flow *flow)
{
  Scheme       *s      = flow->scheme;
  Memory       *memory = &s->memory;
  BalanceSheet *sheet  = &s->sheet;
  const struct {
    const char *name;
    size_t      size;
    PetscReal  *numbers; /* all members of a struct */
  } kept[] = {
      {"statistics", sizeof(s->stats), &s->stats.speed_max},
      {"speed_bound", sizeof(s->bound), &s->bound.start},
      {"energy", sizeof(s->energy), &s->energy.work},
      {"flight", sizeof(sheet->flight), &sheet->flight.on},
      {"steady_test", sizeof(s->steady), &s->steady.start},
  };

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(kept); k++)
    PetscCall(MemoryAddReals(memory, kept[k].name, (PetscInt)(kept[k].size / sizeof(PetscReal)),
                             kept[k].numbers));
  for (PetscInt kind = BALANCE_MOMENTUM; kind <= BALANCE_ANGULAR; kind++) {
    const PetscBool linear = kind == BALANCE_MOMENTUM;

    PetscCall(
        MemoryAddReal(memory, linear ? "flight_momentum" : "flight_angular", &sheet->value[kind]));
    PetscCall(MemoryAddInt(memory, linear ? "flew" : "turned", &sheet->applies[kind]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* UnevennessReport - Adds the unevenness to the figures of the scheme. It is the largest root mean
   square of C - 1 so far, with the concentration C of particles that shifting spreads in a full
   box. In taylor_green (Re = 100, n = 24 to 64) steps too long for the strain of the flow make it:
   up to 0.12 the velocity errs by at most 0.6 %, and by more than 2.5 % from 0.2 on. */
PetscErrorCode UnevennessReport(Flow *flow)
{
  Scheme *s = flow->scheme;

  PetscFunctionBegin;
  if (!(s->needs & NEED_CONCENTRATION) || SceneHasFreeSurface(flow->scene))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SchemeAddFigure(
      (SchemeFigure){
          .name  = "unevenness",
          .value = &s->stats.unevenness,
          .most  = UNEVEN,
          .remedy =
              "the particles were unevenly spread, and the velocity may err by some per cent; try "
              "a smaller -cfl or -dt",
          .quiet = PETSC_TRUE,
      },
      s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
