/*
  Identities of particles and neighbours on any number of ranks: no particle is lost, values of
  fields stay with their particles, the position of a copy is that of its owner plus a shift, and
  rows equal a search over all particles and periodic images.
*/
/* RANKS: 1 2 3 */
#include "isph/start.h"
#include "crowd.h"

/* Checks normals, depths and sides of own wall particles and of their copies. */
static void CheckWalls(const Setting *s, const Particles *p)
{
  PetscInt wrong = 0;

  for (PetscInt i = 0; i < ParticlesAll(p) && p->depth; i++) {
    const PetscInt  side = (PetscInt)p->side[i], axis = side / 2;
    const PetscReal plane = side % 2 ? s->scene.hi[axis] : s->scene.lo[axis];

    if (!ParticlesIsWall(p, i)) continue;
    wrong += PetscAbsReal(p->x[axis][i] + p->normal[axis][i] * p->depth[i] - plane) > 1e-12;
    wrong += p->normal[axis][i] != (side % 2 ? -1.0 : 1.0);
    wrong += s->walls.layers > 0 && !s->walls.surface && p->depth[i] < 0.49 * s->scene.dx;
    for (PetscInt a = 0; a < p->dim; a++) {
      if (SceneIsPeriodic(&s->scene, a)) continue;
      wrong +=
          p->depth[i] < PetscMax(s->scene.lo[a] - p->x[a][i], p->x[a][i] - s->scene.hi[a]) - 1e-12;
    }
  }
  CloudAssertNone("walls", s->name, wrong);
}

/* Moves particles by up to `step` [dx] and checks particles and neighbours after each move. */
static void Follow(const Setting *s, PetscReal step, PetscInt n_steps)
{
  const Scene *scene = &s->scene;
  Particles   *p;
  Neighbors   *nb;
  PetscReal   *tag[2];
  PetscInt     starts = 0;

  ASSERT_OK(ParticlesCreate(scene, RADIUS * scene->dx, &p));
  ASSERT_OK(ParticlesFill(scene, s->walls, NULL, p));
  ASSERT_OK(NeighborsCreate(RADIUS * scene->dx, scene->dx, &nb));
  ASSERT_OK(ParticlesRegister(p, "tag", 2, HALO_EPOCH, ENTRY_ZERO, tag));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    for (PetscInt c = 0; c < 2; c++) tag[c][i] = CrowdTag(p->id[i], c);
  }
  ASSERT_OK(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  CheckWalls(s, p);
  for (PetscInt k = 0; k < n_steps; k++) {
    PetscBool started;

    ASSERT_OK(NeighborsUpdate(p, step * scene->dx, nb));
    CrowdCheckParticles(s, p, tag);
    CrowdCheckNeighbors(s, p, nb);
    CrowdMove(scene, p, step * scene->dx);
    ASSERT_OK(ParticlesUpdateEpoch(scene, p, PETSC_FALSE, &started));
    if (!started) ASSERT_OK(ParticlesUpdateHalo(p));
    starts += started;
  }
  CheckWalls(s, p);
  CloudAssertNone("epochs started", s->name, step * n_steps > 4.0 && starts == 0);
  CloudAssertNone("a margin saved searches", s->name, step < 0.02 && nb->builds > n_steps / 4);
  ASSERT_OK(NeighborsDestroy(&nb));
  ASSERT_OK(ParticlesDestroy(&p));
}

static void test_walls(void **state)
{
  const Setting layers = CrowdBox("2D layers", 2, 24, 17, 1, 0, 3);
  const Setting plane  = CrowdBox("2D plane", 2, 24, 17, 1, 0, 0);
  Setting       both   = CrowdBox("2D plane and layers", 2, 24, 17, 1, 0, 3);

  (void)state;
  both.walls.surface = PETSC_TRUE;
  Follow(&both, 0.7, 5);
  Follow(&layers, 0.7, 10);
  Follow(&plane, 0.7, 10);
  Follow(&layers, 0.01, 30);
}

static void test_periodic(void **state)
{
  const Setting both    = CrowdBox("2D periodic", 2, 20, 20, 1, 2, 0);
  const Setting channel = CrowdBox("2D channel", 2, 13, 20, 1, 1, 3);
  const Setting narrow  = CrowdBox("2D short period", 2, 4, 30, 1, 1, 3);
  const Setting tiny    = CrowdBox("2D periods shorter than the radius", 2, 2, 3, 1, 2, 0);

  (void)state;
  Follow(&both, 0.7, 10);
  Follow(&both, 0.05, 12);
  Follow(&channel, 0.7, 10);
  Follow(&narrow, 0.7, 10);
  Follow(&tiny, 0.7, 10);
}

static void test_three_dimensions(void **state)
{
  const Setting mixed  = CrowdBox("3D channel", 3, 7, 8, 9, 2, 3);
  const Setting cavity = CrowdBox("3D cavity", 3, 7, 8, 6, 0, 2);
  const Setting plane  = CrowdBox("3D plane", 3, 7, 8, 6, 1, 0);

  (void)state;
  Follow(&mixed, 0.7, 7);
  Follow(&cavity, 0.7, 7);
  Follow(&plane, 0.7, 7);
}

static void test_more_ranks_than_particles(void **state)
{
  const Setting one = CrowdBox("one particle", 2, 1, 1, 1, 0, 3);
  const Setting two = CrowdBox("two particles", 2, 2, 1, 1, 2, 0);

  (void)state;
  Follow(&one, 0.7, 5);
  Follow(&two, 0.7, 10);
}

static void test_balance(void **state)
{
  const Setting s = CrowdBox("balance", 2, 100, 100, 1, 0, 3);
  Particles    *p;
  PetscMPIInt   ranks;

  (void)state;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  ASSERT_OK(ParticlesCreate(&s.scene, RADIUS * s.scene.dx, &p));
  ASSERT_OK(ParticlesFill(&s.scene, s.walls, NULL, p));
  for (PetscInt k = 0; k < 4; k++) {
    PetscInt most = p->n_fluid;

    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_INT, MPI_MAX, p->comm);
    CloudAssertNone("max / mean of fluid", s.name, (double)most * ranks > 1.1 * p->N_fluid);
    for (PetscInt i = 0; i < p->n_fluid; i++) { /* the flow is compressed towards a corner */
      p->x[0][i] = s.scene.lo[0] + 0.6 * (p->x[0][i] - s.scene.lo[0]);
      p->x[1][i] = s.scene.lo[1] + 0.8 * (p->x[1][i] - s.scene.lo[1]);
    }
    ASSERT_OK(ParticlesUpdateEpoch(&s.scene, p, PETSC_FALSE, NULL));
  }
  ASSERT_OK(ParticlesDestroy(&p));
}

/* Positions differ from the lattice by the jitter at most, and do not depend on the number of
   ranks. */
static void test_jitter(void **state)
{
  Setting     s = CrowdBox("jitter", 2, 16, 12, 1, 1, 3);
  Particles  *p;
  All         some, alone;
  PetscInt    far = 0, differ = 0, moved = 0;
  PetscMPIInt rank;

  (void)state;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  ASSERT_OK(ParticlesCreate(&s.scene, RADIUS * s.scene.dx, &p));
  ASSERT_OK(ParticlesFill(&s.scene, s.walls, NULL, p));
  CrowdGather(p, &some);
  for (PetscInt id = 0; id < p->N_fluid; id++) {
    const PetscInt cell[2] = {id % 16, id / 16};
    for (PetscInt a = 0; a < 2; a++) {
      PetscReal d = some.x[2 * id + a] - s.scene.lo[a] - (cell[a] + 0.5) * s.scene.dx;
      if (a == 0) d -= 1.6 * PetscFloorReal(d / 1.6 + 0.5);
      far += PetscAbsReal(d) > 0.2 * s.scene.dx + 1e-14;
      moved += PetscAbsReal(d) > 0.02 * s.scene.dx;
    }
  }
  CloudAssertNone("within jitter", s.name, far);
  assert_in_range(moved, p->N_fluid, 2 * p->N_fluid);
  ASSERT_OK(ParticlesDestroy(&p));

  { /* the same particles on a communicator of this rank only */
    MPI_Comm world   = PETSC_COMM_WORLD;
    PETSC_COMM_WORLD = PETSC_COMM_SELF;
    differ += ParticlesCreate(&s.scene, RADIUS * s.scene.dx, &p) ? 1 : 0;
    differ += ParticlesFill(&s.scene, s.walls, NULL, p) ? 1 : 0;
    CrowdGather(p, &alone);
    for (PetscInt k = 0; k < 2 * alone.n; k++) differ += alone.x[k] != some.x[k];
    differ += ParticlesDestroy(&p) ? 1 : 0;
    PETSC_COMM_WORLD = world;
  }
  CloudAssertNone("independent of ranks", s.name, differ);
  CrowdFree(&some);
  CrowdFree(&alone);
}

/* CellsFind() finds the same particles as a search over all local particles, for small and large
   radii. */
static void test_cells_find(void **state)
{
  const Setting s = CrowdBox("cells", 2, 14, 11, 1, 1, 3);
  Particles    *p;
  Cells         cells = {0};
  PetscInt      list[2000], wrong = 0;

  (void)state;
  ASSERT_OK(ParticlesCreate(&s.scene, RADIUS * s.scene.dx, &p));
  ASSERT_OK(ParticlesFill(&s.scene, s.walls, NULL, p));
  ASSERT_OK(CellsBuild(p, 0.26, &cells));
  for (PetscInt k = 0; k < 60; k++) {
    const PetscReal x[2]   = {0.4 + 1.5 * CrowdNoise(k, 0), 0.9 + 1.5 * CrowdNoise(k, 1)};
    const PetscReal radius = 0.02 + 0.3 * (k % 5);
    PetscInt        n      = 0, count;

    wrong += CellsFind(&cells, x, radius, 2000, list, &count) ? 1 : 0;
    for (PetscInt i = 0; i < ParticlesAll(p); i++) {
      if (PetscSqr(p->x[0][i] - x[0]) + PetscSqr(p->x[1][i] - x[1]) >= radius * radius) continue;
      wrong += n >= count || list[n] != i;
      n++;
    }
    wrong += n != count;
  }
  CloudAssertNone("found", s.name, wrong);
  ASSERT_OK(CellsFree(&cells));
  ASSERT_OK(ParticlesDestroy(&p));
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_walls),
      cmocka_unit_test(test_periodic),
      cmocka_unit_test(test_three_dimensions),
      cmocka_unit_test(test_more_ranks_than_particles),
      cmocka_unit_test(test_balance),
      cmocka_unit_test(test_jitter),
      cmocka_unit_test(test_cells_find),
  };
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
