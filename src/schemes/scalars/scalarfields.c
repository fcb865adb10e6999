/* Fits of scalars at any place, for expressions that depend on them, and of velocities on walls. */
#include "isph/fits.h"
#include "scalars.h"

#define REACH 2.6  /* of the fit [dx] */
#define RIDGE 1e-9 /* of its moments, over their trace */
#define MOST  400  /* particles within the reach */

/* Returns the linear fit at x of values by [j stride]. Input: gives - boundaries with values, NULL:
   none; list - n particles around. */
static PetscReal FitAt(const Particles *p, const PetscReal all[], PetscInt stride,
                       const PetscBool gives[], const PetscReal x[], PetscInt n,
                       const PetscInt list[])
{
  const PetscInt d = p->dim, terms = d + 1;
  PetscReal      M[16] = {0.0}, b[4] = {0.0}, factor[16];

  for (PetscInt k = 0; k < n; k++) {
    const PetscInt j      = list[k];
    PetscReal      phi[4] = {1.0}, y[ISPH_MAX_DIM], r2 = 0.0, W;

    if (ParticlesIsWall(p, j) && (!gives || !gives[(PetscInt)p->side[j]])) continue;
    if (ParticlesIsWall(p, j)) ParticlesWallPoint(p, j, y);
    for (PetscInt a = 0; a < d; a++) {
      phi[1 + a] = ((ParticlesIsWall(p, j) ? y[a] : p->x[a][j]) - x[a]) / p->dx[0];
      r2 += PetscSqr(phi[1 + a]);
    }
    if (r2 < 1e-18) return all[j * stride];
    W = PetscSqr(PetscMax(0.0, 1.0 - r2 / PetscSqr(REACH)));
    for (PetscInt t = 0; t < terms; t++) {
      b[t] += W * phi[t] * all[j * stride];
      for (PetscInt q = 0; q < terms; q++) M[t * terms + q] += W * phi[t] * phi[q];
    }
  }
  if (M[0] <= 0.0) return 0.0;
  DenseCholeskyRidge(terms, M, RIDGE, factor);
  DenseCholeskySolve(terms, factor, b);
  return b[0];
}

/* ScalarsAt - Sets the present scalars at a place: those of a particle there, or fits. Input: ctx -
   the flow; t - not used */
void ScalarsAt(void *ctx, PetscReal t, const PetscReal x[], PetscReal value[])
{
  const Flow      *flow = (const Flow *)ctx;
  const Scalars   *all  = flow->state->scalars;
  const Particles *p    = flow->particles;
  PetscInt         n    = 0, list[MOST];
  PetscErrorCode   code = PETSC_SUCCESS;

  (void)t;
  if (all->cells.n) code = CellsFind(&all->cells, x, REACH * p->dx[0], MOST, list, &n);
  for (PetscInt k = 0; k < all->n; k++)
    value[k] = n && !code ? FitAt(p, all->scalar[k].all, 1, all->scalar[k].gives, x, n, list)
                          : ScalarAtStart(all->scalar[k].given, x);
}

/* ScalarSlip - Sets the velocities of own walls that do not give them, as planes of symmetry, to
   fits of the fluid. Input: u - velocities of all particles, components together. */
PetscErrorCode ScalarSlip(const Flow *flow, PetscReal u[])
{
  const Particles *p = flow->particles;
  const PetscInt   d = p->dim;

  PetscFunctionBegin;
  for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++) {
    PetscReal x[ISPH_MAX_DIM];
    PetscInt  n = -1, list[MOST];

    for (PetscInt a = 0; a < d; a++) {
      if (BoundaryVelocityEquation(flow->scene, (PetscInt)p->side[i], a) == EQUATION_VALUE)
        continue;
      ParticlesWallPoint(p, i, x);
      if (n < 0)
        PetscCall(CellsFind(&flow->state->scalars->cells, x, REACH * p->dx[0], MOST, list, &n));
      u[i * d + a] = FitAt(p, u + a, d, NULL, x, n, list);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
