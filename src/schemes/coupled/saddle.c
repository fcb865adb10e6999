/*
  The matrix of the coupled system, scaled so that all entries are of order 1 and residuals of
  momentum and of mass have equal size. The unknowns are the velocity u and the scaled pressure q.
  With p = rho dx/T q and 1/T = 1/(4 dt) + nu/dx^2 (steady: nu/dx^2):

    [ T (shift - nu L)   dx G          ] [u]   [T f]
    [ dx D               C + c c^T     ] [q] = [g  ]

  L, G and D are the operators of Laplacian, gradient and divergence; shift is the factor of u in
  du/dt; f and g contain forces and wall data. G is one-sided at walls: the wall pressure gradient
  follows from the momentum equation of the particles next to the wall. All unknowns belong to the
  same particles, so G and D do not act on grid modes of the pressure. C q, the residual of a
  quadratic fit of q, brings these modes into the continuity equation. For smooth pressures it is a
  flux of order dx^3 (dx^4 inside lattices); it vanishes for quadratic pressures and needs no
  condition at walls. The column c of GaugeColumn() fixes the constant of the pressure. See
  docs/theory.md, (92) to (94).
*/
#include "saddle.h"
#include "schemes/step.h"

/* Numbers of interlaced components in the rows and in the columns of a block. */
typedef struct {
  PetscInt rows, cols; /* 1 or dim */
} Interlacing;

/* Creates a block, scale times the operators op[c] on the shared pattern; op[c] fills rows
   dim i + c or columns dim j + c. */
static PetscErrorCode BlockCreate(const Particles *p, const Pattern *pattern, Interlacing by,
                                  PetscReal scale, const AffineOperator op[], MatType type,
                                  Mat *block)
{
  const PetscInt n = p->n_fluid, entries = pattern->row[n];
  PetscInt      *row, *col, q = 0;
  PetscScalar   *value;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(by.rows * n + 1, &row, by.rows * by.cols * entries, &col,
                         by.rows * by.cols * entries, &value));
  row[0] = 0;
  for (PetscInt r = 0; r < by.rows * n; r++) {
    const PetscInt i = r / by.rows;

    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++) {
      for (PetscInt c = 0; c < by.cols; c++) {
        col[q]     = by.cols * pattern->col[s] + c;
        value[q++] = scale * op[by.rows > 1 ? r % by.rows : c].a[s];
      }
    }
    row[r + 1] = q;
  }
  PetscCall(MatCreate(p->comm, block));
  PetscCall(MatSetSizes(*block, by.rows * n, by.cols * n, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(*block, MATAIJ));
  PetscCall(MatSeqAIJSetPreallocationCSR(*block, row, col, value));
  PetscCall(MatMPIAIJSetPreallocationCSR(*block, row, col, value));
  PetscCall(PetscFree3(row, col, value));
  PetscCall(MatConvert(*block, type, MAT_INPLACE_MATRIX, block));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix T (-nu L + v.grad) of a velocity component, then the matrix of all interlaced
   components; v: `advecting`, if given. */
static PetscErrorCode ViscousCreate(const Scene *scene, const Operators *ops, PetscReal step,
                                    const Vec advecting[], Mat *viscous)
{
  Mat scalar, gradient, all;

  PetscFunctionBegin;
  PetscCall(MatDuplicate(ops->velocity[0].visc.A, MAT_COPY_VALUES, &scalar));
  PetscCall(MatScale(scalar, -scene->nu * step));
  for (PetscInt a = 0; advecting && a < scene->dim; a++) {
    PetscCall(MatDuplicate(ops->velocity[0].grad_u[a].A, MAT_COPY_VALUES, &gradient));
    PetscCall(MatDiagonalScale(gradient, advecting[a], NULL));
    PetscCall(MatAXPY(scalar, step, gradient, UNKNOWN_NONZERO_PATTERN));
    PetscCall(MatDestroy(&gradient));
  }
  PetscCall(MatCreateMAIJ(scalar, scene->dim, &all));
  PetscCall(MatConvert(all, MATAIJ, MAT_INITIAL_MATRIX, viscous));
  PetscCall(MatSetBlockSize(*viscous, scene->dim));
  PetscCall(MatDestroy(&all));
  PetscCall(MatDestroy(&scalar));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SaddleAssemble - Assembles all blocks except F from the present operators; for F see
  SaddleSetShift()

  Collective.

  Input Parameters:
+ step      - T, the factor that scales the momentum equation [s]
. advecting - advecting velocity of implicit convection [m/s]; NULL: no implicit convection
- type      - of the blocks, from SolverMatType()
*/
PetscErrorCode SaddleAssemble(const Scene *scene, const Particles *p, const Operators *ops,
                              PetscReal step, const Vec advecting[], MatType type, Saddle *s)
{
  const Interlacing tall = {scene->dim, 1}, wide = {1, scene->dim}, single = {1, 1};

  PetscFunctionBegin;
  PetscCall(SaddleFree(s));
  s->dim        = scene->dim;
  s->n          = p->n_fluid;
  s->step       = step;
  s->unit       = scene->rho * scene->dx / step;
  s->shift      = NAN;
  s->assemblies = ops->assemblies;
  PetscCall(ViscousCreate(scene, ops, step, advecting, &s->viscous));
  PetscCall(MatConvert(s->viscous, type, MAT_INITIAL_MATRIX, &s->F));
  PetscCall(BlockCreate(p, &ops->fluid, tall, scene->dx, ops->grad_p, type, &s->G));
  PetscCall(BlockCreate(p, &ops->fluid, wide, scene->dx, ops->div, type, &s->D));
  PetscCall(BlockCreate(p, &ops->fluid, single, 1.0, &ops->filter_p, type, &s->C));
  PetscCall(GaugeColumn(p, scene->dim, &s->gauge));
  PetscCall(MatCreateNest(p->comm, 2, NULL, 2, NULL, (Mat[]){s->F, s->G, s->D, s->C}, &s->P));
  PetscCall(MatCreateLRC(s->P, s->gauge, NULL, s->gauge, &s->A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleSetShift - Computes the momentum block F = (T shift) I + viscous for a new shift, the
   factor of u in du/dt; collective */
PetscErrorCode SaddleSetShift(PetscReal shift, Saddle *s)
{
  PetscFunctionBegin;
  if (shift == s->shift) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCopy(s->viscous, s->F, SAME_NONZERO_PATTERN));
  PetscCall(MatShift(s->F, s->step * shift));
  for (PetscInt k = 0; k < 2; k++) { /* tells PETSc about the changed block */
    PetscCall(MatAssemblyBegin(k ? s->A : s->P, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(k ? s->A : s->P, MAT_FINAL_ASSEMBLY));
  }
  s->shift = shift;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleFree - Frees all matrices; collective */
PetscErrorCode SaddleFree(Saddle *s)
{
  Mat *all[] = {&s->A, &s->P, &s->gauge, &s->C, &s->D, &s->G, &s->F, &s->viscous};

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(all); k++) PetscCall(MatDestroy(all[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SaddleFlatten - Converts the blocks to a single sparse matrix, for preconditioners without blocks

  Collective. Adds 1e-6 to the diagonal of the pressure rows; otherwise the constant pressure would
  make the matrix singular. On entry flat is NULL, or a matrix of the same blocks that is reused.
*/
PetscErrorCode SaddleFlatten(Mat nest, Mat *flat)
{
  const PetscInt *index;
  PetscInt        n;
  IS              rows[2];

  PetscFunctionBegin;
  PetscCall(MatConvert(nest, MATAIJ, *flat ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX, flat));
  PetscCall(MatNestGetISs(nest, rows, NULL));
  PetscCall(ISGetLocalSize(rows[1], &n));
  PetscCall(ISGetIndices(rows[1], &index));
  for (PetscInt i = 0; i < n; i++)
    PetscCall(MatSetValue(*flat, index[i], index[i], 1e-6, ADD_VALUES));
  PetscCall(ISRestoreIndices(rows[1], &index));
  PetscCall(MatAssemblyBegin(*flat, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*flat, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddlePut - Sets x = (u, p/unit); not collective */
PetscErrorCode SaddlePut(const Saddle *s, Vec u[], Vec p, Vec x)
{
  const PetscScalar *from;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArray(x, &to));
  for (PetscInt c = 0; c < s->dim; c++) {
    PetscCall(VecGetArrayRead(u[c], &from));
    for (PetscInt i = 0; i < s->n; i++) to[s->dim * i + c] = from[i];
    PetscCall(VecRestoreArrayRead(u[c], &from));
  }
  PetscCall(VecGetArrayRead(p, &from));
  for (PetscInt i = 0; i < s->n; i++) to[s->dim * s->n + i] = from[i] / s->unit;
  PetscCall(VecRestoreArrayRead(p, &from));
  PetscCall(VecRestoreArray(x, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleGet - Extracts u and p from x = (u, p/unit); p may be NULL; not collective */
PetscErrorCode SaddleGet(const Saddle *s, Vec x, Vec u[], Vec p)
{
  const PetscScalar *from;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(x, &from));
  for (PetscInt c = 0; c < s->dim; c++) {
    PetscCall(VecGetArray(u[c], &to));
    for (PetscInt i = 0; i < s->n; i++) to[i] = from[s->dim * i + c];
    PetscCall(VecRestoreArray(u[c], &to));
  }
  if (p) {
    PetscCall(VecGetArray(p, &to));
    for (PetscInt i = 0; i < s->n; i++) to[i] = from[s->dim * s->n + i] * s->unit;
    PetscCall(VecRestoreArray(p, &to));
  }
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleAdd - Adds scale times `part` to the rows of velocity component c in x, or to the rows of
   the pressure if c = dim; not collective */
PetscErrorCode SaddleAdd(const Saddle *s, PetscInt c, PetscReal scale, Vec part, Vec x)
{
  const PetscInt     stride = c < s->dim ? s->dim : 1, first = c < s->dim ? c : s->dim * s->n;
  const PetscScalar *from;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(part, &from));
  PetscCall(VecGetArray(x, &to));
  for (PetscInt i = 0; i < s->n; i++) to[first + stride * i] += scale * from[i];
  PetscCall(VecRestoreArray(x, &to));
  PetscCall(VecRestoreArrayRead(part, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}
