/*
  Values at points by moving least squares: a quadratic fit about a point with a free constant,

    f(x + X) = c_0 + sum_t c_t phi_t(X/R),   min sum_k W_k (f_k - fit(X_k))^2,   value = c_0

  and the same fit of a vector, of which some neighbours give the normal component only.

  Reference: P. Lancaster & K. Salkauskas, Math. Comput. 37 (1981) 141-158
*/
#include "isph/operators.h"

/* Computes the basis 1, s_a, s_a s_b (b <= a) of neighbour k. */
static inline void PointBasis(PetscInt dim, PetscReal *const s[], PetscInt k, PetscReal phi[])
{
  PetscInt t = 1 + dim;

  phi[0] = 1.0;
  for (PetscInt a = 0; a < dim; a++) {
    phi[1 + a] = s[a][k];
    for (PetscInt b = 0; b <= a; b++) phi[t++] = s[a][k] * s[b][k];
  }
}

static inline PetscBool PointFitInline(PetscInt dim, PetscInt n, PetscReal *const s[],
                                       const PetscReal W[], PetscReal w[])
{
  const PetscInt terms                                      = 1 + dim + dim * (dim + 1) / 2;
  PetscReal      moments[POINT_FIT_TERMS * POINT_FIT_TERMS] = {0.0}, phi[POINT_FIT_TERMS];
  PetscReal      c[POINT_FIT_TERMS]                         = {1.0};

  for (PetscInt k = 0; k < n; k++) {
    PointBasis(dim, s, k, phi);
    for (PetscInt t = 0; t < terms; t++) {
      const PetscReal weighted = W[k] * phi[t];

      for (PetscInt q = 0; q <= t; q++) moments[t * terms + q] += weighted * phi[q];
    }
  }
  for (PetscInt t = 0; t < terms; t++) {
    for (PetscInt q = 0; q < t; q++) moments[q * terms + t] = moments[t * terms + q];
  }
  if (DenseCholesky(terms, moments)) return PETSC_FALSE;
  DenseCholeskySolve(terms, moments, c);
  for (PetscInt k = 0; k < n; k++) {
    PetscReal sum = 0.0;

    PointBasis(dim, s, k, phi);
    for (PetscInt t = 0; t < terms; t++) sum += phi[t] * c[t];
    w[k] = W[k] * sum;
  }
  return PETSC_TRUE;
}

/*
  PointFit - Computes the weights w_k of f(x) = sum_k w_k f_k

  Not collective.

  Input Parameters:
+ n - number of neighbours
. s - their offsets (x_k - x)/R, at most 1 in length [-]
- W - their weights in the fit [-]

  Returns: PETSC_FALSE if the neighbours do not determine the fit, and then sets no weights

  Properties: exact for quadratic fields.
*/
PetscBool PointFit(PetscInt dim, PetscInt n, PetscReal *const s[], const PetscReal W[],
                   PetscReal w[])
{
  return dim == 2 ? PointFitInline(2, n, s, W, w) : PointFitInline(3, n, s, W, w);
}

/* Computes the moment matrix of the fit of a vector. */
static void VectorMoments(PetscInt dim, PetscInt n, PetscReal *const s[], const PetscReal W[],
                          const PetscBool wall[], PetscReal *const normal[], PetscReal moments[])
{
  const PetscInt terms = 1 + dim + dim * (dim + 1) / 2, size = dim * terms;

  for (PetscInt k = 0; k < n; k++) {
    PetscReal phi[POINT_FIT_TERMS];

    PointBasis(dim, s, k, phi);
    for (PetscInt c = 0; c < dim; c++) {
      for (PetscInt e = 0; e < dim; e++) {
        const PetscReal couple = wall[k] ? normal[c][k] * normal[e][k] : (c == e ? 1.0 : 0.0);

        if (couple == 0.0) continue;
        for (PetscInt t = 0; t < terms; t++) {
          for (PetscInt q = 0; q < terms; q++)
            moments[(c * terms + t) * size + e * terms + q] += couple * W[k] * phi[t] * phi[q];
        }
      }
    }
  }
}

/*
  VectorFit - Computes the weights w of u_a(x) = sum_k sum_b w[a][b]_k u_b,k in a fit of a vector u

    sum_k W_k |u_k - fit(X_k)|^2 + sum_w W_w (n.(u_w - fit(X_w)))^2 -> min

  with fluid neighbours k and wall neighbours w, see DivergenceFit_Mls(). Not collective.

  Input Parameters:
+ n, s, W - as for PointFit()
. wall    - flags of neighbours that give the normal component only
- normal  - their unit normals

  Output Parameter:
. w - w[a dim + b], n weights each

  Returns: PETSC_FALSE if the neighbours do not determine the fit, and then sets no weights

  Properties: exact for quadratic fields.
*/
PetscBool VectorFit(PetscInt dim, PetscInt n, PetscReal *const s[], const PetscReal W[],
                    const PetscBool wall[], PetscReal *const normal[], PetscReal *const w[])
{
  const PetscInt terms = 1 + dim + dim * (dim + 1) / 2, size = dim * terms;
  PetscReal      moments[ISPH_MAX_DIM * ISPH_MAX_DIM * POINT_FIT_TERMS * POINT_FIT_TERMS] = {0.0};

  VectorMoments(dim, n, s, W, wall, normal, moments);
  if (DenseCholesky(size, moments)) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal c[ISPH_MAX_DIM * POINT_FIT_TERMS] = {0.0};

    c[a * terms] = 1.0;
    DenseCholeskySolve(size, moments, c);
    for (PetscInt k = 0; k < n; k++) {
      PetscReal phi[POINT_FIT_TERMS], part[ISPH_MAX_DIM] = {0.0}, along = 0.0;

      PointBasis(dim, s, k, phi);
      for (PetscInt b = 0; b < dim; b++) {
        for (PetscInt t = 0; t < terms; t++) part[b] += W[k] * phi[t] * c[b * terms + t];
        if (wall[k]) along += normal[b][k] * part[b];
      }
      for (PetscInt b = 0; b < dim; b++)
        w[a * dim + b][k] = wall[k] ? along * normal[b][k] : part[b];
    }
  }
  return PETSC_TRUE;
}
