/* Fits of the nearest particles at the points of a group. The nearest particles may lie near a
   conic section, on which a quadratic function vanishes. Then the weights are large and amplify the
   data: a fit of 14 with a sum of 22 spoilt the flow of 64 x 64 particles within a step. Such fits
   take more particles. */
#include "isph/fits.h"

#define LARGEST_SUM 2.5 /* of absolute weights; 1.2 to 1.6 on a lattice */

/* NearestTakesMore - Returns true if a fit of `wanted` particles needs more. Input: more - there
   are more; sum - of the absolute weights, infinity without a fit. */
PetscBool NearestTakesMore(PetscInt least, PetscInt wanted, PetscBool more, PetscReal sum)
{
  return more && sum > LARGEST_SUM && wanted < NEAREST_TIMES * least;
}

/* Returns the largest number of particles in a fit, and pads the others with the weight zero. */
static PetscInt Pad(PetscInt dim, NearestFits *f)
{
  const PetscInt m       = 1 << dim;
  PetscInt       longest = 0;

  for (PetscInt i = 0; i < m; i++) longest = PetscMax(longest, f->n[i]);
  for (PetscInt i = 0; i < m; i++) {
    for (PetscInt k = f->n[i]; k < longest; k++) {
      f->W[k * m + i] = 0.0;
      for (PetscInt a = 0; a < dim; a++) f->s[a][k * m + i] = 0.0;
    }
  }
  return longest;
}

/* Returns the sum of the absolute weights of fit i, infinity without a fit. */
static PetscReal SumOfWeights(PetscInt m, PetscInt i, const NearestFits *f)
{
  PetscReal sum = 0.0;

  for (PetscInt k = 0; k < f->n[i]; k++) sum += PetscAbsReal(f->w[k * m + i]);
  return f->fits[i] ? sum : PETSC_INFINITY;
}

/* NearestFitsCompute - Computes fits at the points of a group, of `least` particles or more. Input:
   degree - of the fits; todo - flags of the points that have a fit; others have no particles; Fill
   - sets n, W, s and what else belongs to the fit of the `wanted` nearest at point i; more -
   PETSC_FALSE if there are no more; ctx - its data. Output: f - the weights w of n particles at
   each point, and flags of fits that are determined. */
PetscErrorCode NearestFitsCompute(PetscInt dim, PetscInt degree, PetscInt least,
                                  const PetscBool todo[], NearestFill Fill, void *ctx,
                                  NearestFits *f)
{
  const PetscInt m = 1 << dim;
  PetscReal     *s[ISPH_MAX_DIM];
  PetscInt       wanted[POINT_FITS], left = 0; /* wanted 0: the fit is done */
  PetscBool      more[POINT_FITS];

  PetscFunctionBegin;
  for (PetscInt a = 0; a < dim; a++) s[a] = f->s[a];
  for (PetscInt i = 0; i < m; i++) {
    f->n[i]   = 0;
    wanted[i] = todo[i] ? least : 0;
    left += todo[i] ? 1 : 0;
  }
  while (left) {
    for (PetscInt i = 0; i < m; i++)
      if (wanted[i]) PetscCall(Fill(ctx, i, wanted[i], f, &more[i]));
    PointFits(dim, degree, Pad(dim, f), s, f->W, f->w, f->fits); /* those of all points */
    for (PetscInt i = 0; i < m; i++) {
      if (!wanted[i]) continue;
      if (NearestTakesMore(least, wanted[i], more[i], SumOfWeights(m, i, f))) {
        wanted[i] += least / 3;
      } else {
        wanted[i] = 0;
        left--;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
