/*
  Products of operators by their rows are those of their matrices; the matrix of a solver is
  shift I + scale A; fits in a batch are those of single particles; sums of matrices are PETSc's.
*/
/* RANKS: 2 */
#include "rows/assembly.h"
#include "rows/rows.h"
#include "isph/operators.h"
#include "cloud.h"

static const CloudBox boxes[] = {
    {.name = "2D box", .dim = 2, .cells = {13, 10}, .jitter = 0.2},
    {.name = "2D channel", .dim = 2, .cells = {14, 9}, .n_periodic = 1, .jitter = 0.2},
    {.name = "2D periodic", .dim = 2, .cells = {11, 12}, .n_periodic = 2, .jitter = 0.2},
    {.name = "3D box", .dim = 3, .cells = {8, 8, 7}, .jitter = 0.1},
    {.name = "3D periodic", .dim = 3, .cells = {6, 6, 7}, .n_periodic = 3, .jitter = 0.1},
};
#define BOXES (sizeof(boxes) / sizeof(boxes[0]))

#define ROUNDING 1e-13 /* over the largest value */
#define FITS     1e-11 /* the same, amplified by normal equations of condition 1e4 */

/* Checks that two vectors differ by at most a multiple of the largest value. */
static void AssertNear(const char *what, const char *where, PetscReal most, Vec y, Vec expected)
{
  PetscReal norm, difference;

  ASSERT_OK(VecNorm(expected, NORM_INFINITY, &norm));
  ASSERT_OK(VecAXPY(y, -1.0, expected));
  ASSERT_OK(VecNorm(y, NORM_INFINITY, &difference));
  CloudAssertNone(what, where, !(difference <= most * norm));
}

static void AssertEqual(const char *what, const char *where, Vec y, Vec expected)
{
  AssertNear(what, where, ROUNDING, y, expected);
}

/* Sets random values over fluid and walls. */
static void SetRandom(Cloud *cloud)
{
  PetscRandom random;

  ASSERT_OK(PetscRandomCreate(PETSC_COMM_WORLD, &random));
  ASSERT_OK(VecSetRandom(cloud->f[0], random));
  ASSERT_OK(VecSetRandom(cloud->e, random));
  ASSERT_OK(PetscRandomDestroy(&random));
}

/* Computes y = A f + B e by the matrices; parts: 1 - A f, 2 - B e, 3 - both. */
static void MatrixProduct(const Cloud *cloud, const AffineOperator *op, int parts, Vec y)
{
  ASSERT_OK(VecZeroEntries(y));
  if (parts & 1) ASSERT_OK(MatMultAdd(op->A, cloud->f[0], y, y));
  if (parts & 2 && op->B) ASSERT_OK(MatMultAdd(op->B, cloud->e, y, y));
}

static void test_products(void **state)
{
  (void)state;
  for (size_t b = 0; b < BOXES; b++) {
    const char           *name = boxes[b].name;
    Cloud                 cloud;
    const AffineOperator *op[ISPH_MAX_DIM + 2];
    Vec                   y[ISPH_MAX_DIM + 2], expected;
    PetscInt              n = 0;

    ASSERT_OK(CloudCreate(&boxes[b], "", &cloud));
    SetRandom(&cloud);
    op[n++] = &cloud.ops->ppe;
    op[n++] = &cloud.ops->velocity[0].visc;
    for (PetscInt a = 0; a < boxes[b].dim; a++) op[n++] = &cloud.ops->div[a];
    ASSERT_OK(VecDuplicate(cloud.y, &expected));
    for (PetscInt k = 0; k < n; k++) ASSERT_OK(VecDuplicate(cloud.y, &y[k]));
    ASSERT_OK(AffineApplyAll(n, op, cloud.f[0], cloud.e, y));
    for (PetscInt k = 0; k < n; k++) {
      CloudAssertNone("products by rows", name, !op[k]->rows);
      MatrixProduct(&cloud, op[k], 3, expected);
      AssertEqual("all products", name, y[k], expected);
      ASSERT_OK(AffineApply(op[k], cloud.f[0], cloud.e, y[k]));
      ASSERT_OK(AffineApplyAdd(op[k], cloud.f[0], cloud.e, y[k]));
      ASSERT_OK(VecScale(expected, 2.0));
      AssertEqual("a product added", name, y[k], expected);
      ASSERT_OK(AffineApplyWalls(op[k], cloud.e, y[k]));
      MatrixProduct(&cloud, op[k], 2, expected);
      AssertEqual("wall data", name, y[k], expected);
    }
    for (PetscInt k = 0; k < n; k++) ASSERT_OK(VecDestroy(&y[k]));
    ASSERT_OK(VecDestroy(&expected));
    ASSERT_OK(CloudDestroy(&cloud));
  }
}

/* On a lattice rows repeat, also beside walls, and their products are those of rows that are all
   stored; on disordered particles none repeats. */
static void test_repeats(void **state)
{
  (void)state;
  for (size_t b = 0; b < 2 * BOXES; b++) {
    CloudBox              box = boxes[b / 2];
    Cloud                 all, cloud;
    const AffineOperator *op[2][ISPH_MAX_DIM + 2];
    PetscInt              n = 0, count[4];
    PetscMPIInt           ranks;

    box.jitter = b % 2 ? 0.2 : 0.0;
    for (PetscInt a = 0; a < box.dim; a++) box.cells[a] += 8;
    ASSERT_OK(CloudCreate(&box, "", &all));
    box.without_matrices = PETSC_TRUE;
    ASSERT_OK(CloudCreate(&box, "", &cloud));
    for (PetscInt c = 0; c < 2; c++) {
      const Operators *ops = c ? cloud.ops : all.ops;

      n          = 0;
      op[c][n++] = &ops->ppe;
      op[c][n++] = &ops->velocity[0].visc;
      for (PetscInt a = 0; a < box.dim; a++) op[c][n++] = &ops->div[a];
    }
    SetRandom(&all);
    ASSERT_OK(VecCopy(all.f[0], cloud.f[0]));
    for (PetscInt k = 0; k < n; k++) {
      ASSERT_OK(AffineApply(op[0][k], all.f[0], all.e, all.y));
      ASSERT_OK(AffineApply(op[1][k], cloud.f[0], all.e, cloud.y));
      AssertEqual("products of rows that repeat", box.name, cloud.y, all.y);
    }
    count[0] = cloud.ops->rows.n_weights;
    count[1] = cloud.ops->rows.fluid.row[cloud.particles->n_fluid];
    count[2] = cloud.ops->rows.n_apart;
    count[3] = all.ops->rows.n_apart;
    ASSERT_OK(MPI_Allreduce(MPI_IN_PLACE, count, 4, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
    CloudAssertNone("stored weights", box.name,
                    b % 2 ? count[0] != count[1] : count[0] >= count[1]);
    CloudAssertNone("weights beside walls", box.name,
                    b % 2 ? count[2] != count[3] : count[3] && count[2] >= count[3]);
    ASSERT_OK(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
    CloudAssertNone("runs of rows", box.name,
                    b % 2 ? cloud.ops->rows.n_runs : ranks == 1 && !cloud.ops->rows.n_runs);
    ASSERT_OK(CloudDestroy(&cloud));
    ASSERT_OK(CloudDestroy(&all));
  }
}

/* Lists the operators whose rows products make from fits; returns their number. */
static PetscInt ListFitted(const Operators *ops, PetscInt dim, const AffineOperator *op[])
{
  PetscInt n = 0;

  op[n++] = &ops->velocity[0].filter_u;
  for (PetscInt a = 0; a < dim; a++) op[n++] = &ops->velocity[0].grad_u[a];
  return n;
}

/* Compares the products of all components of a velocity with those by matrices, and single products
   of the operators of the pressure. */
static void CompareFitted(const Cloud *stored, const Cloud *fitted, const char *name)
{
  AffineProducts        of = {.fields = stored->scene.dim};
  const AffineOperator *by_matrix[AFFINE_MOST];

  for (PetscInt c = 0; c < of.fields; c++) {
    of.n        = ListFitted(fitted->ops, of.fields, of.op[c]);
    of.f[c]     = fitted->f[c];
    of.walls[c] = fitted->e;
    for (PetscInt k = 0; k < of.n; k++) ASSERT_OK(VecDuplicate(fitted->y, &of.y[c][k]));
  }
  (void)ListFitted(stored->ops, of.fields, by_matrix);
  ASSERT_OK(AffineApplyFields(&of));
  for (PetscInt e = 0; e < of.fields * of.n; e++) {
    const PetscInt c = e / of.n, k = e % of.n;

    ASSERT_OK(MatMult(by_matrix[k]->A, of.f[c], stored->y));
    if (by_matrix[k]->B) ASSERT_OK(MatMultAdd(by_matrix[k]->B, fitted->e, stored->y, stored->y));
    AssertNear("products of fits", name, FITS, of.y[c][k], stored->y);
    ASSERT_OK(VecDestroy(&of.y[c][k]));
  }
  for (PetscInt a = 0; fitted->ops->div[0].needed && a < of.fields; a++) {
    ASSERT_OK(AffineApply(&fitted->ops->div[a], fitted->f[a], fitted->e, fitted->y));
    ASSERT_OK(AffineApply(&stored->ops->div[a], fitted->f[a], fitted->e, stored->y));
    AssertNear("divergence by fits", name, FITS, fitted->y, stored->y);
    ASSERT_OK(AffineApplyWalls(&fitted->ops->velocity[0].grad_u[a], fitted->e, fitted->y));
    ASSERT_OK(AffineApplyWalls(&stored->ops->velocity[0].grad_u[a], fitted->e, stored->y));
    AssertNear("wall data by fits", name, FITS, fitted->y, stored->y);
  }
}

/* Rows of particles that move are made from fits, and their products are those of stored rows, with
   and without operators of the pressure. */
static void test_fitted(void **state)
{
  const char *const options[] = {
      "-gradient mls -visc_laplacian mls -h_over_dx 1.5",
      "-gradient mls -visc_laplacian mls -ppe_laplacian mls -h_over_dx 1.5",
      "-gradient mls -visc_laplacian mls -ppe_laplacian mls -mls_degree 3 -h_over_dx 1.8",
      "-gradient mls -visc_laplacian mls -ppe_laplacian mls -mls_degree 4 -h_over_dx 2"};

  (void)state;
  for (size_t b = 0; b < 4 * BOXES; b++) {
    CloudBox    box = boxes[b / 4];
    Cloud       stored, fitted;
    PetscRandom random;

    box.moves = PETSC_TRUE;
    box.needs = NEED_VISCOSITY | NEED_GRADIENT_U | NEED_FILTER_U;
    if (b % 4) box.needs |= NEED_PRESSURE | NEED_FILTER_P;
    ASSERT_OK(CloudCreate(&box, options[b % 4], &stored));
    box.without_matrices = PETSC_TRUE;
    ASSERT_OK(CloudCreate(&box, options[b % 4], &fitted));
    CloudAssertNone("rows of fits", box.name, !fitted.ops->rows.fitted);
    CloudAssertNone("stored rows", box.name, stored.ops->rows.fitted != NULL);
    ASSERT_OK(PetscRandomCreate(PETSC_COMM_WORLD, &random));
    for (PetscInt c = 0; c < box.dim; c++) ASSERT_OK(VecSetRandom(fitted.f[c], random));
    ASSERT_OK(VecSetRandom(fitted.e, random));
    ASSERT_OK(PetscRandomDestroy(&random));
    CompareFitted(&stored, &fitted, box.name);
    ASSERT_OK(CloudDestroy(&fitted));
    ASSERT_OK(CloudDestroy(&stored));
  }
}

/* Checks that a shell is the matrix 250 I - 0.4 A. */
static void CheckShell(const AffineOperator *op, const char *name, Mat expected)
{
  Mat shell, flat;
  Vec x, y, right;

  ASSERT_OK(AffineSystemCreate(op, MATSHELL, &shell));
  ASSERT_OK(AffineSystemSet(op, 7.0, 3.0, shell));
  ASSERT_OK(AffineSystemSet(op, 250.0, -0.4, shell));
  ASSERT_OK(MatCreateVecs(expected, &x, &y));
  ASSERT_OK(VecDuplicate(y, &right));
  ASSERT_OK(VecSetRandom(x, NULL));
  ASSERT_OK(MatMult(shell, x, y));
  ASSERT_OK(MatMult(expected, x, right));
  AssertEqual("product of a shell", name, y, right);
  ASSERT_OK(AffineSystemFlatten(shell, &flat));
  ASSERT_OK(MatMult(flat, x, y));
  AssertEqual("product of its matrix", name, y, right);
  ASSERT_OK(MatGetDiagonal(shell, y));
  ASSERT_OK(MatGetDiagonal(expected, right));
  AssertEqual("diagonal of a shell", name, y, right);
  ASSERT_OK(VecDestroy(&x));
  ASSERT_OK(VecDestroy(&y));
  ASSERT_OK(VecDestroy(&right));
  ASSERT_OK(MatDestroy(&flat));
  ASSERT_OK(MatDestroy(&shell));
}

/* The matrix is the same from the rows and from the matrix of the operator, for each type, and also
   if its values are set twice; a shell has the same entries, products and diagonal. */
static void test_system(void **state)
{
  const char *const types[] = {MATSAME, MATBAIJ};

  (void)state;
  for (size_t k = 0; k < 2 * BOXES; k++) {
    const char    *name = boxes[k / 2].name;
    Cloud          cloud;
    AffineOperator by_rows;
    Mat            J, expected, plain;
    PetscReal      norm, difference;

    ASSERT_OK(CloudCreate(&boxes[k / 2], "", &cloud));
    by_rows   = cloud.ops->velocity[0].visc;
    by_rows.A = by_rows.B = NULL;
    ASSERT_OK(AffineSystemCreate(&by_rows, types[k % 2], &J));
    ASSERT_OK(AffineSystemSet(&by_rows, 7.0, 3.0, J));
    ASSERT_OK(AffineSystemSet(&by_rows, 250.0, -0.4, J));
    ASSERT_OK(AffineSystemCreate(&cloud.ops->velocity[0].visc, MATSAME, &expected));
    ASSERT_OK(AffineSystemSet(&cloud.ops->velocity[0].visc, 250.0, -0.4, expected));
    ASSERT_OK(MatNorm(expected, NORM_FROBENIUS, &norm));
    ASSERT_OK(MatConvert(J, MATAIJ, MAT_INITIAL_MATRIX, &plain));
    ASSERT_OK(MatAXPY(plain, -1.0, expected, DIFFERENT_NONZERO_PATTERN));
    ASSERT_OK(MatNorm(plain, NORM_FROBENIUS, &difference));
    CloudAssertNone(types[k % 2], name, !(difference <= ROUNDING * norm));
    ASSERT_OK(MatDestroy(&plain));
    CheckShell(&by_rows, name, expected);
    ASSERT_OK(MatDestroy(&expected));
    ASSERT_OK(MatDestroy(&J));
    ASSERT_OK(CloudDestroy(&cloud));
  }
}

/* Returns the largest difference of two rows over the largest weight. */
static PetscReal RowDifference(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal most = 0.0, difference = 0.0;

  for (PetscInt k = 0; k < n; k++) {
    most       = PetscMax(most, PetscAbsReal(b[k]));
    difference = PetscMax(difference, PetscAbsReal(a[k] - b[k]));
  }
  return difference / most;
}

/* Compares the rows of a fit of a degree in a batch with those of the same fit alone; returns the
   number of errors. Normal equations of condition 1e4 amplify rounding. Filters have even degrees.
   Counts fits in `compared`, but for those that their neighbours do not determine, which a batch
   skips. Not collective. */
static PetscInt CompareFits(PetscInt degree, Stencil *st, PetscInt *compared)
{
  const PetscInt n = st->n, rows = 2 + st->dim, first = degree % 2;
  PetscReal     *kept, *w, *g[ISPH_MAX_DIM], *of_fit[] = {st->fit.filter, st->fit.laplacian};
  PetscBool      in_batch = st->fit.wanted == degree ? PETSC_TRUE : PETSC_FALSE;
  PetscInt       wrong    = 0;

  if (PetscMalloc2(rows * n, &kept, rows * n, &w)) return 1;
  for (PetscInt r = 0; r < rows; r++) {
    const PetscReal *row = r < 2 ? of_fit[r] : st->fit.gradient[r - 2];

    if (r >= 2) g[r - 2] = w + r * n;
    for (PetscInt k = 0; k < n; k++) kept[r * n + k] = row[k];
  }
  st->fit.wanted = 0; /* computes the fit anew */
  st->degree     = degree;
  if (LaplacianRow_Mls(st, w + n) || GradientRow_Mls(st, g)) wrong++;
  if (first == 0 && FilterRow_Mls(st, w)) wrong++;
  if (st->fit.degree == degree) wrong += in_batch ? 0 : 1;
  for (PetscInt r = first; in_batch && r < rows; r++)
    wrong += RowDifference(n, kept + r * n, w + r * n) < 1e-11 ? 0 : 1;
  if (in_batch) (*compared)++;
  return PetscFree2(kept, w) ? wrong + 1 : wrong;
}

/* Compares fits of a degree about all particles of a cloud. */
static void CompareBatches(const Cloud *cloud, const char *name, PetscInt degree)
{
  Stencil **batch = cloud->ops->work->batch;
  PetscInt  wrong = 0, compared = 0;

  for (PetscInt i = 0; i < cloud->particles->n_fluid; i += MLS_BATCH) {
    const PetscInt count = PetscMin(MLS_BATCH, cloud->particles->n_fluid - i);

    for (PetscInt l = 0; l < count; l++) {
      wrong += GatherStencil(&cloud->scene, cloud->particles, cloud->neighbors, cloud->ops, i + l,
                             batch[l])
                   ? 1
                   : 0;
    }
    wrong += MlsFitBatch(degree, count, batch, cloud->ops->work->fits) ? 1 : 0;
    for (PetscInt l = 0; l < count; l++) wrong += CompareFits(degree, batch[l], &compared);
  }
  CloudAssertNone("rows of a batch", name, wrong);
  ASSERT_OK(MPI_Allreduce(MPI_IN_PLACE, &compared, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  CloudAssertNone("fits in a batch", name, compared == 0);
}

static void test_batch(void **state)
{
  const char *const wide[] = {"-h_over_dx 1.3", "-h_over_dx 1.6", "-h_over_dx 2"};

  (void)state;
  for (size_t b = 0; b < BOXES; b++) {
    for (PetscInt degree = 2; degree <= 4; degree++) {
      Cloud cloud;

      ASSERT_OK(CloudCreate(&boxes[b], wide[degree - 2], &cloud));
      CompareBatches(&cloud, boxes[b].name, degree);
      ASSERT_OK(CloudDestroy(&cloud));
    }
  }
}

/* Creates a matrix of 12 rows and 10 columns on each rank; row i has each stride-th column of all
   ranks from i % stride on. */
static void SparseMat(PetscInt stride, Mat *A)
{
  SparseRows  rows;
  PetscMPIInt size, rank;
  PetscInt    q = 0;

  ASSERT_OK(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  ASSERT_OK(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  ASSERT_OK(SparseRowsMalloc(12, 12 * 10 * size, &rows));
  for (PetscInt i = 0; i < 12; i++) {
    for (PetscInt c = i % stride; c < 10 * size; c += stride) {
      rows.col[q]     = c;
      rows.value[q++] = 1.0 / (1.0 + c + stride * i + rank);
    }
    rows.row[i + 1] = q;
  }
  ASSERT_OK(SparseRowsMat(PETSC_COMM_WORLD, &rows, 10, A));
}

/* The sum of matrices of different patterns has the entries of both, as PETSc's. */
static void test_sums(void **state)
{
  PetscReal norm;
  PetscBool equal;
  Mat       X, Y, sum;

  (void)state;
  SparseMat(2, &X);
  SparseMat(3, &Y);
  ASSERT_OK(MatDuplicate(Y, MAT_COPY_VALUES, &sum));
  ASSERT_OK(MatAXPY(sum, 1.0, X, DIFFERENT_NONZERO_PATTERN));
  ASSERT_OK(SparseAdd(X, &Y));
  ASSERT_OK(MatEqual(Y, sum, &equal));
  assert_true(equal);
  ASSERT_OK(MatNorm(sum, NORM_FROBENIUS, &norm));
  assert_true(norm > 1.0);
  ASSERT_OK(MatDestroy(&sum));
  ASSERT_OK(MatDestroy(&Y));
  ASSERT_OK(MatDestroy(&X));
}

int main(int argc, char *argv[])
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_products), cmocka_unit_test(test_repeats),
      cmocka_unit_test(test_system),   cmocka_unit_test(test_fitted),
      cmocka_unit_test(test_batch),    cmocka_unit_test(test_sums)};
  int failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  return PetscFinalize() || failed;
}
