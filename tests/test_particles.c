/*
  Identities of particles and neighbours on any number of ranks: no particle is lost, fields follow
  their particles, copies sit at owner plus shift, and rows equal brute force over all particles and
  periodic images.
*/
/* RANKS: 1 2 3 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include "isph/particles.h"

#define RADIUS 2.6 /* [dx] */

static const CaseRow problem = {.name = "test", .brief = "", .citation = ""};

/* A scene of spacing 0.1 with its walls. */
typedef struct {
  const char   *name;
  Scene         scene;
  WallPlacement walls;
} Setting;

static Setting Box(const char *name, PetscInt dim, PetscInt nx, PetscInt ny, PetscInt nz,
                   PetscInt n_periodic, PetscInt layers)
{
  Setting        s     = {.name = name, .walls = {.layers = layers}};
  const PetscInt n[3]  = {nx, ny, nz};
  Scene         *scene = &s.scene;

  scene->problem = &problem;
  scene->physics = PHYSICS_PRESSURE | (n_periodic < dim ? PHYSICS_WALLS : 0);
  scene->dim     = dim;
  scene->n       = nx;
  scene->dx      = 0.1;
  scene->jitter  = 0.2;
  scene->seed    = 7;
  for (PetscInt a = 0; a < dim; a++) {
    scene->lo[a]       = -0.3 + 0.7 * a;
    scene->hi[a]       = scene->lo[a] + n[a] * scene->dx;
    scene->cells[a]    = n[a];
    scene->periodic[a] = a < n_periodic;
  }
  return s;
}

/* Positions of all particles of all ranks by id, for tests only. */
typedef struct {
  PetscInt   n;
  PetscReal *x;     /* x[dim id + a] */
  PetscReal *found; /* number of occurrences of each id */
} All;

static void GatherAll(const Particles *p, All *all)
{
  all->n = p->N_fluid + p->N_wall;
  PetscCallVoid(PetscCalloc2(all->n * p->dim, &all->x, all->n, &all->found));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    all->found[p->id[i]] += 1.0;
    for (PetscInt a = 0; a < p->dim; a++) all->x[p->dim * p->id[i] + a] = p->x[a][i];
  }
  MPI_Allreduce(MPI_IN_PLACE, all->x, (int)(all->n * p->dim), MPIU_REAL, MPI_SUM, p->comm);
  MPI_Allreduce(MPI_IN_PLACE, all->found, (int)all->n, MPIU_REAL, MPI_SUM, p->comm);
}

/* Fails on all ranks if any rank has something wrong; otherwise the other ranks would hang. */
static void AssertNone(const char *what, const char *where, PetscInt wrong)
{
  MPI_Allreduce(MPI_IN_PLACE, &wrong, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  if (wrong) print_error("%s: %s: %d wrong\n", where, what, (int)wrong);
  assert_int_equal(wrong, 0);
}
#define ASSERT_OK(call) AssertNone(#call, "PETSc", (call) ? 1 : 0)

/* Returns a fixed pseudo-random number in (-1, 1) for each particle and k. */
static PetscReal Noise(PetscInt id, PetscInt k)
{
  const PetscReal s = PetscSinReal(12.9898 * (id + 1) + 78.233 * (k + 1)) * 43758.5453;
  return 2.0 * (s - PetscFloorReal(s)) - 1.0;
}

/* Moves each fluid particle by at most `length` along each axis and keeps it inside the walls. */
static void Move(const Scene *scene, Particles *p, PetscReal length)
{
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal margin = 0.3 * scene->dx;

      p->x[a][i] += length * Noise(p->id[i], a);
      if (scene->periodic[a]) continue;
      p->x[a][i] = PetscMin(PetscMax(p->x[a][i], scene->lo[a] + margin), scene->hi[a] - margin);
    }
  }
}

static PetscReal TagOf(PetscInt id, PetscInt c)
{
  return 3.0 * id + 0.25 * c;
}

/* Checks that ids occur once, numbers ascend, fields follow and copies sit at owner plus shift. */
static void CheckParticles(const Setting *s, const Particles *p, PetscReal *const tag[])
{
  const PetscInt own = ParticlesOwn(p), dim = p->dim;
  PetscInt       lost = 0, strayed = 0, misplaced = 0, kinds = 0, unordered = 0, count[2];
  PetscReal     *numbered;
  All            all;

  GatherAll(p, &all);
  PetscCallVoid(PetscCalloc1(all.n, &numbered));
  for (PetscInt k = 0; k < all.n; k++) lost += all.found[k] != 1.0;
  for (PetscInt i = 0; i < own; i++) {
    numbered[p->row[i] + (i < p->n_fluid ? 0 : p->N_fluid)] += 1.0;
    unordered +=
        p->row[i] != (i < p->n_fluid ? p->fluid_start + i : p->wall_start + i - p->n_fluid);
  }
  MPI_Allreduce(MPI_IN_PLACE, numbered, (int)all.n, MPIU_REAL, MPI_SUM, p->comm);
  for (PetscInt k = 0; k < all.n; k++) lost += numbered[k] != 1.0;
  for (PetscInt i = 0; i < ParticlesAll(p); i++) {
    kinds += ParticlesIsWall(p, i) != (p->kind[i] == PARTICLE_WALL);
    for (PetscInt c = 0; c < 2; c++) strayed += tag[c][i] != TagOf(p->id[i], c);
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal shift = i < own ? 0.0 : p->halo_shift[a][i - own];
      const PetscReal error = p->x[a][i] - all.x[dim * p->id[i] + a] - shift;

      misplaced += PetscAbsReal(error) > 1e-13;
      if (!s->scene.periodic[a]) misplaced += shift != 0.0;
    }
  }
  count[0] = p->n_fluid;
  count[1] = p->n_wall;
  MPI_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT, MPI_SUM, p->comm);
  PetscCallVoid(PetscFree(numbered));
  PetscCallVoid(PetscFree2(all.x, all.found));
  AssertNone("ids and numbers occur once", s->name, lost);
  AssertNone("numbers ascend", s->name, unordered);
  AssertNone("fields follow", s->name, strayed);
  AssertNone("halo is owner plus shift", s->name, misplaced);
  AssertNone("fluid or wall", s->name, kinds);
  AssertNone("counts", s->name, (count[0] != p->N_fluid) + (count[1] != p->N_wall));
}

/* Compares row i with all particles and images, by count and by a sum weighted with ids. */
static PetscInt RowErrors(const Scene *scene, const Particles *p, const Neighbors *nb,
                          const All *all, PetscInt i)
{
  const PetscInt dim   = p->dim;
  PetscInt       wrong = 0, close = 0, in_row = 0, reach[3] = {0, 0, 0};
  PetscReal      sum_row = 0.0, sum_all = 0.0;

  for (PetscInt k = nb->row[i]; k < nb->row[i + 1]; k++) {
    const PetscInt j  = nb->col[k];
    PetscReal      r2 = 0.0;

    wrong += j == i || (k > nb->row[i] && nb->col[k - 1] >= j);
    for (PetscInt a = 0; a < dim; a++) r2 += PetscSqr(p->x[a][j] - p->x[a][i]);
    if (r2 >= PetscSqr(nb->radius)) continue;
    in_row++;
    sum_row += PetscSqrtReal(r2) * (1 + p->id[j]);
  }
  for (PetscInt a = 0; a < dim; a++) {
    if (scene->periodic[a]) reach[a] = 2 + (PetscInt)(nb->radius / (scene->hi[a] - scene->lo[a]));
  }
  for (PetscInt id = 0; id < all->n; id++) {
    for (PetscInt c2 = -reach[2]; c2 <= reach[2]; c2++) {
      for (PetscInt c1 = -reach[1]; c1 <= reach[1]; c1++) {
        for (PetscInt c0 = -reach[0]; c0 <= reach[0]; c0++) {
          const PetscInt image[3] = {c0, c1, c2};
          PetscReal      r2       = 0.0;

          if (id == p->id[i] && !c0 && !c1 && !c2) continue;
          for (PetscInt a = 0; a < dim; a++) {
            r2 += PetscSqr(all->x[dim * id + a] + image[a] * (scene->hi[a] - scene->lo[a]) -
                           p->x[a][i]);
          }
          if (r2 >= PetscSqr(nb->radius)) continue;
          close++;
          sum_all += PetscSqrtReal(r2) * (1 + id);
        }
      }
    }
  }
  wrong += close != in_row || PetscAbsReal(sum_row - sum_all) > 1e-10 * (1.0 + sum_all);
  return wrong;
}

static void CheckNeighbors(const Setting *s, const Particles *p, const Neighbors *nb)
{
  PetscInt wrong = 0;
  All      all;

  GatherAll(p, &all);
  for (PetscInt i = 0; i < p->n_fluid; i++) wrong += RowErrors(&s->scene, p, nb, &all, i);
  PetscCallVoid(PetscFree2(all.x, all.found));
  AssertNone("rows equal brute force", s->name, wrong);
}

/* Checks normals, depths and sides of own and copied wall particles. */
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
      if (s->scene.periodic[a]) continue;
      wrong +=
          p->depth[i] < PetscMax(s->scene.lo[a] - p->x[a][i], p->x[a][i] - s->scene.hi[a]) - 1e-12;
    }
  }
  AssertNone("walls", s->name, wrong);
}

/* Moves by `step` [dx] and checks particles and neighbours after each move. */
static void Follow(const Setting *s, PetscReal step, PetscInt n_steps)
{
  const Scene *scene = &s->scene;
  Particles   *p;
  Neighbors   *nb;
  PetscReal   *tag[2];
  PetscInt     starts = 0;

  ASSERT_OK(ParticlesCreate(scene, s->walls, RADIUS * scene->dx, NULL, &p));
  ASSERT_OK(NeighborsCreate(RADIUS * scene->dx, &nb));
  ASSERT_OK(ParticlesRegister(p, "tag", 2, HALO_EPOCH, tag));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    for (PetscInt c = 0; c < 2; c++) tag[c][i] = TagOf(p->id[i], c);
  }
  ASSERT_OK(ParticlesUpdateEpoch(scene, p, PETSC_TRUE, NULL));
  CheckWalls(s, p);
  for (PetscInt k = 0; k < n_steps; k++) {
    PetscBool started;

    ASSERT_OK(NeighborsUpdate(p, step * scene->dx, nb));
    CheckParticles(s, p, tag);
    CheckNeighbors(s, p, nb);
    Move(scene, p, step * scene->dx);
    ASSERT_OK(ParticlesUpdateEpoch(scene, p, PETSC_FALSE, &started));
    if (!started) ASSERT_OK(ParticlesUpdateHalo(p));
    starts += started;
  }
  CheckWalls(s, p);
  AssertNone("epochs started", s->name, step * n_steps > 4.0 && starts == 0);
  AssertNone("a margin saved searches", s->name, step < 0.02 && nb->builds > n_steps / 4);
  ASSERT_OK(NeighborsDestroy(&nb));
  ASSERT_OK(ParticlesDestroy(&p));
}

static void test_walls(void **state)
{
  const Setting layers = Box("2D layers", 2, 24, 17, 1, 0, 3);
  const Setting plane  = Box("2D plane", 2, 24, 17, 1, 0, 0);
  Setting       both   = Box("2D plane and layers", 2, 24, 17, 1, 0, 3);

  (void)state;
  both.walls.surface = PETSC_TRUE;
  Follow(&both, 0.7, 5);
  Follow(&layers, 0.7, 10);
  Follow(&plane, 0.7, 10);
  Follow(&layers, 0.01, 30);
}

static void test_periodic(void **state)
{
  const Setting both    = Box("2D periodic", 2, 20, 20, 1, 2, 0);
  const Setting channel = Box("2D channel", 2, 13, 20, 1, 1, 3);
  const Setting narrow  = Box("2D short period", 2, 4, 30, 1, 1, 3);
  const Setting tiny    = Box("2D periods shorter than the radius", 2, 2, 3, 1, 2, 0);

  (void)state;
  Follow(&both, 0.7, 10);
  Follow(&both, 0.05, 12);
  Follow(&channel, 0.7, 10);
  Follow(&narrow, 0.7, 10);
  Follow(&tiny, 0.7, 10);
}

static void test_three_dimensions(void **state)
{
  const Setting mixed  = Box("3D channel", 3, 7, 8, 9, 2, 3);
  const Setting cavity = Box("3D cavity", 3, 7, 8, 6, 0, 2);
  const Setting plane  = Box("3D plane", 3, 7, 8, 6, 1, 0);

  (void)state;
  Follow(&mixed, 0.7, 7);
  Follow(&cavity, 0.7, 7);
  Follow(&plane, 0.7, 7);
}

static void test_more_ranks_than_particles(void **state)
{
  const Setting one = Box("one particle", 2, 1, 1, 1, 0, 3);
  const Setting two = Box("two particles", 2, 2, 1, 1, 2, 0);

  (void)state;
  Follow(&one, 0.7, 5);
  Follow(&two, 0.7, 10);
}

static void test_balance(void **state)
{
  const Setting s = Box("balance", 2, 100, 100, 1, 0, 3);
  Particles    *p;
  PetscMPIInt   ranks;

  (void)state;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  ASSERT_OK(ParticlesCreate(&s.scene, s.walls, RADIUS * s.scene.dx, NULL, &p));
  for (PetscInt k = 0; k < 4; k++) {
    PetscInt most = p->n_fluid;

    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_INT, MPI_MAX, p->comm);
    AssertNone("max / mean of fluid", s.name, (double)most * ranks > 1.1 * p->N_fluid);
    for (PetscInt i = 0; i < p->n_fluid; i++) { /* the flow is compressed towards a corner */
      p->x[0][i] = s.scene.lo[0] + 0.6 * (p->x[0][i] - s.scene.lo[0]);
      p->x[1][i] = s.scene.lo[1] + 0.8 * (p->x[1][i] - s.scene.lo[1]);
    }
    ASSERT_OK(ParticlesUpdateEpoch(&s.scene, p, PETSC_FALSE, NULL));
  }
  ASSERT_OK(ParticlesDestroy(&p));
}

/* Positions stay within the jitter of the lattice and do not depend on the number of ranks. */
static void test_jitter(void **state)
{
  Setting     s = Box("jitter", 2, 16, 12, 1, 1, 3);
  Particles  *p;
  All         some, alone;
  PetscInt    far = 0, differ = 0, moved = 0;
  PetscMPIInt rank;

  (void)state;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  ASSERT_OK(ParticlesCreate(&s.scene, s.walls, RADIUS * s.scene.dx, NULL, &p));
  GatherAll(p, &some);
  for (PetscInt id = 0; id < p->N_fluid; id++) {
    const PetscInt cell[2] = {id % 16, id / 16};
    for (PetscInt a = 0; a < 2; a++) {
      PetscReal d = some.x[2 * id + a] - s.scene.lo[a] - (cell[a] + 0.5) * s.scene.dx;
      if (a == 0) d -= 1.6 * PetscFloorReal(d / 1.6 + 0.5);
      far += PetscAbsReal(d) > 0.2 * s.scene.dx + 1e-14;
      moved += PetscAbsReal(d) > 0.02 * s.scene.dx;
    }
  }
  AssertNone("within jitter", s.name, far);
  assert_in_range(moved, p->N_fluid, 2 * p->N_fluid);
  ASSERT_OK(ParticlesDestroy(&p));

  { /* the same particles on a communicator of this rank only */
    MPI_Comm world   = PETSC_COMM_WORLD;
    PETSC_COMM_WORLD = PETSC_COMM_SELF;
    differ += ParticlesCreate(&s.scene, s.walls, RADIUS * s.scene.dx, NULL, &p) ? 1 : 0;
    GatherAll(p, &alone);
    for (PetscInt k = 0; k < 2 * alone.n; k++) differ += alone.x[k] != some.x[k];
    differ += ParticlesDestroy(&p) ? 1 : 0;
    PETSC_COMM_WORLD = world;
  }
  AssertNone("independent of ranks", s.name, differ);
  PetscCallVoid(PetscFree2(some.x, some.found));
  PetscCallVoid(PetscFree2(alone.x, alone.found));
}

/* A search around a point equals brute force over local particles, for small and large radii. */
static void test_cells_find(void **state)
{
  const Setting s = Box("cells", 2, 14, 11, 1, 1, 3);
  Particles    *p;
  Cells         cells = {0};
  PetscInt      list[2000], wrong = 0;

  (void)state;
  ASSERT_OK(ParticlesCreate(&s.scene, s.walls, RADIUS * s.scene.dx, NULL, &p));
  ASSERT_OK(CellsBuild(p, 0.26, &cells));
  for (PetscInt k = 0; k < 60; k++) {
    const PetscReal x[2]   = {0.4 + 1.5 * Noise(k, 0), 0.9 + 1.5 * Noise(k, 1)};
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
  AssertNone("found", s.name, wrong);
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
