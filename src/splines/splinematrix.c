/* The matrix of the pressure increment on splines, A = -scale^2 D G: the product of divergence and
   gradient. Moving particles change both in each step, so A is a shell that applies one after the
   other. Fixed particles keep them, so A is computed once; its product with a vector takes about an
   eighth of the operations. */
#include "splines.h"
#include "isph/operators.h"

#define JUMP_SHARE   1e-3 /* least share of a spline in a fluid with a jump of its own */
#define JUMP_PENALTY 1e3  /* of the divergence in a fluid, over the largest viscosity */

/* Context of the shell. */
typedef struct {
  Splines         *splines;
  const Particles *particles;
} SplineFactors;

/* Computes y = A x by the factors of A. */
static PetscErrorCode SplineMatrix(Mat A, Vec x, Vec y)
{
  SplineFactors     *factors;
  Splines           *s;
  const Particles   *p;
  const PetscScalar *in;
  PetscScalar       *out;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &factors));
  s = factors->splines;
  p = factors->particles;
  PetscCall(SplinesGradient(s, x, s->fits.value));
  SplinesDivideByInertia(s, s->fits.value);
  if (s->cut[0]) {
    PetscCall(MatMult(s->cut[1], s->cut_gradient, y));
    PetscCall(VecScale(y, -PetscSqr(s->scale)));
  } else {
    PetscCall(PetscArrayzero(s->fits.value + p->dim * p->n_fluid, p->dim * p->n_wall));
    PetscCall(SplinesIntegrate(p, s, y));
    PetscCall(VecScale(y, s->scale));
  }
  PetscCall(VecGetArrayRead(x, &in));
  PetscCall(VecGetArray(y, &out));
  for (PetscInt k = 0; k < s->n_unused; k++) out[s->unused[k]] = in[s->unused[k]];
  PetscCall(VecRestoreArray(y, &out));
  PetscCall(VecRestoreArrayRead(x, &in));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Return the bounds of the entries of the fit of component a from component b at point g. */
static PetscInt First(const SplineFits *f, PetscInt a, PetscInt b, PetscInt g)
{
  return f->first[f->sets == 1 ? 0 : a][f->sets == 1 ? 0 : b][g];
}

static PetscInt Last(const SplineFits *f, PetscInt a, PetscInt b, PetscInt g)
{
  return f->last[f->sets == 1 ? 0 : a][f->sets == 1 ? 0 : b][g];
}

/* Assembles the matrix of the gradient, splines -> interlaced components over fluid [1/m]. */
static PetscErrorCode GradientMat(const Splines *s, const Particles *p, Mat *G)
{
  PetscInt *width;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->dim * p->n_fluid, &width));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt c = 0; c < p->dim; c++) x[c] = p->x[c][i];
    width[p->dim * i] = SplineRowWidth(s, &s->pressure, x);
    for (PetscInt c = 1; c < p->dim; c++) width[p->dim * i + c] = width[p->dim * i];
  }
  PetscCall(SplineMat(p->comm, p->dim * p->n_fluid, s->own.size, width, G));
  PetscCall(PetscFree(width));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM];
    SplineRow at;

    for (PetscInt c = 0; c < p->dim; c++) x[c] = p->x[c][i];
    SplineRowAt(s, &s->pressure, p, x, &at);
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscInt row = p->dim * p->row[i] + a;

      PetscCall(MatSetValues(*G, 1, &row, at.n, at.number, at.gradient[a], ADD_VALUES));
    }
  }
  PetscCall(SplineMatFinish(*G));
  if (s->mixture.inertia) PetscCall(SplinesDivideRows(s, p, *G));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles the matrix of the fit of component a, interlaced components over fluid -> points. */
static PetscErrorCode FitMat(const Splines *s, const Particles *p, PetscInt a, Mat *J)
{
  const SplineFits *f = &s->fits;
  PetscInt          row, *width;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(f->points, &width));
  for (PetscInt g = 0; g < f->points; g++)
    for (PetscInt b = 0; b < p->dim; b++)
      if (f->coupled || b == a) width[g] += Last(f, a, b, g) - First(f, a, b, g);
  PetscCall(SplineMat(p->comm, f->points, p->dim * p->n_fluid, width, J));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*J, &row, NULL));
  for (PetscInt g = 0; g < f->points; g++, row++) {
    for (PetscInt b = 0; b < p->dim; b++) {
      if (b != a && !f->coupled) continue;
      for (PetscInt k = First(f, a, b, g); k < Last(f, a, b, g); k++) {
        if (ParticlesIsWall(p, f->j[k])) continue;
        PetscCall(MatSetValue(*J, row, p->dim * p->row[f->j[k]] + b, f->w[k], ADD_VALUES));
      }
    }
  }
  PetscCall(SplineMatFinish(*J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the matrix of the integrals of the velocity, sum_a T_a^T J_a with the integrals T_a
   along axis a and the fits J_a of component a: interlaced components over fluid -> splines; each
   J_a is multiplied by G first if it is given. MatTransposeMatMult() would add the parts of other
   ranks in the order in which they arrive, and runs would differ in their last digits. */
static PetscErrorCode IntegralMat(const Splines *s, const Particles *p, Mat G, Mat *D)
{
  Mat T, transposed, part, J, fit;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < s->lattice.dim; a++) {
    PetscCall(FitMat(s, p, a, &J));
    fit = J;
    if (G) PetscCall(SplineProductMat(J, G, &fit));
    if (G) PetscCall(MatDestroy(&J));
    PetscCall(SplineGradientMat(p, s, a, &T));
    PetscCall(MatTranspose(T, MAT_INITIAL_MATRIX, &transposed));
    PetscCall(MatDestroy(&T));
    PetscCall(SplineProductMat(transposed, fit, a ? &part : D));
    PetscCall(MatDestroyAll(&transposed, &fit));
    if (!a) continue;
    PetscCall(MatAXPY(*D, 1.0, part, DIFFERENT_NONZERO_PATTERN));
    PetscCall(MatDestroy(&part));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesBlocks - Creates the matrices of gradient and divergence for the present particles, with
  interlaced components of the velocity

    G p = rho_0/rho grad p,   D u = d of SplinesDivergence() without the terms of walls   [1/m]

  Collective. Rows of splines that are no unknowns are empty; columns are not if a side gives their
  number.
*/
PetscErrorCode SplinesBlocks(const Particles *p, const Splines *s, Mat *G, Mat *D)
{
  PetscFunctionBegin;
  if (s->cut[0]) {
    PetscCall(MatDuplicate(s->cut[0], MAT_COPY_VALUES, G));
    PetscCall(MatDuplicate(s->cut[1], MAT_COPY_VALUES, D));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(GradientMat(s, p, G));
  PetscCall(IntegralMat(s, p, NULL, D));
  PetscCall(MatScale(*D, -1.0 / s->scale));
  if (s->extension) PetscCall(SplineClear(s, PETSC_FALSE, 0.0, *D));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- beside interfaces: divergences of strain cells ---- */

/* Assembles the splines at the n own cells, cells -> splines; cells of fluids other than `fluid`
   (-1: none) have an empty row. */
static PetscErrorCode CellSplinesMat(const Particles *p, const Splines *s, const StrainCells *cells,
                                     PetscInt n, PetscInt fluid, Mat *P)
{
  PetscInt  row = 0, *width;
  PetscReal x[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &width));
  for (PetscInt c = 0; c < cells->n; c++)
    if (StrainHasCell(p, cells, c, x)) width[row++] = SplineRowWidth(s, &s->lattice, x);
  PetscCall(SplineMat(p->comm, n, s->own.size, width, P));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*P, &row, NULL));
  for (PetscInt c = 0; c < cells->n; c++) {
    SplineRow at;

    if (!StrainHasCell(p, cells, c, x)) continue;
    if (fluid < 0 || cells->fluid[c] == fluid) {
      SplineRowAt(s, &s->lattice, p, x, &at);
      PetscCall(MatSetValues(*P, 1, &row, at.n, at.number, at.value, ADD_VALUES));
    }
    row++;
  }
  PetscCall(SplineMatFinish(*P));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles V_c div u of the cells over the volume of a cell of the splines: interlaced components
   over fluid, or over walls -> cells. */
static PetscErrorCode CellDivergenceMat(const Particles *p, const Splines *s,
                                        const StrainCells *cells, PetscInt n, PetscBool walls,
                                        Mat *T)
{
  const StrainBlocks *flux = &cells->flux;
  const PetscInt      d    = p->dim;
  const PetscReal     cell = PetscPowReal(s->scale, (PetscReal)d);
  PetscInt            row  = 0, *width;
  PetscReal           x[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &width));
  for (PetscInt c = 0; c < cells->n; c++) {
    if (!StrainHasCell(p, cells, c, x)) continue;
    for (PetscInt a = 0; a < d; a++) {
      const PetscInt q = cells->sets == 1 ? 0 : a;

      width[row] += cells->first[q][c + 1] - cells->first[q][c];
    }
    if (flux->n) width[row] += d * (flux->start[c + 1] - flux->start[c]);
    row++;
  }
  PetscCall(SplineMat(p->comm, n, d * (walls ? p->n_wall : p->n_fluid), width, T));
  PetscCall(PetscFree(width));
  PetscCall(MatGetOwnershipRange(*T, &row, NULL));
  for (PetscInt c = 0; c < cells->n; c++) {
    if (!StrainHasCell(p, cells, c, x)) continue;
    for (PetscInt a = 0; a < d; a++) {
      const PetscInt q = cells->sets == 1 ? 0 : a;

      for (PetscInt e = cells->first[q][c]; e < cells->first[q][c + 1]; e++) {
        const PetscInt j = cells->j[q][e];

        if (ParticlesIsWall(p, j) != walls) continue;
        PetscCall(MatSetValue(*T, row, d * p->row[j] + a,
                              cells->volume[c] / cell * cells->g[q][a][e], ADD_VALUES));
      }
    }
    for (PetscInt e = flux->n ? flux->start[c] : 0; e < (flux->n ? flux->start[c + 1] : 0); e++)
      for (PetscInt a = 0; a < d && ParticlesIsWall(p, flux->j[e]) == walls; a++)
        PetscCall(MatSetValue(*T, row, d * p->row[flux->j[e]] + a, flux->w[e * d + a] / cell,
                              ADD_VALUES));
    row++;
  }
  PetscCall(SplineMatFinish(*T));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets gamma to the penalty of the divergence in the part of each spline that a fluid has, over its
   volume: 0 unless the spline has two fluids. */
static PetscErrorCode JumpPenalty(const Particles *p, const StrainCells *cells, Mat all, Mat part,
                                  PetscReal nu, Vec gamma)
{
  PetscInt     end;
  PetscScalar *g, *m;
  Vec          volume, whole;

  PetscFunctionBegin;
  PetscCall(SplineCellVolumes(p, cells, all, &volume));
  PetscCall(MatCreateVecs(all, &whole, NULL));
  PetscCall(MatMultTranspose(all, volume, whole));
  PetscCall(MatMultTranspose(part, volume, gamma));
  PetscCall(VecGetArray(gamma, &g));
  PetscCall(VecGetArray(whole, &m));
  PetscCall(VecGetLocalSize(gamma, &end));
  for (PetscInt k = 0; k < end; k++) {
    const PetscReal share = m[k] > 0.0 ? g[k] / m[k] : 0.0;

    g[k] = share > JUMP_SHARE && share < 1.0 - JUMP_SHARE ? JUMP_PENALTY * nu / g[k] : 0.0;
  }
  PetscCall(VecRestoreArray(whole, &m));
  PetscCall(VecRestoreArray(gamma, &g));
  PetscCall(VecDestroyAll(&volume, &whole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Adds the penalty of the divergence in each fluid beside interfaces to the viscous matrices,

    -1/(nu_0 M_i) sum_k gamma_k d_k d_k^T u,   d_k u = int psi_k div u over a fluid

  In the limit gamma_k d_k u are jumps of the pressure, and each fluid has no divergence.
*/
static PetscErrorCode AddJumps(const Flow *flow, const StrainCells *cells, PetscInt n, Mat all,
                               const Mat T[], PetscReal *const mass[], Splines *s)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  AffineOperator  *visc  = &flow->ops->velocity[0].visc;
  const PetscReal  cell  = PetscPowReal(s->scale, (PetscReal)p->dim);

  PetscFunctionBegin;
  for (PetscInt f = 1; f < SceneFluids(scene); f++) {
    PetscReal nu = 0.0;
    Mat       part, D[2] = {NULL, NULL}, back, added;
    Vec       gamma;

    for (PetscInt k = 0; k < SceneFluids(scene); k++)
      nu = PetscMax(nu, k ? scene->region_nu[k - 1] : scene->nu);
    PetscCall(CellSplinesMat(p, s, cells, n, f, &part));
    PetscCall(MatCreateVecs(part, &gamma, NULL));
    PetscCall(JumpPenalty(p, cells, all, part, nu, gamma));
    PetscCall(SplineGathered(part, T[0], &D[0]));
    if (T[1]) PetscCall(SplineGathered(part, T[1], &D[1]));
    PetscCall(MatTranspose(D[0], MAT_INITIAL_MATRIX, &back));
    PetscCall(VelocityRowsDivide(p, mass, -cell * cell / scene->nu, back));
    for (PetscInt w = 0; w < 2; w++) {
      if (!D[w]) continue;
      PetscCall(MatDiagonalScale(D[w], gamma, NULL));
      PetscCall(SplineProductMat(back, D[w], &added));
      PetscCall(SparseAdd(added, w ? &visc->B : &visc->A));
      PetscCall(MatDestroy(&added));
      PetscCall(MatScale(D[w], cell));
      s->jump[f - 1][w] = D[w];
    }
    PetscCall(MatDestroyAll(&back, &part));
    PetscCall(VecDestroy(&gamma));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesSetJumps - Computes the jumps of the pressure by which a velocity is free of divergence in
   each fluid, from the velocity u of the viscous solve; collective. Fluids below a free surface
   have splines of their own. */
PetscErrorCode SplinesSetJumps(const Flow *flow, const Vec u[], Splines *s)
{
  PetscFunctionBegin;
  if (s->fluids > 1) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt f = 0; f < s->n_jumps; f++) {
    PetscCall(SplinesOfVelocity(flow, s->jump[f], u, s->jumps[f]));
    PetscCall(VecScale(s->jumps[f], -flow->scene->rho));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesCutAssemble - Computes gradient and divergence from the strain cells if the flow has
  interfaces and a weak form: each fluid has its own divergence there, and the gradient is the
  adjoint

    (D u)_q = sum_c V_c psi_q(x_c) (div u)_c,   (G p)_i = -1/M_i sum_q p_q d(D u)_q/du_i

  Collective. As in the fits of splinefits.c, walls along the axes take part with their normal
  velocity only.
*/
PetscErrorCode SplinesCutAssemble(Flow *flow, Splines *s)
{
  const Particles *p     = flow->particles;
  const Operators *ops   = flow->ops;
  StrainCells     *cells = NULL;
  PetscInt         n     = 0;
  PetscReal        x[ISPH_MAX_DIM], *mass[ISPH_MAX_DIM];
  Mat              all = NULL, T[2] = {NULL, NULL};

  const StrainQuantity normal = {.sets = p->dim, .normal = PETSC_TRUE};

  PetscFunctionBegin;
  if (s->in_cut == flow->ops->assemblies) PetscFunctionReturn(PETSC_SUCCESS);
  s->in_cut = flow->ops->assemblies;
  PetscCall(SplinesCutFree(s));
  if (!OperatorsCutFluids(flow->scene, ops) || !ops->strain) PetscFunctionReturn(PETSC_SUCCESS);
  if (ops->cut_surface) {
    cells = ops->strain; /* walls give all of their velocity: there is no fluid past them */
  } else {
    PetscCall(StrainAssemble(flow->scene, p, flow->neighbors, CELL_EDGE, ops->forms.degree, &normal,
                             &cells));
  }
  for (PetscInt a = 0; a < p->dim; a++) mass[a] = ops->strain->mass[ops->strain->sets == 1 ? 0 : a];
  for (PetscInt c = 0; c < cells->n; c++) n += StrainHasCell(p, cells, c, x) ? 1 : 0;
  s->n_jumps = SceneFluids(flow->scene) - 1;
  PetscCall(PetscCalloc2(s->n_jumps, &s->jump, s->n_jumps, &s->jumps));
  for (PetscInt f = 0; f < s->n_jumps; f++) {
    PetscCall(VecDuplicate(s->mass, &s->jumps[f]));
    PetscCall(VecSet(s->jumps[f], 0.0));
  }
  PetscCall(CellDivergenceMat(p, s, cells, n, PETSC_FALSE, &T[0]));
  if (flow->ops->forms.wall) PetscCall(CellDivergenceMat(p, s, cells, n, PETSC_TRUE, &T[1]));
  if (ops->cut_surface) {
    const PetscInt sets                     = s->fluids == 1 ? 1 : s->fluids + 1;
    Mat            of[SCENE_MAX_FLUIDS + 2] = {NULL};

    for (PetscInt f = 0; f < sets; f++)
      PetscCall(CellSplinesMat(p, s, cells, n, f == sets - 1 ? -1 : f, &of[f]));
    PetscCall(SplineSurfaceRows(flow, n, of, T, s));
    for (PetscInt f = 0; f < sets; f++) PetscCall(MatDestroy(&of[f]));
    PetscCall(FlowSurfaceTension(flow));
    PetscCall(SplinesShareOut(s));
  } else {
    PetscCall(CellSplinesMat(p, s, cells, n, -1, &all));
    for (PetscInt w = 0; w < 2; w++)
      if (T[w]) PetscCall(SplineGathered(all, T[w], &s->cut[1 + w]));
  }
  PetscCall(MatTranspose(s->cut[1], MAT_INITIAL_MATRIX, &s->cut[0]));
  PetscCall(VelocityRowsDivide(p, mass, -PetscPowReal(s->scale, (PetscReal)p->dim), s->cut[0]));
  PetscCall(MatCreateVecs(s->cut[0], NULL, &s->cut_gradient));
  if (ops->cut_surface && s->has_products) PetscCall(SplineSurfaceStiffness(s));
  if (!ops->cut_surface) PetscCall(AddJumps(flow, cells, n, all, T, mass, s));
  PetscCall(MatDestroyAll(&all, &T[0], &T[1]));
  if (!ops->cut_surface) PetscCall(StrainDestroy(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesPressOnWalls - Adds the forces of a pressure on own wall particles, the adjoint of their
   part in the divergence of strain cells; collective. Input/Output: force - component a on w at
   [w dim + a] [N]. */
PetscErrorCode SplinesPressOnWalls(const Splines *s, Vec p, PetscReal force[])
{
  const PetscReal    cell = PetscPowReal(s->scale, (PetscReal)s->lattice.dim);
  const PetscScalar *load;
  PetscInt           n;
  Vec                walls, excess;

  PetscFunctionBegin;
  if (!s->cut[2]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(s->cut[2], &walls, NULL));
  PetscCall(SplinesExcess(s, p, &excess));
  PetscCall(MatMultTranspose(s->cut[2], excess, walls));
  PetscCall(VecDestroy(&excess));
  PetscCall(VecGetLocalSize(walls, &n));
  PetscCall(VecGetArrayRead(walls, &load));
  for (PetscInt k = 0; k < n; k++) force[k] += cell * load[k];
  PetscCall(VecRestoreArrayRead(walls, &load));
  PetscCall(VecDestroy(&walls));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes A; splines that are no unknowns have the equation phi = 0. */
static PetscErrorCode SplineProduct(Splines *s, const Particles *p)
{
  Mat G;

  PetscFunctionBegin;
  if (s->cut[0]) {
    PetscCall(SplineProductMat(s->cut[1], s->cut[0], &s->A));
    PetscCall(MatScale(s->A, -PetscSqr(s->scale)));
  } else {
    PetscCall(GradientMat(s, p, &G));
    PetscCall(IntegralMat(s, p, G, &s->A));
    PetscCall(MatDestroy(&G));
    PetscCall(MatScale(s->A, s->scale));
  }
  if (!s->extension) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplineClear(s, PETSC_FALSE, 0.0, s->A));
  PetscCall(MatSetOption(s->A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  PetscCall(SplineUnusedRows(s, s->A));
  PetscCall(SplineMatFinish(s->A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FactorsDestroy(Mat A)
{
  SplineFactors *factors;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(A, &factors));
  PetscCall(PetscFree(factors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the shell that applies the factors one after the other. */
static PetscErrorCode SplineShell(Splines *s, const Particles *p)
{
  const PetscInt own = s->own.size, all = s->lattice.N;
  SplineFactors *factors;

  PetscFunctionBegin;
  PetscCall(PetscNew(&factors));
  *factors = (SplineFactors){.splines = s, .particles = p};
  PetscCall(MatCreateShell(p->comm, own, own, all, all, factors, &s->A));
  PetscCall(MatShellSetOperation(s->A, MATOP_MULT, (void (*)(void))SplineMatrix));
  PetscCall(MatShellSetOperation(s->A, MATOP_DESTROY, (void (*)(void))FactorsDestroy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplinesMatrix - Creates the matrix of the pressure increment for the present particles;
   collective */
PetscErrorCode SplinesMatrix(const Particles *p, Splines *s)
{
  PetscFunctionBegin;
  if (SceneMoves(s->lattice.scene)) {
    if (!s->A) PetscCall(SplineShell(s, p));
  } else if (s->product != s->assemblies) {
    PetscCall(MatDestroy(&s->A));
    PetscCall(SplineProduct(s, p));
  }
  s->product = s->assemblies;
  PetscFunctionReturn(PETSC_SUCCESS);
}
