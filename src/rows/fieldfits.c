/* Gradients of fields by fits of a degree of their own, and the difference between those of the
   quadratic and of the cubic fit of a velocity. They share no row with the operators of a run, and
   tell how far these can be trusted. */
#include "assembly.h"
#include "rows.h"

#define ANOTHER_FLUID 2.0 /* ratio of viscosities from which a neighbour is of another fluid [-] */

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

/* Leaves neighbours out of the fits of a stencil, or lowers their weights, by the kind of field.
   Fits of a velocity beside another fluid are one-sided, because it has a kink at the interface.
   Stresses are continuous across it along its normal, but those of a stiff fluid are less certain
   by the ratio of the viscosities; fits from the fluid alone have no wall neighbours. */
static void SelectNeighbors(const Particles *p, FieldKind kind, Stencil *st)
{
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal ratio;

    if (st->wall[k]) {
      if (kind == FIELD_STRESS) st->equation[k] = EQUATION_NONE;
      continue;
    }
    if (!p->nu || kind == FIELD_WHOLE_VELOCITY) continue;
    ratio = p->nu[st->j[k]] / p->nu[st->i];
    if (kind == FIELD_STRESS) st->W[k] *= PetscMin(1.0, 1.0 / PetscSqr(ratio));
    else if (ratio > ANOTHER_FLUID || ratio < 1.0 / ANOTHER_FLUID) st->W[k] = 0.0;
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

/* Adds the products of the rows of a stencil with field f to particle l of the range. */
static void AddProducts(const FieldGradients *of, const Stencil *st, PetscReal *const g[],
                        PetscInt f, PetscInt l)
{
  const PetscReal *v = of->value[f];
  PetscReal       *A = of->gradient + (l * of->n_fields + f) * st->dim;

  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal y =
        st->equation[k] == EQUATION_VALUE ? v[st->j[k] * of->stride] - v[st->i * of->stride] : 0.0;

    for (PetscInt a = 0; a < st->dim; a++) A[a] += g[a][k] * y;
    if (of->laplacian) of->laplacian[l * of->n_fields + f] += st->fit.laplacian[k] * y;
  }
}

/* Computes the gradients of all fields in a batch of particles, the first of which is `from` of the
   range. */
static PetscErrorCode FitFields(const Scene *scene, const Assembly *work, const FieldGradients *of,
                                PetscInt from, PetscInt count, PetscReal *g[])
{
  PetscFunctionBegin;
  for (PetscInt f = 0; f < of->n_fields; f++) {
    for (PetscInt l = 0; of->kind != FIELD_STRESS && l < count; l++)
      StencilSetVelocity(scene, f, work->batch[l]);
    PetscCall(FitBatch(of->degree, count, work));
    for (PetscInt l = 0; l < count; l++) {
      PetscBool known;

      PetscCall(GradientRow_MlsDegree(work->batch[l], of->degree, g, &known));
      if (of->determined && !known) of->determined[from + l] = PETSC_FALSE;
      AddProducts(of, work->batch[l], g, f, from + l);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Clears the results of a range of particles. */
static PetscErrorCode Clear(PetscInt dim, const FieldGradients *of)
{
  PetscFunctionBegin;
  PetscCall(PetscArrayzero(of->gradient, of->count * of->n_fields * dim));
  if (of->laplacian) PetscCall(PetscArrayzero(of->laplacian, of->count * of->n_fields));
  for (PetscInt l = 0; of->determined && l < of->count; l++) of->determined[l] = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OperatorsFitGradients - Computes gradients of fields at a range of particles by fits of a degree.
   The fits have the neighbours of the operators, with the equations of boundaries on the surface
   for a velocity, and none for a stress. If the neighbours do not determine a degree, the next
   lower one stands. Input/Output: of - in: range, degree and fields; out: gradients, Laplacians,
   and whether the degree is determined. Note: needs the rows of neighbours of these particles, and
   the fields in the halo. */
PetscErrorCode OperatorsFitGradients(const Scene *scene, const Particles *p, const Neighbors *nb,
                                     Operators *ops, const FieldGradients *of)
{
  Stencil *const *batch      = ops->work->batch;
  const PetscBool fits_walls = batch[0]->fits_walls;
  const PetscReal weak       = batch[0]->weak;
  PetscInt        longest    = 0;
  PetscReal      *storage, *g[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt i = of->first; i < of->first + of->count; i++)
    longest = PetscMax(longest, nb->row[i + 1] - nb->row[i]);
  PetscCall(PetscMalloc1(longest * p->dim, &storage));
  for (PetscInt a = 0; a < p->dim; a++) g[a] = storage + longest * a;
  for (PetscInt l = 0; l < MLS_BATCH; l++) {
    batch[l]->fits_walls = PETSC_TRUE;
    if (of->weak > 0.0) batch[l]->weak = of->weak;
  }
  PetscCall(Clear(p->dim, of));
  for (PetscInt i = 0; i < of->count; i += MLS_BATCH) {
    const PetscInt count = PetscMin(MLS_BATCH, of->count - i);

    for (PetscInt l = 0; l < count; l++) {
      PetscCall(GatherStencil(scene, p, nb, ops, of->first + i + l, batch[l]));
      if (!fits_walls) MoveToSurface(p, ops, batch[l]);
      SelectNeighbors(p, of->kind, batch[l]);
    }
    PetscCall(FitFields(scene, ops->work, of, i, count, g));
  }
  for (PetscInt l = 0; l < MLS_BATCH; l++) {
    batch[l]->fits_walls = fits_walls;
    batch[l]->weak       = weak;
  }
  PetscCall(PetscFree(storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OperatorsCompareGradients - Computes the gradient of the velocity at each particle by a cubic fit,
  and its difference from the gradient of the quadratic fit

    d_i = |grad_3 u - grad_2 u|

  |.| is Frobenius' norm. d_i is of order dx^2, like the error of the gradients of a run, and large
  where the particles do not resolve the velocity. Input/Output: of - in: the range of particles;
  out: gradient and d_i, which is the norm of the whole gradient if the points do not determine the
  cubic fit; the gradient is then the quadratic fit's. Note: needs the rows of neighbours of these
  particles, and the velocity in the halo.
*/
PetscErrorCode OperatorsCompareGradients(const Scene *scene, const Particles *p,
                                         const Neighbors *nb, Operators *ops,
                                         const GradientComparison *of)
{
  const PetscInt entries = p->dim * p->dim;
  FieldGradients fit     = {.kind     = FIELD_WHOLE_VELOCITY,
                            .first    = of->first,
                            .count    = of->count,
                            .n_fields = p->dim,
                            .stride   = 1,
                            .degree   = 3,
                            .gradient = of->gradient};
  PetscBool     *determined;
  PetscReal     *quadratic;

  PetscFunctionBegin;
  for (PetscInt c = 0; c < p->dim; c++) fit.value[c] = p->u[c];
  PetscCall(PetscMalloc2(of->count, &determined, of->count * entries, &quadratic));
  fit.determined = determined;
  PetscCall(OperatorsFitGradients(scene, p, nb, ops, &fit));
  fit.degree     = 2;
  fit.gradient   = quadratic;
  fit.determined = NULL;
  PetscCall(OperatorsFitGradients(scene, p, nb, ops, &fit));
  for (PetscInt l = 0; l < of->count; l++) {
    PetscReal sum = 0.0;

    for (PetscInt e = l * entries; e < (l + 1) * entries; e++)
      sum += PetscSqr(of->gradient[e] - (determined[l] ? quadratic[e] : 0.0));
    of->difference[l] = PetscSqrtReal(sum);
  }
  PetscCall(PetscFree2(determined, quadratic));
  PetscFunctionReturn(PETSC_SUCCESS);
}
