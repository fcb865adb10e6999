/*
  Graded lattices (-spacing_wall): the map of an axis, the sizes of the particles, their neighbours,
  and rows that are exact for quadratic fields in spite of unequal edges; also rows of particles
  that are not on a lattice (-spacing_growth).
*/
/* RANKS: 1 2 */
#include "isph/start.h"
#include "crowd.h"

/* Returns the edge of cell c of the lattice along an axis. */
static PetscReal Edge(const Scene *scene, PetscInt axis, PetscInt c)
{
  return SceneLatticePlace(scene, axis, c + 1.0) - SceneLatticePlace(scene, axis, (PetscReal)c);
}

/* Returns the error of SceneFromUniform(), SceneToUniform() and the slope between them at x. */
static PetscReal MapError(const Scene *scene, PetscInt axis, PetscReal x)
{
  const PetscReal step = 1e-5 * SceneFinest(scene), y = SceneToUniform(scene, axis, x);
  PetscReal       slope, other, error;

  error = PetscAbsReal(SceneFromUniform(scene, axis, y, &slope) - x);
  error += PetscAbsReal((SceneFromUniform(scene, axis, y + step, &other) -
                         SceneFromUniform(scene, axis, y - step, &other)) /
                            (2.0 * step) -
                        slope);
  return error;
}

/* The slope of the map at a wall is the spacing of the option, also for one wall only, and edges
   grow from walls on; SceneEdges() finds the edges from the centres of cells. */
static void CheckAxis(const Scene *scene, PetscInt axis, const char *where)
{
  const LatticeMap *map  = &scene->map[axis];
  const PetscInt    n    = scene->cells[axis];
  const PetscReal   tiny = 1e-6, side = SceneCellSide(scene, axis);
  PetscReal         wrong = 0.0, growth = 0.0, slope[2];

  slope[0] = (SceneLatticePlace(scene, axis, tiny) - scene->lo[axis]) / (tiny * side);
  slope[1] = (scene->hi[axis] - SceneLatticePlace(scene, axis, n - tiny)) / (tiny * side);
  for (PetscInt end = 0; end < 2; end++) {
    if (map->wall[end]) wrong = PetscMax(wrong, PetscAbsReal(slope[end] - scene->spacing_wall));
  }
  CloudAssertNone("slope at walls", where, wrong > 1e-4);
  CloudAssertNone("ends", where,
                  PetscAbsReal(SceneLatticePlace(scene, axis, 0.0) - scene->lo[axis]) > 1e-12 ||
                      PetscAbsReal(SceneLatticePlace(scene, axis, n) - scene->hi[axis]) > 1e-12);
  for (PetscInt c = 0; c < n; c++) {
    PetscReal x[ISPH_MAX_DIM], edge[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = SceneLatticePlace(scene, a, 0.5);
    x[axis] = SceneLatticePlace(scene, axis, c + 0.5);
    SceneEdges(scene, x, edge);
    CloudAssertNone("edges at centres", where,
                    PetscAbsReal(edge[axis] - Edge(scene, axis, c)) > 1e-12 * side);
    CloudAssertNone("bounds", where,
                    edge[axis] < SceneFinest(scene) * (1.0 - 1e-12) ||
                        edge[axis] > SceneCoarsest(scene) * (1.0 + 1e-12));
    CloudAssertNone("from the uniform lattice and back", where,
                    MapError(scene, axis, x[axis]) > 1e-9);
    if (c)
      growth = PetscMax(growth, PetscAbsReal(PetscLogReal(edge[axis] / Edge(scene, axis, c - 1))));
  }
  CloudAssertNone("growth", where, growth > SceneGrowth(scene));
}

static void test_map(void **state)
{
  const BoundaryRow plane = {.name = "plane", .properties = BOUNDARY_PARTICLES | BOUNDARY_CONFINES};
  Setting           two   = CrowdBox("two walls", 2, 20, 33, 1, 0, 0),
          one             = CrowdBox("one", 2, 20, 17, 1, 0, 0);

  (void)state;
  CrowdReadSpacing("-spacing_wall 0.5", &two.scene);
  CheckAxis(&two.scene, 0, two.name);
  CheckAxis(&two.scene, 1, two.name);
  CloudAssertNone("symmetric", two.name,
                  PetscAbsReal(Edge(&two.scene, 0, 2) - Edge(&two.scene, 0, 17)) > 1e-14);
  SceneSetSide(&one.scene, 1, &plane);
  SceneSetSide(&one.scene, 2, &plane);
  CrowdReadSpacing("-spacing_wall 0.6", &one.scene);
  CheckAxis(&one.scene, 0, one.name);
  CheckAxis(&one.scene, 1, one.name);
  CloudAssertNone("grows away from the wall", one.name,
                  Edge(&one.scene, 0, 19) < 1.8 * Edge(&one.scene, 0, 0) ||
                      Edge(&one.scene, 1, 0) < 1.8 * Edge(&one.scene, 1, 16));
}

/* With the spacing 1 nothing changes: no particle has stretched axes. */
static void test_uniform(void **state)
{
  Setting      s = CrowdBox("uniform", 2, 12, 9, 1, 1, 0);
  PetscReal    x[ISPH_MAX_DIM], stretch[ISPH_MAX_DIM];
  const Scene *scene = &s.scene;

  (void)state;
  CrowdReadSpacing("-spacing_wall 1", &s.scene);
  for (PetscInt a = 0; a < 2; a++) x[a] = scene->lo[a];
  SceneStretch(scene, x, stretch);
  CloudAssertNone("spacing", s.name, SceneSpacing(scene, x) != scene->dx);
  CloudAssertNone("stretch", s.name, stretch[0] != 1.0 || stretch[1] != 1.0);
  CloudAssertNone("graded", s.name, SceneIsGraded(scene));
}

/* Volumes fill the box; stretches have the mean square 1; the axis without walls is uniform; rows
   of neighbours equal a search over all pairs. */
static void CheckParticles(Setting *s, const char options[])
{
  const Scene *scene = &s->scene;
  Particles   *p;
  Neighbors   *nb;
  PetscReal    volume = 0.0, box = 1.0;
  PetscInt     wrong = 0;

  CrowdReadSpacing(options, &s->scene);
  ASSERT_OK(ParticlesCreate(scene, RADIUS * SceneCoarsest(scene), &p));
  ASSERT_OK(ParticlesFill(scene, s->walls, NULL, p));
  ASSERT_OK(NeighborsCreate(RADIUS * SceneCoarsest(scene), SceneCoarsest(scene), &nb));
  for (PetscInt i = 0; i < ParticlesOwn(p); i++) {
    PetscReal squares = 0.0;

    if (!ParticlesIsWall(p, i)) volume += p->volume[i];
    for (PetscInt a = 0; a < p->dim; a++) squares += PetscSqr(p->stretch[a][i]);
    wrong += PetscAbsReal(squares - p->dim) > 1e-12 ||
             ParticlesLargestEdge(p, i) > SceneCoarsest(scene) * (1.0 + 1e-12);
  }
  CloudAssertNone("mean square of stretch, largest edge", s->name, wrong);
  MPI_Allreduce(MPI_IN_PLACE, &volume, 1, MPIU_REAL, MPI_SUM, p->comm);
  for (PetscInt a = 0; a < p->dim; a++) box *= scene->hi[a] - scene->lo[a];
  CloudAssertNone("volumes fill the box", s->name, PetscAbsReal(volume - box) > 1e-12 * box);
  ASSERT_OK(NeighborsUpdate(p, 0.0, nb));
  CrowdCheckNeighbors(s, p, nb);
  ASSERT_OK(NeighborsDestroy(&nb));
  ASSERT_OK(ParticlesDestroy(&p));
}

static void test_particles(void **state)
{
  Setting square  = CrowdBox("2D closed", 2, 20, 16, 1, 0, 0);
  Setting channel = CrowdBox("2D channel", 2, 9, 24, 1, 1, 0);
  Setting cube    = CrowdBox("3D closed", 3, 10, 9, 11, 0, 0);

  (void)state;
  CheckParticles(&square, "-spacing_wall 0.5");
  CheckParticles(&channel, "-spacing_wall 0.35");
  CheckParticles(&cube, "-spacing_wall 0.7");
}

/* Checks Laplacian, gradient, pressure rows and filter for a quadratic field whose values, or whose
   normal derivatives, are given at walls. */
static void CheckRows(Cloud *cloud, const char *where, const Quadratic *f)
{
  const Operators *ops = cloud->ops;
  const Quadratic  lap = QuadraticLaplacian(cloud, f), zero = {0};
  const PetscReal  dx = cloud->scene.dx;
  PetscReal        error;
  PetscScalar     *scale, *y;

  cloud->wall_u[0] = *f;
  ASSERT_OK(CloudSet(cloud, f, cloud->f[0]));
  ASSERT_OK(CloudSetWalls(cloud));
  ASSERT_OK(AffineApply(&ops->velocity[0].visc, cloud->f[0], cloud->walls.u[0], cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, &lap, PETSC_FALSE, &error));
  CloudAssertNone("Laplacian", where, error * dx * dx > 1e-8);
  ASSERT_OK(CloudSetSlope(cloud, f, cloud->e));
  ASSERT_OK(AffineApply(&ops->ppe, cloud->f[0], cloud->e, cloud->y));
  ASSERT_OK(VecGetArray(cloud->y, &y));
  ASSERT_OK(VecGetArray(ops->ppe_scale, &scale));
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) y[i] /= scale[i];
  ASSERT_OK(VecRestoreArray(ops->ppe_scale, &scale));
  ASSERT_OK(VecRestoreArray(cloud->y, &y));
  ASSERT_OK(CloudError(cloud, cloud->y, &lap, PETSC_FALSE, &error));
  CloudAssertNone("pressure Laplacian", where, error * dx * dx > 1e-8);
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    const Quadratic slope = QuadraticDerivative(cloud, f, a);

    ASSERT_OK(AffineApply(&ops->velocity[0].grad_u[a], cloud->f[0], cloud->walls.u[0], cloud->y));
    ASSERT_OK(CloudError(cloud, cloud->y, &slope, PETSC_FALSE, &error));
    CloudAssertNone("gradient", where, error * dx > 1e-9);
  }
  ASSERT_OK(AffineApply(&ops->filter_p, cloud->f[0], cloud->e, cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, &zero, PETSC_FALSE, &error));
  CloudAssertNone("pressure filter", where, error > 1e-9);
}

/* Checks the divergence of a quadratic velocity along one axis. */
static void CheckDivergence(Cloud *cloud, const char *where, const Quadratic *f, PetscInt axis)
{
  const Quadratic zero = {0}, slope = QuadraticDerivative(cloud, f, axis);
  PetscReal       error;

  for (PetscInt c = 0; c < cloud->scene.dim; c++) {
    cloud->wall_u[c] = c == axis ? *f : zero;
    ASSERT_OK(CloudSet(cloud, &cloud->wall_u[c], cloud->f[c]));
  }
  ASSERT_OK(CloudSetWalls(cloud));
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  ASSERT_OK(CloudError(cloud, cloud->y, &slope, PETSC_FALSE, &error));
  CloudAssertNone("divergence", where, error * cloud->scene.dx > 1e-9);
}

static void CheckQuadratics(const CloudBox *box, const char options[])
{
  Cloud cloud;

  ASSERT_OK(CloudCreate(box, options, &cloud));
  CloudAssertNone("graded", box->name, !SceneIsGraded(&cloud.scene));
  for (PetscInt k = 0; k < QuadraticCount(box->dim); k++) {
    const Quadratic f = QuadraticMonomial(box->dim, k);

    CheckRows(&cloud, box->name, &f);
    for (PetscInt a = 0; a < box->dim; a++) CheckDivergence(&cloud, box->name, &f, a);
  }
  CloudAssertNone("all fits are determined", box->name, cloud.ops->regularised_rows);
  ASSERT_OK(CloudDestroy(&cloud));
}

static void test_quadratics(void **state)
{
  CloudBox plane = {
      .name = "2D", .dim = 2, .cells = {20, 16, 1}, .grad_p_without_walls = PETSC_TRUE};
  CloudBox space = {
      .name = "3D", .dim = 3, .cells = {10, 9, 11}, .grad_p_without_walls = PETSC_TRUE};

  (void)state;
  CheckQuadratics(&plane, "-spacing_wall 0.5");
  CheckQuadratics(&plane, "-spacing_wall 0.5 -mls_degree 3 -h_over_dx 2.4");
  CheckQuadratics(&plane, "-spacing_wall 0.5 -spacing_growth 0.15 -h_over_dx 1.4");
  plane.jitter = 0.2;
  CheckQuadratics(&plane, "-spacing_wall 0.5 -h_over_dx 1.5");
  CheckQuadratics(&space, "-spacing_wall 0.7 -h_over_dx 1.5");
  CheckQuadratics(&space, "-spacing_wall 0.7 -spacing_growth 0.2 -h_over_dx 1.5");
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_map), cmocka_unit_test(test_uniform),
                                     cmocka_unit_test(test_particles),
                                     cmocka_unit_test(test_quadratics)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
