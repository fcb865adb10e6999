/*
  Cells of the lattice of splines that bodies cut: the area or volume of the fluid, and the theorem
  of Gauss for every spline, over the fluid and over its boundary.
*/
#include "splines/splines.h"
#include "cloud.h"

/* Bodies in a box of 20 x 18 cells of 0.1 from (0, 0); `solid` is their area in the box. In 3D the
   box has 10 x 9 x 8 cells, and the volume is right to a share `error`. */
static const struct {
  const char *name;
  PetscInt    dim;
  PetscInt    n_bodies;
  const char *shape[2];
  PetscInt    n[2];
  PetscReal   number[2][8];
  PetscBool   around, periodic;
  PetscReal   solid, error;
} shapes[] = {
    {"polygon",
     2,
     1,
     {"polygon"},
     {8},
     {{0.55, 0.42, 1.31, 0.73, 0.8, 0.85, 0.7, 1.33}},
     .solid = 0.20615},
    {"box on lines of the lattice", 2, 1, {"box"}, {4}, {{0.6, 0.6, 1.2, 1.0}}, .solid = 0.24},
    {"two bodies",
     2,
     2,
     {"box", "polygon"},
     {4, 6},
     {{0.33, 0.51, 0.77, 1.02}, {1.1, 0.62, 1.62, 0.8, 1.2, 1.3}},
     .solid = 0.2244 + 0.1678},
    {"box across periodic sides",
     2,
     1,
     {"box"},
     {4},
     {{-0.23, -0.31, 0.37, 0.42}},
     .periodic = PETSC_TRUE,
     .solid    = 0.438},
    {"around the fluid",
     2,
     1,
     {"polygon"},
     {8},
     {{0.31, 0.42, 1.73, 0.33, 1.55, 1.51, 0.42, 1.37}},
     .around = PETSC_TRUE,
     .solid  = 2.0 * 1.8 - 1.35875},
    {"ball",
     3,
     1,
     {"ball"},
     {4},
     {{0.511, 0.463, 0.42, 0.21}},
     .solid = 4.0 / 3.0 * PETSC_PI * 0.21 * 0.21 * 0.21,
     .error = 0.013},
    {"ball across sides, and a box on lines of the lattice",
     3,
     2,
     {"ball", "box"},
     {4, 6},
     {{0.0, 0.9, 0.4, 0.2}, {0.55, 0.2, 0.2, 0.8, 0.45, 0.6}},
     .solid = 1.0 / 3.0 * PETSC_PI * 0.2 * 0.2 * 0.2 + 0.025,
     .error = 0.006},
    {"balls across periodic sides",
     3,
     1,
     {"ball"},
     {4},
     {{0.03, 0.85, 0.04, 0.25}},
     .periodic = PETSC_TRUE,
     .solid    = 4.0 / 3.0 * PETSC_PI * 0.25 * 0.25 * 0.25,
     .error    = 0.01},
    {"oblique prism",
     3,
     1,
     {"prism"},
     {8},
     {{0.31, 0.22, 0.75, 0.33, 0.66, 0.71, 0.22, 0.57}},
     .solid = 0.8 * 0.17185,
     .error = 0.005},
    {"vessel around the fluid",
     3,
     1,
     {"revolved"},
     {8},
     {{0.0, 0.11, 0.37, 0.11, 0.43, 0.69, 0.0, 0.69}},
     .around = PETSC_TRUE,
     .solid  = 0.72 - PETSC_PI * 0.58 / 3.0 * (0.37 * 0.37 + 0.37 * 0.43 + 0.43 * 0.43),
     .error  = 0.004},
};

/* Creates the bodies of a scene, with cells of 0.1 m. A vessel has the axis z in its middle. */
static void SetShapes(size_t k, Scene *scene, SplineLattice *lattice, SplineBodies **bodies)
{
  const PetscBool solid = shapes[k].dim == 3 ? PETSC_TRUE : PETSC_FALSE;

  *scene = (Scene){.dim = shapes[k].dim, .dx = 0.05, .hi = {2.0, 1.8}};
  if (solid) *scene = (Scene){.dim = 3, .dx = 0.05, .hi = {1.0, 0.9, 0.8}};
  for (PetscInt a = 0; a < 2 && shapes[k].around && solid; a++) {
    scene->lo[a] = -0.5 * scene->hi[a];
    scene->hi[a] *= 0.5;
  }
  SceneSetSides(scene, shapes[k].periodic ? &BoundaryPeriodic : &BoundaryWall);
  for (PetscInt b = 0; b < shapes[k].n_bodies; b++) {
    const ShapeRow *row;
    Boundary       *boundary = SceneAddBody(scene);

    ASSERT_OK(TableFind(solid ? &SolidTable : &ShapeTable, shapes[k].shape[b],
                        (const TableRow **)(const void *)&row));
    CloudAssertNone("shape", shapes[k].name,
                    BodySet(scene, row, shapes[k].n[b], shapes[k].number[b], &boundary->body) !=
                        NULL);
    boundary->body.around = shapes[k].around;
  }
  ASSERT_OK(SplineLatticeSet(scene, 2.0, lattice));
  ASSERT_OK(SplineBodiesCreate(scene, lattice, bodies));
}

/* A linear velocity, and its divergence. */
static const PetscReal slope[3][3] = {{0.3, -0.7, 0.2}, {0.4, 0.5, -0.6}, {-0.1, 0.8, 0.9}};

static PetscReal VelocityAt(const SplineLattice *l, PetscInt a, const PetscReal x[])
{
  PetscReal u = 0.2 + 0.1 * a;

  for (PetscInt b = 0; b < l->dim; b++) u += slope[a][b] * x[b];
  return u;
}

/* Adds int grad psi . u + psi div u over the fluid of a cell, over the volume of a cell, to each
   spline. */
static void AddFluid(const SplineLattice *l, const SplineBodies *s, PetscInt c, PetscReal sum[])
{
  const PetscInt   n = SplinesAtPoint(l), nodes = 1 << l->dim;
  const SplineCut *cut = s->cut[c] < 0 ? NULL : &s->cuts[s->cut[c]];
  PetscInt         cell[ISPH_MAX_DIM];

  SplineIndex(l->dim, NULL, l->cells, c, cell);
  for (PetscInt e = 0; e < nodes * n; e++) {
    const PetscInt node = e / n, k = e % n;
    PetscInt       index[ISPH_MAX_DIM];
    const PetscInt q = SplineOfCell(l, cell, k, index);
    PetscReal      x[ISPH_MAX_DIM];
    SplineValues   at;

    if (cut) SplineCutNode(l->dim, cut, node, x);
    for (PetscInt a = 0; !cut && a < l->dim; a++)
      x[a] = l->lo[a] + (cell[a] + 0.5 + ((node >> a) % 2 ? GAUSS : -GAUSS)) * l->side[a];
    if (!cut) SplinesAt(l, x, &at);
    for (PetscInt a = 0; a < l->dim; a++) {
      const PetscReal *integral = cut ? cut->integral + node * (1 + l->dim) * n + k : NULL;
      const PetscReal  whole    = s->fraction[c] / nodes;

      sum[q] += (cut ? integral[(1 + a) * n] : whole * at.gradient[a][k]) * VelocityAt(l, a, x);
      sum[q] += (cut ? integral[0] : whole * at.value[k]) * slope[a][a];
    }
  }
}

/* Subtracts int psi u . n over the surface of bodies in the plane, by five points on each part. */
static void SubtractSurface(const SplineLattice *l, const SplineBodies *s, PetscReal sum[])
{
  static const PetscReal rule[5][2] = {{0.0, 128.0 / 225.0},
                                       {0.53846931010568309104, 0.47862867049936646804},
                                       {-0.53846931010568309104, 0.47862867049936646804},
                                       {0.90617984593866399280, 0.23692688505618908751},
                                       {-0.90617984593866399280, 0.23692688505618908751}};

  for (PetscInt e = 0; e < 5 * s->n_surface; e++) {
    const SplineSurface *part   = &s->surface[e / 5];
    const PetscReal      r      = rule[e % 5][0];
    const PetscReal      weight = 0.5 * rule[e % 5][1] * part->length / (l->side[0] * l->side[1]);
    PetscReal            x[2];
    SplineValues         at;

    for (PetscInt a = 0; a < 2; a++)
      x[a] = 0.5 * ((1.0 - r) * part->from[a] + (1.0 + r) * part->to[a]);
    SplinesAt(l, x, &at);
    for (PetscInt k = 0; k < at.n; k++)
      for (PetscInt a = 0; a < 2; a++)
        sum[SplineNatural(l, at.index[k])] -=
            weight * at.value[k] * VelocityAt(l, a, x) * part->normal[a];
  }
}

/* Subtracts int psi u . n over the patches in space. */
static void SubtractPatches(const SplineLattice *l, const SplineBodies *s, PetscReal sum[])
{
  const PetscReal scale = PetscPowReal(l->side[0] * l->side[1] * l->side[2], 1.0 / 3.0);

  for (PetscInt e = 0; e < 4 * s->n_patches; e++) {
    const SplinePatch *patch = &s->patches[e / 4];
    PetscInt           cell[ISPH_MAX_DIM];

    SplineIndex(3, NULL, l->cells, patch->cell, cell);
    for (PetscInt k = 0; k < 3 * SPLINES_AT_QUADRATIC; k++) {
      const PetscInt a = k / SPLINES_AT_QUADRATIC, m = k % SPLINES_AT_QUADRATIC;
      PetscInt       index[ISPH_MAX_DIM];

      sum[SplineOfCell(l, cell, m, index)] -=
          patch->integral[e % 4][a][m] * VelocityAt(l, a, patch->x[e % 4]) / scale;
    }
  }
}

/* Returns true if a spline has a part in a cell with a whole face on a side of the box, whose flux
   the points of the side give. */
static PetscBool IsAtSide(const SplineLattice *l, const SplineBodies *s, PetscInt q)
{
  const PetscInt width[ISPH_MAX_DIM] = {3, 3, 3};
  PetscInt       index[ISPH_MAX_DIM], cell[ISPH_MAX_DIM];

  SplineIndex(l->dim, NULL, l->count, q, index);
  for (PetscInt k = 0; k < (l->dim == 3 ? 27 : 9); k++) {
    PetscBool in = PETSC_TRUE, side = PETSC_FALSE;

    SplineIndex(l->dim, NULL, width, k, cell);
    for (PetscInt a = 0; a < l->dim; a++) {
      cell[a] += index[a] - (l->periodic[a] ? 1 : 2);
      if (cell[a] < 0 || cell[a] >= l->cells[a]) in = PETSC_FALSE;
      if (cell[a] == 0 || cell[a] == l->cells[a] - 1) side = PETSC_TRUE;
    }
    if (l->periodic[0] && (!in || side)) return PETSC_TRUE; /* the velocity jumps there */
    if (in && side) {
      const PetscInt c =
          cell[0] + l->cells[0] * (cell[1] + (l->dim == 3 ? l->cells[1] * cell[2] : 0));

      if (s->fraction[c] > 0.0 && (l->dim == 2 || s->cut[c] < 0)) return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* The theorem of Gauss for every spline away from whole sides of the box and a linear velocity, and
   the area or the volume of the fluid. */
static void test_shapes(void **state)
{
  (void)state;
  for (size_t k = 0; k < sizeof(shapes) / sizeof(shapes[0]); k++) {
    Scene         scene;
    SplineLattice lattice;
    SplineBodies *bodies;
    PetscReal     area = 0.0, cell = 1.0, *sum;
    PetscInt      cells = 1, tried = 0;

    SetShapes(k, &scene, &lattice, &bodies);
    for (PetscInt a = 0; a < lattice.dim; a++) {
      cells *= lattice.cells[a];
      cell *= lattice.side[a];
    }
    ASSERT_OK(PetscCalloc1(lattice.N, &sum));
    for (PetscInt c = 0; c < cells; c++) {
      area += (1.0 - bodies->fraction[c]) * cell;
      if (bodies->fraction[c] > 0.0) AddFluid(&lattice, bodies, c, sum);
    }
    CloudAssertNone("area", shapes[k].name,
                    !(PetscAbsReal(area - shapes[k].solid) <
                      1e-10 + shapes[k].error * PetscAbsReal(shapes[k].solid)));
    SubtractSurface(&lattice, bodies, sum);
    SubtractPatches(&lattice, bodies, sum);
    for (PetscInt q = 0; q < lattice.N; q++) {
      if (IsAtSide(&lattice, bodies, q)) continue;
      tried += sum[q] != 0.0 ? 1 : 0;
      CloudAssertNone("Gauss", shapes[k].name, !(PetscAbsReal(sum[q]) < 1e-12));
    }
    CloudAssertNone("splines", shapes[k].name, tried < 20);
    ASSERT_OK(PetscFree(sum));
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
