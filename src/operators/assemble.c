/*
  Assembly of the matrices. A loop over the fluid particles gathers the stencil of each particle,
  computes the particle's row of every operator, and stores the weights of fluid and wall neighbours
  in arrays that share a sparsity pattern.
*/
#include "assembly.h"
#include "boundary_rows.h"
#include "extension.h"
#include "rows.h"
#include "wall_points.h"

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
  if (ops->first_pass[0].needed) AddRows_Composed(st, diagonal, ops);
  if (ops->ppe.needed) {
    PetscCall(AddRows_Pressure(scene, st, diagonal, ops));
    if (ops->needs & NEED_FREE_GRAD_P)
      PetscCall(AddRows_GradientWithoutWalls(scene, st, diagonal, ops));
    if (ops->filter_p.needed) PetscCall(AddRow_PressureFilter(scene, st, diagonal, ops));
    PetscCall(AddRows_Divergence(scene, st, diagonal, ops));
    if (st->kind != SURFACE_INSIDE) SetRows_Surface(st, diagonal, ops);
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

/* Finds the place of row i in operators that have a twin: a row with wall neighbours, or with no
   neighbours at all, is apart, because its equations depend on the quantity. */
static PetscErrorCode PlaceApart(const Stencil *st, Operators *ops)
{
  OperatorRows   *rows = &ops->rows;
  const PetscInt  end  = rows->n_apart + rows->fluid.row[st->i + 1] - rows->fluid.row[st->i];
  AffineOperator *all[OPERATORS_COUNT];

  PetscFunctionBegin;
  ops->work->shared  = st->n && !st->n_wall ? PETSC_TRUE : PETSC_FALSE;
  rows->apart[st->i] = ops->work->shared ? -1 : rows->n_apart;
  if (ops->work->shared) PetscFunctionReturn(PETSC_SUCCESS);
  if (end > rows->apart_capacity) {
    rows->apart_capacity = end + end / 2;
    OperatorsList(ops, all);
    for (PetscInt k = 0; k < OPERATORS_COUNT; k++)
      if (all[k]->twin)
        PetscCall(PetscRealloc(rows->apart_capacity * sizeof(PetscReal), &all[k]->apart));
  }
  rows->n_apart = end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Destroys the matrices of the last assembly and makes room for the new rows. */
static PetscErrorCode BeginAssembly(const Scene *scene, const Particles *p, const Neighbors *nb,
                                    Operators *ops, AffineOperator *needed[], PetscInt count)
{
  const PetscInt walls    = ops->forms.wall ? WallEntries(p, nb) : 0;
  const PetscInt entries  = nb->row[p->n_fluid] + p->n_fluid - walls;
  const PetscInt capacity = ops->rows.fluid.capacity, wall_capacity = ops->rows.walls.capacity;
  PetscInt       longest = 1;
  PetscBool      grown;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < count; k++) {
    PetscCall(MatDestroy(&needed[k]->A));
    PetscCall(MatDestroy(&needed[k]->B));
  }
  PetscCall(PatternBegin(&ops->rows.fluid, p->n_fluid, entries));
  if (ops->forms.wall) PetscCall(PatternBegin(&ops->rows.walls, p->n_fluid, walls));
  grown = ops->rows.fluid.capacity != capacity || ops->rows.walls.capacity != wall_capacity ||
                  (count && !needed[0]->a)
              ? PETSC_TRUE
              : PETSC_FALSE;
  for (PetscInt k = 0; grown && k < count; k++) {
    PetscCall(PetscFree(needed[k]->a));
    PetscCall(PetscFree(needed[k]->b));
    if (!needed[k]->twin)
      PetscCall(PetscMalloc1(ops->rows.fluid.capacity * needed[k]->width, &needed[k]->a));
    if (ops->forms.wall)
      PetscCall(PetscMalloc1(ops->rows.walls.capacity * needed[k]->width, &needed[k]->b));
  }
  if (p->n_fluid > ops->rows.rows_capacity) {
    ops->rows.rows_capacity = p->n_fluid + p->n_fluid / 8;
    PetscCall(PetscFree(ops->rows.apart));
    PetscCall(PetscMalloc1(ops->rows.rows_capacity, &ops->rows.apart));
  }
  ops->rows.n_apart = 0;
  for (PetscInt i = 0; i < p->n_fluid; i++)
    longest = PetscMax(longest, nb->row[i + 1] - nb->row[i] + 1);
  if (longest > ops->work->slot_capacity) {
    ops->work->slot_capacity = 2 * longest;
    PetscCall(PetscFree4(ops->work->slot, ops->work->w, ops->work->m, ops->work->wall_w));
    PetscCall(PetscMalloc4(4 * ops->work->slot_capacity, &ops->work->slot,
                           ops->work->slot_capacity * ops->velocity[0].visc.width, &ops->work->w,
                           ops->work->slot_capacity, &ops->work->m,
                           ops->work->slot_capacity * ops->velocity[0].visc.width,
                           &ops->work->wall_w));
    for (PetscInt a = 0; a < scene->dim; a++) {
      PetscCall(PetscFree(ops->work->g[a]));
      PetscCall(PetscMalloc1(ops->work->slot_capacity, &ops->work->g[a]));
    }
  }
  if (ops->needs & NEED_CONCENTRATION && ops->epoch != p->epoch) {
    PetscCall(PetscFree(ops->concentration.value));
    PetscCall(PetscMalloc1(p->n_fluid, &ops->concentration.value));
    for (PetscInt a = 0; a < scene->dim; a++) {
      PetscCall(PetscFree(ops->concentration.gradient[a]));
      PetscCall(PetscMalloc1(p->n_fluid, &ops->concentration.gradient[a]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the factor -dx_i^2 of each row of the pressure Laplacian, once in each epoch:
   docs/theory.md, (121). */
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

  PetscFunctionBegin;
  for (PetscInt l = 0; l < count; l++) {
    PetscCall(GatherStencil(scene, p, nb, ops, first + l, batch[l]));
    WallPointShares(ops, batch[l]);
    StencilSetVelocity(scene, 0, batch[l]); /* the first fit that rows ask for */
  }
  if (ops->work->has_fits) PetscCall(MlsFitBatch(ops->forms.degree, count, batch, ops->work->fits));
  for (PetscInt l = 0; l < count; l++) {
    PetscInt diagonal;

    PlaceRow(p, batch[l], ops, &diagonal);
    PetscCall(PlaceApart(batch[l], ops));
    PetscCall(AssembleRow(scene, p, batch[l], diagonal, ops));
    if (ops->needs & NEED_CONCENTRATION) AssembleConcentration(scene, p, batch[l], first + l, ops);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OperatorsAssemble - Assembles all matrices of the run for the present positions of particles

    (op f)_i = sum_j A_ij f_j + sum_w B_iw e_w

  for operators op on values f of the fluid, with wall data e.

  Collective on the particles' communicator. Does nothing if positions and numbering have not
  changed since the last assembly.

  Output Parameter:
. changed - flag: the matrices are new

  Notes: increases ops->assemblies, the stamp by which solvers recognise new matrices; sets
  ops->regularised_rows, the number of least-squares fits whose points did not determine them.
*/
PetscErrorCode OperatorsAssemble(const Scene *scene, const Particles *p, const Neighbors *nb,
                                 Operators *ops, PetscBool *changed)
{
  AffineOperator *needed[OPERATORS_COUNT];
  const PetscInt  count = NeededOperators(ops, needed);

  PetscFunctionBegin;
  *changed = (ops->epoch != p->epoch || ops->moved != p->moved) ? PETSC_TRUE : PETSC_FALSE;
  if (!*changed) PetscFunctionReturn(PETSC_SUCCESS);
  if (ops->free) PetscCall(FreeSurfaceFind(scene, p, nb, &ops->forms, ops->free));
  if (!count && !(ops->needs & NEED_CONCENTRATION)) { /* such as with NEED_STREAMS alone */
    ops->epoch = p->epoch;
    ops->moved = p->moved;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(BeginAssembly(scene, p, nb, ops, needed, count));
  PetscCall(ScalePressureRows(p, ops));
  PetscCall(LaplacianFactors(scene, p, nb, ops, &ops->forms.visc));
  PetscCall(LaplacianFactors(scene, p, nb, ops, &ops->forms.ppe));
  for (PetscInt l = 0; l < MLS_LANES; l++) ops->work->batch[l]->regularised = 0;
  for (PetscInt i = 0; i < p->n_fluid; i += MLS_LANES)
    PetscCall(AssembleBatch(scene, p, nb, i, PetscMin(MLS_LANES, p->n_fluid - i), ops));
  for (PetscInt k = 0; k < count; k++) {
    if (!needed[k]->has_matrices) continue;
    if (ops->forms.components_coupled && needed[k] == &ops->velocity[0].visc) continue;
    PetscCall(
        PatternMat(p->comm, &ops->rows.fluid, p->n_fluid, p->n_fluid, needed[k]->a, &needed[k]->A));
    if (!ops->forms.wall) continue;
    PetscCall(
        PatternMat(p->comm, &ops->rows.walls, p->n_fluid, p->n_wall, needed[k]->b, &needed[k]->B));
  }
  if (ops->first_pass[0].needed) PetscCall(AssembleComposed(p, ops));
  else if (ops->forms.components_coupled && ops->velocity[0].visc.needed)
    PetscCall(AssembleViscousBlock(scene, p, ops));
  ops->rows.particles = p;
  if (ops->forms.wall && ops->forms.wall->Extend) PetscCall(ExtendWalls(scene, p, nb, ops));
  ops->regularised_rows = 0;
  for (PetscInt l = 0; l < MLS_LANES; l++)
    ops->regularised_rows += ops->work->batch[l]->regularised;
  ops->epoch = p->epoch;
  ops->moved = p->moved;
  ops->assemblies++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
