/*
  Rows sum_k w_k (f_k - f_i) of particles i beside walls, and their entries in the matrices. Rows of
  the pressure and of the divergence use only the normal condition of a wall, which gives n.grad p
  or n.u. In the tangential directions a dummy w continues the gradient at i, which the row itself
  computes. With X = x_w - x_i and X_t = X - (X.n) n

    p_w - p_i = (X.n) n.grad p + X_t.(grad p)_i
    u_w - u_i = n beta n.(u_wall - u_i) + ...              for the rest see DummyRow_Divergence()

  The gradient at i is unknown, but linear in the values of the neighbours and the wall data. So
  each row with dummies has a small linear system, whose solution gives new weights. A row that is
  exact for linear fields remains exact beside walls: theory.md, (walls:pressure) and those up to
  (walls:matrix).
*/
#include "rows/assembly.h"
#include "boundary_rows.h"
#include "rows/rows.h"
#include "wall_points.h"

/* Sets the row scale sum_k w_k (f_k - f_i) in the matrix A, for a stencil without walls whose slots
   follow each other. `diagonal` neighbours come before the diagonal. */
static void SetRow(const Stencil *st, const Operators *ops, PetscInt diagonal, PetscReal scale,
                   const PetscReal w[], const AffineOperator *op)
{
  PetscReal *row = AffineRow(&ops->rows, op, st->i), *after = row + 1, sum = 0.0;

#pragma omp simd reduction(+ : sum)
  for (PetscInt k = 0; k < st->n; k++) sum += scale * w[k];
  for (PetscInt k = 0; k < diagonal; k++) row[k] = scale * w[k];
  for (PetscInt k = diagonal; k < st->n; k++) after[k] = scale * w[k];
  row[diagonal] = -sum;
}

/* AddRow_Velocity - Adds the row sum_k w_k (f_k - f_i) to an operator on a velocity component f.
   WallWeights() converts the weights of dummies to weights of wall velocities. A wall particle on
   the surface contributes its own value, or its given n.grad f if that is its equation. */
void AddRow_Velocity(const Stencil *st, const Operators *ops, PetscInt diagonal,
                     const PetscReal w[], AffineOperator *op)
{
  const PetscReal *of_walls;
  PetscReal       *a, *b, sum = 0.0;

  if (ops->work->simple) {
    SetRow(st, ops, diagonal, 1.0, w, op);
    return;
  }
  EmptyRow(ops, st->i, op, &a, &b);
  of_walls = WallWeights(st, ops, 1, w);
  for (PetscInt k = 0; k < st->n; k++) {
    const PetscReal weight = st->wall[k] ? of_walls[k] : w[k];

    (st->wall[k] ? b : a)[ops->work->slot[k]] += weight;
    if (st->equation[k] == EQUATION_VALUE) sum += weight;
  }
  a[diagonal] -= sum;
}

/* Adds the row scale sum_k w_k (f_k - f_i) to an operator on a scalar f whose value or n.grad f is
   given at boundaries. In a fit w_k of a wall neighbour multiplies f_k - f_i, or n.grad f if that
   is its equation. For a dummy it multiplies f_w - f_i = (X.n) n.grad f; the tangential part of
   this difference is already in the weights w_k. */
static void AddRow_Pressure(const Stencil *st, const Operators *ops, PetscInt diagonal,
                            PetscReal scale, const PetscReal w[], AffineOperator *op)
{
  PetscReal *a, *b, sum = 0.0, tangent[ISPH_MAX_DIM];

  if (ops->work->simple) {
    SetRow(st, ops, diagonal, scale, w, op);
    return;
  }
  EmptyRow(ops, st->i, op, &a, &b);
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal weight = scale * w[k];

    if (!st->wall[k]) {
      a[ops->work->slot[k]] += weight;
      sum += weight;
      continue;
    }
    if (!st->fits_walls) weight *= SplitX(st, k, tangent);
    else if (st->equation[k] == EQUATION_VALUE) sum += weight;
    b[ops->work->slot[k]] += weight;
  }
  a[diagonal] -= sum;
}

#define SMALL_MAX (ISPH_MAX_DIM * ISPH_MAX_DIM) /* unknowns: the entries of grad u */

/* Solves X A = B; the `rows` rows of X replace B. A and B are stored by rows, with entries of order
   1. Returns PETSC_FALSE if A is singular or an entry of X exceeds 10: then too little fluid is
   near the wall. For comparison, the largest entry in cavities with moving particles is 2.4 (2D and
   3D). */
static PetscBool SmallSolve(PetscInt n, PetscReal A[], PetscInt rows, PetscReal B[])
{
  DenseEliminate(n, A, rows, B);
  for (PetscInt t = 0; t < rows * n; t++) {
    const PetscReal pivot = A[t % n * (n + 1)];

    if (!(PetscAbsReal(pivot) > PETSC_SMALL)) return PETSC_FALSE;
    B[t] /= pivot;
    if (!(PetscAbsReal(B[t]) <= 10.0)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Multiplies the weights g_k of all neighbours by the matrix K, which is dim x dim by rows. */
static void MultiplyWeights(const Stencil *st, const PetscReal K[], PetscReal *g[])
{
  const PetscInt d = st->dim;

  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal c[ISPH_MAX_DIM];

    for (PetscInt b = 0; b < d; b++) c[b] = g[b][k];
    for (PetscInt a = 0; a < d; a++) {
      g[a][k] = 0.0;
      for (PetscInt b = 0; b < d; b++) g[a][k] += K[a * d + b] * c[b];
    }
  }
}

/*
  DummyRow_Gradient - Adapts gradient weights to dummies, for a scalar f whose n.grad f is given at
  walls

    (I - sum_w g_w X_t^T) grad f = sum_fluid g_k (f_k - f_i) + sum_w g_w (X.n) n.grad f

  with dummies w, X = x_w - x_i, and X_t = X - (X.n) n. Input/Output: g - gradient weights g_k; out:
  multiplied by the inverse of the matrix on the left, or unchanged if SmallSolve() returns
  PETSC_FALSE. Properties: the new weights are exact for linear fields if g is.
*/
static void DummyRow_Gradient(const Stencil *st, PetscReal *g[])
{
  const PetscInt d            = st->dim;
  PetscReal      A[SMALL_MAX] = {0.0}, inverse[SMALL_MAX] = {0.0}, tangent[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < d; a++) A[a * d + a] = inverse[a * d + a] = 1.0;
  for (PetscInt k = 0; k < st->n; k++) {
    if (!st->wall[k]) continue;
    (void)SplitX(st, k, tangent);
    for (PetscInt a = 0; a < d; a++) {
      for (PetscInt b = 0; b < d; b++) A[a * d + b] -= g[a][k] * tangent[b];
    }
  }
  if (SmallSolve(d, A, d, inverse)) MultiplyWeights(st, inverse, g);
}

/*
  DummyRow_Laplacian - Adapts Laplacian weights to dummies that continue the gradient at i

    w_k += (sum_w w_w X_t).g_k,   g_k: gradient weights from DummyRow_Gradient()

  with dummies w, X = x_w - x_i, and X_t = X - (X.n) n. Properties: the new weights are exact for
  linear fields if w and g are; not symmetric.
*/
static void DummyRow_Laplacian(const Stencil *st, PetscReal *const g[], PetscReal w[])
{
  PetscReal sum[ISPH_MAX_DIM] = {0.0}, tangent[ISPH_MAX_DIM];

  for (PetscInt k = 0; k < st->n; k++) {
    if (!st->wall[k]) continue;
    (void)SplitX(st, k, tangent);
    for (PetscInt a = 0; a < st->dim; a++) sum[a] += w[k] * tangent[a];
  }
  for (PetscInt k = 0; k < st->n; k++) {
    for (PetscInt a = 0; a < st->dim; a++) w[k] += sum[a] * g[a][k];
  }
}

/* AddRows_Pressure - Adds a particle's rows of -dx^2 lap p and grad p, with a given wall pressure
   gradient. Notes: the Laplacian omits the tangential part of p_w - p_i for dummies in two cases.
   If its form is declared symmetric, this keeps the matrix symmetric for CG. If the gradient form
   is not exact for linear fields, it cannot give the tangential part. */
PetscErrorCode AddRows_Pressure(const Scene *scene, Stencil *st, PetscInt diagonal, Operators *ops)
{
  const PetscBool follow = !LaplacianIs(&ops->forms.ppe, FORM_SYMMETRIC) &&
                           (ops->forms.gradient->properties & FORM_EXACT_LINEAR);

  PetscFunctionBegin;
  StencilSetQuantity(scene, FIT_PRESSURE, st);
  PetscCall(LaplacianWeights(&ops->forms.ppe, st, ops->work->w));
  if (StoresRow(ops, &ops->grad_p[0])) PetscCall(ops->forms.gradient->Row(st, ops->work->g));
  if (st->n_wall && !st->fits_walls) {
    DummyRow_Gradient(st, ops->work->g);
    if (follow) DummyRow_Laplacian(st, ops->work->g, ops->work->w);
  }
  AddRow_Pressure(st, ops, diagonal, -PetscSqr(st->dx), ops->work->w, &ops->ppe);
  if (ops->needs & NEED_FREE_GRAD_P || !StoresRow(ops, &ops->grad_p[0]))
    PetscFunctionReturn(PETSC_SUCCESS); /* see AddRows_GradientWithoutWalls() */
  for (PetscInt a = 0; a < st->dim; a++)
    AddRow_Pressure(st, ops, diagonal, 1.0, ops->work->g[a], &ops->grad_p[a]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AddRows_GradientWithoutWalls - Adds a particle's rows of grad p, from fluid neighbours and from
   boundaries that give the pressure. The coupled scheme needs these rows: there the wall pressure
   gradient is not prescribed but follows from the momentum equation. */
PetscErrorCode AddRows_GradientWithoutWalls(const Scene *scene, Stencil *st, PetscInt diagonal,
                                            Operators *ops)
{
  PetscFunctionBegin;
  if (!StoresRow(ops, &ops->grad_p[0])) PetscFunctionReturn(PETSC_SUCCESS);
  StencilSetQuantity(scene, FIT_PRESSURE_FREE, st);
  PetscCall(ops->forms.gradient->Row(st, ops->work->g));
  for (PetscInt a = 0; a < st->dim; a++)
    AddRow_Pressure(st, ops, diagonal, 1.0, ops->work->g[a], &ops->grad_p[a]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if some neighbour gives a value to the present fit. */
static PetscBool GivesValue(const Stencil *st)
{
  for (PetscInt k = 0; k < st->n; k++)
    if (st->equation[k] == EQUATION_VALUE) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* AddRow_PressureFilter - Adds a particle's row of the pressure filter: p minus its quadratic fit,
   from fluid neighbours and from boundaries that give the pressure. The wall pressure gradient does
   not enter. Without such neighbours the row gives the pressure itself. */
PetscErrorCode AddRow_PressureFilter(const Scene *scene, Stencil *st, PetscInt diagonal,
                                     Operators *ops)
{
  PetscFunctionBegin;
  if (!StoresRow(ops, &ops->filter_p)) PetscFunctionReturn(PETSC_SUCCESS);
  StencilSetQuantity(scene, FIT_PRESSURE_FREE, st);
  PetscCall(FilterRow_Mls(st, ops->work->w));
  AddRow_Pressure(st, ops, diagonal, 1.0, ops->work->w, &ops->filter_p);
  if (!GivesValue(st)) AffineRow(&ops->rows, &ops->filter_p, st->i)[diagonal] = 1.0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the matrix I - T of DummyRow_Divergence(), by rows (a, b) and columns (c, e). */
static void DummyMatrix(const Stencil *st, PetscReal *const g[], PetscReal A[])
{
  const PetscInt d = st->dim, n = d * d;

  for (PetscInt t = 0; t < n * n; t++) A[t] = t % (n + 1) ? 0.0 : 1.0;
  for (PetscInt k = 0; k < st->n; k++) {
    PetscReal tangent[ISPH_MAX_DIM];

    if (!st->wall[k]) continue;
    (void)SplitX(st, k, tangent);
    for (PetscInt a = 0; a < d; a++) {
      for (PetscInt c = 0; c < d; c++) {
        const PetscReal nn = st->normal[a][k] * st->normal[c][k];

        for (PetscInt e = 0; e < d; e++) {
          const PetscReal follows =
              ((a == c) - nn) * st->X[e][k] - (st->beta[k] - 1.0) * nn * tangent[e];

          for (PetscInt b = 0; b < d; b++) A[(a * d + b) * n + c * d + e] -= g[b][k] * follows;
        }
      }
    }
  }
}

/*
  DummyRow_Divergence - Computes weights of the divergence of a velocity beside dummies

    u_w - u_i = n [ beta n.(u_wall - u_i) - (beta - 1) n.(grad u X_t) ] + (I - n n^T) grad u X

  with X = x_w - x_i, X_t = X - (X.n) n and the factor beta of walls.c. The normal component of u_w
  is extrapolated linearly from the fluid velocity at x_i + X_t, straight above the dummy. The
  tangential components continue the velocity gradient at i and do not depend on the wall velocity.
  With U_ab = du_a/dx_b this gives the linear system

    U_ab - sum_ce T_ab,ce U_ce = sum_fluid g_k,b (u_k - u_i)_a
                                 + sum_w g_w,b n_a beta n.(u_wall - u_i)
    T_ab,ce = sum_w g_w,b [ (delta_ac - n_a n_c) X_e - (beta - 1) n_a n_c X_t,e ]

  Only the divergence tr U is required. It is sum_ab lambda_ab (right-hand side)_ab, if lambda
  solves lambda (I - T) = delta. Input/Output: g - gradient weights; out: g[a][k] = sum_b lambda_ab
  g_k,b multiplies (u_k - u_i)_a; unchanged if I - T has no inverse. Properties: exact for linear
  velocities if g is exact for linear fields and beta is not capped.
*/
static void DummyRow_Divergence(const Stencil *st, PetscReal *g[])
{
  const PetscInt d = st->dim;
  PetscReal      A[SMALL_MAX * SMALL_MAX], lambda[SMALL_MAX] = {0.0};

  DummyMatrix(st, g, A);
  for (PetscInt a = 0; a < d; a++) lambda[a * d + a] = 1.0;
  if (SmallSolve(d * d, A, 1, lambda)) MultiplyWeights(st, lambda, g);
}

/* Adds a row of the divergence. Its weights are d[c][k] of (u_k - u_i)_c for fluid neighbour k, and
   m[k] st->beta[k] of n.(u_wall - u_i) for wall neighbour k, or of n.grad (n.u) if that is its
   equation. */
static void AddRow_Divergence(const Stencil *st, PetscInt diagonal, PetscReal *d[],
                              const PetscReal m[], Operators *ops)
{
  for (PetscInt c = 0; c < st->dim; c++) {
    const AffineOperator *op = &ops->div[c];
    PetscReal            *a, *b, sum = 0.0;

    if (ops->work->simple) {
      SetRow(st, ops, diagonal, 1.0, d[c], op);
      continue;
    }
    EmptyRow(ops, st->i, op, &a, &b);
    for (PetscInt k = 0; k < st->n; k++) {
      const PetscReal weight = st->wall[k] ? m[k] * st->normal[c][k] * st->beta[k] : d[c][k];

      (st->wall[k] ? b : a)[ops->work->slot[k]] += weight;
      if (st->equation[k] == EQUATION_VALUE) sum += weight;
    }
    a[diagonal] -= sum;
  }
}

/* AddRows_Divergence - Adds a particle's rows of the divergence. If wall neighbours have equations
   in fits and the gradient form has a DivergenceFit, the rows come from this fit of the velocity
   vector, otherwise from the weights of the gradient: theory.md, section 5. */
PetscErrorCode AddRows_Divergence(const Scene *scene, Stencil *st, PetscInt diagonal,
                                  Operators *ops)
{
  PetscFunctionBegin;
  if (!StoresRow(ops, &ops->div[0])) PetscFunctionReturn(PETSC_SUCCESS);
  StencilSetQuantity(scene, FIT_VELOCITY_NORMAL, st);
  if (st->n_wall && st->fits_walls && ops->forms.gradient->DivergenceFit) {
    PetscCall(ops->forms.gradient->DivergenceFit(st, ops->work->g, ops->work->m));
  } else {
    PetscCall(ops->forms.gradient->Row(st, ops->work->g));
    if (st->n_wall && !st->fits_walls) DummyRow_Divergence(st, ops->work->g);
    for (PetscInt k = 0; st->n_wall && k < st->n; k++) {
      ops->work->m[k] = 0.0;
      for (PetscInt c = 0; st->wall[k] && c < st->dim; c++)
        ops->work->m[k] += ops->work->g[c][k] * st->normal[c][k];
    }
  }
  AddRow_Divergence(st, diagonal, ops->work->g, ops->work->m, ops);
  PetscFunctionReturn(PETSC_SUCCESS);
}
