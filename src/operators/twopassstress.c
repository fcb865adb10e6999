/*
  The viscous operator of forms of two passes, on all velocity components together: the divergence D
  of the stress S of the velocity gradient G u. The first pass computes the stress, the second its
  divergence, so the stencil is twice as wide. Both passes are matrices; their product is the
  viscous operator. With the strain operator

    (E u)_i,ab = G_a u_b + G_b u_a for a > b,   (E u)_i,aa = G_a u_a

  and the symmetric stress by its entries a >= b, tau:grad u is the sum of tau_ab (E u)_ab, and the
  adjoint form is -V^-1 E^T V S E: docs/theory.md, (170) to (174). The velocity of walls enters G as
  in every row. Beside walls the adjoint form has the stress of dummies too, continued from the
  fluid: docs/theory.md, (215) to (217). The other divergence is that of the fluid's stress alone,
  one-sided beside walls.
*/
#include "rows/assembly.h"
#include "walls/boundary_rows.h"
#include "choose.h"
#include "rows/rows.h"

/* Returns the number of entries of a symmetric tensor. */
static PetscInt Entries(PetscInt dim)
{
  return dim * (dim + 1) / 2;
}

/* Returns the index of the entries (a, b) and (b, a) of a symmetric tensor. */
static PetscInt Entry(PetscInt a, PetscInt b)
{
  return a >= b ? a * (a + 1) / 2 + b : b * (b + 1) / 2 + a;
}

/* ComposedNeed - Marks the operators of both passes that the chosen form needs; not collective */
void ComposedNeed(const Scene *scene, Operators *ops)
{
  const LaplacianForm *visc = &ops->forms.visc;

  if (!(ops->needs & NEED_VISCOSITY)) return;
  for (PetscInt a = 0; visc->row && visc->row->composed && a < scene->dim; a++) {
    ops->first_pass[a].needed  = PETSC_TRUE;
    ops->second_pass[a].needed = SceneHas(scene, PHYSICS_WALLS) ? PETSC_TRUE : PETSC_FALSE;
  }
}

/*
  ComposedRefuse - Refuses a form whose stress is continued beyond walls, if its grid modes stay

  Collective. On fixed particles a third of the modes decay slower than all modes of the flow, and
  beside walls some grow: docs/theory.md, (285). A pressure drives them, and so does the error of
  the force on disordered particles. In channels on lattices the flow has no part in them.
*/
PetscErrorCode ComposedRefuse(const Scene *scene, const LaplacianForm *visc)
{
  const PetscBool drives = SceneHas(scene, PHYSICS_PRESSURE) || scene->jitter > 0.0;

  PetscFunctionBegin;
  UserCheck(
      !visc->continued || SceneMoves(scene) || !drives,
      "-visc_laplacian %s: on fixed particles with walls its grid modes have no viscosity, and %s "
      "drives them; use a form with safe_implicit in -catalogue, such as mls",
      visc->row->name, scene->jitter > 0.0 ? "-jitter" : "the pressure");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the rows of the divergence of the fluid's stress. */
static void AddRows_FluidStress(Stencil *st, PetscInt diagonal, Operators *ops)
{
  PetscReal **c = ops->work->g, *V = ops->work->w;

  for (PetscInt k = 0; k < st->n; k++) {
    V[k] = st->V[k];
    if (st->wall[k]) st->V[k] = 0.0; /* has no stress */
  }
  LaplacianGradient(&ops->forms.visc, st, c);
  for (PetscInt k = 0; k < st->n; k++) st->V[k] = V[k];
  for (PetscInt a = 0; a < st->dim; a++)
    AddRow_Velocity(st, ops, diagonal, c[a], &ops->second_pass[a]);
}

/*
  Adds the rows by which the force of an adjoint form beside walls differs from -V^-1 E^T V

    sum_w (tau_i + tau_w).c_iw  in place of  tau_i.(sum_w beta_w c_iw),   w: dummies

  tau_w is continued linearly, with slopes by MomentInverse(). Input: c - c_iw of the first
  pass, whose rows are complete.

  Reference: the continuation of dummies' values by J. P. Morris, P. J. Fox, Y. Zhu, J. Comput.
  Phys. 136 (1997), here of the stress
*/
static void AddRows_WallStress(const Stencil *st, PetscInt diagonal, PetscReal *const c[],
                               Operators *ops)
{
  const PetscInt d      = st->dim;
  PetscReal     *weight = ops->work->w, inverse[ISPH_MAX_DIM * ISPH_MAX_DIM];
  PetscBool      sloped;

  MomentWeights(st, PETSC_FALSE, weight);
  sloped = MomentInverse(st, weight, inverse);
  for (PetscInt b = 0; b < d; b++) {
    PetscReal *a, *over_walls, reach[ISPH_MAX_DIM] = {0.0}, slope[ISPH_MAX_DIM] = {0.0};
    PetscReal  own = AffineRow(&ops->rows, &ops->first_pass[b], st->i)[diagonal];

    EmptyRow(ops, st->i, &ops->second_pass[b], &a, &over_walls);
    if (!st->n_wall) continue;
    for (PetscInt k = 0; k < st->n; k++) {
      own += (st->wall[k] ? 2.0 : 1.0) * c[b][k];
      for (PetscInt e = 0; e < d && st->wall[k]; e++) reach[e] += c[b][k] * st->X[e][k];
    }
    for (PetscInt e = 0; e < d * d && sloped; e++) slope[e / d] += inverse[e] * reach[e % d];
    for (PetscInt k = 0; k < st->n; k++) {
      PetscReal along = 0.0;

      if (st->wall[k]) continue;
      for (PetscInt e = 0; e < d; e++) along += st->X[e][k] * slope[e];
      a[ops->work->slot[k]] += weight[k] * along;
      own -= weight[k] * along;
    }
    a[diagonal] += own;
  }
}

/* AddRows_Composed - Adds a particle's rows of both passes; not collective */
void AddRows_Composed(Stencil *st, PetscInt diagonal, Operators *ops)
{
  PetscReal **c = ops->work->g;

  LaplacianGradient(&ops->forms.visc, st, c);
  for (PetscInt a = 0; a < st->dim; a++)
    AddRow_Velocity(st, ops, diagonal, c[a], &ops->first_pass[a]);
  if (!ops->second_pass[0].needed) return;
  if (!ops->forms.visc.row->composed->transposed) AddRows_FluidStress(st, diagonal, ops);
  else AddRows_WallStress(st, diagonal, c, ops);
}

/* Appends an entry to rows in the making. */
static void Store(SparseRows *to, PetscInt *used, PetscInt column, PetscReal value)
{
  to->col[*used]       = column;
  to->value[(*used)++] = value;
}

/* Puts the entries of a slot into the row (a, b) of E, or of the stress S E if t >= 0, which is
   g + g^T - t tr(g) I. Input: g - weights of the gradient; first - column of the particle. */
static void PutStress(PetscInt d, PetscInt a, PetscInt b, PetscReal t, const PetscReal g[],
                      PetscInt first, SparseRows *to, PetscInt *used)
{
  if (a != b) {
    Store(to, used, first + b, g[a]);
    Store(to, used, first + a, g[b]);
    return;
  }
  for (PetscInt c = 0; c < d; c++) {
    if (t < 0.0 && c == a) Store(to, used, first + c, g[a]);
    if (t >= 0.0) Store(to, used, first + c, (c == a ? 2.0 * g[a] : 0.0) - t * g[c]);
  }
}

/* Creates E (t < 0) or S E over fluid or over walls. */
static PetscErrorCode StrainMat(const Particles *p, const Operators *ops, PetscBool over_walls,
                                PetscReal t, Mat *A)
{
  const Pattern *pattern = over_walls ? &ops->rows.walls : &ops->rows.fluid;
  const PetscInt d = p->dim, count = pattern->row[p->n_fluid];
  SparseRows     to;
  PetscInt       used = 0;

  PetscFunctionBegin;
  PetscCall(SparseRowsMalloc(Entries(d) * p->n_fluid, count * (d * (d - 1) + d * d), &to));
  for (PetscInt r = 0; r < Entries(d) * p->n_fluid; r++) {
    const PetscInt i = r / Entries(d),
                   a = r % Entries(d) < 1   ? 0
                       : r % Entries(d) < 3 ? 1
                                            : 2,
                   b = r % Entries(d) - Entry(a, 0);

    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++) {
      PetscReal g[ISPH_MAX_DIM];

      for (PetscInt e = 0; e < d; e++)
        g[e] = over_walls ? ops->first_pass[e].b[s] : ops->first_pass[e].a[s];
      PutStress(d, a, b, t, g, d * pattern->col[s], &to, &used);
    }
    to.row[r + 1] = used;
  }
  PetscCall(SparseRowsMat(p->comm, &to, d * (over_walls ? p->n_wall : p->n_fluid), A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates a divergence of the stress of the fluid: component a is sum_b D_b tau_ab. */
static PetscErrorCode DivergenceMat(const Particles *p, const Operators *ops,
                                    const AffineOperator *of, Mat *D)
{
  const Pattern *pattern = &ops->rows.fluid;
  const PetscInt d = p->dim, count = pattern->row[p->n_fluid];
  SparseRows     to;
  PetscInt       used = 0;

  PetscFunctionBegin;
  PetscCall(SparseRowsMalloc(d * p->n_fluid, count * d * d, &to));
  for (PetscInt r = 0; r < d * p->n_fluid; r++) {
    const PetscInt i = r / d, a = r % d;

    for (PetscInt s = pattern->row[i]; s < pattern->row[i + 1]; s++) {
      for (PetscInt b = 0; b < d; b++)
        Store(&to, &used, Entries(d) * pattern->col[s] + Entry(a, b), of[b].a[s]);
    }
    to.row[r + 1] = used;
  }
  PetscCall(SparseRowsMat(p->comm, &to, Entries(d) * p->n_fluid, D));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Multiplies the rows of a matrix by power (1 or -1) of the particles' volumes, and by `sign`;
   input: rows - of each particle. */
static PetscErrorCode ScaleByVolume(const Particles *p, PetscInt rows, PetscReal sign,
                                    PetscBool inverse, Mat A)
{
  PetscScalar *factor;
  Vec          scale;

  PetscFunctionBegin;
  PetscCall(MatCreateVecs(A, NULL, &scale));
  PetscCall(VecGetArrayWrite(scale, &factor));
  for (PetscInt r = 0; r < rows * p->n_fluid; r++)
    factor[r] = sign * (inverse ? 1.0 / p->volume[r / rows] : p->volume[r / rows]);
  PetscCall(VecRestoreArrayWrite(scale, &factor));
  PetscCall(MatDiagonalScale(A, scale, NULL));
  PetscCall(VecDestroy(&scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the divergence D = -V^-1 E^T V of the adjoint form, with the stress of dummies beside
   walls. */
static PetscErrorCode AdjointMat(const Particles *p, const Operators *ops, Mat *D)
{
  Mat E, walls;

  PetscFunctionBegin;
  PetscCall(StrainMat(p, ops, PETSC_FALSE, -1.0, &E));
  PetscCall(ScaleByVolume(p, Entries(p->dim), 1.0, PETSC_FALSE, E));
  PetscCall(MatTranspose(E, MAT_INITIAL_MATRIX, D));
  PetscCall(MatDestroy(&E));
  PetscCall(ScaleByVolume(p, p->dim, -1.0, PETSC_TRUE, *D));
  if (!ops->second_pass[0].needed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DivergenceMat(p, ops, ops->second_pass, &walls));
  PetscCall(MatAXPY(*D, 1.0, walls, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatDestroy(&walls));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  AssembleComposed - Creates the matrices A and B of the viscous operator of a form of two passes

    A = D S E over fluid,   B = D S E over walls

  Collective on the particles' communicator. Input: the rows of both passes.

  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), model B, Eq.
  (29); J. Fang, A. Parriaux, M. Rentschler, C. Ancey, Appl. Numer. Math. 59 (2009), Eq. (59)
*/
PetscErrorCode AssembleComposed(const Particles *p, Operators *ops)
{
  const LaplacianRow *form  = ops->forms.visc.row;
  const PetscReal     trace = ComposedTrace(form->composed, p->dim);
  const PetscBool     walls = ops->second_pass[0].needed;
  AffineOperator     *visc  = &ops->velocity[0].visc;
  Mat                 D, T, *product[] = {&visc->A, &visc->B};

  PetscFunctionBegin;
  PetscCall(form->composed->transposed
                ? AdjointMat(p, ops, &D)
                : DivergenceMat(p, ops, walls ? ops->second_pass : ops->first_pass, &D));
  for (PetscInt k = 0; k < (ops->forms.wall ? 2 : 1); k++) {
    PetscCall(MatDestroy(product[k]));
    PetscCall(StrainMat(p, ops, k ? PETSC_TRUE : PETSC_FALSE, trace, &T));
    PetscCall(MatMatMult(D, T, MAT_INITIAL_MATRIX, PETSC_DEFAULT, product[k]));
    PetscCall(MatProductClear(*product[k]));
    PetscCall(MatSetBlockSizes(*product[k], p->dim, p->dim));
    PetscCall(MatDestroy(&T));
  }
  PetscCall(MatDestroy(&D));
  PetscFunctionReturn(PETSC_SUCCESS);
}
