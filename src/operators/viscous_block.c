/*
  The viscous operator on all velocity components together, for forms that couple them and for
  rheologies. Component b of particle j is unknown number dim j + b, and

    (A u)_ia = sum_j sum_b w_ij,ab nu_ij/nu (u_j - u_i)_b.

  The weights w_ij,ab stay in the slots of the shared pattern, so that new viscosities nu_ij need no
  new rows.
*/
#include "isph/operators.h"
#include "isph/strain.h"
#include "rows/assembly.h"
#include "walls/boundary_rows.h"
#include "walls/wall_points.h"

/* Returns the number of matrix entries of a slot in a row: dim if the form couples components (a,
   b), otherwise 1, of the diagonal (a, a). */
static PetscInt SlotEntries(const Operators *ops, PetscInt dim)
{
  return ops->velocity[0].visc.width == 1 ? 1 : dim;
}

/* KeepBlockRow - Stores the weights of a row in their slots, for wall neighbours the weights of
   wall data from WallWeights(). The slot of the diagonal has the particle's own weight; a neighbour
   that is its periodic image has none. */
void KeepBlockRow(const Stencil *st, PetscInt diagonal, const PetscReal w[], Operators *ops)
{
  const PetscInt   width    = ops->velocity[0].visc.width;
  const PetscReal *of_walls = WallWeights(st, ops, width, w);
  PetscReal       *a, *b;

  EmptyRow(ops, st->i, &ops->velocity[0].visc, &a, &b);
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal       *to   = (st->wall[k] ? b : a) + ops->work->slot[k] * width;
    const PetscReal *from = st->wall[k] ? of_walls : w;

    for (PetscInt e = 0; e < width; e++) to[e] += from[k * width + e];
  }
  for (PetscInt e = 0; e < width; e++) a[diagonal * width + e] = width > 1 ? st->own[e] : 0.0;
}

/* AssembleViscousBlock - Creates the matrices of the viscous operator from the stored weights;
   collective on the particles' communicator */
PetscErrorCode AssembleViscousBlock(const Scene *scene, const Particles *p, Operators *ops)
{
  AffineOperator *visc    = &ops->velocity[0].visc;
  const PetscInt  entries = SlotEntries(ops, p->dim);

  PetscFunctionBegin;
  PetscCall(PatternBlocks(p, entries, &ops->rows.fluid, p->n_fluid, &visc->A));
  if (ops->forms.wall) PetscCall(PatternBlocks(p, entries, &ops->rows.walls, p->n_wall, &visc->B));
  PetscCall(OperatorsScaleViscosity(scene, p, ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The layout of a slot: its weights, and its entries in each of the dim rows of a particle, which
   are `stride` apart. */
typedef struct {
  PetscInt dim, width, entries, stride;
} Slot;

/* Multiplies the weights of a slot by `ratio`, a viscosity over scene->nu, writes them to its
   entries and adds them to the sum of the row. */
static void ScaleSlot(const Slot *slot, PetscReal ratio, const PetscReal w[], PetscReal to[],
                      PetscReal sum[])
{
  for (PetscInt a = 0, e = 0; a < slot->dim; a++) {
    for (PetscInt b = 0; b < slot->entries; b++, e++) {
      to[a * slot->stride + b] = ratio * w[slot->width == 1 ? 0 : e];
      sum[e] += to[a * slot->stride + b];
    }
  }
}

/* Computes the entries of the rows of particle i for the present viscosities. Input: value - arrays
   over fluid and over walls, the latter NULL without walls. */
static void ScaleRow(const Scene *scene, const Particles *p, const Operators *ops, PetscInt i,
                     PetscReal *const value[])
{
  const AffineOperator *op    = &ops->velocity[0].visc;
  const Pattern        *fluid = &ops->rows.fluid, *walls = &ops->rows.walls;
  const PetscInt        d = p->dim, entries = SlotEntries(ops, d);
  const PetscInt        first = fluid->row[i], n = fluid->row[i + 1] - first;
  const PetscInt        first_wall           = value[1] ? walls->row[i] : 0,
                 n_wall                      = value[1] ? walls->row[i + 1] - first_wall : 0;
  const PetscReal own                        = p->nu ? p->nu[i] / scene->nu : 1.0;
  const Slot      slot                       = {d, op->width, entries, entries * n},
             wall                            = {d, op->width, entries, entries * n_wall};
  PetscReal sum[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0}, *a = value[0] + d * entries * first;
  PetscInt  diagonal = 0;

  for (PetscInt k = 0; k < n; k++) {
    const PetscInt  s     = first + k;
    const PetscReal ratio = p->nu ? PairViscosity(own, p->nu[fluid->local[s]] / scene->nu) : own;

    if (fluid->col[s] == p->row[i]) diagonal = k;
    else ScaleSlot(&slot, ratio, &op->a[s * op->width], a + k * entries, sum);
  }
  for (PetscInt k = 0; k < n_wall; k++)
    ScaleSlot(&wall, own, &op->b[(first_wall + k) * op->width],
              value[1] + (d * first_wall + k) * entries, sum);
  for (PetscInt e = 0; e < d * entries; e++) {
    const PetscReal w = op->a[(first + diagonal) * op->width + (op->width == 1 ? 0 : e)];

    a[e / entries * slot.stride + diagonal * entries + e % entries] = own * w - sum[e];
  }
}

/* Computes the viscous matrices of strain cells for the present viscosities. Products have those of
   the cells. A tension has entries of its own in the matrix. */
static PetscErrorCode ScaleCells(const Scene *scene, const Particles *p, const Operators *ops)
{
  const AffineOperator *op = &ops->velocity[0].visc;

  PetscFunctionBegin;
  if (ops->cut_surface && p->dim == 3) {
    PetscCall(MatAssemblyBegin(op->A, MAT_FINAL_ASSEMBLY)); /* preconditioners are out of date */
    PetscCall(MatAssemblyEnd(op->A, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(StrainScale(scene, p, ops->strain, ops->cut_part[0] ? ops->cut_part[0] : op->A, op->B));
  if (!ops->cut_part[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatZeroEntries(op->A));
  for (PetscInt k = 0; k < 2; k++)
    PetscCall(MatAXPY(op->A, 1.0, ops->cut_part[k], SUBSET_NONZERO_PATTERN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsScaleViscosity - Computes the values of visc.A and visc.B for the present viscosities of
   particles. Collective on the particles' communicator. To be called only if
   ops->forms.components_coupled, and with viscosities that are up to date in the halo. */
PetscErrorCode OperatorsScaleViscosity(const Scene *scene, const Particles *p, Operators *ops)
{
  const AffineOperator *op      = &ops->velocity[0].visc;
  PetscReal            *value[] = {NULL, NULL};
  SparseRows           *a, *b;

  PetscFunctionBegin;
  if (ops->strain) {
    PetscCall(ScaleCells(scene, p, ops));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(SparseRowsGet(op->A, MAT_VALUES, &a));
  value[0] = a->value;
  if (ops->forms.wall) PetscCall(SparseRowsGet(op->B, MAT_VALUES, &b));
  if (ops->forms.wall) value[1] = b->value;
  for (PetscInt i = 0; i < p->n_fluid; i++) ScaleRow(scene, p, ops, i, value);
  PetscCall(PatternMatSet(a, op->A));
  if (ops->forms.wall) PetscCall(PatternMatSet(b, op->B));
  PetscFunctionReturn(PETSC_SUCCESS);
}
