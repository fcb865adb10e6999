/*
  The preconditioner of the pressure on splines in a box without bodies: the exact inverse of

    K + c c^T,   c = M 1/sqrt(1^T M 1)

  by splinelattice.c. c fixes the mean of the pressure over the box; it is absent if a side gives
  the pressure, and numbers that are given stay. On several ranks the splines are first dealt out in
  slabs, which have all splines along all axes but one, and then for the
  product along this axis in slabs of another axis.
*/
#include "splines.h"

/* Splines of a rank if the lattice is divided evenly along one axis only. */
typedef struct {
  PetscInt axis, first[ISPH_MAX_DIM], n[ISPH_MAX_DIM], size;
  Vec      v; /* a number of each spline, in the order of the rank's block */
} SplineSlab;

struct SplineInverse {
  const Splines *splines;
  SplineTensor   tensor;
  PetscInt       dim, capacity;
  PetscReal     *work[2];
  PetscBool      spread; /* over several ranks */
  SplineSlab     slab, turned;
  VecScatter     deal, turn; /* splines -> slab -> turned */
};

/* Divides the lattice among the ranks along an axis. */
static PetscErrorCode SlabSet(const SplineLattice *l, MPI_Comm comm, PetscInt axis, SplineSlab *s)
{
  PetscMPIInt ranks, rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  s->axis = axis;
  s->size = 1;
  for (PetscInt a = 0; a < l->dim; a++) {
    s->first[a] = a == axis ? rank * l->count[a] / ranks : 0;
    s->n[a]     = a == axis ? (rank + 1) * l->count[a] / ranks - s->first[a] : l->count[a];
    s->size *= s->n[a];
  }
  PetscCall(VecCreateMPI(comm, s->size, PETSC_DETERMINE, &s->v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the global number of a spline in slabs. */
static PetscInt SlabNumber(const SplineLattice *l, PetscMPIInt ranks, PetscInt axis,
                           const PetscInt index[])
{
  const PetscInt count = l->count[axis], rank = ((index[axis] + 1) * ranks - 1) / count;
  const PetscInt first = rank * count / ranks, n = (rank + 1) * count / ranks - first;
  PetscInt       number = 0;

  for (PetscInt a = l->dim - 1; a >= 0; a--)
    number = a == axis ? number * n + index[a] - first : number * l->count[a] + index[a];
  return l->N / count * first + number;
}

/* Creates the scatter from a vector to the slabs of this rank; `from` of NULL: from the splines'
   own order. */
static PetscErrorCode SlabScatter(const Splines *s, const Particles *p, const SplineSlab *from,
                                  const SplineSlab *to, VecScatter *scatter)
{
  PetscInt   *number, start;
  PetscMPIInt ranks;
  IS          source, target;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(PetscMalloc1(to->size, &number));
  for (PetscInt k = 0; k < to->size; k++) {
    PetscInt index[ISPH_MAX_DIM];

    SplineIndex(s->lattice.dim, to->first, to->n, k, index);
    number[k] =
        from ? SlabNumber(&s->lattice, ranks, from->axis, index) : SplinesGlobal(s, p, index);
  }
  PetscCall(VecGetOwnershipRange(to->v, &start, NULL));
  PetscCall(ISCreateGeneral(p->comm, to->size, number, PETSC_OWN_POINTER, &source));
  PetscCall(ISCreateStride(p->comm, to->size, start, 1, &target));
  PetscCall(VecScatterCreate(from ? from->v : s->mass, source, to->v, target, scatter));
  PetscCall(ISDestroy(&source));
  PetscCall(ISDestroy(&target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the axis along which the boxes of the ranks are shortest in sum: slabs across it need the
   least communication. */
static PetscInt SplitAxis(const Splines *s, PetscMPIInt ranks)
{
  PetscReal least = PETSC_INFINITY;
  PetscInt  axis  = 0;

  for (PetscInt a = s->lattice.dim - 1; a >= 0; a--) {
    PetscReal sum = 0.0;

    for (PetscMPIInt r = 0; r < ranks; r++)
      sum += (PetscReal)s->block[r].n[a] / (PetscReal)s->lattice.count[a];
    if (sum >= least) continue;
    least = sum;
    axis  = a;
  }
  return axis;
}

static PetscErrorCode FreeSlabs(SplineInverse *v)
{
  PetscFunctionBegin;
  PetscCall(VecDestroyAll(&v->slab.v, &v->turned.v));
  PetscCall(VecScatterDestroy(&v->deal));
  PetscCall(VecScatterDestroy(&v->turn));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineInverseNumber - Prepares the inverse for the present numbers of the splines; collective */
PetscErrorCode SplineInverseNumber(const Splines *s, const Particles *p, SplineInverse *v)
{
  PetscInt    size = s->own.size;
  PetscMPIInt ranks;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(p->comm, &ranks));
  PetscCall(FreeSlabs(v));
  v->spread = ranks > 1;
  if (v->spread) {
    const PetscInt axis = SplitAxis(s, ranks);

    PetscCall(SlabSet(&s->lattice, p->comm, axis, &v->slab));
    PetscCall(SlabSet(&s->lattice, p->comm, axis ? axis - 1 : s->lattice.dim - 1, &v->turned));
    PetscCall(SlabScatter(s, p, NULL, &v->slab, &v->deal));
    PetscCall(SlabScatter(s, p, &v->slab, &v->turned, &v->turn));
    size = PetscMax(v->slab.size, v->turned.size);
  } else {
    v->slab = (SplineSlab){.axis = -1, .size = size};
    PetscCall(PetscArraycpy(v->slab.n, s->lattice.count, ISPH_MAX_DIM));
  }
  if (size <= v->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  v->capacity = size;
  for (PetscInt k = 0; k < 2; k++) {
    PetscCall(PetscFree(v->work[k]));
    PetscCall(PetscMalloc1(size, &v->work[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies all axes of a slab but its own, or only the axis given, by V^T or V: from v->work[0]
   to v->work[0]. */
static void TransformSlab(const SplineSlab *slab, PetscInt only, PetscBool back, SplineInverse *v)
{
  for (PetscInt a = 0; a < v->dim; a++) {
    PetscReal *from = v->work[0];

    if (a == slab->axis || (only >= 0 && a != only)) continue;
    SplineTensorAlong(&v->tensor, slab->n, a, back, from, v->work[1]);
    v->work[0] = v->work[1];
    v->work[1] = from;
  }
}

/* Moves numbers in v->work[0] from slabs of one kind to slabs of the other, or back. */
static PetscErrorCode TurnSlabs(ScatterMode mode, SplineInverse *v)
{
  const SplineSlab *from = mode == SCATTER_FORWARD ? &v->slab : &v->turned;
  const SplineSlab *to   = mode == SCATTER_FORWARD ? &v->turned : &v->slab;

  PetscFunctionBegin;
  PetscCall(VecPlaceArray(from->v, v->work[0]));
  PetscCall(VecPlaceArray(to->v, v->work[1]));
  PetscCall(VecScatterBegin(v->turn, from->v, to->v, INSERT_VALUES, mode));
  PetscCall(VecScatterEnd(v->turn, from->v, to->v, INSERT_VALUES, mode));
  PetscCall(VecResetArray(from->v));
  PetscCall(VecResetArray(to->v));
  for (PetscInt k = 0; k < to->size; k++) v->work[0][k] = v->work[1][k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves a vector to the slabs in v->work[0], or back. */
static PetscErrorCode Deal(Vec x, ScatterMode mode, SplineInverse *v)
{
  const PetscBool to_slabs = mode == SCATTER_FORWARD;
  PetscScalar    *a;

  PetscFunctionBegin;
  if (v->spread) {
    PetscCall(VecPlaceArray(v->slab.v, v->work[0]));
    PetscCall(VecScatterBegin(v->deal, to_slabs ? x : v->slab.v, to_slabs ? v->slab.v : x,
                              INSERT_VALUES, mode));
    PetscCall(VecScatterEnd(v->deal, to_slabs ? x : v->slab.v, to_slabs ? v->slab.v : x,
                            INSERT_VALUES, mode));
    PetscCall(VecResetArray(v->slab.v));
  } else if (to_slabs) {
    PetscCall(VecGetArrayRead(x, (const PetscScalar **)&a));
    PetscCall(PetscArraycpy(v->work[0], a, v->slab.size));
    PetscCall(VecRestoreArrayRead(x, (const PetscScalar **)&a));
  } else {
    PetscCall(VecGetArrayWrite(x, &a));
    PetscCall(PetscArraycpy(a, v->work[0], v->slab.size));
    PetscCall(VecRestoreArrayWrite(x, &a));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the numbers that sides give. */
static PetscErrorCode KeepGiven(const Splines *s, Vec b, Vec x)
{
  const PetscScalar *from;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(b, &from));
  PetscCall(VecGetArray(x, &to));
  for (PetscInt k = 0; k < s->n_unused; k++) to[s->unused[k]] = from[s->unused[k]];
  PetscCall(VecRestoreArray(x, &to));
  PetscCall(VecRestoreArrayRead(b, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineInverseApply - Computes x = (K + c c^T)^-1 b; collective */
PetscErrorCode SplineInverseApply(SplineInverse *v, Vec b, Vec x)
{
  PetscFunctionBegin;
  PetscCall(Deal(b, SCATTER_FORWARD, v));
  TransformSlab(&v->slab, -1, PETSC_FALSE, v);
  if (v->spread) {
    PetscCall(TurnSlabs(SCATTER_FORWARD, v));
    TransformSlab(&v->turned, v->slab.axis, PETSC_FALSE, v);
    SplineTensorDivide(&v->tensor, v->turned.first, v->turned.n, v->work[0]);
    TransformSlab(&v->turned, v->slab.axis, PETSC_TRUE, v);
    PetscCall(TurnSlabs(SCATTER_REVERSE, v));
  } else {
    SplineTensorDivide(&v->tensor, v->slab.first, v->slab.n, v->work[0]);
  }
  TransformSlab(&v->slab, -1, PETSC_TRUE, v);
  PetscCall(Deal(x, SCATTER_REVERSE, v));
  if (!v->tensor.floats) PetscCall(KeepGiven(v->splines, b, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineInverseColumn - Sets the column of the gauge to c; collective */
PetscErrorCode SplineInverseColumn(const Splines *s, Mat column)
{
  const PetscScalar *mass;
  PetscScalar       *c, sum;

  PetscFunctionBegin;
  PetscCall(VecSum(s->mass, &sum));
  PetscCall(VecGetArrayRead(s->mass, &mass));
  PetscCall(MatDenseGetArrayWrite(column, &c));
  for (PetscInt k = 0; k < s->own.size; k++) c[k] = mass[k] / PetscSqrtReal(sum);
  PetscCall(MatDenseRestoreArrayWrite(column, &c));
  PetscCall(VecRestoreArrayRead(s->mass, &mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineInverseCreate - Creates the inverse of the stiffness of splines without bodies; not
   collective */
PetscErrorCode SplineInverseCreate(const Splines *s, SplineInverse **inverse)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(inverse));
  (*inverse)->splines = s;
  (*inverse)->dim     = s->lattice.dim;
  PetscCall(SplineTensorSet(&s->lattice, s->scale, &(*inverse)->tensor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineInverseDestroy - Frees the inverse; collective */
PetscErrorCode SplineInverseDestroy(SplineInverse **inverse)
{
  SplineInverse *v = *inverse;

  PetscFunctionBegin;
  if (!v) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FreeSlabs(v));
  PetscCall(SplineTensorFree(&v->tensor));
  for (PetscInt k = 0; k < 2; k++) PetscCall(PetscFree(v->work[k]));
  PetscCall(PetscFree(*inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ApplyShell(PC pc, Vec b, Vec x)
{
  SplineInverse *v;

  PetscFunctionBegin;
  PetscCall(PCShellGetContext(pc, &v));
  PetscCall(SplineInverseApply(v, b, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineInversePC - Makes the inverse the product of a preconditioner of type shell; collective.
   The inverse is symmetric. */
PetscErrorCode SplineInversePC(SplineInverse *inverse, PC pc)
{
  PetscFunctionBegin;
  PetscCall(PCShellSetContext(pc, inverse));
  PetscCall(PCShellSetApply(pc, ApplyShell));
  PetscCall(PCShellSetApplyTranspose(pc, ApplyShell));
  PetscCall(PCShellSetName(pc, "tensor"));
  PetscFunctionReturn(PETSC_SUCCESS);
}
