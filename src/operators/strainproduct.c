/* Products with the viscous matrix of strainmatrix.c without its entries, cell by cell. In space a
   row would have the velocities of all particles within six spacings. */
#include "isph/operators.h"
#include "isph/strain.h"

/* The data of a product. */
typedef struct {
  const Scene       *scene;
  const Particles   *p;
  const StrainCells *cells;
  PetscBool          walls; /* the product is with velocities of walls */
  PetscReal         *u;     /* work: component a of particle j at [j dim + a], of all particles */
} Product;

/* Sets the velocities of all particles from those of the vector; others are zero. */
static PetscErrorCode SetVelocities(const Product *of, Vec x)
{
  const Particles   *p     = of->p;
  const PetscInt     first = of->walls ? p->n_fluid : 0, n = of->walls ? p->n_wall : p->n_fluid;
  const PetscScalar *v;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(of->u, p->dim * ParticlesAll(p)));
  PetscCall(VecGetArrayRead(x, &v));
  for (PetscInt e = 0; e < p->dim * n; e++) of->u[p->dim * first + e] = PetscRealPart(v[e]);
  PetscCall(VecRestoreArrayRead(x, &v));
  PetscCall(ParticlesHaloVectors(p, of->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the velocity gradient in a cell whose components have the same weights in 3D. */
static void GradientInSpace(const StrainCells *s, PetscInt c, const PetscReal u[],
                            PetscReal g[][ISPH_MAX_DIM])
{
  const PetscReal *const w[] = {s->g[0][0], s->g[0][1], s->g[0][2]};

  for (PetscInt k = s->first[0][c]; k < s->first[0][c + 1]; k++) {
    const PetscReal *v = &u[3 * s->j[0][k]];

    for (PetscInt a = 0; a < 3; a++)
      for (PetscInt b = 0; b < 3; b++) g[a][b] += v[a] * w[b][k];
  }
}

/* Computes V_c nu_c/nu_0 (grad u + grad u^T) of cell c. */
static void StressOf(const Product *of, PetscInt c, PetscReal stress[][ISPH_MAX_DIM])
{
  const StrainCells *s                             = of->cells;
  const PetscInt     d                             = of->p->dim;
  const PetscReal    factor                        = s->volume[c] * s->nu[c] / of->scene->nu;
  PetscReal          g[ISPH_MAX_DIM][ISPH_MAX_DIM] = {{0.0}};

  if (d == 3 && s->sets == 1) GradientInSpace(s, c, of->u, g);
  for (PetscInt a = 0; a < d && !(d == 3 && s->sets == 1); a++) {
    const PetscInt q = s->sets == 1 ? 0 : a;

    for (PetscInt b = 0; b < d; b++) {
      PetscReal sum = 0.0;

      for (PetscInt k = s->first[q][c]; k < s->first[q][c + 1]; k++)
        sum += s->g[q][b][k] * of->u[s->j[q][k] * d + a];
      g[a][b] = sum;
    }
  }
  for (PetscInt a = 0; a < d; a++)
    for (PetscInt b = 0; b < d; b++) stress[a][b] = factor * (g[a][b] + g[b][a]);
}

/* Subtracts the forces of the stress in a cell whose components have the same weights in 3D. */
static void ForcesInSpace(const StrainCells *s, PetscInt c, PetscInt n_fluid,
                          PetscReal stress[][ISPH_MAX_DIM], PetscScalar to[])
{
  const PetscReal *const w[] = {s->g[0][0], s->g[0][1], s->g[0][2]};

  for (PetscInt k = s->first[0][c]; k < s->first[0][c + 1]; k++) {
    const PetscInt j = s->j[0][k];

    if (j >= n_fluid) continue;
    for (PetscInt a = 0; a < 3; a++)
      to[3 * j + a] -= (w[0][k] * stress[a][0] + w[1][k] * stress[a][1] + w[2][k] * stress[a][2]) /
                       s->mass[0][j];
  }
}

static PetscErrorCode Product_Mult(Mat A, Vec x, Vec y)
{
  Product           *of;
  const Particles   *p;
  const StrainCells *s;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &of));
  p = of->p;
  s = of->cells;
  PetscCall(SetVelocities(of, x));
  PetscCall(VecZeroEntries(y));
  PetscCall(VecGetArray(y, &to));
  for (PetscInt c = 0; c < s->all; c++) {
    PetscReal stress[ISPH_MAX_DIM][ISPH_MAX_DIM];

    StressOf(of, c, stress);
    if (p->dim == 3 && s->sets == 1) ForcesInSpace(s, c, p->n_fluid, stress, to);
    for (PetscInt a = 0; a < p->dim && !(p->dim == 3 && s->sets == 1); a++) {
      const PetscInt q = s->sets == 1 ? 0 : a;

      for (PetscInt k = s->first[q][c]; k < s->first[q][c + 1]; k++) {
        const PetscInt j   = s->j[q][k];
        PetscReal      sum = 0.0;

        if (j >= p->n_fluid) continue;
        for (PetscInt b = 0; b < p->dim; b++) sum += s->g[q][b][k] * stress[a][b];
        to[p->dim * j + a] -= sum / s->mass[q][j];
      }
    }
  }
  PetscCall(VecRestoreArray(y, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Product_GetDiagonal(Mat A, Vec diagonal)
{
  Product           *of;
  const Particles   *p;
  const StrainCells *s;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &of));
  p = of->p;
  s = of->cells;
  PetscCall(VecZeroEntries(diagonal));
  PetscCall(VecGetArray(diagonal, &to));
  for (PetscInt c = 0; c < s->all; c++) {
    const PetscReal factor = s->volume[c] * s->nu[c] / of->scene->nu;

    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscInt q = s->sets == 1 ? 0 : a;

      for (PetscInt k = s->first[q][c]; k < s->first[q][c + 1]; k++) {
        const PetscInt j   = s->j[q][k];
        PetscReal      sum = PetscSqr(s->g[q][a][k]);

        if (j >= p->n_fluid) continue;
        for (PetscInt b = 0; b < p->dim; b++) sum += PetscSqr(s->g[q][b][k]);
        to[p->dim * j + a] -= factor * sum / s->mass[q][j];
      }
    }
  }
  PetscCall(VecRestoreArray(diagonal, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Product_Destroy(Mat A)
{
  Product *of;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &of));
  PetscCall(FreeAll(&of->u, &of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainProducts - Creates the viscous matrix over interlaced components of fluid, or of walls,
   whose products read the present cells; they last as long as these; collective */
PetscErrorCode StrainProducts(const Scene *scene, const Particles *p, PetscBool walls,
                              const StrainCells *cells, Mat *A)
{
  const PetscInt d = p->dim;
  Product       *of;

  PetscFunctionBegin;
  PetscCall(PetscNew(&of));
  *of = (Product){.scene = scene, .p = p, .cells = cells, .walls = walls};
  PetscCall(PetscMalloc1(d * ParticlesAll(p) + 1, &of->u));
  PetscCall(MatCreateShell(p->comm, d * p->n_fluid, d * (walls ? p->n_wall : p->n_fluid),
                           PETSC_DETERMINE, PETSC_DETERMINE, of, A));
  PetscCall(MatShellSetOperation(*A, MATOP_MULT, (void (*)(void))Product_Mult));
  PetscCall(MatShellSetOperation(*A, MATOP_DESTROY, (void (*)(void))Product_Destroy));
  if (!walls)
    PetscCall(MatShellSetOperation(*A, MATOP_GET_DIAGONAL, (void (*)(void))Product_GetDiagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}
