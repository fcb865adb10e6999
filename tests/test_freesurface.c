/*
  Free surfaces: particles on the surface of discs and films are found and no others, their normals
  and curvatures converge to those of a circle, waves of any length have a curvature of their sign
  with surface tension, and a fragment of two particles is isolated. The end of a thin film on a
  wall is rough, and the film behind it is smooth. Rough particles that are too near are moved
  apart. Shifts carry no particle at the contact line over the dry wall. The sides of a jet begin at
  the opening where its fluid enters.
*/
/* RANKS: 1 3 */
#include "crowd.h"
#include "schemes/step.h"

typedef struct {
  Setting       s;
  Particles    *p;
  Neighbors    *nb;
  OperatorForms forms;
  FreeSurface   free;
} Pool;

/* Errors of normals and curvatures on a circle, largest over the surface. */
typedef struct {
  PetscReal normal, curvature;
} CircleError;

static void Fill(PetscReal jitter, Pool *pool)
{
  OperatorForms *forms = &pool->forms;
  Scene         *scene = &pool->s.scene;

  *forms        = (OperatorForms){.h_over_dx = 1.5};
  forms->kernel = (const KernelRow *)(const void *)TableGet(&KernelTable, 0);
  forms->h      = forms->h_over_dx * scene->dx;
  forms->radius = forms->kernel->support * forms->h;
  pool->free    = (FreeSurface){0};
  scene->jitter = jitter;
  ASSERT_OK(ParticlesCreate(scene, pool->s.walls, forms->radius, NULL, &pool->p));
  ASSERT_OK(NeighborsCreate(forms->radius, scene->dx, &pool->nb));
}

static void Find(Pool *pool)
{
  ASSERT_OK(NeighborsUpdate(pool->p, 0.0, pool->nb));
  ASSERT_OK(FreeSurfaceFind(&pool->s.scene, pool->p, pool->nb, &pool->forms, &pool->free));
}

static void Empty(Pool *pool)
{
  ASSERT_OK(FreeSurfaceFree(&pool->free));
  ASSERT_OK(NeighborsDestroy(&pool->nb));
  ASSERT_OK(ParticlesDestroy(&pool->p));
}

/* Returns the number of particles of a kind on all ranks that are on the surface, or are not. */
static PetscInt Count(const Pool *pool, SurfaceKind kind, PetscBool (*on)(const Pool *, PetscInt),
                      PetscBool is)
{
  PetscInt n = 0;

  for (PetscInt i = 0; i < pool->p->n_fluid; i++)
    n += pool->free.kind[i] == kind && on(pool, i) == is ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &n, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  return n;
}

static PetscReal Radius(const Particles *p, PetscInt i)
{
  return PetscSqrtReal(PetscSqr(p->x[0][i]) + PetscSqr(p->x[1][i]));
}

static PetscBool OnCircle(const Pool *pool, PetscInt i)
{
  return Radius(pool->p, i) > 1.0 - 0.3 * pool->s.scene.dx ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool OnTop(const Pool *pool, PetscInt i)
{
  const Scene *scene = &pool->s.scene;

  return pool->p->x[1][i] > scene->hi[1] - 0.3 * scene->dx ? PETSC_TRUE : PETSC_FALSE;
}

/* Fills a disc of radius 1 with n particles along it. */
static void Disc(PetscInt n, Pool *pool)
{
  Scene *scene;

  pool->s   = CrowdBox("disc", 2, 3 * n, 3 * n, 1, 2, 0);
  scene     = &pool->s.scene;
  scene->dx = 1.0 / n;
  for (PetscInt a = 0; a < 2; a++) {
    scene->lo[a] = -1.5;
    scene->hi[a] = 1.5;
  }
  SceneSetSides(scene, &BoundaryNone);
  scene->physics = PHYSICS_PRESSURE;
  BodyCircle(scene, 0.0, 0.0, 1.0, SceneAddFilled(scene));
  Fill(0.0, pool);
}

static CircleError ErrorOnCircle(const Pool *pool)
{
  const Particles *p     = pool->p;
  CircleError      error = {0.0, 0.0};

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal off = 0.0;

    if (pool->free.kind[i] != SURFACE_SMOOTH) continue;
    for (PetscInt a = 0; a < 2; a++)
      off += PetscSqr(pool->free.normal[2 * i + a] - p->x[a][i] / Radius(p, i));
    error.normal    = PetscMax(error.normal, PetscSqrtReal(off));
    error.curvature = PetscMax(error.curvature, PetscAbsReal(pool->free.curvature[i] - 1.0));
  }
  MPI_Allreduce(MPI_IN_PLACE, &error, 2, MPIU_REAL, MPI_MAX, PETSC_COMM_WORLD);
  return error;
}

static void test_disc(void **state)
{
  CircleError error[2];

  (void)state;
  for (PetscInt m = 0; m < 2; m++) {
    Pool pool;

    Disc(m ? 24 : 12, &pool);
    Find(&pool);
    CloudAssertNone("missed", "disc",
                    Count(&pool, SURFACE_SMOOTH, OnCircle, PETSC_TRUE) !=
                        (PetscInt)PetscFloorReal(2.0 * PETSC_PI * (m ? 24 : 12) + 0.5));
    CloudAssertNone("in the disc", "disc",
                    Count(&pool, SURFACE_INSIDE, OnCircle, PETSC_FALSE) +
                            Count(&pool, SURFACE_SMOOTH, OnCircle, PETSC_TRUE) !=
                        pool.p->N_fluid);
    error[m] = ErrorOnCircle(&pool);
    Empty(&pool);
  }
  CloudAssertNone("normal", "disc", error[1].normal > 1e-3);
  CloudAssertNone("curvature, of order 2", "disc", error[1].curvature > error[0].curvature / 3.0);
}

static void test_film(void **state)
{
  (void)state;
  for (PetscInt walls = 0; walls < 2; walls++) {
    for (PetscInt jitter = 0; jitter < 2; jitter++) {
      Pool pool;

      pool.s = CrowdBox("film", 2, 20, 9, 1, walls ? 0 : 1, 0);
      SceneSetSide(&pool.s.scene, 3, &BoundaryFree);
      Fill(0.2 * jitter, &pool);
      Find(&pool);
      CloudAssertNone("top", "film", Count(&pool, SURFACE_SMOOTH, OnTop, PETSC_TRUE) != 20);
      CloudAssertNone("below", "film", Count(&pool, SURFACE_INSIDE, OnTop, PETSC_FALSE) != 160);
      Empty(&pool);
    }
  }
}

static PetscBool Anywhere(const Pool *pool, PetscInt i)
{
  (void)pool;
  (void)i;
  return PETSC_TRUE;
}

/* Returns the change of the curvature in proportion to the disturbance a cos(m theta) of the radius
   of a disc, over m^2 a/R^2. */
static PetscReal Stiffness(PetscInt m, Pool *pool)
{
  const Particles *p      = pool->p;
  const PetscReal  a      = 1e-3 * pool->s.scene.dx;
  PetscReal        sum[2] = {0.0, 0.0};

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal r = Radius(p, i), angle = PetscAtan2Real(p->x[1][i], p->x[0][i]);

    if (!OnCircle(pool, i)) continue;
    for (PetscInt c = 0; c < 2; c++)
      p->x[c][i] *= (1.0 + a * PetscCosReal((PetscReal)m * angle)) / r;
  }
  ASSERT_OK(ParticlesUpdateEpoch(&pool->s.scene, pool->p, PETSC_TRUE, NULL));
  Find(pool);
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal wave = PetscCosReal((PetscReal)m * PetscAtan2Real(p->x[1][i], p->x[0][i]));

    if (pool->free.kind[i] != SURFACE_SMOOTH) continue;
    sum[0] += wave * (pool->free.curvature[i] - 1.0);
    sum[1] += wave * wave * (PetscReal)(m * m) * a;
  }
  MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD);
  return sum[0] / sum[1];
}

/* With surface tension the curvature of waves of any length has their sign, so that no wave grows;
   the shortest ones have none, and -0.027 with the weights of normals, docs/theory.md, (163). Long
   waves have it with an error of order 2, about (m dx/R)^2; kappa - 1/R = (m^2 - 1) a/R^2. */
static void test_stiffness(void **state)
{
  const PetscInt n = 12, on = 75; /* particles on the circle */

  (void)state;
  for (PetscInt m = 4; m <= on / 2; m++) {
    const PetscReal exact = 1.0 - 1.0 / (PetscReal)(m * m);
    PetscReal       stiffness;
    Pool            pool;

    Disc(n, &pool);
    pool.free.tension = 1.0;
    stiffness         = Stiffness(m, &pool);
    CloudAssertNone("wrong sign", "disc", stiffness < -1e-3);
    if (m == 4)
      CloudAssertNone("stiffness of a long wave", "disc",
                      PetscAbsReal(stiffness / exact - 1.0) >
                          1.1 * PetscSqr((PetscReal)m / (PetscReal)n));
    Empty(&pool);
  }
}

/* Two particles far from the disc. */
static void test_isolated(void **state)
{
  Pool pool;

  (void)state;
  Disc(12, &pool);
  for (PetscInt i = 0; i < pool.p->n_fluid; i++) {
    if (pool.p->id[i] > 1) continue;
    pool.p->x[0][i] = 1.4;
    pool.p->x[1][i] = 1.4 + (PetscReal)pool.p->id[i] / 12.0;
  }
  ASSERT_OK(ParticlesUpdateEpoch(&pool.s.scene, pool.p, PETSC_TRUE, NULL));
  Find(&pool);
  CloudAssertNone("isolated", "fragment",
                  Count(&pool, SURFACE_ISOLATED, Anywhere, PETSC_TRUE) != 2);
  Empty(&pool);
}

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
  Fill(0.0, pool);
  for (PetscInt i = 0; i < pool->p->n_fluid; i++)
    pool->p->x[1][i] = scene->lo[1] + share * (pool->p->x[1][i] - scene->lo[1]);
  ASSERT_OK(ParticlesUpdateEpoch(scene, pool->p, PETSC_TRUE, NULL));
  Find(pool);
}

/* The end of a film of 1.5 dx has no smooth particle, and the film behind it no rough one. The end
   of a film of 2.5 dx is no nose: its vertical front is smooth. */
static void test_nose(void **state)
{
  Pool pool;

  (void)state;
  Film(0.6, &pool);
  CloudAssertNone("smooth", "end of a film of 1.5 dx",
                  Count(&pool, SURFACE_SMOOTH, AtEnd, PETSC_TRUE));
  CloudAssertNone("not smooth", "film of 1.5 dx",
                  Count(&pool, SURFACE_SMOOTH, BehindNose, PETSC_TRUE) < FILM - 9);
  CloudAssertNone("rough", "film of 1.5 dx", Count(&pool, SURFACE_ROUGH, BehindNose, PETSC_TRUE));
  Empty(&pool);
  Film(1.0, &pool);
  CloudAssertNone("rough", "film of 2.5 dx", Count(&pool, SURFACE_ROUGH, BehindNose, PETSC_TRUE));
  CloudAssertNone("no smooth particle", "end of a film of 2.5 dx",
                  Count(&pool, SURFACE_SMOOTH, AtEnd, PETSC_TRUE) == 0);
  Empty(&pool);
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
  Empty(&pool);
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
  Find(pool);
}

/* Returns true if own particle i is smooth and at the contact line on the floor. The other end of
   the film has a contact line on a wall. */
static PetscBool AtFloor(const Flow *flow, PetscInt i)
{
  const Particles   *p    = flow->particles;
  const FreeSurface *free = flow->ops->free;
  const PetscReal    half = flow->scene->lo[0] + 0.5 * FILM * p->dx[i];

  return free->contact[i] && free->kind[i] == SURFACE_SMOOTH && p->x[0][i] > half;
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
  Empty(&pool);
}

#define JET   3.0  /* radius of the opening of a jet [dx] */
#define SWELL 1.08 /* of its radius below the opening */

/* Returns the distance of own particle i from the axis of the jet [dx]. */
static PetscReal FromAxis(const Pool *pool, PetscInt i)
{
  const Scene *scene = &pool->s.scene;
  PetscReal    r2    = 0.0;

  for (PetscInt a = 0; a < 3; a += 2)
    r2 += PetscSqr(pool->p->x[a][i] - 0.5 * (scene->lo[a] + scene->hi[a]));
  return PetscSqrtReal(r2) / scene->dx;
}

/* Returns true if own particle i is in the first row of the jet or in the second one. */
static PetscBool IsFirst(const Pool *pool, PetscInt i)
{
  return pool->s.scene.hi[1] - pool->p->x[1][i] < 2.0 * pool->s.scene.dx ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool AtRim(const Pool *pool, PetscInt i)
{
  return IsFirst(pool, i) && FromAxis(pool, i) > SWELL * (JET - 0.6) ? PETSC_TRUE : PETSC_FALSE;
}

static PetscBool InJet(const Pool *pool, PetscInt i)
{
  return IsFirst(pool, i) && FromAxis(pool, i) < SWELL * (JET - 1.0) ? PETSC_TRUE : PETSC_FALSE;
}

/* Creates a round jet that swells below an opening, with its first row at a depth [dx]. */
static void Jet(PetscReal depth, Pool *pool)
{
  const BoundaryRow *inflow;
  const ShapeRow    *circle;
  Scene             *scene;
  PetscInt          *list, n = 0;

  pool->s = CrowdBox("rim", 3, 14, 10, 14, 0, 0);
  scene   = &pool->s.scene;
  ASSERT_OK(TableWant(&BoundaryTable, "boundary", "inflow", &inflow));
  ASSERT_OK(TableWant(&ShapeTable, "shape", "circle", &circle));
  SceneSetSide(scene, 3, inflow);
  scene->motion = (const MotionRow *)(const void *)TableGet(&MotionTable, 0); /* lagrangian */
  assert_null(BodySet(scene, circle, 3,
                      (PetscReal[]){0.5 * (scene->lo[0] + scene->hi[0]),
                                    0.5 * (scene->lo[2] + scene->hi[2]), JET * scene->dx},
                      &scene->boundary[3].hole));
  Fill(0.0, pool);
  ASSERT_OK(PetscMalloc1(pool->p->n_fluid, &list));
  for (PetscInt i = 0; i < pool->p->n_fluid; i++) {
    pool->p->x[1][i] -= (depth - 0.5) * scene->dx;
    if (FromAxis(pool, i) > JET || pool->p->x[1][i] < scene->lo[1] + 3.0 * scene->dx) list[n++] = i;
    for (PetscInt a = 0; a < 3; a += 2) {
      const PetscReal axis = 0.5 * (scene->lo[a] + scene->hi[a]);

      pool->p->x[a][i] = axis + SWELL * (pool->p->x[a][i] - axis);
    }
  }
  ASSERT_OK(ParticlesRemove(scene, pool->p, n, list));
  ASSERT_OK(PetscFree(list));
  ASSERT_OK(ParticlesUpdateEpoch(scene, pool->p, PETSC_TRUE, NULL));
  Find(pool);
}

/* Before a row of fluid enters, the row before it is up to 1.5 dx below the opening. Its particles
   at the side of the jet are on the surface, and those near the axis are inside. */
static void test_rim(void **state)
{
  (void)state;
  for (PetscInt k = 2; k < 6; k++) {
    Pool pool;

    Jet(0.25 * k, &pool);
    CloudAssertNone("inside", "at the side of a jet",
                    Count(&pool, SURFACE_INSIDE, AtRim, PETSC_TRUE));
    CloudAssertNone("smooth", "inside a jet", Count(&pool, SURFACE_SMOOTH, InJet, PETSC_TRUE));
    CloudAssertNone("rough", "inside a jet", Count(&pool, SURFACE_ROUGH, InJet, PETSC_TRUE));
    CloudAssertNone("no particle", "inside a jet",
                    Count(&pool, SURFACE_INSIDE, InJet, PETSC_TRUE) == 0);
    Empty(&pool);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_disc),         cmocka_unit_test(test_film),
      cmocka_unit_test(test_stiffness),    cmocka_unit_test(test_isolated),
      cmocka_unit_test(test_nose),         cmocka_unit_test(test_separate),
      cmocka_unit_test(test_contact_line), cmocka_unit_test(test_rim)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
