/*
  The matrix of the coupled system, scaled so that all entries are of order 1 and residuals of
  momentum and of mass have equal size. The unknowns are the velocity u and the scaled pressure q.
  With p_i = rho dx_i/T_i q_i and 1/T_i = 1/(4 dt) + nu_i/dx_i^2 (steady: nu_i/dx_i^2), for
  particles of equal size and viscosity:

    [ T (shift - nu L)   dx G          ] [u]   [T f]
    [ dx D               C + c c^T     ] [q] = [g  ]

  For several sizes or viscosities the rows of momentum are multiplied by T_i and the rows of mass
  by dx_i, and T_i/(rho dx_i) C p replaces C q: theory.md, (coupled:sizes).

  L, G and D are the operators of viscosity, gradient and divergence; L couples velocity components
  if its form does. shift is the factor of u in du/dt; f and g contain forces and wall data. G is
  one-sided at walls: the wall pressure gradient follows from the momentum equation of the particles
  next to the wall. All unknowns belong to the same particles, so G and D do not act on grid modes
  of the pressure. C q, the residual of a quadratic fit of q, brings these modes into the continuity
  equation. For smooth pressures it is a flux of order dx^3 (dx^4 inside lattices); it vanishes for
  quadratic pressures and needs no condition at walls. The column c of GaugeColumn() fixes the
  constant of the pressure. See theory.md, (coupled:scales), (coupled:system) and (coupled:modes).
*/
#include "saddle.h"

/* SaddleTime - Returns T, the time in which momentum changes a velocity on the scale of the grid:
   1/T = 1/(4 dt) + nu/dx^2, steady 1/T = nu/dx^2 [s]; nu: viscosity [m^2/s]. Not collective. The
   factor 1/4 gives the block C equal weight against inertia and viscosity. Of the factors 1, 1/3,
   1/6, 1/12 and 1/24 the values near 1/4 take the fewest iterations; the error of moving vortices
   at Re = 100 is half the error with the factor 1. dt is rounded to eighths of a power of two, so
   that steps that differ by rounding share their matrices. */
PetscReal SaddleTime(PetscReal nu, const Clock *clock, PetscReal dx)
{
  const PetscReal diffusion = nu / PetscSqr(dx);
  PetscReal       dt;
  int             exponent;

  if (clock->steady_solve) return 1.0 / diffusion;
  dt = PetscFloorReal(8.0 * frexp(clock->dt, &exponent) + 0.5) / 8.0;
  return 1.0 / (0.25 / ldexp(dt, exponent) + diffusion);
}

/* Computes the units of each particle over the units of the reference spacing. */
static PetscErrorCode SetUnits(const Flow *flow, Saddle *s)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;
  PetscScalar     *time, *length, *mass, *viscosity;

  PetscFunctionBegin;
  s->step  = SaddleTime(scene->nu, flow->clock, scene->dx);
  s->unit  = scene->rho * scene->dx / s->step;
  s->level = scene->level;
  PetscCall(FluidVec(p, NULL, &s->time));
  PetscCall(FluidVec(p, NULL, &s->length));
  PetscCall(FluidVec(p, NULL, &s->mass));
  PetscCall(FluidVec(p, NULL, &s->viscosity));
  PetscCall(VecGetArrayWrite(s->viscosity, &viscosity));
  PetscCall(VecGetArrayWrite(s->mass, &mass));
  PetscCall(VecGetArrayWrite(s->time, &time));
  PetscCall(VecGetArrayWrite(s->length, &length));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal nu = p->nu ? p->nu[i] : scene->nu;

    viscosity[i] = nu / scene->nu;
    time[i]      = SaddleTime(nu, flow->clock, p->dx[i]) / s->step;
    length[i] = mass[i] = p->dx[i] / scene->dx;
  }
  PetscCall(VecRestoreArrayWrite(s->viscosity, &viscosity));
  PetscCall(VecRestoreArrayWrite(s->mass, &mass));
  PetscCall(VecRestoreArrayWrite(s->length, &length));
  PetscCall(VecRestoreArrayWrite(s->time, &time));
  PetscCall(VecDuplicate(s->length, &s->pressure));
  PetscCall(VecPointwiseDivide(s->pressure, s->length, s->time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates G, D and C in the units of each particle. */
static PetscErrorCode CreateBlocks(const Flow *flow, Saddle *s)
{
  const Particles *p   = flow->particles;
  const Operators *ops = flow->ops;
  const PetscReal  dx  = flow->scene->dx;
  Vec              momentum, mass; /* T_i/T of momentum rows; factor of the rows of C */

  PetscFunctionBegin;
  PetscCall(VelocityVecRepeat(p, s->time, &momentum));
  if (flow->scheme->splines) {
    PetscCall(SaddleOnSplines(flow, momentum, s));
    PetscCall(VecDestroy(&momentum));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecDuplicate(s->length, &mass));
  PetscCall(VecPointwiseDivide(mass, s->time, s->length));
  PetscCall(AffineBlock(p, &ops->rows, &(AffineLayout){s->dim, 1, dx, momentum, s->pressure, NULL},
                        ops->grad_p, &s->G));
  PetscCall(AffineBlock(p, &ops->rows, &(AffineLayout){1, s->dim, dx, s->mass, NULL, NULL},
                        ops->div, &s->D));
  PetscCall(AffineBlock(p, &ops->rows, &(AffineLayout){1, 1, 1.0, mass, s->pressure, NULL},
                        &ops->filter_p, &s->C));
  PetscCall(VecDestroyAll(&momentum, &mass));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a term to a matrix and destroys the term; a matrix that is NULL becomes the term. */
static PetscErrorCode AddTerm(Mat term, Mat *sum)
{
  PetscFunctionBegin;
  if (*sum) {
    PetscCall(SparseAdd(term, sum));
    PetscCall(MatDestroy(&term));
  } else {
    *sum = term;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the matrix with the entries of F: the block of a component, or F itself. */
static Mat EntriesOf(const Saddle *s)
{
  return s->component ? s->component : s->F;
}

/* Creates the vector T_i/T of the rows of this matrix. */
static PetscErrorCode TimesOfRows(const Particles *p, const Saddle *s, Vec *times)
{
  PetscFunctionBegin;
  if (!s->component) {
    PetscCall(VelocityVecRepeat(p, s->time, times));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecDuplicate(s->time, times));
  PetscCall(VecCopy(s->time, *times));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix of w z x u, by which the axes of a turning frame turn. */
static PetscErrorCode CreateTurn(const Flow *flow, Mat *turn)
{
  const PetscInt  dim = flow->scene->dim, n = dim * flow->particles->n_fluid;
  const PetscReal rate = SceneFrameRate(flow->scene, flow->clock->t);
  PetscInt        first;

  PetscFunctionBegin;
  PetscCall(MatCreateAIJ(flow->particles->comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, 1, NULL, 0,
                         NULL, turn));
  PetscCall(MatGetOwnershipRange(*turn, &first, NULL));
  for (PetscInt i = first; i < first + n; i += dim) {
    PetscCall(MatSetValue(*turn, i, i + 1, -rate, INSERT_VALUES));
    PetscCall(MatSetValue(*turn, i + 1, i, rate, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(*turn, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*turn, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Momentum_Mult(Mat F, Vec x, Vec y)
{
  Saddle *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(F, &s));
  PetscCall(MatMult(s->viscous, x, y));
  PetscCall(VecAXPBY(y, s->shift, -s->nu, x));
  PetscCall(VecPointwiseMult(y, y, s->rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Momentum_GetDiagonal(Mat F, Vec diagonal)
{
  Saddle *s;

  PetscFunctionBegin;
  PetscCall(MatShellGetContext(F, &s));
  PetscCall(MatGetDiagonal(s->viscous, diagonal));
  PetscCall(VecScale(diagonal, -s->nu));
  PetscCall(VecShift(diagonal, s->shift));
  PetscCall(VecPointwiseMult(diagonal, diagonal, s->rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates F from a viscous matrix that has products only. */
static PetscErrorCode MomentumProducts(const Flow *flow, Mat viscous, Saddle *s)
{
  const PetscInt n = s->dim * s->n;

  PetscFunctionBegin;
  s->nu      = flow->scene->nu;
  s->viscous = viscous;
  PetscCall(PetscObjectReference((PetscObject)viscous));
  PetscCall(VelocityVecRepeat(flow->particles, s->time, &s->rows));
  PetscCall(VecScale(s->rows, s->step));
  PetscCall(
      MatCreateShell(flow->particles->comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, s, &s->F));
  PetscCall(MatShellSetOperation(s->F, MATOP_MULT, (void (*)(void))Momentum_Mult));
  PetscCall(MatShellSetOperation(s->F, MATOP_GET_DIAGONAL, (void (*)(void))Momentum_GetDiagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets F and its diagonal for shift 0 to T_i (-nu L + v.grad) of all velocity components, and in a
   turning frame T_i w z x u; v: `advecting`, if given. Terms that are the same for each component
   are summed up before they are interlaced, and F is a MATMAIJ if it has no others. */
static PetscErrorCode CreateMomentum(const Flow *flow, const Vec advecting[], Saddle *s)
{
  const Scene             *scene   = flow->scene;
  const VelocityOperators *of      = &flow->ops->velocity[0];
  const PetscBool          couples = flow->ops->forms.components_coupled;
  Mat                      term, scalar = NULL;
  PetscBool                entries;

  PetscFunctionBegin;
  PetscCall(MatHasOperation(of->visc.A, MATOP_GET_ROW, &entries));
  if (!entries) {
    PetscCall(MomentumProducts(flow, of->visc.A, s));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatDuplicate(of->visc.A, MAT_COPY_VALUES, &term));
  PetscCall(MatScale(term, -scene->nu));
  s->F = couples ? term : NULL;
  if (!couples) scalar = term;
  for (PetscInt a = 0; advecting && a < scene->dim; a++) {
    PetscCall(MatDuplicate(of->grad_u[a].A, MAT_COPY_VALUES, &term));
    PetscCall(MatDiagonalScale(term, advecting[a], NULL));
    PetscCall(AddTerm(term, &scalar));
  }
  if (scalar) PetscCall(MatCreateMAIJ(scalar, scene->dim, &term));
  if (scalar && s->repeats) {
    s->component = scalar;
    s->F         = term;
  } else if (scalar) {
    PetscCall(MatConvert(term, MATAIJ, MAT_INPLACE_MATRIX, &term));
    PetscCall(AddTerm(term, &s->F));
    PetscCall(MatDestroy(&scalar));
  }
  if (advecting && scene->frame) {
    PetscCall(CreateTurn(flow, &term));
    PetscCall(AddTerm(term, &s->F));
  }
  if (!s->component) PetscCall(MatSetBlockSize(s->F, scene->dim));
  PetscCall(TimesOfRows(flow->particles, s, &s->diagonal));
  PetscCall(VecScale(s->diagonal, s->step));
  PetscCall(MatDiagonalScale(EntriesOf(s), s->diagonal, NULL));
  PetscCall(MatGetDiagonal(EntriesOf(s), s->diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleAssemble - Assembles all blocks from the present operators, but for the shift of F; see
   SaddleSetShift(). Collective. Input: advecting - velocity of implicit convection [m/s]; NULL: no
   implicit convection. */
PetscErrorCode SaddleAssemble(const Flow *flow, const Vec advecting[], Saddle *s)
{
  const Scene     *scene = flow->scene;
  const Particles *p     = flow->particles;

  PetscFunctionBegin;
  PetscCall(SaddleFree(s));
  s->dim = scene->dim;
  s->n = s->n_p = p->n_fluid;
  s->shift      = NAN;
  s->assemblies = flow->ops->assemblies;
  PetscCall(SetUnits(flow, s));
  PetscCall(CreateMomentum(flow, advecting, s));
  PetscCall(CreateBlocks(flow, s));
  PetscCall(GaugeColumn(scene, p->comm, scene->dim * p->n_fluid, s->n_p, 1.0, &s->gauge));
  PetscCall(MatCreateNest(p->comm, 2, NULL, 2, NULL, (Mat[]){s->F, s->G, s->D, s->C}, &s->P));
  PetscCall(GaugeMatrix(s->P, s->gauge, &s->A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleSetShift - Computes the momentum block F for a new shift, the factor of u in du/dt;
   collective */
PetscErrorCode SaddleSetShift(const Particles *p, PetscReal shift, Saddle *s)
{
  Vec rows;

  PetscFunctionBegin;
  if (shift == s->shift) PetscFunctionReturn(PETSC_SUCCESS);
  if (!s->viscous) {
    PetscCall(TimesOfRows(p, s, &rows));
    PetscCall(VecAYPX(rows, s->step * shift, s->diagonal));
    PetscCall(MatDiagonalSet(EntriesOf(s), rows, INSERT_VALUES));
    PetscCall(VecDestroy(&rows));
  }
  for (PetscInt k = 0; k < 3; k++) { /* tells PETSc about the changed block */
    const Mat changed[] = {s->F, s->P, s->A};

    PetscCall(MatAssemblyBegin(changed[k], MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(changed[k], MAT_FINAL_ASSEMBLY));
  }
  s->shift = shift;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleFree - Frees all matrices and units; collective */
PetscErrorCode SaddleFree(Saddle *s)
{
  Mat *all[] = {&s->A, &s->P, &s->gauge, &s->C, &s->D, &s->G, &s->F, &s->component, &s->viscous};

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(all); k++) PetscCall(MatDestroy(all[k]));
  PetscCall(VecDestroyAll(&s->diagonal, &s->time, &s->length, &s->mass, &s->viscosity, &s->pressure,
                          &s->constant, &s->rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleFlatten - Converts the blocks to a single sparse matrix, for preconditioners without
   blocks. Collective. Adds 1e-6 to the diagonal of the pressure rows; otherwise an undetermined
   constant of the pressure would make the matrix singular. On entry flat is NULL, or a matrix of
   the same blocks that is reused. A matrix without blocks is not copied. */
PetscErrorCode SaddleFlatten(Mat P, Mat *flat)
{
  const PetscInt *index;
  PetscInt        n;
  PetscBool       nested;
  IS              rows[2];
  Mat             F, nest, **block;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)P, MATNEST, &nested));
  if (!nested) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatNestGetSubMats(P, NULL, NULL, &block));
  PetscCall(MatConvert(block[0][0], MATAIJ, MAT_INITIAL_MATRIX, &F)); /* it may be a MATMAIJ */
  PetscCall(MatCreateNest(PetscObjectComm((PetscObject)P), 2, NULL, 2, NULL,
                          (Mat[]){F, block[0][1], block[1][0], block[1][1]}, &nest));
  PetscCall(MatConvert(nest, MATAIJ, *flat ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX, flat));
  PetscCall(MatDestroyAll(&nest, &F));
  PetscCall(MatNestGetISs(P, rows, NULL));
  PetscCall(ISGetLocalSize(rows[1], &n));
  PetscCall(ISGetIndices(rows[1], &index));
  for (PetscInt i = 0; i < n; i++)
    PetscCall(MatSetValue(*flat, index[i], index[i], 1e-6, ADD_VALUES));
  PetscCall(ISRestoreIndices(rows[1], &index));
  PetscCall(MatAssemblyBegin(*flat, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*flat, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddlePut - Sets x = (u, q); p_i less the pressure level of the scene is q_i times the unit of
   pressures; not collective */
PetscErrorCode SaddlePut(const Saddle *s, Vec u[], Vec p, Vec x)
{
  const PetscScalar *from, *unit, *one = NULL;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArray(x, &to));
  for (PetscInt c = 0; c < s->dim; c++) {
    PetscCall(VecGetArrayRead(u[c], &from));
    for (PetscInt i = 0; i < s->n; i++) to[s->dim * i + c] = from[i];
    PetscCall(VecRestoreArrayRead(u[c], &from));
  }
  PetscCall(VecGetArrayRead(p, &from));
  PetscCall(VecGetArrayRead(s->pressure, &unit));
  if (s->constant) PetscCall(VecGetArrayRead(s->constant, &one));
  for (PetscInt i = 0; i < s->n_p; i++)
    to[s->dim * s->n + i] = (from[i] - s->level * (one ? one[i] : 1.0)) / s->unit / unit[i];
  if (one) PetscCall(VecRestoreArrayRead(s->constant, &one));
  PetscCall(VecRestoreArrayRead(s->pressure, &unit));
  PetscCall(VecRestoreArrayRead(p, &from));
  PetscCall(VecRestoreArray(x, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleGet - Extracts u and p from x, see SaddlePut(); p may be NULL; not collective */
PetscErrorCode SaddleGet(const Saddle *s, Vec x, Vec u[], Vec p)
{
  const PetscScalar *from, *unit, *one = NULL;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(x, &from));
  for (PetscInt c = 0; c < s->dim; c++) {
    PetscCall(VecGetArray(u[c], &to));
    for (PetscInt i = 0; i < s->n; i++) to[i] = from[s->dim * i + c];
    PetscCall(VecRestoreArray(u[c], &to));
  }
  if (p) {
    PetscCall(VecGetArray(p, &to));
    PetscCall(VecGetArrayRead(s->pressure, &unit));
    if (s->constant) PetscCall(VecGetArrayRead(s->constant, &one));
    for (PetscInt i = 0; i < s->n_p; i++)
      to[i] = s->level * (one ? one[i] : 1.0) + from[s->dim * s->n + i] * s->unit * unit[i];
    if (one) PetscCall(VecRestoreArrayRead(s->constant, &one));
    PetscCall(VecRestoreArrayRead(s->pressure, &unit));
    PetscCall(VecRestoreArray(p, &to));
  }
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SaddleAdd - Adds scale T_i/T part to the rows of velocity component c, or for c = dim adds scale
   dx_i/dx part to the rows of mass. Not collective. Input: scale - factor for a particle of the
   reference spacing. */
PetscErrorCode SaddleAdd(const Saddle *s, PetscInt c, PetscReal scale, Vec part, Vec x)
{
  const PetscInt     stride = c < s->dim ? s->dim : 1, first = c < s->dim ? c : s->dim * s->n;
  const PetscInt     n     = c < s->dim ? s->n : s->n_p;
  const Vec          units = c < s->dim ? s->time : s->mass;
  const PetscScalar *from, *unit;
  PetscScalar       *to;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(part, &from));
  PetscCall(VecGetArrayRead(units, &unit));
  PetscCall(VecGetArray(x, &to));
  for (PetscInt i = 0; i < n; i++) to[first + stride * i] += scale * (unit[i] * from[i]);
  PetscCall(VecRestoreArray(x, &to));
  PetscCall(VecRestoreArrayRead(units, &unit));
  PetscCall(VecRestoreArrayRead(part, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}
