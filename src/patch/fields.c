/* Fields of patch tests with their exact Laplacians, as functions of x in the unit square or cube.
   A new field needs two functions and a row of the table. */
#include "isph/patch.h"

/* Sums all monomials c x^i y^j z^k of the row's degrees or, if `laplacian`, their Laplacians. The
   coefficients c are 1, 1/2, 1/3, ... in the order of the monomials, or random numbers in (-1, 1)
   that follow from the seed. */
static PetscReal PolynomialSum(const FieldRow *row, PetscInt dim, PetscInt seed,
                               const PetscReal x[], PetscBool laplacian)
{
  const PetscInt most = row->degree[1], most_z = dim == 3 ? most : 0;
  PetscReal      sum = 0.0;
  PetscInt       n   = 0;

  for (PetscInt i = 0; i <= most; i++) {
    for (PetscInt j = 0; j <= most - i; j++) {
      for (PetscInt k = 0; k <= PetscMin(most_z, most - i - j); k++) {
        const PetscInt e[ISPH_MAX_DIM] = {i, j, k};
        PetscReal      c, term = 1.0, second = 0.0;

        if (i + j + k < row->degree[0]) continue;
        c = row->random ? ParticlesHash(seed, n, 3) : 1.0 / (PetscReal)(n + 1);
        n++;
        for (PetscInt a = 0; a < dim; a++) term *= PetscPowRealInt(x[a], (int)e[a]);
        for (PetscInt a = 0; a < dim && laplacian; a++) {
          PetscReal part = (PetscReal)(e[a] * (e[a] - 1));

          if (e[a] < 2) continue;
          for (PetscInt b = 0; b < dim; b++)
            part *= PetscPowRealInt(x[b], (int)(b == a ? e[b] - 2 : e[b]));
          second += part;
        }
        sum += c * (laplacian ? second : term);
      }
    }
  }
  return sum;
}

static PetscReal PolynomialValue(const FieldRow *row, PetscInt dim, PetscInt seed,
                                 const PetscReal x[])
{
  return PolynomialSum(row, dim, seed, x, PETSC_FALSE);
}

static PetscReal PolynomialLaplacian(const FieldRow *row, PetscInt dim, PetscInt seed,
                                     const PetscReal x[])
{
  return PolynomialSum(row, dim, seed, x, PETSC_TRUE);
}

static PetscReal ZhengValue(const FieldRow *row, PetscInt dim, PetscInt seed, const PetscReal x[])
{
  PetscReal sum = 0.0;

  for (PetscInt a = 0; a < dim; a++) sum += PetscSqr(PetscSqr(x[a]));
  return sum;
}

static PetscReal ZhengLaplacian(const FieldRow *row, PetscInt dim, PetscInt seed,
                                const PetscReal x[])
{
  PetscReal sum = 0.0;

  for (PetscInt a = 0; a < dim; a++) sum += 12.0 * PetscSqr(x[a]);
  return sum;
}

/* Returns sin(2 pi x) cos(2 pi y) cos(2 pi z). */
static PetscReal WaveValue(const FieldRow *row, PetscInt dim, PetscInt seed, const PetscReal x[])
{
  PetscReal product = PetscSinReal(2.0 * PETSC_PI * x[0]);

  for (PetscInt a = 1; a < dim; a++) product *= PetscCosReal(2.0 * PETSC_PI * x[a]);
  return product;
}

static PetscReal WaveLaplacian(const FieldRow *row, PetscInt dim, PetscInt seed,
                               const PetscReal x[])
{
  return -4.0 * PETSC_PI * PETSC_PI * (PetscReal)dim * WaveValue(row, dim, seed, x);
}

/* Returns WaveValue() plus x^3 y^2 (times z^2 in 3D), which has no symmetry of the lattice. */
static PetscReal MixedValue(const FieldRow *row, PetscInt dim, PetscInt seed, const PetscReal x[])
{
  const PetscReal z2 = dim == 3 ? x[2] * x[2] : 1.0;

  return WaveValue(row, dim, seed, x) + x[0] * x[0] * x[0] * x[1] * x[1] * z2;
}

static PetscReal MixedLaplacian(const FieldRow *row, PetscInt dim, PetscInt seed,
                                const PetscReal x[])
{
  const PetscReal x3 = x[0] * x[0] * x[0], y2 = x[1] * x[1], z2 = dim == 3 ? x[2] * x[2] : 1.0;
  PetscReal       lap = 6.0 * x[0] * y2 * z2 + 2.0 * x3 * z2;

  if (dim == 3) lap += 2.0 * x3 * y2;
  return WaveLaplacian(row, dim, seed, x) + lap;
}

static const FieldRow fields[] = {
    {.name      = "mixed",
     .brief     = "sin(2 pi x) cos(2 pi y) + x^3 y^2, in 3D times cos(2 pi z) and z^2",
     .Value     = MixedValue,
     .Laplacian = MixedLaplacian},
    {.name      = "wave",
     .brief     = "sin(2 pi x) cos(2 pi y), in 3D times cos(2 pi z)",
     .Value     = WaveValue,
     .Laplacian = WaveLaplacian},
    {.name      = "zheng",
     .brief     = "x^4 + y^4, in 3D + z^4",
     .citation  = "Zheng, Ma & Shao, Water 10 (2018)",
     .Value     = ZhengValue,
     .Laplacian = ZhengLaplacian},
    {.name      = "constant",
     .brief     = "one",
     .Value     = PolynomialValue,
     .Laplacian = PolynomialLaplacian},
    {.name      = "linear",
     .brief     = "all monomials of degree 1",
     .degree    = {1, 1},
     .Value     = PolynomialValue,
     .Laplacian = PolynomialLaplacian},
    {.name      = "quadratic",
     .brief     = "all monomials of degree 2",
     .degree    = {2, 2},
     .Value     = PolynomialValue,
     .Laplacian = PolynomialLaplacian},
    {.name      = "cubic",
     .brief     = "all monomials of degree 3",
     .degree    = {3, 3},
     .Value     = PolynomialValue,
     .Laplacian = PolynomialLaplacian},
    {.name      = "quartic",
     .brief     = "all monomials of degree 4",
     .degree    = {4, 4},
     .Value     = PolynomialValue,
     .Laplacian = PolynomialLaplacian},
    {.name      = "random",
     .brief     = "all monomials up to degree 4, coefficients by -seed",
     .degree    = {0, 4},
     .random    = PETSC_TRUE,
     .Value     = PolynomialValue,
     .Laplacian = PolynomialLaplacian},
};
const Table FieldTable = TABLE("Fields of patch tests", fields);
