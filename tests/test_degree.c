/*
  Least-squares fits of every degree: gradient, Laplacian, divergence, pressure rows and filters of
  polynomials of the degree are exact on disordered particles, inside and beside walls, in 2D and
  3D; one degree lower they are not.
*/
/* RANKS: 1 2 */
#include "cloud.h"

#define MOST_TERMS 56 /* monomials up to degree 5 in 3D */

/* A field of all monomials up to a degree of s = (x - centre)/(4 dx). */
typedef struct {
  PetscInt  degree;
  PetscReal c[MOST_TERMS];
} Polynomial;

static Polynomial MakeField(PetscInt degree, PetscInt seed)
{
  Polynomial f = {.degree = degree};

  for (PetscInt t = 0; t < MOST_TERMS; t++) f.c[t] = ParticlesHash(seed, t, 0);
  return f;
}

/* Returns s^power differentiated `times` times. */
static PetscReal Power(PetscReal s, PetscInt power, PetscInt times)
{
  PetscReal value = 1.0;

  for (PetscInt k = 0; k < times; k++) value *= (PetscReal)(power - k);
  for (PetscInt k = 0; k < power - times; k++) value *= s;
  return power < times ? 0.0 : value;
}

/* Returns the derivative of a field, `times[a]` times along axis a, at local particle i. */
static PetscReal FieldAt(const Cloud *cloud, const Polynomial *f, const PetscInt times[],
                         PetscInt i)
{
  const PetscInt  last            = cloud->scene.dim == 3 ? f->degree : 0;
  const PetscReal length          = 4.0 * cloud->scene.dx;
  PetscReal       s[ISPH_MAX_DIM] = {0.0}, sum = 0.0, scale = 1.0;
  PetscInt        t = 0;

  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    const PetscReal centre = 0.5 * (cloud->scene.lo[a] + cloud->scene.hi[a]);

    s[a] = (cloud->particles->x[a][i] - centre) / length;
    for (PetscInt k = 0; k < times[a]; k++) scale /= length;
  }
  for (PetscInt x = 0; x <= f->degree; x++) {
    for (PetscInt y = 0; x + y <= f->degree; y++) {
      for (PetscInt z = 0; z <= last && x + y + z <= f->degree; z++)
        sum += f->c[t++] * Power(s[0], x, times[0]) * Power(s[1], y, times[1]) *
               Power(s[2], z, times[2]);
    }
  }
  return scale * sum;
}

/* Sets f over fluid, and over walls its values or, if `slope`, n.grad f. */
static void SetField(const Cloud *cloud, const Polynomial *f, PetscBool slope, Vec fluid, Vec walls)
{
  const Particles *p          = cloud->particles;
  const PetscInt   none[3]    = {0, 0, 0};
  const PetscInt   unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  PetscReal       *value;

  ASSERT_OK(VecGetArray(fluid, &value));
  for (PetscInt i = 0; i < p->n_fluid; i++) value[i] = FieldAt(cloud, f, none, i);
  ASSERT_OK(VecRestoreArray(fluid, &value));
  ASSERT_OK(VecGetArray(walls, &value));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt i = p->n_fluid + k;

    value[k] = slope ? 0.0 : FieldAt(cloud, f, none, i);
    for (PetscInt a = 0; slope && a < p->dim; a++)
      value[k] += p->normal[a][i] * FieldAt(cloud, f, unit[a], i);
  }
  ASSERT_OK(VecRestoreArray(walls, &value));
}

/* Returns the largest |y - exact| dx^order over fluid, the exact value a sum over the given
   derivatives of n fields. */
static PetscReal Largest(const Cloud *cloud, PetscInt n, const Polynomial f[],
                         const PetscInt times[][3], PetscInt order)
{
  const PetscReal *y;
  PetscReal        worst = 0.0;

  ASSERT_OK(VecGetArrayRead(cloud->y, &y));
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) {
    PetscReal exact = 0.0;

    for (PetscInt k = 0; k < n; k++) exact += FieldAt(cloud, &f[k], times[k], i);
    worst = PetscMax(worst, PetscAbsReal(y[i] - exact) * PetscPowRealInt(cloud->scene.dx, order));
  }
  ASSERT_OK(VecRestoreArrayRead(cloud->y, &y));
  MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD);
  return worst;
}

/* Checks all operators on polynomials of degree `of`; their errors are rounding if `exact`. The
   bounds are those of quadratic fits in the other tests. */
static void CheckField(const char *where, const Cloud *cloud, PetscInt degree, PetscInt of,
                       PetscBool exact)
{
  const Operators *ops         = cloud->ops;
  const PetscInt   dim         = cloud->scene.dim;
  const PetscInt   unit[3][3]  = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const PetscInt   twice[3][3] = {{2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  const Polynomial f[3]        = {MakeField(of, 1), MakeField(of, 2), MakeField(of, 3)};
  const Polynomial same[3]     = {f[0], f[0], f[0]};
  const Polynomial none        = {.degree = 0};
  const PetscInt   zero[1][3]  = {{0, 0, 0}};

  for (PetscInt c = dim - 1; c >= 0; c--)
    SetField(cloud, &f[c], PETSC_FALSE, cloud->f[c], cloud->walls.u[c]);
  ASSERT_OK(CloudDivergence(cloud, cloud->y));
  CloudAssertNone("div", where, (Largest(cloud, dim, f, unit, 1) < 1e-8) != exact);
  ASSERT_OK(AffineApply(&ops->velocity[0].visc, cloud->f[0], cloud->walls.u[0], cloud->y));
  CloudAssertNone("lap u", where, (Largest(cloud, dim, same, twice, 2) < 1e-8) != exact);
  for (PetscInt a = 0; a < dim; a++) {
    ASSERT_OK(AffineApply(&ops->velocity[0].grad_u[a], cloud->f[0], cloud->walls.u[0], cloud->y));
    CloudAssertNone("grad u", where, (Largest(cloud, 1, f, &unit[a], 1) < 1e-8) != exact);
  }
  SetField(cloud, &f[0], PETSC_TRUE, cloud->f[0], cloud->e);
  if (ops->filter_p.needed && degree % 2 == 0) {
    ASSERT_OK(AffineApply(&ops->filter_p, cloud->f[0], cloud->e, cloud->y));
    CloudAssertNone("filter of p", where, (Largest(cloud, 1, &none, zero, 0) < 1e-8) != exact);
  } else if (!ops->filter_p.needed) {
    ASSERT_OK(AffineApply(&ops->ppe, cloud->f[0], cloud->e, cloud->y));
    ASSERT_OK(VecScale(cloud->y, -1.0 / PetscSqr(cloud->scene.dx)));
    CloudAssertNone("lap p", where, (Largest(cloud, dim, same, twice, 2) < 1e-8) != exact);
  }
  for (PetscInt a = 0; a < dim; a++) {
    ASSERT_OK(AffineApply(&ops->grad_p[a], cloud->f[0], cloud->e, cloud->y));
    CloudAssertNone("grad p", where, (Largest(cloud, 1, f, &unit[a], 1) < 1e-8) != exact);
  }
}

static void CheckBox(const CloudBox *box, PetscInt degree, const char more[])
{
  char  options[64];
  Cloud cloud;

  ASSERT_OK(
      PetscSNPrintf(options, sizeof(options), "-mls_degree %" PetscInt_FMT "%s", degree, more));
  ASSERT_OK(CloudCreate(box, options, &cloud));
  CloudAssertNone("a fit was not determined", options, cloud.ops->regularised_rows);
  CheckField(options, &cloud, degree, degree, PETSC_TRUE);
  CheckField(options, &cloud, degree, degree + 1, PETSC_FALSE);
  ASSERT_OK(CloudDestroy(&cloud));
}

/* Filters are checked where their degree is that of the fits, an even one. Fits to the fluid alone
   reach further: in a corner they have a quarter of the neighbours. */
static void test_exact(void **state)
{
  (void)state;
  for (PetscInt degree = 2; degree <= MLS_MAX_DEGREE; degree++) {
    CloudBox box = {.name = "box", .dim = 2, .cells = {10, 11, 9}, .jitter = 0.2};

    CheckBox(&box, degree, "");
    box.grad_p_without_walls = PETSC_TRUE;
    CheckBox(&box, degree, " -h_over_dx 3");
    box.grad_p_without_walls = PETSC_FALSE;
    box.dim                  = 3;
    CheckBox(&box, degree, "");
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_exact)};
  int                     failed;

  if (PetscInitialize(&argc, &argv, NULL, NULL)) return 1;
  failed = cmocka_run_group_tests(tests, NULL, NULL);
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
  return PetscFinalize() || failed ? 1 : 0;
}
