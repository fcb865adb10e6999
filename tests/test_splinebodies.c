/*
  Cells of the lattice of splines that bodies cut: the area of the fluid, and the theorem of Gauss
  for every spline, over the fluid and over the surface of the bodies.
*/
#include "splines/splines.h"
#include "cloud.h"

/* Bodies in a box of 20 x 18 cells of 0.1 from (0, 0); `solid` is their area in the box. */
static const struct {
  const char *name;
  PetscInt    n_bodies;
  const char *shape[2];
  PetscInt    n[2];
  PetscReal   number[2][8];
  PetscBool   around, periodic;
  PetscReal   solid;
} shapes[] = {
    {"polygon",
     1,
     {"polygon"},
     {8},
     {{0.55, 0.42, 1.31, 0.73, 0.8, 0.85, 0.7, 1.33}},
     .solid = 0.20615},
    {"box on lines of the lattice", 1, {"box"}, {4}, {{0.6, 0.6, 1.2, 1.0}}, .solid = 0.24},
    {"two bodies",
     2,
     {"box", "polygon"},
     {4, 6},
     {{0.33, 0.51, 0.77, 1.02}, {1.1, 0.62, 1.62, 0.8, 1.2, 1.3}},
     .solid = 0.2244 + 0.1678},
    {"box across periodic sides",
     1,
     {"box"},
     {4},
     {{-0.23, -0.31, 0.37, 0.42}},
     .periodic = PETSC_TRUE,
     .solid    = 0.438},
    {"around the fluid",
     1,
     {"polygon"},
     {8},
     {{0.31, 0.42, 1.73, 0.33, 1.55, 1.51, 0.42, 1.37}},
     .around = PETSC_TRUE,
     .solid  = 2.0 * 1.8 - 1.35875},
};

/* Creates the bodies of a scene, with cells of 0.1 m. */
static void SetShapes(size_t k, Scene *scene, SplineLattice *lattice, SplineBodies **bodies)
{
  *scene = (Scene){.dim = 2, .dx = 0.05, .hi = {2.0, 1.8}};
  SceneSetSides(scene, shapes[k].periodic ? &BoundaryPeriodic : &BoundaryWall);
  for (PetscInt b = 0; b < shapes[k].n_bodies; b++) {
    const ShapeRow *row;
    Boundary       *boundary = SceneAddBody(scene);

    ASSERT_OK(TableFind(&ShapeTable, shapes[k].shape[b], (const TableRow **)(const void *)&row));
    CloudAssertNone("shape", shapes[k].name,
                    BodySet(scene, row, shapes[k].n[b], shapes[k].number[b], &boundary->body) !=
                        NULL);
    boundary->body.around = shapes[k].around;
  }
  ASSERT_OK(SplineLatticeSet(scene, 2.0, lattice));
  ASSERT_OK(SplineBodiesCreate(scene, lattice, bodies));
}

/* Returns psi_q u.v or grad psi_q . u + psi_q div u of a linear velocity u at x. */
static PetscReal Integrand(const SplineLattice *l, PetscInt q, const PetscReal x[],
                           const PetscReal normal[])
{
  static const PetscReal g[2][2] = {{0.3, -0.7}, {0.4, 0.5}};
  SplineValues           at;
  PetscReal              sum = 0.0;

  SplinesAt(l, x, &at);
  for (PetscInt k = 0; k < at.n; k++) {
    if (SplineNatural(l, at.index[k]) != q) continue;
    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal u = 0.2 + g[a][0] * x[0] + g[a][1] * x[1];

      sum += normal ? at.value[k] * u * normal[a] : at.gradient[a][k] * u + at.value[k] * g[a][a];
    }
  }
  return sum;
}

/* Integrates over the fluid, or over the surface of the bodies by five points on each part. */
static PetscReal Integrate(const SplineLattice *l, const SplineBodies *s, PetscInt q,
                           PetscBool surface)
{
  PetscReal       sum  = 0.0;
  const PetscReal cell = l->side[0] * l->side[1];

  for (PetscInt k = 0; surface && k < s->n_surface; k++) {
    static const PetscReal rule[5][2] = {{0.0, 128.0 / 225.0},
                                         {0.53846931010568309104, 0.47862867049936646804},
                                         {-0.53846931010568309104, 0.47862867049936646804},
                                         {0.90617984593866399280, 0.23692688505618908751},
                                         {-0.90617984593866399280, 0.23692688505618908751}};
    const SplineSurface   *part       = &s->surface[k];

    for (PetscInt g = 0; g < 5; g++) {
      PetscReal x[2];

      for (PetscInt a = 0; a < 2; a++)
        x[a] = 0.5 * ((1.0 - rule[g][0]) * part->from[a] + (1.0 + rule[g][0]) * part->to[a]);
      sum += 0.5 * rule[g][1] * part->length * Integrand(l, q, x, part->normal);
    }
  }
  for (PetscInt c = 0; !surface && c < l->cells[0] * l->cells[1]; c++) {
    const SplineCut *cut = s->cut[c] < 0 ? NULL : &s->cuts[s->cut[c]];

    for (PetscInt g = 0; cut && g < cut->n; g++) {
      const PetscReal x[2] = {s->x[0][cut->first + g], s->x[1][cut->first + g]};

      sum += s->weight[cut->first + g] * cell * Integrand(l, q, x, NULL);
    }
    for (PetscInt k = 0; !cut && s->fraction[c] > 0.0 && k < 4; k++) {
      const PetscReal x[2] = {
          l->lo[0] + (c % l->cells[0] + 0.5 + (k % 2 ? GAUSS : -GAUSS)) * l->side[0],
          l->lo[1] + (c / l->cells[0] + 0.5 + (k / 2 ? GAUSS : -GAUSS)) * l->side[1]};

      sum += 0.25 * cell * Integrand(l, q, x, NULL);
    }
  }
  return sum;
}

/* The theorem of Gauss for every spline away from the sides of the box and a linear velocity, and
   the area of the fluid. */
static void test_shapes(void **state)
{
  (void)state;
  for (size_t k = 0; k < sizeof(shapes) / sizeof(shapes[0]); k++) {
    Scene         scene;
    SplineLattice lattice;
    SplineBodies *bodies;
    PetscReal     area = 0.0;

    SetShapes(k, &scene, &lattice, &bodies);
    for (PetscInt c = 0; c < lattice.cells[0] * lattice.cells[1]; c++)
      area += (1.0 - bodies->fraction[c]) * lattice.side[0] * lattice.side[1];
    CloudAssertNone("area", shapes[k].name, !(PetscAbsReal(area - shapes[k].solid) < 1e-10));
    for (PetscInt q = 0; q < lattice.N; q++) {
      const PetscInt i = q % lattice.count[0], j = q / lattice.count[0];

      if (i < 2 || j < 2 || i >= lattice.count[0] - 2 || j >= lattice.count[1] - 2) continue;
      CloudAssertNone("Gauss", shapes[k].name,
                      !(PetscAbsReal(Integrate(&lattice, bodies, q, PETSC_FALSE) -
                                     Integrate(&lattice, bodies, q, PETSC_TRUE)) < 1e-12));
    }
    ASSERT_OK(SplineBodiesDestroy(&bodies));
  }
}

int main(int argc, char *argv[])
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_shapes)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed;
}
