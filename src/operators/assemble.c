/* Assembly of the matrices. A loop over the fluid particles gathers the stencil of each particle,
   computes the particle's row of every operator, and stores the weights of fluid and wall
   neighbours in arrays that share a sparsity pattern. */
#include "rows/assembly.h"
#include "walls/boundary_rows.h"
#include "fitted.h"
#include "isph/strain.h"
#include "rows/rows.h"
#include "walls/wall_points.h"

/* Adds a particle's row to the patterns of the matrices A and B. Finds the slots of its neighbours
   and of the diagonal: their positions in the arrays of values. */
static void PlaceRow(const Particles *p, const Stencil *st, Operators *ops, PetscInt *diagonal)
{
  const PetscInt capacity = ops->work->slot_capacity;
  Pattern       *fluid    = &ops->rows.fluid;
  PetscInt *cols = ops->work->slot + capacity, *local = cols + capacity, *place = local + capacity;
  PetscInt  n = 0, own = -1;

  for (PetscInt k = 0; k < st->n; k++) { /* inserts the diagonal so that columns ascend */
    if (st->wall[k]) continue;
    if (own < 0 && st->j[k] > st->i) {
      own        = n;
      local[n++] = st->i;
    }
    local[n++] = st->j[k];
  }
  if (own < 0) {
    own        = n;
    local[n++] = st->i;
  }
  for (PetscInt k = 0; k < n; k++) cols[k] = p->row[local[k]];
  ops->work->simple = PatternRow(fluid, st->i, cols, local, n, place) && !st->n_wall;
  ops->work->single = fluid->row[st->i + 1] - fluid->row[st->i] == n;
  *diagonal         = place[own] - fluid->row[st->i];
  for (PetscInt k = 0, q = 0; k < st->n; k++) {
    if (st->wall[k]) continue;
    if (q == own) q++;
    ops->work->slot[k] = place[q++] - fluid->row[st->i];
  }
  if (!ops->forms.wall) return;
  n = 0;
  for (PetscInt k = 0; k < st->n; k++) {
    if (!st->wall[k]) continue;
    local[n]  = st->j[k];
    cols[n++] = p->row[st->j[k]];
  }
  (void)PatternRow(&ops->rows.walls, st->i, cols, local, n, place);
  if (ops->rows.walls.row[st->i + 1] - ops->rows.walls.row[st->i] != n)
    ops->work->single = PETSC_FALSE;
  n = 0;
  for (PetscInt k = 0; k < st->n; k++) {
    if (st->wall[k]) ops->work->slot[k] = place[n++] - ops->rows.walls.row[st->i];
  }
}

/* Assembles a particle's rows in the operators of a velocity component, whose wall equations
   StencilSetVelocity() has set in the stencil. */
static PetscErrorCode AssembleVelocityRow(const Scene *scene, const Particles *p, Stencil *st,
                                          PetscInt diagonal, Operators *ops, VelocityOperators *of)
{
  PetscFunctionBegin;
  if (of->visc.needed && StoresRow(ops, &of->visc)) {
    PetscCall(LaplacianWeights(&ops->forms.visc, st, ops->work->w));
    if (p->nu && !ops->forms.components_coupled) WeighByViscosity(scene, p, st, ops->work->w);
    if (ops->forms.components_coupled) KeepBlockRow(st, diagonal, ops->work->w, ops);
    else AddRow_Velocity(st, ops, diagonal, ops->work->w, &of->visc);
  }
  if (of->grad_u[0].needed && StoresRow(ops, &of->grad_u[0])) {
    PetscCall(ops->forms.gradient->Row(st, ops->work->g));
    for (PetscInt a = 0; a < st->dim; a++)
      AddRow_Velocity(st, ops, diagonal, ops->work->g[a], &of->grad_u[a]);
  }
  if (of->filter_u.needed && StoresRow(ops, &of->filter_u)) {
    PetscCall(FilterRow_Mls(st, ops->work->w));
    AddRow_Velocity(st, ops, diagonal, ops->work->w, &of->filter_u);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Assembles a particle's rows in all operators, in an order in which operators share least-squares
   fits. */
static PetscErrorCode AssembleRow(const Scene *scene, const Particles *p, Stencil *st,
                                  PetscInt diagonal, Operators *ops)
{
  PetscFunctionBegin;
  for (PetscInt c = 0; c < ops->n_velocity; c++) {
    StencilSetVelocity(scene, c, st);
    PetscCall(AssembleVelocityRow(scene, p, st, diagonal, ops, &ops->velocity[c]));
  }
  if (ops->ppe.needed) {
    PetscCall(AddRows_Pressure(scene, st, diagonal, ops));
    if (ops->needs & NEED_FREE_GRAD_P)
      PetscCall(AddRows_GradientWithoutWalls(scene, st, diagonal, ops));
    if (ops->filter_p.needed) PetscCall(AddRow_PressureFilter(scene, st, diagonal, ops));
    PetscCall(AddRows_Divergence(scene, st, diagonal, ops));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the operators that the run needs; returns their number. */
static PetscInt NeededOperators(Operators *ops, AffineOperator *needed[])
{
  AffineOperator *all[OPERATORS_COUNT];
  PetscInt        count = 0;

  OperatorsList(ops, all);
  for (PetscInt k = 0; k < OPERATORS_COUNT; k++) {
    if (all[k]->needed) needed[count++] = all[k];
  }
  return count;
}

/* Returns the number of wall particles in all lists of neighbours. */
static PetscInt WallEntries(const Particles *p, const Neighbors *nb)
{
  const PetscInt own = ParticlesOwn(p), halo = own + p->n_halo_fluid;
  PetscInt       n = 0;

#pragma omp simd reduction(+ : n)
  for (PetscInt q = 0; q < nb->row[p->n_fluid]; q++)
    n += (nb->col[q] >= p->n_fluid && nb->col[q] < own) || nb->col[q] >= halo ? 1 : 0;
  return n;
}

/* Returns true if operators that share rows need not store that of a particle. The row of a twin
   has no wall neighbours, whose equations depend on the quantity. Rows made from fits need the
   coefficients, and a column for each neighbour. */
static PetscBool IsShared(const Stencil *st, const OperatorRows *rows)
{
  const PetscInt *fluid = &rows->fluid.row[st->i], *walls = &rows->walls.row[st->i];

  if (!rows->fitted) return st->n && !st->n_wall;
  if (!st->fit.fitted || fluid[1] - fluid[0] != st->n - st->n_wall + 1) return PETSC_FALSE;
  return !st->n_wall || walls[1] - walls[0] == st->n_wall;
}

/* Returns true if row i repeats an earlier one. */
static inline PetscBool Repeats(const Operators *ops, PetscInt i)
{
  return ops->work->like && ops->work->like[i] < i;
}

/* Finds the place of the present row in operators that share rows. */
static PetscErrorCode PlaceApart(const Stencil *st, Operators *ops)
{
  OperatorRows   *rows = &ops->rows;
  const PetscInt  end  = rows->n_apart + rows->fluid.row[st->i + 1] - rows->fluid.row[st->i];
  AffineOperator *all[OPERATORS_COUNT];

  PetscFunctionBegin;
  ops->work->shared  = IsShared(st, rows);
  rows->apart[st->i] = ops->work->shared     ? -1
                       : Repeats(ops, st->i) ? rows->apart[ops->work->like[st->i]]
                                             : rows->n_apart;
  if (ops->work->shared || Repeats(ops, st->i)) PetscFunctionReturn(PETSC_SUCCESS);
  if (end > rows->apart_capacity) {
    rows->apart_capacity = end + end / 2;
    OperatorsList(ops, all);
    for (PetscInt k = 0; k < OPERATORS_COUNT; k++)
      if (all[k]->needed && AffineShares(all[k]))
        PetscCall(PetscRealloc(rows->apart_capacity * sizeof(PetscReal), &all[k]->apart));
  }
  rows->n_apart = end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the weights of row i over walls from the equal row: they are stored in all rows. */
static PetscErrorCode CopyWalls(PetscInt i, Operators *ops)
{
  const PetscInt *row = ops->rows.walls.row, from = row ? row[ops->work->like[i]] : 0;
  const PetscInt  n = row ? row[i + 1] - row[i] : 0;
  AffineOperator *needed[OPERATORS_COUNT];
  const PetscInt  count = n ? NeededOperators(ops, needed) : 0;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < count; k++)
    PetscCall(PetscArraycpy(needed[k]->b + row[i], needed[k]->b + from, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the place of the weights of row i, if rows repeat. */
static PetscErrorCode PlaceWeights(PetscInt i, Operators *ops)
{
  OperatorRows *rows = &ops->rows;

  PetscFunctionBegin;
  if (!ops->work->like) PetscFunctionReturn(PETSC_SUCCESS);
  if (Repeats(ops, i)) {
    rows->first[i] = rows->first[ops->work->like[i]];
    PetscCall(CopyWalls(i, ops));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  rows->first[i] = rows->n_weights;
  rows->n_weights += rows->fluid.row[i + 1] - rows->fluid.row[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room in the workspace for the longest row. */
static PetscErrorCode ReserveWork(const Scene *scene, const Particles *p, const Neighbors *nb,
                                  Operators *ops)
{
  const PetscInt width   = ops->velocity[0].visc.width;
  Assembly      *work    = ops->work;
  PetscInt       longest = 1;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++)
    longest = PetscMax(longest, nb->row[i + 1] - nb->row[i] + 1);
  if (ops->rows.fitted) PetscCall(FittedReserve(p, longest, ops->rows.fitted));
  if (longest <= work->slot_capacity) PetscFunctionReturn(PETSC_SUCCESS);
  work->slot_capacity = 2 * longest;
  PetscCall(PetscFree5(work->slot, work->w, work->m, work->wall_w, work->excess));
  PetscCall(PetscMalloc5(4 * work->slot_capacity, &work->slot, work->slot_capacity * width,
                         &work->w, work->slot_capacity, &work->m, work->slot_capacity * width,
                         &work->wall_w, SceneBoundaries(scene), &work->excess));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(PetscFree(work->g[a]));
    PetscCall(PetscMalloc1(work->slot_capacity, &work->g[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Destroys the matrices of the last assembly and makes room for the pattern of the new rows. */
static PetscErrorCode BeginPattern(const Particles *p, const Neighbors *nb, Operators *ops,
                                   AffineOperator *needed[], PetscInt count)
{
  OperatorRows  *rows    = &ops->rows;
  const PetscInt walls   = ops->forms.wall ? WallEntries(p, nb) : 0;
  const PetscInt entries = nb->row[p->n_fluid] + p->n_fluid - walls;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < count; k++) {
    PetscCall(MatDestroyAll(&needed[k]->A, &needed[k]->B));
  }
  PetscCall(PatternBegin(&rows->fluid, rows->has_columns, p->n_fluid, entries));
  if (ops->forms.wall) PetscCall(PatternBegin(&rows->walls, rows->has_columns, p->n_fluid, walls));
  if (p->n_fluid > rows->rows_capacity) {
    rows->rows_capacity = p->n_fluid + p->n_fluid / 8;
    PetscCall(PetscFree(rows->apart));
    PetscCall(PetscMalloc1(rows->rows_capacity, &rows->apart));
  }
  rows->n_apart = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the rows that repeat; without repetition weights are in the order of the pattern. Output:
   capacity - room for the weights of an operator, over its width. */
static PetscErrorCode ChooseWeights(const Scene *scene, const Particles *p, const Neighbors *nb,
                                    Operators *ops, PetscInt *capacity)
{
  OperatorRows *rows = &ops->rows;
  Stencil      *st   = ops->work->stencil;

  PetscFunctionBegin;
  *capacity = rows->fluid.capacity;
  if (!rows->repeats) {
    rows->first = rows->fluid.row;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscFree(rows->first));
  PetscCall(PetscMalloc1(p->n_fluid, &rows->first));
  PetscCall(PetscMalloc1(p->n_fluid, &ops->work->like));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt diagonal;

    PetscCall(GatherStencil(scene, p, nb, ops, i, st));
    PlaceRow(p, st, ops, &diagonal);
    ops->work->like[i] = ops->work->single;
  }
  PetscCall(FindRepeats(scene, p, rows, ops->work->like));
  PetscCall(FindRuns(ops->work->like, rows));
  rows->n_weights = *capacity = 0;
  for (PetscInt i = 0; i < p->n_fluid; i++)
    if (!Repeats(ops, i)) *capacity += rows->fluid.row[i + 1] - rows->fluid.row[i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for the weights of the needed operators. Input: fluid, walls - weights of an operator,
   over its width. */
static PetscErrorCode ReserveWeights(PetscInt fluid, PetscInt walls, AffineOperator *needed[],
                                     PetscInt count, OperatorRows *rows)
{
  const PetscBool grown = rows->weights_capacity < fluid || rows->walls_capacity < walls;

  PetscFunctionBegin;
  if (!grown) PetscFunctionReturn(PETSC_SUCCESS);
  rows->weights_capacity = fluid;
  rows->walls_capacity   = walls;
  for (PetscInt k = 0; k < count; k++) {
    PetscCall(FreeAll(&needed[k]->a, &needed[k]->b));
    if (!AffineShares(needed[k])) PetscCall(PetscMalloc1(fluid * needed[k]->width, &needed[k]->a));
    if (walls) PetscCall(PetscMalloc1(walls * needed[k]->width, &needed[k]->b));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for all that an assembly computes. */
static PetscErrorCode BeginAssembly(const Scene *scene, const Particles *p, const Neighbors *nb,
                                    Operators *ops, AffineOperator *needed[], PetscInt count)
{
  Concentration *c = &ops->concentration;
  PetscInt       capacity;

  PetscFunctionBegin;
  PetscCall(ReserveWork(scene, p, nb, ops));
  PetscCall(BeginPattern(p, nb, ops, needed, count));
  PetscCall(ChooseWeights(scene, p, nb, ops, &capacity));
  PetscCall(ReserveWeights(capacity, ops->rows.walls.capacity, needed, count, &ops->rows));
  if (!(ops->needs & NEED_CONCENTRATION) || ops->epoch == p->epoch)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(c->value));
  PetscCall(PetscMalloc1(p->n_fluid, &c->value));
  for (PetscInt a = 0; a < scene->dim; a++) {
    PetscCall(PetscFree(c->gradient[a]));
    PetscCall(PetscMalloc1(p->n_fluid, &c->gradient[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the factor -dx_i^2 of each row of the pressure Laplacian, once in each epoch:
   theory.md, (projection:matrix). */
static PetscErrorCode ScalePressureRows(const Particles *p, Operators *ops)
{
  PetscScalar *scale;

  PetscFunctionBegin;
  if (!ops->ppe.needed || (ops->ppe_scale && ops->epoch == p->epoch))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDestroy(&ops->ppe_scale));
  PetscCall(FluidVec(p, NULL, &ops->ppe_scale));
  PetscCall(VecGetArrayWrite(ops->ppe_scale, &scale));
  for (PetscInt i = 0; i < p->n_fluid; i++) scale[i] = -PetscSqr(p->dx[i]);
  PetscCall(VecRestoreArrayWrite(ops->ppe_scale, &scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the concentration of particle i and its gradient, for shifting and for the pressure
   source of -ppe_alpha. */
static void AssembleConcentration(const Scene *scene, const Particles *p, const Stencil *st,
                                  PetscInt i, Operators *ops)
{
  PetscReal x[ISPH_MAX_DIM], gradient[ISPH_MAX_DIM];

  for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
  ConcentrationRow(scene, ops->forms.kernel, st, x, st->fits_walls, &ops->concentration.value[i],
                   gradient);
  for (PetscInt a = 0; a < scene->dim; a++) ops->concentration.gradient[a][i] = gradient[a];
}

/* Assembles the rows of `count` particles from particle `first` on. */
static PetscErrorCode AssembleBatch(const Scene *scene, const Particles *p, const Neighbors *nb,
                                    PetscInt first, PetscInt count, Operators *ops)
{
  Stencil *const *batch = ops->work->batch;
  Stencil        *fresh[MLS_BATCH];
  PetscInt        fits = 0;

  PetscFunctionBegin;
  for (PetscInt l = 0; l < count; l++) {
    PetscCall(GatherStencil(scene, p, nb, ops, first + l, batch[l]));
    WallPointShares(ops, batch[l]);
    StencilSetVelocity(scene, 0, batch[l]); /* the first fit that rows ask for */
    if (ops->rows.fitted && (!batch[l]->n_wall || ops->work->fits_walls))
      FittedPlace(ops->rows.fitted, batch[l]);
    if (!Repeats(ops, first + l)) fresh[fits++] = batch[l];
  }
  if (ops->work->has_fits) PetscCall(MlsFitBatch(ops->forms.degree, fits, fresh, ops->work->fits));
  for (PetscInt l = 0; l < count; l++) {
    PetscInt diagonal;

    PlaceRow(p, batch[l], ops, &diagonal);
    PetscCall(PlaceWeights(first + l, ops));
    PetscCall(PlaceApart(batch[l], ops));
    if (!Repeats(ops, first + l)) PetscCall(AssembleRow(scene, p, batch[l], diagonal, ops));
    if (ops->needs & NEED_CONCENTRATION && !ops->cut_surface)
      AssembleConcentration(scene, p, batch[l], first + l, ops);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the viscous matrices of a weak form. */
static PetscErrorCode AssembleWeak(const Scene *scene, const Particles *p, const Neighbors *nb,
                                   Operators *ops)
{
  const StrainQuantity velocity = {.sets = ops->n_velocity, .cut = ops->cut_surface};
  AffineOperator      *visc     = &ops->velocity[0].visc;
  const PetscBool      products = ops->cut_surface && p->dim == 3;

  PetscFunctionBegin;
  PetscCall(MatDestroyAll(&visc->A, &visc->B));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MatDestroy(&ops->cut_part[k]));
  PetscCall(
      StrainAssemble(scene, p, nb, StrainEdge(scene), ops->forms.degree, &velocity, &ops->strain));
  StrainViscosities(scene, p, ops->strain);
  if (products) {
    if (SceneViscosityVaries(scene)) PetscCall(StrainPlaces(p, ops->strain));
    PetscCall(StrainProducts(scene, p, PETSC_FALSE, ops->strain, &visc->A));
    if (ops->forms.wall) PetscCall(StrainProducts(scene, p, PETSC_TRUE, ops->strain, &visc->B));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(StrainMatrices(scene, p, ops->forms.wall ? PETSC_TRUE : PETSC_FALSE, ops->strain,
                           &visc->A, &visc->B));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OperatorsAssemble - Assembles all matrices of the run for the present positions of particles

    (op f)_i = sum_j A_ij f_j + sum_w B_iw e_w

  for operators op on values f of the fluid, with wall data e. Collective on the particles'
  communicator. Does nothing if positions and numbering have not changed since the last assembly.
  Output: changed - flag: the matrices are new. Notes: increases ops->assemblies, the stamp by which
  solvers recognise new matrices; sets ops->regularised_rows, the number of least-squares fits whose
  points did not determine them.
*/
PetscErrorCode OperatorsAssemble(const Scene *scene, const Particles *p, const Neighbors *nb,
                                 Operators *ops, PetscBool *changed)
{
  AffineOperator  *needed[OPERATORS_COUNT];
  const PetscInt   count   = NeededOperators(ops, needed);
  const KernelSize kernel  = FormsKernel(&ops->forms);
  const PetscBool  weak    = ops->needs & NEED_VISCOSITY && ops->forms.visc.row->weak;
  Mat              like[2] = {NULL, NULL};

  PetscFunctionBegin;
  *changed = (ops->epoch != p->epoch || ops->moved != p->moved) ? PETSC_TRUE : PETSC_FALSE;
  if (!*changed) PetscFunctionReturn(PETSC_SUCCESS);
  if (!count && !weak && !(ops->needs & NEED_CONCENTRATION)) { /* such as with NEED_STREAMS alone */
    ops->epoch = p->epoch;
    ops->moved = p->moved;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(BeginAssembly(scene, p, nb, ops, needed, count));
  PetscCall(ScalePressureRows(p, ops));
  PetscCall(LaplacianFactors(scene, p, nb, ops, &ops->forms.visc));
  PetscCall(LaplacianFactors(scene, p, nb, ops, &ops->forms.ppe));
  for (PetscInt l = 0; l < MLS_BATCH; l++) ops->work->batch[l]->regularised = 0;
  for (PetscInt i = 0; i < p->n_fluid; i += MLS_BATCH)
    PetscCall(AssembleBatch(scene, p, nb, i, PetscMin(MLS_BATCH, p->n_fluid - i), ops));
  PetscCall(PetscFree(ops->work->like));
  for (PetscInt k = 0; k < count; k++) {
    if (!needed[k]->has_matrices) continue;
    if (ops->forms.components_coupled && needed[k] == &ops->velocity[0].visc) continue;
    PetscCall(PatternMat(p->comm, &ops->rows.fluid, p->n_fluid, p->n_fluid, needed[k]->a, like[0],
                         &needed[k]->A));
    like[0] = needed[k]->A;
    if (!ops->forms.wall) continue;
    PetscCall(PatternMat(p->comm, &ops->rows.walls, p->n_fluid, p->n_wall, needed[k]->b, like[1],
                         &needed[k]->B));
    like[1] = needed[k]->B;
  }
  if (weak) PetscCall(AssembleWeak(scene, p, nb, ops));
  else if (ops->forms.components_coupled && ops->velocity[0].visc.needed)
    PetscCall(AssembleViscousBlock(scene, p, ops));
  if (ops->cut_surface && ops->needs & NEED_CONCENTRATION)
    PetscCall(StrainUnevenness(scene, p, nb, &kernel, ops->strain, ops->concentration.value,
                               ops->concentration.gradient));
  ops->rows.particles   = p;
  ops->regularised_rows = 0;
  for (PetscInt l = 0; l < MLS_BATCH; l++)
    ops->regularised_rows += ops->work->batch[l]->regularised;
  ops->epoch = p->epoch;
  ops->moved = p->moved;
  ops->assemblies++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
