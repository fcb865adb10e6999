/* Scalars at any place, for expressions that depend on them. */
#include "isph/fits.h"
#include "scalars.h"

#define REACH 2.6  /* of the fit [dx] */
#define RIDGE 1e-9 /* of its moments, over their trace */
#define MOST  400  /* particles within the reach */

/* Returns the linear fit of scalar s at x. Input: list - n particles around. */
static PetscReal FitAt(const Particles *p, const Scalar *s, const PetscReal x[], PetscInt n,
                       const PetscInt list[])
{
  const PetscInt d = p->dim, terms = d + 1;
  PetscReal      M[16] = {0.0}, b[4] = {0.0}, factor[16];

  for (PetscInt k = 0; k < n; k++) {
    const PetscInt j      = list[k];
    PetscReal      phi[4] = {1.0}, y[ISPH_MAX_DIM], r2 = 0.0, W;

    if (ParticlesIsWall(p, j) && !s->gives[(PetscInt)p->side[j]]) continue;
    if (ParticlesIsWall(p, j)) ParticlesWallPoint(p, j, y);
    for (PetscInt a = 0; a < d; a++) {
      phi[1 + a] = ((ParticlesIsWall(p, j) ? y[a] : p->x[a][j]) - x[a]) / p->dx[0];
      r2 += PetscSqr(phi[1 + a]);
    }
    if (r2 < 1e-18) return s->all[j];
    W = PetscSqr(PetscMax(0.0, 1.0 - r2 / PetscSqr(REACH)));
    for (PetscInt t = 0; t < terms; t++) {
      b[t] += W * phi[t] * s->all[j];
      for (PetscInt q = 0; q < terms; q++) M[t * terms + q] += W * phi[t] * phi[q];
    }
  }
  if (M[0] <= 0.0) return 0.0;
  DenseCholeskyRidge(terms, M, RIDGE, factor);
  DenseCholeskySolve(terms, factor, b);
  return b[0];
}

/* ScalarsAt - Sets the present scalars at a place: those of a particle there, or fits; not
   collective. Input: ctx - the flow; t - not used */
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
    value[k] =
        n && !code ? FitAt(p, &all->scalar[k], x, n, list) : ScalarAtStart(all->scalar[k].given, x);
}
