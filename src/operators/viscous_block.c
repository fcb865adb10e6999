/*
  The viscous operator on all velocity components together, for forms that couple them and for
  rheologies. Component b of particle j is unknown number dim j + b, and

    (A u)_ia = sum_j sum_b w_ij,ab nu_ij/nu (u_j - u_i)_b.

  The weights w_ij,ab stay in the slots of the shared pattern, so that new viscosities nu_ij need no
  new rows.
*/
#include "assembly.h"
#include "boundary_rows.h"
#include "wall_points.h"

/* Returns the number of matrix entries of a slot: dim^2 if the form couples components (a, b),
   otherwise dim, of the diagonal (a, a). */
static PetscInt SlotEntries(const Operators *ops, PetscInt dim)
{
  return ops->velocity[0].visc.width == 1 ? dim : ops->velocity[0].visc.width;
}

/* KeepBlockRow - Stores the weights of a row in their slots, for wall neighbours the weights of
   wall data from WallWeights(). The slot of the diagonal has the particle's own weight; a neighbour
   that is its periodic image has none. Not collective. */
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

/* Creates a matrix of dim x dim blocks on a pattern, without values; columns: number of own
   particles that the columns stand for. */
static PetscErrorCode ViscousBlockMat(const Particles *p, const Operators *ops,
                                      const Pattern *pattern, PetscInt columns, Mat *A)
{
  const PetscInt d = p->dim, entries = SlotEntries(ops, d),
                 count = pattern->row[p->n_fluid] * entries;
  PetscInt *row, *col, n = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(count, &row, count, &col));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++) {
      for (PetscInt e = 0; e < entries; e++, n++) {
        row[n] = d * p->row[i] + (entries == d ? e : e / d);
        col[n] = d * pattern->col[s] + e % d;
      }
    }
  }
  PetscCall(MatCreate(p->comm, A));
  PetscCall(MatSetSizes(*A, d * p->n_fluid, d * columns, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetBlockSizes(*A, d, d));
  PetscCall(MatSetType(*A, MATAIJ));
  PetscCall(MatSetPreallocationCOO(*A, count, row, col));
  PetscCall(PetscFree2(row, col));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AssembleViscousBlock - Creates the matrices of the viscous operator from the stored weights;
   collective on the particles' communicator */
PetscErrorCode AssembleViscousBlock(const Scene *scene, const Particles *p, Operators *ops)
{
  PetscFunctionBegin;
  PetscCall(ViscousBlockMat(p, ops, &ops->rows.fluid, p->n_fluid, &ops->velocity[0].visc.A));
  if (ops->forms.wall)
    PetscCall(ViscousBlockMat(p, ops, &ops->rows.walls, p->n_wall, &ops->velocity[0].visc.B));
  PetscCall(OperatorsScaleViscosity(scene, p, ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies the weights of a slot by `ratio`, a viscosity over scene->nu, and adds them to the sum
   of the row. */
static void ScaleSlot(PetscInt width, PetscInt entries, PetscReal ratio, const PetscReal w[],
                      PetscReal value[], PetscReal sum[])
{
  for (PetscInt e = 0; e < entries; e++) {
    value[e] = ratio * w[width == 1 ? 0 : e];
    sum[e] += value[e];
  }
}

/*
  OperatorsScaleViscosity - Computes the values of visc.A and visc.B for the present viscosities of
  particles

  Collective on the particles' communicator. To be called only if ops->forms.components_coupled, and
  with viscosities that are up to date in the halo.
*/
PetscErrorCode OperatorsScaleViscosity(const Scene *scene, const Particles *p, Operators *ops)
{
  const PetscInt        width = ops->velocity[0].visc.width, entries = SlotEntries(ops, p->dim);
  const Pattern        *fluid = &ops->rows.fluid, *walls = &ops->rows.walls;
  const AffineOperator *op = &ops->velocity[0].visc;
  PetscReal            *a, *b;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(fluid->row[p->n_fluid] * entries, &a,
                         ops->forms.wall ? walls->row[p->n_fluid] * entries : 0, &b));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal own                              = p->nu ? p->nu[i] / scene->nu : 1.0;
    PetscReal       sum[ISPH_MAX_DIM * ISPH_MAX_DIM] = {0.0};
    PetscInt        diagonal                         = -1;

    for (PetscInt s = fluid->row[i]; s < fluid->row[i + 1]; s++) {
      const PetscReal ratio = p->nu ? PairViscosity(own, p->nu[fluid->local[s]] / scene->nu) : own;

      if (fluid->col[s] == p->row[i]) diagonal = s;
      else ScaleSlot(width, entries, ratio, &op->a[s * width], &a[s * entries], sum);
    }
    for (PetscInt s = ops->forms.wall ? walls->row[i] : 0; ops->forms.wall && s < walls->row[i + 1];
         s++)
      ScaleSlot(width, entries, own, &op->b[s * width], &b[s * entries], sum);
    for (PetscInt e = 0; e < entries; e++)
      a[diagonal * entries + e] = own * op->a[diagonal * width + (width == 1 ? 0 : e)] - sum[e];
  }
  PetscCall(MatSetValuesCOO(op->A, a, INSERT_VALUES));
  if (ops->forms.wall) PetscCall(MatSetValuesCOO(op->B, b, INSERT_VALUES));
  PetscCall(PetscFree2(a, b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OperatorsStrainRate - Computes the strain rate of each fluid particle [1/s]

    g = sqrt(2 E:E),   E = (grad u + grad u^T)/2

  Collective. Input: u - velocity components over the fluid; walls - components of the wall
  velocity, NULL entries without walls. Output: g - n_fluid numbers.
*/
PetscErrorCode OperatorsStrainRate(const Operators *ops, const Particles *p, const Vec u[],
                                   const Vec walls[], PetscReal g[])
{
  Vec                slope;
  const PetscScalar *s;

  PetscFunctionBegin;
  PetscCall(VecDuplicate(u[0], &slope));
  for (PetscInt i = 0; i < p->n_fluid; i++) g[i] = 0.0;
  for (PetscInt c = 0; c < p->dim; c++) {
    for (PetscInt a = 0; a <= c; a++) { /* g^2 += (1 or 1/2) (du_c/dx_a + du_a/dx_c)^2 */
      PetscCall(AffineApply(&OperatorsOfVelocity(ops, c)->grad_u[a], u[c], walls[c], slope));
      PetscCall(AffineApplyAdd(&OperatorsOfVelocity(ops, a)->grad_u[c], u[a], walls[a], slope));
      PetscCall(VecGetArrayRead(slope, &s));
      for (PetscInt i = 0; i < p->n_fluid; i++) g[i] += (a == c ? 0.5 : 1.0) * PetscSqr(s[i]);
      PetscCall(VecRestoreArrayRead(slope, &s));
    }
  }
  PetscCall(VecDestroy(&slope));
  for (PetscInt i = 0; i < p->n_fluid; i++) g[i] = PetscSqrtReal(g[i]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OperatorsFollowStrain - Computes the viscosities of a rheology from the strain rate, and updates
  the viscous operator

  Collective on the particles' communicator. Input: u - velocity components over the fluid; walls -
  wall velocity. Output: p->nu with its halo, ops->velocity[0].visc.
*/
PetscErrorCode OperatorsFollowStrain(const Scene *scene, Particles *p, const WallValues *walls,
                                     const Vec u[], Operators *ops)
{
  PetscFunctionBegin;
  PetscCall(OperatorsStrainRate(ops, p, u, walls->u, p->nu));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    p->nu[i] = RheologyViscosity(&scene->rheology, p->nu[i]);
  PetscCall(ParticlesHaloField(p, p->nu));
  PetscCall(OperatorsScaleViscosity(scene, p, ops));
  PetscFunctionReturn(PETSC_SUCCESS);
}
