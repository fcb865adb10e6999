/*
  Ends of films on a wall: that of a thin film is rough, and the film behind it is smooth. Rough
  particles that are too near are moved apart. Shifts carry no particle at the contact line over the
  dry wall.
*/
/* RANKS: 1 3 */
#include "pool.h"
#include "isph/motion.h"

#define FILM 18 /* length of the film [dx] */

/* Returns true if particle i is at most 2.1 dx from the end of the film. A top particle there is
   nearer than 2.5 dx to the lowest one at the end, which is 1.2 dx deeper. */
static PetscBool AtEnd(const Pool *pool, PetscInt i)
{
  const Scene *scene = &pool->s.scene;

  return pool->p->x[0][i] > scene->lo[0] + (FILM - 2.1) * scene->dx ? PETSC_TRUE : PETSC_FALSE;
}

/* Returns true if particle i is behind the nose and away from the other end, which touches a wall:
   a nose ends 2.4 + 2.5 dx from the wall that is not touched, which begins 1.3 dx from the film. */
static PetscBool BehindNose(const Pool *pool, PetscInt i)
{
  const Scene    *scene = &pool->s.scene;
  const PetscReal x     = (pool->p->x[0][i] - scene->lo[0]) / scene->dx;

  return x > 3.0 && x < FILM - 4.9 ? PETSC_TRUE : PETSC_FALSE;
}

/* Sets the filled region: a box from beyond the corner of the walls to the end of the film. */
static void SetFilmRegion(Scene *scene)
{
  const PetscReal left = scene->lo[0] - scene->dx, right = scene->lo[0] + FILM * scene->dx;
  const PetscReal below = scene->lo[1] - scene->dx, top = scene->lo[1] + 2.5 * scene->dx;
  const PetscReal x[] = {left, below, right, below, right, top, left, top};

  assert_null(BodyPolygon(scene, 4, x, SceneAddFilled(scene)));
}

/* A film of three layers that ends on the floor, pressed to the thickness 2.5 share dx. */
static void Film(PetscReal share, Pool *pool)
{
  Scene *scene;

  pool->s = CrowdBox("nose", 2, 30, 12, 1, 0, 0);
  scene   = &pool->s.scene;
  SceneSetSide(scene, 3, &BoundaryNone);
  SetFilmRegion(scene);
  PoolFill(0.0, pool);
  for (PetscInt i = 0; i < pool->p->n_fluid; i++)
    pool->p->x[1][i] = scene->lo[1] + share * (pool->p->x[1][i] - scene->lo[1]);
  ASSERT_OK(ParticlesUpdateEpoch(scene, pool->p, PETSC_TRUE, NULL));
  PoolFind(pool);
}

/* The end of a film of 1.5 dx has no smooth particle, and the film behind it no rough one. The end
   of a film of 2.5 dx is no nose: its vertical front is smooth. */
static void test_nose(void **state)
{
  Pool pool;

  (void)state;
  Film(0.6, &pool);
  CloudAssertNone("smooth", "end of a film of 1.5 dx",
                  PoolCount(&pool, SURFACE_SMOOTH, AtEnd, PETSC_TRUE));
  CloudAssertNone("not smooth", "film of 1.5 dx",
                  PoolCount(&pool, SURFACE_SMOOTH, BehindNose, PETSC_TRUE) < FILM - 9);
  CloudAssertNone("rough", "film of 1.5 dx",
                  PoolCount(&pool, SURFACE_ROUGH, BehindNose, PETSC_TRUE));
  PoolEmpty(&pool);
  Film(1.0, &pool);
  CloudAssertNone("rough", "film of 2.5 dx",
                  PoolCount(&pool, SURFACE_ROUGH, BehindNose, PETSC_TRUE));
  CloudAssertNone("no smooth particle", "end of a film of 2.5 dx",
                  PoolCount(&pool, SURFACE_SMOOTH, AtEnd, PETSC_TRUE) == 0);
  PoolEmpty(&pool);
}

/* Compares the displacements of a pressed film, whose layers are 0.6 dx apart. Rough particles are
   moved apart to 0.7 dx: those of the outer layers have a neighbour on one side and move by half of
   0.1 dx. Returns the largest displacement. */
static PetscReal TryApart(Pool *pool, PetscReal apart[])
{
  const PetscReal dx      = pool->s.scene.dx;
  Operators       ops     = {.free = &pool->free};
  const Flow      flow    = {.particles = pool->p, .neighbors = pool->nb, .ops = &ops};
  PetscReal       largest = 0.0;

  FlowSeparate(&flow, apart);
  for (PetscInt i = 0; i < pool->p->n_fluid; i++) {
    const PetscInt  layer = (PetscInt)((pool->p->x[1][i] - pool->s.scene.lo[1]) / (0.6 * dx));
    const PetscReal along =
        pool->free.kind[i] == SURFACE_ROUGH ? 0.05 * dx * (PetscReal)(layer - 1) : 0.0;

    largest = PetscMax(largest, PetscAbsReal(along));
    assert_true(PetscAbsReal(apart[2 * i]) < 1e-12 * dx);
    assert_true(PetscAbsReal(apart[2 * i + 1] - along) < 1e-12 * dx);
  }
  return largest;
}

/* Rough particles of the nose of a film move apart, smooth ones and those inside stay. */
static void test_separate(void **state)
{
  Pool       pool;
  PetscReal *apart, largest;

  (void)state;
  Film(0.6, &pool);
  ASSERT_OK(PetscMalloc1(2 * pool.p->n_fluid, &apart));
  largest = TryApart(&pool, apart);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD);
  CloudAssertNone("rough particle", "film of 1.5 dx", largest == 0.0);
  ASSERT_OK(PetscFree(apart));
  PoolEmpty(&pool);
}

#define LEAN 0.3 /* of the end of a film, over its height */

/* A film of three layers whose end leans back. */
static void LeaningFilm(Pool *pool)
{
  const Scene *scene = &pool->s.scene;

  Film(1.0, pool);
  for (PetscInt i = 0; i < pool->p->n_fluid; i++)
    pool->p->x[0][i] -= LEAN * (pool->p->x[1][i] - scene->lo[1]) *
                        (pool->p->x[0][i] - scene->lo[0]) / (FILM * scene->dx);
  ASSERT_OK(ParticlesUpdateEpoch(scene, pool->p, PETSC_TRUE, NULL));
  PoolFind(pool);
}

/* Returns true if own particle i is smooth and at the contact line on the floor. The other end of
   the film has a contact line on a wall. */
static PetscBool AtFloor(const Flow *flow, PetscInt i)
{
  const Particles   *p    = flow->particles;
  const FreeSurface *free = flow->ops->free;
  const PetscReal    half = flow->scene->lo[0] + 0.5 * FILM * p->dx[i];

  return free->at_contact_line[i] && free->kind[i] == SURFACE_SMOOTH && p->x[0][i] > half;
}

/* Returns true if a shift of own particle i along the floor is limited wrongly. A smooth particle
   keeps its part along the surface, one at the contact line only a shift into the film. Rough
   particles only move apart and do not count. */
static PetscBool IsLimitedWrongly(const Flow *flow, PetscInt i, PetscReal along)
{
  const FreeSurface *free = flow->ops->free;
  const PetscReal   *n = &free->normal[2 * i], none[2] = {0.0, 0.0};
  const PetscReal    normal  = free->kind[i] == SURFACE_SMOOTH ? along * n[0] : 0.0;
  PetscReal          shift[] = {along, 0.0}, wanted[2] = {along - normal * n[0], -normal * n[1]};

  if (FreeSurfaceIsRough(free, i)) return PETSC_FALSE;
  if (AtFloor(flow, i) && along > 0.0) wanted[0] = 0.0;
  FlowLimitShift(flow, none, i, shift);
  return PetscAbsReal(shift[0] - wanted[0]) + PetscAbsReal(shift[1] - wanted[1]) >
         1e-12 * flow->particles->dx[i];
}

/* Shifts do not lengthen a film over the dry floor before it. */
static void test_contact_line(void **state)
{
  Pool      pool;
  Operators ops      = {.free = &pool.free};
  Scheme    scheme   = {0};
  Clock     clock    = {.dt = 1.0};
  Flow      flow     = {.ops = &ops, .scheme = &scheme, .clock = &clock};
  PetscInt  count[2] = {0, 0}; /* particles at the contact line, wrong shifts */

  (void)state;
  LeaningFilm(&pool);
  flow.scene             = &pool.s.scene;
  flow.particles         = pool.p;
  flow.neighbors         = pool.nb;
  scheme.stats.speed_max = pool.s.scene.dx;
  for (PetscInt i = 0; i < pool.p->n_fluid; i++) {
    count[0] += AtFloor(&flow, i) ? 1 : 0;
    for (PetscInt way = -1; way < 2; way += 2)
      count[1] += IsLimitedWrongly(&flow, i, 0.1 * (PetscReal)way * pool.s.scene.dx) ? 1 : 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  CloudAssertNone("no contact line", "film of 2.5 dx", count[0] == 0);
  CloudAssertNone("shifts", "film of 2.5 dx", count[1]);
  PoolEmpty(&pool);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_nose), cmocka_unit_test(test_separate),
                                     cmocka_unit_test(test_contact_line)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
