/*
  Rows of a matrix that repeat: of a lattice of splines and fixed particles. Equal rows are stored
  once, so products read little memory. The matrix is a shell.
*/
#include "splines.h"

#define LEAST 1000 /* stored rows for which there is room in any case */
#define SHARE 4    /* more stored rows than this part of all rows do not repeat */

/* SplineRowsCreate - Creates n rows without entries; not collective. Input: each - values of an
   entry. */
PetscErrorCode SplineRowsCreate(PetscInt n, PetscInt each, SplineRows **rows)
{
  SplineRows *r;

  PetscFunctionBegin;
  PetscCall(PetscNew(&r));
  r->n    = n;
  r->each = each;
  r->size = 64;
  r->most = n / SHARE + LEAST;
  while (r->size < 2 * r->most) r->size *= 2;
  PetscCall(PetscMalloc1(n, &r->of));
  PetscCall(PetscMalloc1(r->size, &r->table));
  for (PetscInt k = 0; k < r->size; k++) r->table[k] = -1;
  r->row_room = LEAST;
  PetscCall(PetscCalloc1(r->row_room + 1, &r->first));
  *rows = r;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineRowsDestroy - Frees rows; not collective */
PetscErrorCode SplineRowsDestroy(SplineRows **rows)
{
  PetscFunctionBegin;
  if (!*rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*rows)->of));
  PetscCall(PetscFree((*rows)->base));
  PetscCall(PetscFree((*rows)->first));
  PetscCall(PetscFree((*rows)->offset));
  PetscCall(PetscFree((*rows)->value));
  PetscCall(PetscFree((*rows)->table));
  PetscCall(PetscFree(*rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for a further row with n entries. */
static PetscErrorCode RowsReserve(PetscInt n, SplineRows *r)
{
  const PetscInt end = r->first[r->stored] + n;

  PetscFunctionBegin;
  if (r->stored == r->row_room) {
    r->row_room *= 2;
    PetscCall(PetscRealloc(sizeof(*r->first) * (size_t)(r->row_room + 1), &r->first));
  }
  if (end <= r->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  r->capacity = end + r->capacity / 4;
  PetscCall(PetscRealloc(sizeof(*r->offset) * (size_t)r->capacity, &r->offset));
  PetscCall(PetscRealloc(sizeof(*r->value) * (size_t)(r->capacity * r->each), &r->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineRowsStore - Stores a row as row k, after `head` entries for the caller; not collective */
PetscErrorCode SplineRowsStore(const SplineEntries *row, PetscInt head, PetscInt k, SplineRows *r)
{
  const PetscInt base = r->base ? r->base[k] : k;
  PetscInt       at   = r->first[r->stored] + head;

  PetscFunctionBegin;
  PetscCall(RowsReserve(row->n + head, r));
  for (PetscInt e = 0; e < row->n; e++) r->offset[at + e] = row->column[e] - base;
  PetscCall(PetscArraycpy(r->value + at * r->each, row->value, row->n * r->each));
  r->of[k]            = r->stored++;
  r->first[r->stored] = at + row->n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesAdd - Adds values to the entry of a column; not collective */
PetscErrorCode SplineEntriesAdd(PetscInt column, const PetscReal value[], SplineEntries *row)
{
  PetscFunctionBegin;
  if (row->place[column] < 0) {
    if (row->n == row->capacity) {
      row->capacity = 2 * row->capacity + 256;
      PetscCall(PetscRealloc(sizeof(*row->column) * (size_t)row->capacity, &row->column));
      PetscCall(
          PetscRealloc(sizeof(*row->value) * (size_t)(row->capacity * ISPH_MAX_DIM), &row->value));
    }
    row->place[column]    = row->n;
    row->column[row->n++] = column;
    for (PetscInt a = 0; a < row->each; a++) row->value[row->place[column] * row->each + a] = 0.0;
  }
  for (PetscInt a = 0; a < row->each; a++)
    row->value[row->place[column] * row->each + a] += value[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineEntriesClear - Removes all entries; not collective */
void SplineEntriesClear(SplineEntries *row)
{
  for (PetscInt e = 0; e < row->n; e++) row->place[row->column[e]] = -1;
  row->n = 0;
}

/* SplineRowsPlace - Returns the place in the table at which the search for a row begins, from whole
   numbers; not collective */
PetscInt SplineRowsPlace(PetscInt n, const PetscInt number[], const SplineRows *r)
{
  PetscInt64 hash = n;

  for (PetscInt k = 0; k < n; k++) hash = (hash * 31 + number[k]) % ((PetscInt64)1 << 48);
  if (hash < 0) hash = -hash;
  return (PetscInt)((hash ^ (hash >> 24)) & (r->size - 1));
}

/* Computes y = A x. */
static PetscErrorCode RowsMult(Mat A, Vec x, Vec y)
{
  const SplineRows  *r;
  const PetscScalar *in;
  PetscScalar       *out;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, (void *)&r));
  PetscCall(VecGetArrayRead(x, &in));
  PetscCall(VecGetArrayWrite(y, &out));
  for (PetscInt k = 0; k < r->n; k++) {
    PetscReal sum = 0.0;

    for (PetscInt e = r->first[r->of[k]]; e < r->first[r->of[k] + 1]; e++)
      sum += r->value[e] * in[k + r->offset[e]];
    out[k] = sum;
  }
  PetscCall(VecRestoreArrayWrite(y, &out));
  PetscCall(VecRestoreArrayRead(x, &in));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RowsMatDestroy(Mat A)
{
  SplineRows *r;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, (void *)&r));
  PetscCall(SplineRowsDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a matrix with the entries of the rows. */
static PetscErrorCode RowsFlatten(Mat A, Mat *flat)
{
  const SplineRows *r;
  PetscInt         *width, *column;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, (void *)&r));
  PetscCall(PetscMalloc2(r->n, &width, r->n, &column));
  for (PetscInt k = 0; k < r->n; k++) width[k] = r->first[r->of[k] + 1] - r->first[r->of[k]];
  PetscCall(SplineMat(PetscObjectComm((PetscObject)A), r->n, r->n, width, flat));
  for (PetscInt k = 0; k < r->n; k++) {
    const PetscInt at = r->first[r->of[k]];

    for (PetscInt e = 0; e < width[k]; e++) column[e] = k + r->offset[at + e];
    PetscCall(MatSetValues(*flat, 1, &k, width[k], column, r->value + at, INSERT_VALUES));
  }
  PetscCall(PetscFree2(width, column));
  PetscCall(SplineMatFinish(*flat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineRowsShell - Creates the square matrix of rows, which it owns then; collective */
PetscErrorCode SplineRowsShell(MPI_Comm comm, SplineRows *rows, Mat *A)
{
  PetscFunctionBegin;
  PetscCall(MatCreateShell(comm, rows->n, rows->n, rows->n, rows->n, rows, A));
  PetscCall(MatShellSetOperation(*A, MATOP_MULT, (void (*)(void))RowsMult));
  PetscCall(MatShellSetOperation(*A, MATOP_DESTROY, (void (*)(void))RowsMatDestroy));
  PetscCall(PetscObjectComposeFunction((PetscObject)*A, MAT_FLATTEN, RowsFlatten));
  PetscFunctionReturn(PETSC_SUCCESS);
}
