/*
  The motion of particles whose spacing depends on place. They follow the streamlines of the flow at
  another speed, w = m u with m = SceneMotionFactor(), the volume of a particle at its place over a
  constant volume. The density of particles wanted is 1/m up to a factor, and it stays:

    div(w/m) = div u = 0

  So no particle is inserted or removed. The particles cross the flow, so that du/dt along their
  paths has the convective term (u - w).grad u. See theory.md, (motion:graded), (motion:term) and
  (motion:sums).
*/
#include "isph/motion.h"

/* Copies the position of particle i. */
static void PlaceOf(const Particles *p, PetscInt i, PetscReal x[])
{
  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
}

/* GradedPath - Multiplies the way of the fluid in a step by the factor of the motion. The factor
   belongs to the middle of the way. Input/Output: way [m]. */
void GradedPath(const Scene *scene, const Particles *p, PetscInt i, PetscReal way[])
{
  PetscReal x[ISPH_MAX_DIM] = {0.0}, factor = ParticlesMotionFactor(scene, p, i);

  PlaceOf(p, i, x);
  for (PetscInt a = 0; a < p->dim; a++) x[a] += 0.5 * factor * way[a];
  factor = SceneMotionFactor(scene, x);
  for (PetscInt a = 0; a < p->dim; a++) way[a] *= factor;
}

/* GradedKeepOffSides - Moves a position that is less than `share` of the edge of its cell from a
   side of the box that confines the fluid, or behind it, to this distance */
void GradedKeepOffSides(const Scene *scene, PetscReal share, PetscReal x[])
{
  PetscReal edge[ISPH_MAX_DIM], way = PETSC_MAX_REAL;

  for (PetscInt a = 0; a < scene->dim; a++)
    way = PetscMin(way, PetscMin(x[a] - scene->lo[a], scene->hi[a] - x[a]));
  if (way >= share * SceneCoarsest(scene)) return;
  SceneEdges(scene, x, edge);
  for (PetscInt a = 0; a < scene->dim; a++) {
    if (BoundaryIs(scene, 2 * a, BOUNDARY_CONFINES))
      x[a] = PetscMax(x[a], scene->lo[a] + share * edge[a]);
    if (BoundaryIs(scene, 2 * a + 1, BOUNDARY_CONFINES))
      x[a] = PetscMin(x[a], scene->hi[a] - share * edge[a]);
  }
}

/* Computes of each own fluid particle the factor of the motion, and the change of its volume in the
   step, over the volume. */
static void SetFactors(const Flow *flow, const PetscScalar *const u[], PetscScalar factor[],
                       PetscScalar growth[])
{
  const Particles *p = flow->particles;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal low[ISPH_MAX_DIM] = {0.0}, high[ISPH_MAX_DIM] = {0.0};

    PlaceOf(p, i, low);
    PlaceOf(p, i, high);
    factor[i] = ParticlesMotionFactor(flow->scene, p, i);
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal half = 0.5 * flow->clock->dt * factor[i] * u[a][i];

      low[a] -= half;
      high[a] += half;
    }
    growth[i] =
        (SceneMotionFactor(flow->scene, high) - SceneMotionFactor(flow->scene, low)) / factor[i];
  }
}

/* Subtracts the convective term of component c from its force. Adds to sum[c] and sum[dim] the
   momentum and the energy, over the density, that this term and the change of volumes add. */
static PetscErrorCode Convect(Flow *flow, PetscInt c, const Vec u[], const PetscScalar factor[],
                              const PetscScalar growth[], Vec force, PetscReal sum[])
{
  const Particles         *p  = flow->particles;
  const VelocityOperators *of = OperatorsOfVelocity(flow->ops, c);
  const AffineOperator    *op[ISPH_MAX_DIM];
  const PetscScalar       *v[ISPH_MAX_DIM], *slope[ISPH_MAX_DIM];
  PetscScalar             *f;
  Vec                      y[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    op[a] = &of->grad_u[a];
    PetscCall(FlowGetWork(flow, &y[a]));
  }
  PetscCall(AffineApplyAll(p->dim, op, u[c], flow->walls.u[c], y));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecGetArrayRead(u[a], &v[a]));
    PetscCall(VecGetArrayRead(y[a], &slope[a]));
  }
  PetscCall(VecGetArray(force, &f));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal term = 0.0, change;

    for (PetscInt a = 0; a < p->dim; a++) term += (1.0 - factor[i]) * v[a][i] * slope[a][i];
    f[i] -= term;
    change = p->volume[i] * (growth[i] * v[c][i] - flow->clock->dt * term);
    sum[c] += change;
    sum[p->dim] += v[c][i] * (change - 0.5 * p->volume[i] * growth[i] * v[c][i]);
  }
  PetscCall(VecRestoreArray(force, &f));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecRestoreArrayRead(y[a], &slope[a]));
    PetscCall(VecRestoreArrayRead(u[a], &v[a]));
    PetscCall(FlowRestoreWork(flow, &y[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  GradedConvection - Subtracts the convective term of graded particles that move from a force

    force -= (1 - m) (u.grad u),   u of VelocityExtrapolate()

  Collective, at the new places of the particles. Adds the momentum and the energy of the step to
  state->graded: those of the change of volumes and of the convective term, whose sums vanish in the
  continuum. Input: at - time of the force within the step: 1 or 1/2.
*/
PetscErrorCode GradedConvection(Flow *flow, PetscReal at, Vec force[])
{
  const Scene       *scene                 = flow->scene;
  Graded            *graded                = &flow->state->graded;
  PetscReal          sum[ISPH_MAX_DIM + 1] = {0.0};
  const PetscScalar *v[ISPH_MAX_DIM];
  PetscScalar       *m, *g;
  Vec                u[ISPH_MAX_DIM], factor, growth;

  PetscFunctionBegin;
  PetscCall(FlowGetWork(flow, &factor));
  PetscCall(FlowGetWork(flow, &growth));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(FlowGetWork(flow, &u[a]));
  PetscCall(VelocityExtrapolate(flow, at, u));
  if (scene->unsteady_walls)
    PetscCall(WallValuesSetVelocity(scene, flow->particles, flow->clock->t + at * flow->clock->dt,
                                    0.0, &flow->walls));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecGetArrayRead(u[a], &v[a]));
  PetscCall(VecGetArray(factor, &m));
  PetscCall(VecGetArray(growth, &g));
  SetFactors(flow, v, m, g);
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(VecRestoreArrayRead(u[a], &v[a]));
  for (PetscInt c = 0; c < scene->dim; c++) PetscCall(Convect(flow, c, u, m, g, force[c], sum));
  PetscCall(VecRestoreArray(growth, &g));
  PetscCall(VecRestoreArray(factor, &m));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, sum, scene->dim + 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  for (PetscInt a = 0; a < scene->dim; a++) graded->momentum[a] += scene->rho * sum[a];
  graded->energy += scene->rho * sum[scene->dim];
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(FlowRestoreWork(flow, &u[a]));
  PetscCall(FlowRestoreWork(flow, &growth));
  PetscCall(FlowRestoreWork(flow, &factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* GradedRemember - Adds the sums of GradedConvection() to the memory of the run */
PetscErrorCode GradedRemember(Flow *flow)
{
  static const char *const names[] = {"graded_momentum_x", "graded_momentum_y",
                                      "graded_momentum_z"};
  Graded                  *graded  = &flow->state->graded;
  Memory                  *memory  = &flow->scheme->memory;

  PetscFunctionBegin;
  if (!SceneMovesGraded(flow->scene)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < flow->scene->dim; a++)
    PetscCall(MemoryAddReal(memory, names[a], &graded->momentum[a]));
  PetscCall(MemoryAddReal(memory, "graded_energy", &graded->energy));
  PetscFunctionReturn(PETSC_SUCCESS);
}
