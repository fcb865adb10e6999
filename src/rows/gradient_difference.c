/*
  The difference between the gradients of the quadratic and of the cubic fit of a velocity. It is of
  order dx^2, like the error of the gradients of a run, and large where the particles do not resolve
  the velocity.
*/
#include "assembly.h"
#include "rows.h"

/* Moves the wall neighbours of a stencil to their surface points, so that each gives the equation
   of its boundary there, whatever the wall treatment is. */
static void MoveToSurface(const Particles *p, const Operators *ops, Stencil *st)
{
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal r2 = 0.0, w[3];

    if (!st->wall[k]) continue;
    for (PetscInt a = 0; a < st->dim; a++) {
      st->X[a][k] += p->depth[st->j[k]] * st->normal[a][k];
      r2 += PetscSqr(st->X[a][k]);
    }
    st->r[k] = PetscSqrtReal(r2);
    KernelEvaluate(ops->forms.kernel, st->dim, st->h, st->r[k], w);
    st->W[k] = w[0];
  }
}

/* Adds the gradient of velocity component f with the weights g, times `sign`, to A. */
static void AddGradient(const Stencil *st, PetscReal *const g[], const PetscReal f[],
                        PetscReal sign, PetscReal A[])
{
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal y = st->equation[k] == EQUATION_VALUE ? f[st->j[k]] - f[st->i] : 0.0;

    for (PetscInt a = 0; a < st->dim; a++) A[a] += sign * g[a][k] * y;
  }
}

/* Computes the fits of a degree in a batch of particles, unless all are valid. */
static PetscErrorCode FitBatch(PetscInt degree, PetscInt count, const Assembly *work)
{
  PetscBool valid = PETSC_TRUE;

  PetscFunctionBegin;
  for (PetscInt l = 0; l < count; l++)
    if (work->batch[l]->fit.wanted != degree) valid = PETSC_FALSE;
  if (!valid) PetscCall(MlsFitBatch(degree, count, work->batch, work->fits));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the gradients in a batch of particles by fits of a degree, times `sign`, and adds them
   to A; clears the flags of particles whose neighbours do not determine the fit. */
static PetscErrorCode AddGradients(const Scene *scene, const Particles *p, const Assembly *work,
                                   PetscInt degree, PetscReal sign, PetscInt count, PetscReal *g[],
                                   PetscReal A[], PetscBool determined[])
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < p->dim; c++) {
    for (PetscInt l = 0; l < count; l++) StencilSetVelocity(scene, c, work->batch[l]);
    PetscCall(FitBatch(degree, count, work));
    for (PetscInt l = 0; l < count; l++) {
      PetscBool known;

      PetscCall(GradientRow_MlsDegree(work->batch[l], degree, g, &known));
      if (!known) determined[l] = PETSC_FALSE;
      AddGradient(work->batch[l], g, p->u[c], sign, A + (l * p->dim + c) * p->dim);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the gradients about particles first, first + 1, ..., and the norms of their
   differences, as OperatorsCompareGradients(). */
static PetscErrorCode CompareBatch(const Scene *scene, const Particles *p, const Neighbors *nb,
                                   const Operators *ops, PetscBool moves_walls, PetscInt first,
                                   PetscInt count, PetscReal *g[], PetscReal gradient[],
                                   PetscReal norm[])
{
  const PetscInt entries = p->dim * p->dim;
  PetscReal      difference[MLS_BATCH * ISPH_MAX_DIM * ISPH_MAX_DIM];
  PetscBool      determined[MLS_BATCH];

  PetscFunctionBegin;
  for (PetscInt l = 0; l < count; l++) {
    PetscCall(GatherStencil(scene, p, nb, ops, first + l, ops->work->batch[l]));
    if (moves_walls) MoveToSurface(p, ops, ops->work->batch[l]);
    determined[l] = PETSC_TRUE;
  }
  PetscCall(PetscArrayzero(gradient, count * entries));
  PetscCall(AddGradients(scene, p, ops->work, 3, 1.0, count, g, gradient, determined));
  PetscCall(PetscArraycpy(difference, gradient, count * entries));
  PetscCall(AddGradients(scene, p, ops->work, 2, -1.0, count, g, difference, determined));
  for (PetscInt l = 0; l < count; l++) {
    const PetscReal *A   = (determined[l] ? difference : gradient) + l * entries;
    PetscReal        sum = 0.0;

    for (PetscInt e = 0; e < entries; e++) sum += PetscSqr(A[e]);
    norm[l] = PetscSqrtReal(sum);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OperatorsCompareGradients - Computes the gradient of the velocity at each particle by a cubic fit,
  and its difference from the gradient of the quadratic fit

    d_i = |grad_3 u - grad_2 u|

  Not collective. |.| is Frobenius' norm. Both fits have the neighbours of the operators, with the
  equations of boundaries on the surface.

  Input/Output Parameter:
. of - in: the range of particles; out: gradient and d_i, which is the norm of the whole gradient if
       the points do not determine the cubic fit; the gradient is then the quadratic fit's

  Note: needs the rows of neighbours of these particles, and the velocity in the halo.
*/
PetscErrorCode OperatorsCompareGradients(const Scene *scene, const Particles *p,
                                         const Neighbors *nb, Operators *ops,
                                         const GradientComparison *of)
{
  Stencil *const *batch      = ops->work->batch;
  const PetscBool fits_walls = batch[0]->fits_walls;
  PetscInt        longest    = 0;
  PetscReal      *storage, *g[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt i = of->first; i < of->first + of->count; i++)
    longest = PetscMax(longest, nb->row[i + 1] - nb->row[i]);
  PetscCall(PetscMalloc1(longest * p->dim, &storage));
  for (PetscInt a = 0; a < p->dim; a++) g[a] = storage + longest * a;
  for (PetscInt l = 0; l < MLS_BATCH; l++) batch[l]->fits_walls = PETSC_TRUE;
  for (PetscInt i = 0; i < of->count; i += MLS_BATCH) {
    PetscCall(CompareBatch(scene, p, nb, ops, fits_walls ? PETSC_FALSE : PETSC_TRUE, of->first + i,
                           PetscMin(MLS_BATCH, of->count - i), g,
                           of->gradient + i * p->dim * p->dim, of->difference + i));
  }
  for (PetscInt l = 0; l < MLS_BATCH; l++) batch[l]->fits_walls = fits_walls;
  PetscCall(PetscFree(storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
