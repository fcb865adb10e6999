/* Storage of the stencil of a particle. GatherStencil() fills it, and row functions read it. */
#include "isph/rows.h"

/* StencilCreate - Creates an empty stencil */
PetscErrorCode StencilCreate(PetscInt dim, Stencil **stencil)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(stencil));
  (*stencil)->dim    = dim;
  (*stencil)->degree = (*stencil)->least_degree = 2;
  (*stencil)->weak                              = MLS_WEAK;
  (*stencil)->sloped                            = SLOPE_NONE;
  for (PetscInt a = 0; a < dim; a++) (*stencil)->stretch[a] = 1.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StencilFree(Stencil *st)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(PetscFree3(st->X[a], st->normal[a], st->fit.gradient[a]));
    PetscCall(PetscFree(st->slope[a]));
  }
  PetscCall(PetscFree2(st->walls, st->radial));
  PetscCall(PetscFree6(st->fit.phi, st->fit.W, st->fit.value, st->fit.weighted, st->fit.laplacian,
                       st->fit.filter));
  PetscCall(PetscFree7(st->r, st->V, st->W, st->dW, st->ddW, st->beta, st->j));
  PetscCall(PetscFree7(st->wall, st->corrected[0], st->corrected[1], st->side, st->share,
                       st->equation, st->factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StencilDestroy(Stencil **stencil)
{
  PetscFunctionBegin;
  if (!*stencil) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StencilFree(*stencil));
  PetscCall(PetscFree(*stencil));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StencilReserve - Makes room for n neighbours; the present contents are lost */
PetscErrorCode StencilReserve(Stencil *st, PetscInt n)
{
  PetscFunctionBegin;
  if (n <= st->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(StencilFree(st));
  st->capacity = ISPH_LANES * (2 * n / ISPH_LANES + 1);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(PetscMalloc3(st->capacity, &st->X[a], st->capacity, &st->normal[a], st->capacity,
                           &st->fit.gradient[a]));
    PetscCall(PetscMalloc1(st->capacity, &st->slope[a]));
  }
  PetscCall(PetscMalloc2(st->capacity, &st->walls, st->capacity, &st->radial));
  PetscCall(PetscMalloc6(MLS_MAX_TERMS * st->capacity, &st->fit.phi, st->capacity, &st->fit.W,
                         st->capacity, &st->fit.value, st->capacity, &st->fit.weighted,
                         st->capacity, &st->fit.laplacian, st->capacity, &st->fit.filter));
  PetscCall(PetscMalloc7(st->capacity, &st->r, st->capacity, &st->V, st->capacity, &st->W,
                         st->capacity, &st->dW, st->capacity, &st->ddW, st->capacity, &st->beta,
                         st->capacity, &st->j));
  PetscCall(PetscMalloc7(st->capacity, &st->wall, st->capacity, &st->corrected[0], st->capacity,
                         &st->corrected[1], st->capacity, &st->side, st->capacity, &st->share,
                         st->capacity, &st->equation, st->capacity, &st->factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fills the rest of an array, fewer than ISPH_LANES entries. */
static ISPH_INLINE void FillReals(PetscInt from, PetscInt to, PetscReal value, PetscReal array[])
{
  for (PetscInt k = from; k < to; k++) array[k] = value;
}

/* StencilFinish - Lists the wall neighbours of a stencil whose neighbours have places, volumes and
   kinds, and ends the arrays that sums read in neighbours without volume */
ISPH_WIDE void StencilFinish(Stencil *st)
{
  const PetscInt n = st->n, end = LanesPadded(n);
  PetscInt       n_wall = 0, listed = 0;

  FillReals(n, end, 0.0, st->V);
  FillReals(n, end, 0.0, st->W);
  FillReals(n, end, 0.0, st->dW);
  FillReals(n, end, 0.0, st->ddW);
  FillReals(n, end, st->radius, st->r);
  for (PetscInt a = 0; a < st->dim; a++) FillReals(n, end, 0.0, st->X[a]);
  for (PetscInt k = n; k < end; k++) st->wall[k] = PETSC_FALSE;
  for (PetscInt k = 0; k < n; k++) n_wall += st->wall[k] ? 1 : 0;
  st->n_wall = n_wall;
  for (PetscInt k = 0; listed < n_wall; k++)
    if (st->wall[k]) st->walls[listed++] = k;
}

/* Sets the equation of wall neighbour k; a change invalidates the fit. */
static void SetEquation(Stencil *st, PetscInt k, Equation equation)
{
  if (!st->fits_walls && equation != EQUATION_NONE) equation = EQUATION_VALUE;
  if (equation != st->equation[k]) st->fit.wanted = 0;
  st->equation[k] = equation;
}

/* StencilSetQuantity - Sets the equations that wall neighbours give to fits of a quantity. Keeps
   the fit if no equation changes. A dummy gives a fit its value or no equation; boundary_rows.c
   applies the condition of its boundary. */
void StencilSetQuantity(const Scene *scene, FitQuantity quantity, Stencil *st)
{
  for (PetscInt k = 0; st->n_wall && k < st->n; k++)
    if (st->wall[k]) SetEquation(st, k, BoundaryEquation(scene, st->side[k], quantity));
}

/* StencilSetVelocity - Sets the equations that wall neighbours give to fits of velocity
   component c */
void StencilSetVelocity(const Scene *scene, PetscInt c, Stencil *st)
{
  for (PetscInt k = 0; st->n_wall && k < st->n; k++)
    if (st->wall[k]) SetEquation(st, k, BoundaryVelocityEquation(scene, st->side[k], c));
}

/* StencilSetSize - Sets the lengths that follow from the spacing of the particle. See
   theory.md, (particles:sizes). Does nothing if the spacing is the same as before. Fits multiply
   equations of derivatives by half the radius of the support. */
void StencilSetSize(const KernelRow *kernel, PetscReal h_over_dx, PetscReal dx, Stencil *st)
{
  if (dx == st->dx) return;
  st->dx     = dx;
  st->h      = h_over_dx * dx;
  st->radius = kernel->support * st->h;
  st->scale  = 0.5 * st->radius;
  KernelEvaluate(kernel, st->dim, st->h, 0.0, st->self);
}
