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

/* Collects the data of the equations of velocity component f: differences, or n.grad f = 0. */
static void CollectData(const Stencil *st, const PetscReal f[], PetscReal y[])
{
  for (PetscInt k = 0; k < st->n; k++)
    y[k] = st->equation[k] == EQUATION_VALUE ? f[st->j[k]] - f[st->i] : 0.0;
}

/* Returns sum_k w_k y_k. */
static PetscReal Product(PetscInt n, const PetscReal w[], const PetscReal y[])
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < n; k++) sum += w[k] * y[k];
  return sum;
}

/*
  OperatorsCompareGradients - Computes the gradient of the velocity at each particle by a cubic fit,
  and its difference from the gradient of the quadratic fit

    d_i = |grad_3 u - grad_2 u|

  Collective on the particles' communicator. |.| is Frobenius' norm. Both fits have the neighbours
  of the operators, with the equations of boundaries on the surface.

  Output Parameters:
+ gradient   - du_c/dx_a of own fluid particle i at [(i dim + c) dim + a] [1/s]
- difference - d_i; the norm of the whole gradient if the points do not determine the cubic fit, and
               the gradient is then the quadratic fit's [1/s]

  Notes: needs the lists of neighbours of the present positions. The halo of the velocity is filled.
*/
PetscErrorCode OperatorsCompareGradients(const Scene *scene, const Particles *p,
                                         const Neighbors *nb, Operators *ops, PetscReal gradient[],
                                         PetscReal difference[])
{
  Stencil        *st         = ops->work->stencil;
  const PetscBool fits_walls = st->fits_walls;
  PetscInt        longest    = 0;
  PetscReal      *y, *storage, *quadratic[ISPH_MAX_DIM], *cubic[ISPH_MAX_DIM];

  PetscFunctionBegin;
  for (PetscInt c = 0; c < p->dim; c++) PetscCall(ParticlesHaloField(p, p->u[c]));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    longest = PetscMax(longest, nb->row[i + 1] - nb->row[i]);
  PetscCall(PetscMalloc1(longest * (1 + 2 * p->dim), &storage));
  y = storage;
  for (PetscInt a = 0; a < p->dim; a++) {
    quadratic[a] = storage + longest * (1 + a);
    cubic[a]     = storage + longest * (1 + p->dim + a);
  }
  st->fits_walls = PETSC_TRUE;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal *G = &gradient[i * p->dim * p->dim], all = 0.0, part = 0.0;
    PetscBool  determined = PETSC_TRUE, known;

    PetscCall(GatherStencil(scene, p, nb, ops, i, st));
    if (!fits_walls) MoveToSurface(p, ops, st);
    for (PetscInt c = 0; c < p->dim; c++) {
      StencilSetVelocity(scene, c, st);
      CollectData(st, p->u[c], y);
      PetscCall(GradientRow_MlsDegree(st, 2, quadratic, &known));
      PetscCall(GradientRow_MlsDegree(st, 3, cubic, &known));
      if (!known) determined = PETSC_FALSE;
      for (PetscInt a = 0; a < p->dim; a++) {
        G[c * p->dim + a] = Product(st->n, cubic[a], y);
        all += PetscSqr(G[c * p->dim + a]);
        part += PetscSqr(G[c * p->dim + a] - Product(st->n, quadratic[a], y));
      }
    }
    difference[i] = PetscSqrtReal(determined ? part : all);
  }
  st->fits_walls = fits_walls;
  PetscCall(PetscFree(storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
