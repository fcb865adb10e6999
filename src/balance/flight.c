/*
  The flight of fluid that touches nothing: momentum P and angular momentum L about its middle X,
  per mass, change by the body force f alone,

    P(t) = P(0) + int <f> dt,   L(t) = L(0) + int <(x - X) x f> dt,   P = <u>, L = <(x - X) x u>

  with means <> over the mass. Pressure, viscosity and surface tension act between its own parts. A
  flight begins in the first step without a wall or an opening near a particle, and ends with the
  next contact. See theory.md, (forces:flight).
*/
#include "isph/balance.h"

#define QUIET 0.02 /* speed that counts as motion at least, over that of the surface [-] */

enum { LINEAR, ANGULAR };

/* Means over the mass. */
typedef struct {
  PetscReal mass, x[ISPH_MAX_DIM], x2; /* [-], [m], [m^2] */
  PetscReal of[2][ISPH_MAX_DIM];       /* u, x x u */
  PetscReal force[2][ISPH_MAX_DIM];    /* f, x x f */
  PetscReal square, contacts;          /* |u|^2 [m^2/s^2]; particles beside walls */
} Means;

/* Returns true if own particle i has a wall particle as neighbour. */
static PetscBool TouchesWall(const Particles *p, const Neighbors *nb, PetscInt i)
{
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    if (ParticlesIsWall(p, nb->col[q]) &&
        ParticlesSquareDistance(p, i, nb->col[q]) < PetscSqr(nb->radius))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Adds weight a x b to c. */
static void AddCross(PetscReal weight, const PetscReal a[], const PetscReal b[], PetscReal c[])
{
  for (PetscInt k = 0; k < 3; k++) {
    const PetscInt m = (k + 1) % 3, n = (k + 2) % 3;

    c[k] += weight * (a[m] * b[n] - a[n] * b[m]);
  }
}

/* Adds own particles with the velocity v. */
static void AddParticles(const Flow *flow, const PetscScalar *const v[], Means *sum)
{
  const Particles *p      = flow->particles;
  const PetscBool  forced = SceneHas(flow->scene, PHYSICS_BODY_FORCE);
  const PetscReal  t      = flow->clock->t + 0.5 * flow->clock->dt;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal weight          = ParticlesWeight(p, i);
    PetscReal       x[ISPH_MAX_DIM] = {0.0}, u[ISPH_MAX_DIM] = {0.0}, f[ISPH_MAX_DIM] = {0.0};

    if (TouchesWall(p, flow->neighbors, i)) sum->contacts += 1.0;
    for (PetscInt a = 0; a < p->dim; a++) {
      x[a] = p->x[a][i];
      u[a] = PetscRealPart(v[a][i]);
      sum->x[a] += weight * x[a];
      sum->x2 += weight * PetscSqr(x[a]);
      sum->square += weight * PetscSqr(u[a]);
    }
    if (forced) SceneBodyForce(flow->scene, t, x, f);
    sum->mass += weight;
    for (PetscInt a = 0; a < p->dim; a++) {
      sum->of[LINEAR][a] += weight * u[a];
      sum->force[LINEAR][a] += weight * f[a];
    }
    AddCross(weight, x, u, sum->of[ANGULAR]);
    AddCross(weight, x, f, sum->force[ANGULAR]);
  }
}

/* Computes the means of velocities u, angular ones about the middle of the mass. */
static PetscErrorCode ComputeMeans(const Flow *flow, const Vec u[], Means *mean)
{
  const PetscInt     n = sizeof(*mean) / sizeof(PetscReal), dim = flow->particles->dim;
  PetscReal         *all = &mean->mass, mass;
  const PetscScalar *v[ISPH_MAX_DIM];

  PetscFunctionBegin;
  *mean = (Means){.mass = 0.0};
  for (PetscInt a = 0; a < dim; a++) PetscCall(VecGetArrayRead(u[a], &v[a]));
  AddParticles(flow, v, mean);
  for (PetscInt a = 0; a < dim; a++) PetscCall(VecRestoreArrayRead(u[a], &v[a]));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, all, (PetscMPIInt)n, MPIU_REAL, MPIU_SUM, flow->particles->comm));
  mass = mean->mass;
  for (PetscInt k = 0; k < n - 1; k++) all[k] /= mass; /* but for the contacts */
  for (PetscInt a = 0; a < dim; a++) mean->x2 -= PetscSqr(mean->x[a]);
  AddCross(-1.0, mean->x, mean->of[LINEAR], mean->of[ANGULAR]);
  AddCross(-1.0, mean->x, mean->force[LINEAR], mean->force[ANGULAR]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets a row to the change of a mean that the body force did not give, if it is larger. */
static void Note(const Means *mean, PetscInt of, PetscReal scale, Flow *flow)
{
  const BalanceKind kind   = of == LINEAR ? BALANCE_MOMENTUM : BALANCE_ANGULAR;
  BalanceSheet     *sheet  = &flow->scheme->sheet;
  PetscReal         square = 0.0, value;

  for (PetscInt a = 0; a < 3; a++)
    square += PetscSqr(mean->of[of][a] - sheet->flight.start[of][a] - sheet->flight.given[of][a]);
  value                = PetscSqrtReal(square) / scale;
  sheet->applies[kind] = 1;
  if (value > sheet->value[kind])
    BalanceSet(kind, value, value, flow->clock->t + flow->clock->dt, sheet);
}

/* Begins a flight with the momentum of the fluid. */
static PetscErrorCode TakeOff(const Means *mean, Flight *flight)
{
  PetscFunctionBegin;
  *flight = (Flight){.on = 1.0};
  PetscCall(PetscArraycpy(&flight->start[0][0], &mean->of[0][0], 2 * ISPH_MAX_DIM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins a flight before the first step of a run. */
static PetscErrorCode FlightBegin(Flow *flow)
{
  Means mean;

  PetscFunctionBegin;
  if (flow->clock->step > 0 || flow->state->openings.open) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ComputeMeans(flow, flow->state->u, &mean));
  if (mean.contacts == 0.0) PetscCall(TakeOff(&mean, &flow->scheme->sheet.flight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Begins, continues or ends the flight at the end of a step. */
static PetscErrorCode FlightEnd(Flow *flow)
{
  Flight         *flight = &flow->scheme->sheet.flight;
  const PetscReal quiet  = QUIET * flow->scheme->bound.start;
  Means           mean;
  PetscReal       speed;

  PetscFunctionBegin;
  if (flow->particles->N_fluid == 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ComputeMeans(flow, flow->state->u_next, &mean));
  if (mean.contacts > 0.0 || flow->state->openings.open) flight->on = 0.0;
  else if (flight->on == 0.0) PetscCall(TakeOff(&mean, flight));
  else {
    for (PetscInt of = 0; of < 2; of++)
      for (PetscInt a = 0; a < 3; a++) flight->given[of][a] += flow->clock->dt * mean.force[of][a];
    flight->speed = PetscMax(flight->speed, PetscSqrtReal(mean.square));
    speed         = PetscMax(flight->speed, quiet) + 1e-6 * flow->scene->speed;
    Note(&mean, LINEAR, speed, flow);
    if (!SceneHasBoundary(flow->scene, BOUNDARY_CONTINUES))
      Note(&mean, ANGULAR, speed * PetscSqrtReal(mean.x2), flow);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool CanFly(const Flow *flow)
{
  return SceneHasFreeSurface(flow->scene) && SceneMoves(flow->scene);
}

/* Momentum and angular momentum of fluid that touches nothing. */
const Observer ObserverFlight = {
    .Applies = CanFly,
    .Begin   = FlightBegin,
    .End     = FlightEnd,
};
