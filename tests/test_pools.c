/*
  Fluid that does not fill the box at the start: places and volumes of dams, unions, drops and drops
  on a wall, and walls where no fluid is yet.
*/
/* RANKS: 1 3 */
#include "isph/start.h"
#include "crowd.h"

#define DX     0.1
#define RANGES 2.0 /* largest distance of pairs that are searched [dx] */

typedef struct {
  Setting       s;
  Particles    *p;
  All           all; /* positions of all ranks, fluid first */
  Neighbors    *nb;
  OperatorForms forms;
} Start;

/* Creates a box from (0, 0, 0) to (40, 30, 8) dx between walls, empty. */
static Scene *Tank(PetscInt dim, Start *start)
{
  Scene *scene;

  *start        = (Start){.s = CrowdBox("tank", dim, 40, 30, 8, 0, 0)};
  scene         = &start->s.scene;
  scene->jitter = 0.0;
  for (PetscInt a = 0; a < dim; a++) {
    scene->lo[a] = 0.0;
    scene->hi[a] = scene->cells[a] * DX;
  }
  return scene;
}

/* Fills a region: a circle, a box or a polygon, in 3D through the tank along z. */
static void Add(Scene *scene, const char shape[], PetscInt n, const PetscReal number[])
{
  const char *const names[3][2] = {{"circle", "cylinder"}, {"box", "box"}, {"polygon", "prism"}};
  const PetscReal   box[6]      = {
             number[0], number[1], scene->lo[2], number[2], n > 3 ? number[3] : 0.0, scene->hi[2]};
  const PetscInt  solid = scene->dim == 3 ? 1 : 0;
  const ShapeRow *row   = NULL;

  for (PetscInt k = 0; k < 3; k++)
    if (!strcmp(shape, names[k][0]))
      ASSERT_OK(TableWant(solid ? &SolidTable : &ShapeTable, "shape", names[k][solid], &row));
  if (solid && !strcmp(shape, "box"))
    assert_null(BodySet(scene, row, 6, box, SceneAddFilled(scene)));
  else assert_null(BodySet(scene, row, n, number, SceneAddFilled(scene)));
}

static void Fill(Start *start)
{
  OperatorForms *forms = &start->forms;
  const Scene   *scene = &start->s.scene;

  forms->h_over_dx = 1.5;
  forms->kernel    = (const KernelRow *)(const void *)TableGet(&KernelTable, 0);
  forms->h         = forms->h_over_dx * DX;
  forms->radius    = forms->kernel->support * forms->h;
  ASSERT_OK(ParticlesCreate(scene, forms->radius, &start->p));
  ASSERT_OK(ParticlesFill(scene, start->s.walls, NULL, start->p));
  ASSERT_OK(NeighborsCreate(forms->radius, DX, &start->nb));
  ASSERT_OK(NeighborsUpdate(start->p, 0.0, start->nb));
  CrowdGather(start->p, &start->all);
}

static void Empty(Start *start)
{
  CrowdFree(&start->all);
  ASSERT_OK(NeighborsDestroy(&start->nb));
  ASSERT_OK(ParticlesDestroy(&start->p));
}

static PetscReal SumOf(MPI_Comm comm, PetscReal value)
{
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPIU_REAL, MPI_SUM, comm);
  return value;
}

/* Returns the volume of the fluid particles with x in [low, high). */
static PetscReal VolumeBetween(const Start *start, PetscReal low, PetscReal high)
{
  const Particles *p   = start->p;
  PetscReal        sum = 0.0;

  for (PetscInt i = 0; i < p->n_fluid; i++)
    if (p->x[0][i] >= low && p->x[0][i] < high) sum += p->volume[i];
  return SumOf(p->comm, sum);
}

static void CheckVolume(const Start *start, const char *where, PetscReal low, PetscReal high,
                        PetscReal volume)
{
  CloudAssertNone("volume", where,
                  PetscAbsReal(VolumeBetween(start, low, high) / volume - 1.0) > 1e-3);
}

/* Returns the least distance of two fluid particles. */
static PetscReal Closest(const Start *start)
{
  const PetscInt dim  = start->p->dim;
  PetscReal      best = RANGES * DX;

  for (PetscInt i = 0; i < start->p->N_fluid; i++) {
    for (PetscInt j = 0; j < i; j++) {
      PetscReal r2 = 0.0;

      for (PetscInt a = 0; a < dim; a++)
        r2 += PetscSqr(start->all.x[dim * i + a] - start->all.x[dim * j + a]);
      best = PetscMin(best, PetscSqrtReal(r2));
    }
  }
  return best;
}

/* Returns the number of fluid particles less than a quarter of a spacing below the border. */
static PetscInt Shallow(const Start *start, PetscReal (*depth)(const PetscReal x[]))
{
  const Particles *p = start->p;
  PetscInt         n = 0;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal x[ISPH_MAX_DIM] = {p->x[0][i], p->x[1][i], p->dim == 3 ? p->x[2][i] : 0.0};

    n += depth(x) < 0.25 * DX;
  }
  return n;
}

/* A dam of 10 x 20 cells, half a cell off free borders and walls; in 3D all 8 layers between the
   walls at z. */
static void test_dam(void **state)
{
  const PetscReal box[4] = {0.0, 0.0, 1.0, 2.0};

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    const PetscInt layers = dim == 3 ? 8 : 1;
    PetscReal      least  = 1.0;
    PetscInt       off    = 0;
    Start          start;

    Add(Tank(dim, &start), "box", 4, box);
    Fill(&start);
    assert_int_equal(start.p->N_fluid, 10 * 20 * layers);
    for (PetscInt i = 0; i < start.p->N_fluid; i++) {
      const PetscReal *x = &start.all.x[dim * i], column = x[0] / DX - 0.5, row = x[1] / DX - 0.5;

      off += PetscAbsReal(column - PetscFloorReal(column + 0.5)) > 1e-9 ||
             PetscAbsReal(row - PetscFloorReal(row + 0.5)) > 1e-9;
      least = PetscMin(least, PetscMin(1.0 - x[0], 2.0 - x[1]));
    }
    CloudAssertNone("off the lattice", "dam", off);
    CloudAssertNone("below the border", "dam", PetscAbsReal(least - 0.5 * DX) > 1e-12);
    CheckVolume(&start, "dam", 0.0, 4.0, dim == 3 ? 1.6 : 2.0);
    Empty(&start);
  }
}

/* Every side of the tank has its wall particles, also where it is dry. */
static void test_walls(void **state)
{
  const PetscReal box[4] = {0.0, 0.0, 1.0, 2.0};

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    const PetscInt n[6] = {30, 30, 40, 40, 1200, 1200}, deep = dim == 3 ? 8 : 1;
    PetscReal      count[6] = {0.0};
    Start          start;

    Add(Tank(dim, &start), "box", 4, box);
    Fill(&start);
    for (PetscInt i = start.p->n_fluid; i < ParticlesOwn(start.p); i++)
      count[(PetscInt)start.p->side[i]] += 1.0;
    for (PetscInt side = 0; side < 2 * dim; side++)
      assert_int_equal((PetscInt)SumOf(start.p->comm, count[side]),
                       side < 4 ? n[side] * deep : n[side]);
    Empty(&start);
  }
}

static PetscReal StepDepth(const PetscReal x[])
{
  PetscReal corner = PetscSqrtReal(PetscSqr(x[0] - 1.0) + PetscSqr(x[1] - 0.5));

  if (x[0] > 1.0) return 0.5 - x[1];
  if (x[1] > 0.5) return PetscMin(1.0 - x[0], 2.0 - x[1]);
  return corner;
}

/* A column on a film: the union of two boxes has one lattice and no particle twice. */
static void test_step(void **state)
{
  const PetscReal column[4] = {-1.0, -1.0, 1.0, 2.0}, film[4] = {0.0, 0.0, 4.0, 0.5};
  PetscInt        jumps = 0;
  Start           start;

  (void)state;
  for (PetscInt jitter = 0; jitter < 2; jitter++) {
    Scene *scene = Tank(2, &start);

    scene->jitter = 0.2 * jitter;
    Add(scene, "box", 4, column);
    Add(scene, "box", 4, film);
    Fill(&start);
    CheckVolume(&start, "step", 0.0, 4.0, 3.5);
    CloudAssertNone("closest pair", "step", Closest(&start) < (jitter ? 0.4 : 0.9) * DX);
    for (PetscInt i = 0; i < start.p->N_fluid; i++) {
      const PetscReal *x = &start.all.x[2 * i], corner = PetscMax(x[0] - 1.0, x[1] - 0.5);

      jumps += corner > 1e-9 && StepDepth(x) < -1e-9;
    }
    CloudAssertNone("outside", "step", jumps);
    if (!jitter) CloudAssertNone("shallow", "step", Shallow(&start, StepDepth));
    Empty(&start);
  }
}

static PetscReal CircleDepth(const PetscReal x[])
{
  const PetscReal left  = PetscSqrtReal(PetscSqr(x[0] - 0.9) + PetscSqr(x[1] - 1.2)),
                  right = PetscSqrtReal(PetscSqr(x[0] - 2.9) + PetscSqr(x[1] - 1.6));

  return PetscMax(0.7 - left, 0.9 - right);
}

/* Two drops of different size have their own volumes; their particles are below the circles. */
static void test_drops(void **state)
{
  const PetscReal left[3] = {0.9, 1.2, 0.7}, right[3] = {2.9, 1.6, 0.9};
  Start           start;
  Scene          *scene = Tank(2, &start);

  (void)state;
  Add(scene, "circle", 3, left);
  Add(scene, "circle", 3, right);
  Fill(&start);
  CheckVolume(&start, "small drop", 0.0, 1.8, PETSC_PI * 0.49);
  CheckVolume(&start, "large drop", 1.8, 4.0, PETSC_PI * 0.81);
  CloudAssertNone("closest pair", "drops", Closest(&start) < 0.7 * DX);
  CloudAssertNone("shallow", "drops", Shallow(&start, CircleDepth));
  Empty(&start);
}

static PetscReal HalfDepth(const PetscReal x[])
{
  return 1.0 - PetscSqrtReal(PetscSqr(x[0] - 2.0) + PetscSqr(x[1]));
}

/* Half a drop on the floor, in 3D half a cylinder: its particles are below the circle. */
static void test_half_drop(void **state)
{
  const PetscReal circle[3] = {2.0, 0.0, 1.0};

  (void)state;
  for (PetscInt dim = 2; dim <= 3; dim++) {
    Start start;

    Add(Tank(dim, &start), "circle", 3, circle);
    Fill(&start);
    CheckVolume(&start, "half", 0.0, 4.0, PETSC_PI * (dim == 3 ? 0.4 : 0.5));
    CloudAssertNone("closest pair", "half", Closest(&start) < 0.65 * DX);
    CloudAssertNone("shallow", "half", Shallow(&start, HalfDepth));
    Empty(&start);
  }
}

static PetscReal DomeDepth(const PetscReal x[])
{
  return 0.7 - PetscSqrtReal(PetscSqr(x[0] - 2.0) + PetscSqr(x[1]) + PetscSqr(x[2] - 0.4));
}

/* A ball whose middle is on the floor, cut by both walls along z: the part in the box counts. */
static void test_dome(void **state)
{
  const PetscReal ball[4] = {2.0, 0.0, 0.4, 0.7}, z = 0.4;
  const ShapeRow *row;
  Start           start;
  Scene          *scene = Tank(3, &start);

  (void)state;
  ASSERT_OK(TableWant(&SolidTable, "shape", "ball", &row));
  assert_null(BodySet(scene, row, 4, ball, SceneAddFilled(scene)));
  Fill(&start);
  CheckVolume(&start, "dome", 0.0, 4.0, PETSC_PI * (0.49 * z - z * z * z / 3.0));
  CloudAssertNone("closest pair", "dome", Closest(&start) < 0.6 * DX);
  CloudAssertNone("shallow", "dome", Shallow(&start, DomeDepth));
  Empty(&start);
}

/* A puddle has a lattice although a drop hangs above it; joined by a bridge both are relaxed. */
static void test_pools(void **state)
{
  const PetscReal puddle[4] = {0.0, 0.0, 4.0, 0.75}, drop[3] = {2.0, 1.8, 0.6},
                  bridge[4] = {1.6, 0.5, 2.4, 1.6};
  Start start;

  (void)state;
  for (PetscInt joined = 0; joined < 2; joined++) {
    Scene   *scene = Tank(2, &start);
    PetscInt even  = 0;

    Add(scene, "box", 4, puddle);
    Add(scene, "circle", 3, drop);
    if (joined) Add(scene, "box", 4, bridge);
    Fill(&start);
    for (PetscInt i = 0; i < start.p->N_fluid; i++)
      even += PetscAbsReal(start.all.x[2 * i + 1] - 0.75 / 8.0 * 0.5) < 1e-12;
    CloudAssertNone("first layer", "pools", joined ? even == 40 : even != 40);
    CloudAssertNone("closest pair", "pools", Closest(&start) < 0.65 * DX);
    if (!joined)
      CloudAssertNone(
          "volume", "pools",
          PetscAbsReal(VolumeBetween(&start, 0.0, 4.0) / (3.0 + PETSC_PI * 0.36) - 1.0) > 1e-3);
    Empty(&start);
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_dam),       cmocka_unit_test(test_walls),
                                     cmocka_unit_test(test_step),      cmocka_unit_test(test_drops),
                                     cmocka_unit_test(test_half_drop), cmocka_unit_test(test_dome),
                                     cmocka_unit_test(test_pools)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
