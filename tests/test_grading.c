/*
  Isotropic grading (-spacing, -spacing_growth): the spacing as a function of place, and the cloud
  of particles relaxed to it: distances, numbers of neighbours, ordered rows along walls, volumes.
*/
/* RANKS: 2 */
#include "isph/start.h"
#include "crowd.h"

/* Reads a scene's spacing from options. */
static void ReadSpacing(const char options[], Scene *scene)
{
  scene->jitter = 0.0;
  scene->length = 1.0;
  CrowdReadSpacing(options, scene);
}

static PetscBool Near(PetscReal value, PetscReal wanted)
{
  return PetscAbsReal(value - wanted) <= 1e-12 ? PETSC_TRUE : PETSC_FALSE;
}

/* The spacing has its value at walls in two rows, grows by the given fraction of the distance
   behind them, and is dx far away; an expression of place is in units of dx, and the smaller value
   holds. */
static void test_function(void **state)
{
  Setting         s    = CrowdBox("function", 2, 20, 30, 1, 1, 0);
  Scene          *wall = &s.scene;
  const PetscReal dx = wall->dx, low = wall->lo[1];
  PetscReal       x[ISPH_MAX_DIM] = {wall->lo[0] + 0.3, low, 0.0};

  (void)state;
  ReadSpacing("-spacing_wall 0.4 -spacing_growth 0.1", wall);
  CloudAssertNone("graded", s.name, !SceneIsGraded(wall) || SceneIsMapped(wall));
  CloudAssertNone("at walls", s.name, !Near(SceneSpacing(wall, x), 0.4 * dx));
  x[1] = low + 0.8 * dx;
  CloudAssertNone("two rows", s.name, !Near(SceneSpacing(wall, x), 0.4 * dx));
  x[1] = low + 4.8 * dx;
  CloudAssertNone("growth", s.name, !Near(SceneSpacing(wall, x), 0.8 * dx));
  x[1] = low + 15.0 * dx;
  CloudAssertNone("far away", s.name, !Near(SceneSpacing(wall, x), dx));
  CloudAssertNone("largest growth", s.name, PetscAbsReal(SceneGrowth(wall) - 0.1) > 1e-9);
  s = CrowdBox("expression", 2, 20, 30, 1, 2, 0);
  ReadSpacing("-spacing 0.75+0.25*sin(2*pi*x/2)", &s.scene);
  x[0] = 0.5;
  CloudAssertNone("crest", s.name, !Near(SceneSpacing(&s.scene, x), dx));
  x[0] = -0.5; /* a periodic image of 1.5 */
  CloudAssertNone("trough", s.name, !Near(SceneSpacing(&s.scene, x), 0.5 * dx));
  ASSERT_OK(ExpressionScopeDestroy(&s.scene.scope));
}

/* Checks the fluid about one particle: no neighbour is nearer than 0.75 of the mean of both
   spacings, and away from walls the nearest one is within 1.25, and the particles within 2.5
   spacings fill the circle or ball, by their spacings, up to a quarter. Returns the number of
   faults. */
static PetscInt FaultsAbout(const Scene *scene, const Particles *p, const Neighbors *nb, PetscInt i)
{
  const PetscReal wanted = PETSC_PI * (p->dim == 2 ? PetscSqr(2.5) : 4.0 / 3.0 * 15.625);
  PetscReal       x[ISPH_MAX_DIM], nearest = PETSC_MAX_REAL, within = 1.0;
  PetscInt        side;

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  for (PetscInt k = nb->row[i]; k < nb->row[i + 1]; k++) {
    const PetscInt j  = nb->col[k];
    PetscReal      r2 = 0.0;

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][j] - x[a]);
    nearest = PetscMin(nearest, PetscSqrtReal(r2) / (0.5 * (p->dx[i] + p->dx[j])));
    if (r2 < PetscSqr(2.5 * p->dx[i])) within += PetscPowRealInt(p->dx[j] / p->dx[i], (int)p->dim);
  }
  if (nearest < 0.75) return 1;
  if (SceneFluidDistance(scene, x, &side) < 2.5 * p->dx[i]) return 0;
  return nearest > 1.25 || PetscAbsReal(within - wanted) > 0.25 * wanted;
}

/* Returns 1 if a particle is beside a wall of the box, but in none of the two ordered rows, near
   1/2 and 3/2 of the spacing there. */
static PetscInt OutOfRow(const Scene *scene, const Particles *p, PetscInt i)
{
  PetscReal x[ISPH_MAX_DIM], height;
  PetscInt  side;

  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
  height = SceneFluidDistance(scene, x, &side) / p->dx[i];
  if (side < 0 || BoundaryBody(scene, side) || height > 1.7) return 0;
  if (!GradingHasRows(scene, side)) return 0;
  return PetscAbsReal(height - 0.5) > 0.05 && PetscAbsReal(height - 1.5) > 0.05;
}

/* Checks a cloud; volume: of the fluid [m^dim], within a tolerance [-]. */
static void CheckCloud(Setting *s, const char options[], PetscReal volume, PetscReal tolerance)
{
  const Scene *scene = &s->scene;
  Particles   *p;
  Neighbors   *nb;
  PetscReal    sum[2] = {0.0, 0.0}; /* of volumes, and of dx^dim */
  PetscInt     about = 0, rows = 0, sizes = 0;

  ReadSpacing(options, &s->scene);
  ASSERT_OK(ParticlesCreate(scene, RADIUS * SceneCoarsest(scene), &p));
  ASSERT_OK(ParticlesFill(scene, s->walls, NULL, p));
  ASSERT_OK(NeighborsCreate(RADIUS * SceneCoarsest(scene), SceneCoarsest(scene), &nb));
  ASSERT_OK(NeighborsUpdate(p, 0.0, nb));
  CrowdCheckNeighbors(s, p, nb);
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0};

    for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
    sizes += p->dx[i] != SceneSpacing(scene, x) || p->u[0][i] != 0.0;
    about += FaultsAbout(scene, p, nb, i);
    rows += OutOfRow(scene, p, i);
    sum[0] += p->volume[i];
    sum[1] += PetscPowRealInt(p->dx[i], (int)p->dim);
  }
  CloudAssertNone("sizes follow from places", s->name, sizes);
  CloudAssertNone("distances and numbers of neighbours", s->name, about);
  CloudAssertNone("ordered rows", s->name, rows);
  MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPI_SUM, p->comm);
  CloudAssertNone("volumes fill the fluid", s->name,
                  PetscAbsReal(sum[0] - volume) > tolerance * volume);
  CloudAssertNone("number of particles", s->name, PetscAbsReal(sum[1] - volume) > 0.04 * volume);
  ASSERT_OK(NeighborsDestroy(&nb));
  ASSERT_OK(ParticlesDestroy(&p));
  ASSERT_OK(ExpressionScopeDestroy(&s->scene.scope));
}

static void test_clouds(void **state)
{
  Setting         square = CrowdBox("2D closed", 2, 20, 16, 1, 0, 0);
  Setting         corner = CrowdBox("2D closed, no whole number of particles", 2, 17, 19, 1, 0, 0);
  Setting         periodic = CrowdBox("2D periodic", 2, 20, 20, 1, 2, 0);
  Setting         circle   = CrowdBox("2D with a circle", 2, 24, 24, 1, 1, 0);
  Setting         cube     = CrowdBox("3D closed", 3, 9, 8, 10, 0, 0);
  Setting         slope    = CrowdBox("3D, uneven sides", 3, 10, 9, 10, 1, 0);
  const PetscReal radius   = 0.4;

  (void)state;
  CheckCloud(&square, "-spacing_wall 0.4 -spacing_growth 0.15", 3.2, 1e-9);
  CheckCloud(&corner, "-spacing_wall 0.6 -spacing_growth 0.1", 3.23, 1e-9);
  CheckCloud(&periodic, "-spacing 0.75+0.25*sin(pi*x)*cos(pi*y)", 4.0, 1e-9);
  BodyCircle(&circle.scene, circle.scene.lo[0] + 1.1, circle.scene.lo[1] + 1.2, radius,
             &SceneAddBody(&circle.scene)->body);
  circle.scene.physics |= PHYSICS_WALLS;
  CheckCloud(&circle, "-spacing_wall 0.4 -spacing_growth 0.1", 5.76 - PETSC_PI * PetscSqr(radius),
             0.003);
  CheckCloud(&cube, "-spacing_wall 0.6 -spacing_growth 0.15", 0.72, 1e-9);
  CheckCloud(&slope, "-spacing 0.8+0.2*sin(2*pi*x)", 0.9, 1e-9);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_function),
                                     cmocka_unit_test(test_clouds)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
