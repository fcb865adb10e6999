/* The rates of a scalar, from the gradients of cells and from the boundaries between them. */
#include "scalars.h"

/* Of a cell of particles that move [dx]: such cells are made in each step. With cells of a whole
   spacing values of neighbours part. Cells that a free surface cuts are smaller: at n = 24 errors
   below it are half as large. */
#define EDGE      0.8
#define EDGE_FREE (2.0 / 3.0)

/* Computes the values by local index: of own fluid from c, at own walls a share of those given. */
PetscErrorCode ScalarValues(const Flow *flow, const PetscReal c[], PetscReal share, Scalar *s)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(ParticlesAll(p) + 1), &s->all));
  PetscCall(PetscArraycpy(s->all, c, p->n_fluid));
  for (PetscInt k = 0; k < p->n_wall; k++) s->all[p->n_fluid + k] = share * s->wall[k];
  PetscCall(ParticlesHaloField(p, s->all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarSetWalls - Sets the values of own points of walls at time t; zero where the boundary gives
   none */
PetscErrorCode ScalarSetWalls(const Flow *flow, PetscReal t, Scalar *s)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(p->n_wall + 1), &s->wall));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt side            = (PetscInt)p->side[p->n_fluid + k];
    PetscReal      x[ISPH_MAX_DIM] = {0.0};

    ParticlesWallPoint(p, p->n_fluid + k, x);
    s->wall[k] = s->gives[side] ? ExpressionValue(&s->law[side]->of, 0, t, x) : 0.0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the diffusivities of the cells at time t: at their means of the scalars. */
static PetscErrorCode SetDiffusivities(Flow *flow, PetscReal t, Scalar *s)
{
  const Scalars    *all   = flow->state->scalars;
  const Expression *given = &s->given->diffusivity;
  const PetscInt    d     = flow->scene->dim;
  const PetscBool   mixes = ExpressionUses(given, EXPRESSION_FIELDS);
  PetscReal         least = 0.0;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(s->cells->n + 1), &s->D));
  for (PetscInt c = 0; c < s->cells->n; c++) {
    PetscReal x[ISPH_MAX_DIM] = {0.0}, field[SCALARS_MOST] = {0.0};

    for (PetscInt a = 0; a < d; a++) x[a] = s->cells->centre[a][c];
    for (PetscInt k = 0; mixes && k < all->n; k++)
      for (PetscInt e = s->cells->first[0][c]; e < s->cells->first[0][c + 1]; e++)
        field[k] += s->cells->mean[e] * all->scalar[k].all[s->cells->j[0][e]];
    s->D[c] = given->n
                  ? ExpressionOf(given, ScalarFluid(given, s->cells->fluid[c]), t, x, field, 0.0)
                  : 0.0;
    least   = PetscMin(least, s->D[c]);
  }
  if (!ExpressionUses(given, ~0u)) PetscFunctionReturn(PETSC_SUCCESS); /* a number is checked */
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPIU_REAL, MPIU_MIN, flow->particles->comm));
  UserCheck(least >= 0.0, "%s: it is %.6g in the fluid, and must not be negative", given->option,
            (double)least);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the cells of the present places. */
static PetscErrorCode FindCells(Flow *flow, Scalar *s)
{
  const Particles     *p        = flow->particles;
  const StrainQuantity quantity = {.sets = 1, .gives = s->gives, .cut = flow->ops->cut_surface};
  PetscReal            edge     = CELL_EDGE;

  PetscFunctionBegin;
  PetscCall(NeighborsSearch(p, flow->neighbors)); /* fixed particles keep no lists of neighbours */
  if (SceneMoves(flow->scene)) edge = quantity.cut ? EDGE_FREE : EDGE;
  PetscCall(StrainAssemble(flow->scene, p, flow->neighbors, edge, flow->ops->forms.degree,
                           &quantity, &s->cells));
  if (!SceneMoves(flow->scene) && !SceneHasFreeSurface(flow->scene))
    PetscCall(NeighborsRelease(flow->neighbors)); /* as FlowAssemble() */
  PetscCall(MatDestroy(&s->A));
  if (!s->shell) PetscCall(MatDestroy(&s->J));
  PetscCall(PetscRealloc(sizeof(*s->part) * (size_t)(s->cells->border.n + 1), &s->part));
  s->epoch = p->epoch;
  s->moved = p->moved;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsOpen(const Flow *flow, PetscInt j)
{
  const Particles *p = flow->particles;

  return ParticlesIsWall(p, j) &&
         BoundaryIs(flow->scene, (PetscInt)p->side[j], BOUNDARY_INFLOW | BOUNDARY_OUTFLOW);
}

/* Adds the rates of the cells by local index: of own fluid, and of own points of walls what they
   take from it. Convection is that of the difference from the mean, but through openings, so that a
   uniform value stays one although the divergence of the cells is not quite zero. Input: d - the
   dimension. */
static inline void AddCells(const Flow *flow, PetscInt d, PetscReal mean, const Scalar *s,
                            PetscReal to[])
{
  const StrainCells     *cells = s->cells;
  const PetscReal       *w = flow->state->scalars->flow, *all = s->all;
  const PetscReal *const g[] = {cells->g[0][0], cells->g[0][1], cells->g[0][2]};

  for (PetscInt c = 0; c < cells->n; c++) {
    const PetscInt n = cells->first[0][c + 1], *j = cells->j[0];
    PetscReal      flux[ISPH_MAX_DIM] = {0.0}, past[ISPH_MAX_DIM] = {0.0}, value = 0.0;

    for (PetscInt e = cells->first[0][c]; e < n; e++)
      for (PetscInt b = 0; b < d; b++) flux[b] += g[b][e] * all[j[e]];
    for (PetscInt e = cells->first[0][c]; w && e < n; e++) {
      value += cells->mean[e] * all[j[e]];
      for (PetscInt b = 0; b < d; b++) past[b] += cells->mean[e] * w[j[e] * d + b];
    }
    for (PetscInt b = 0; b < d; b++)
      flux[b] = cells->volume[c] * (past[b] * value - s->D[c] * flux[b]);
    for (PetscInt e = cells->first[0][c]; e < n; e++) {
      PetscReal sum = 0.0;

      for (PetscInt b = 0; b < d; b++) sum += g[b][e] * flux[b];
      to[j[e]] += sum;
    }
    for (PetscInt e = cells->first[0][c]; w && e < n; e++)
      for (PetscInt b = 0; b < d && !IsOpen(flow, j[e]); b++)
        to[j[e]] -= g[b][e] * cells->volume[c] * past[b] * mean;
  }
}

/* Returns the flow of the fluid out of part q of the border, past the particles [m^dim/s]. */
static PetscReal Leaving(const Flow *flow, const Scalar *s, PetscInt q)
{
  const StrainBorder *border = &s->cells->border;
  const PetscReal    *w      = flow->state->scalars->flow;
  const PetscInt      d = flow->scene->dim, row = border->row[q];
  PetscReal           sum = 0.0;

  if (!w || border->side[q] == SceneBoundaries(flow->scene) ||
      !BoundaryIs(flow->scene, border->side[q], BOUNDARY_INFLOW | BOUNDARY_OUTFLOW))
    return 0.0;
  for (PetscInt e = border->rows.start[row]; e < border->rows.start[row + 1]; e++)
    for (PetscInt b = 0; b < d; b++)
      sum += border->rows.w[e] * w[border->rows.j[e] * d + b] * border->normal[q * d + b];
  return sum;
}

/* Returns the law at part q of the border, at time t. */
static PartLaw LawAt(const Flow *flow, const Scalar *s, PetscReal t, PetscInt q)
{
  const StrainBorder   *border = &s->cells->border;
  const ScalarBoundary *law    = s->law[border->side[q]];
  const PetscInt        d      = flow->scene->dim;
  PartLaw               part   = {.leaving = Leaving(flow, s, q)};
  PetscReal             area   = 0.0;

  for (PetscInt a = 0; a < d; a++) area += PetscSqr(border->normal[q * d + a]);
  if (law) part.given = PetscSqrtReal(area) * ExpressionValue(&law->of, 0, t, &border->x[q * d]);
  if (law && law->law == SCALAR_EXCHANGE) {
    part.rate = part.given;
    part.given *= ExpressionValue(&law->of, 1, t, &border->x[q * d]);
  }
  part.rate += part.leaving;
  return part;
}

/* Returns the value at part q of the border, and the share of own fluid in it. */
static PetscReal ValueAt(const Particles *p, const Scalar *s, PetscInt q, PetscReal *own)
{
  const StrainRows *rows  = &s->cells->border.rows;
  const PetscInt    row   = s->cells->border.row[q];
  PetscReal         value = 0.0;

  *own = 0.0;
  for (PetscInt e = rows->start[row]; e < rows->start[row + 1]; e++) {
    value += rows->w[e] * s->all[rows->j[e]];
    if (rows->j[e] < p->n_fluid) *own += rows->w[e];
  }
  return value;
}

/* ScalarRates - Computes the rates of the cells and boundaries for values of own fluid: those of
   own fluid, and for own points of walls what they take from it. Collective. Input: share - 1, or
   0: of the rates that are linear in c only. Output: s->rate [m^dim/s times the unit of the
   scalar]. */
PetscErrorCode ScalarRates(const Flow *flow, const PetscReal c[], PetscReal share, Scalar *s)
{
  const Particles  *p    = flow->particles;
  const StrainRows *rows = &s->cells->border.rows;
  const PetscReal   mean = share * s->average;

  PetscFunctionBegin;
  PetscCall(ScalarValues(flow, c, share, s));
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(ParticlesAll(p) + 1), &s->rate));
  PetscCall(PetscArrayzero(s->rate, ParticlesAll(p)));
  if (p->dim == 2) AddCells(flow, 2, mean, s, s->rate);
  else AddCells(flow, 3, mean, s, s->rate);
  for (PetscInt q = 0; q < s->cells->border.n; q++) {
    const PartLaw  *law = &s->part[q];
    const PetscInt  row = s->cells->border.row[q];
    PetscReal       own;
    const PetscReal value  = ValueAt(p, s, q, &own);
    const PetscReal enters = share * law->given - law->rate * value + law->leaving * mean;

    for (PetscInt e = rows->start[row]; e < rows->start[row + 1]; e++)
      if (rows->j[e] < p->n_fluid) s->rate[rows->j[e]] += enters * rows->w[e];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarDiagonal - Adds the diagonal of the rates without convection */
void ScalarDiagonal(const Flow *flow, const Scalar *s, PetscReal to[])
{
  const PetscInt     n = flow->particles->n_fluid, d = flow->particles->dim;
  const StrainCells *cells = s->cells;
  const StrainRows  *rows  = &cells->border.rows;

  for (PetscInt c = 0; c < cells->n; c++)
    for (PetscInt e = cells->first[0][c]; e < cells->first[0][c + 1]; e++)
      for (PetscInt b = 0; b < d && cells->j[0][e] < n; b++)
        to[cells->j[0][e]] -= cells->volume[c] * s->D[c] * PetscSqr(cells->g[0][b][e]);
  for (PetscInt q = 0; q < cells->border.n; q++)
    for (PetscInt e = rows->start[cells->border.row[q]]; e < rows->start[cells->border.row[q] + 1];
         e++)
      if (rows->j[e] < n) to[rows->j[e]] -= s->part[q].rate * PetscSqr(rows->w[e]);
}

/* Adds a value to the entry of own particle i and particle j, if it is fluid. */
static void AddEntry(const Particles *p, PetscInt i, PetscInt j, PetscReal value, Scalar *s)
{
  const Pattern *col = &s->columns[0];
  PetscInt       k;

  if (ParticlesIsWall(p, j) || value == 0.0) return;
  (void)PetscFindInt(p->row[j], col->row[i + 1] - col->row[i], col->col + col->row[i], &k);
  s->entry[col->row[i] + k] += value;
}

/* Adds the entries of the cells of own particle i. Input: slot - by local index. */
static void AddRow(const Flow *flow, PetscInt i, const PetscInt slot[], Scalar *s)
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = s->cells;
  const PetscReal   *w     = flow->state->scalars->flow;
  const PetscInt     d     = p->dim;
  PetscReal         *to    = s->entry + s->columns[0].row[i];

  for (PetscInt k = cells->of[0][i]; k < cells->of[0][i + 1]; k++) {
    const PetscInt c = cells->cell[0][k], own = cells->at[0][k];
    PetscReal      g[ISPH_MAX_DIM], past      = 0.0;

    for (PetscInt b = 0; b < d; b++) g[b] = cells->volume[c] * cells->g[0][b][own];
    for (PetscInt e = cells->first[0][c]; w && e < cells->first[0][c + 1]; e++)
      for (PetscInt b = 0; b < d; b++) past += cells->mean[e] * g[b] * w[cells->j[0][e] * d + b];
    for (PetscInt e = cells->first[0][c]; e < cells->first[0][c + 1]; e++) {
      const PetscInt j   = cells->j[0][e];
      PetscReal      sum = past * cells->mean[e];

      if (ParticlesIsWall(p, j)) continue;
      for (PetscInt b = 0; b < d; b++) sum -= s->D[c] * g[b] * cells->g[0][b][e];
      to[slot[j]] += sum;
    }
  }
}

/* ScalarMatrix - Computes the matrix of the rates that are linear in c; collective */
PetscErrorCode ScalarMatrix(const Flow *flow, Scalar *s)
{
  const Particles    *p      = flow->particles;
  const StrainBorder *border = &s->cells->border;
  const StrainRows   *r      = &border->rows;
  const StrainList   *list   = &s->cells->list[0];
  PetscInt           *slot;
  SparseRows          rows;

  PetscFunctionBegin;
  if (!s->A) {
    for (PetscInt w = 0; w < 2; w++) PetscCall(PatternFree(&s->columns[w]));
    PetscCall(StrainPatterns(p, s->cells, s->columns));
    PetscCall(
        PetscRealloc(sizeof(PetscReal) * (size_t)(s->columns[0].row[p->n_fluid] + 1), &s->entry));
    PetscCall(PatternMat(p->comm, &s->columns[0], p->n_fluid, p->n_fluid, s->entry, NULL, &s->A));
  }
  PetscCall(PetscArrayzero(s->entry, s->columns[0].row[p->n_fluid]));
  PetscCall(PetscMalloc1(ParticlesAll(p), &slot));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt k = list->start[i]; k < list->start[i + 1]; k++)
      slot[list->local[k]] = list->slot[k];
    AddRow(flow, i, slot, s);
  }
  PetscCall(PetscFree(slot));
  for (PetscInt q = 0; q < border->n; q++)
    for (PetscInt e = r->start[border->row[q]]; e < r->start[border->row[q] + 1]; e++)
      for (PetscInt f = r->start[border->row[q]];
           r->j[e] < p->n_fluid && f < r->start[border->row[q] + 1]; f++)
        AddEntry(p, r->j[e], r->j[f], -s->part[q].rate * r->w[e] * r->w[f], s);
  rows = (SparseRows){
      .n = p->n_fluid, .row = s->columns[0].row, .col = s->columns[0].col, .value = s->entry};
  PetscCall(PatternMatSet(&rows, s->A));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarAssemble - Computes what the rates of a scalar at the end of the step need; collective */
PetscErrorCode ScalarAssemble(Flow *flow, Scalar *s)
{
  const PetscReal t = flow->clock->t + flow->clock->dt;

  PetscFunctionBegin;
  if (s->epoch != flow->particles->epoch || s->moved != flow->particles->moved)
    PetscCall(FindCells(flow, s));
  PetscCall(SetDiffusivities(flow, t, s));
  for (PetscInt q = 0; q < s->cells->border.n; q++) s->part[q] = LawAt(flow, s, t, q);
  s->average = 0.0;
  if (flow->state->scalars->flow) {
    PetscReal amount[2];

    PetscCall(ScalarAmount(flow, s->c, amount));
    s->average = amount[0] / amount[1];
  }
  if (!s->shell) PetscCall(ScalarMatrix(flow, s));
  s->shift = NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarEntering - Computes what enters through each boundary per time, for the values of the end
   of the step: entering [m^dim/s times the unit of the scalar]. Collective. From boundaries that
   give the value it is the reaction: minus the rate of their points. It is consistent: the sum over
   boundaries and sources is the gain of the fluid. */
PetscErrorCode ScalarEntering(const Flow *flow, Scalar *s)
{
  const Particles *p = flow->particles;
  const PetscInt   n = SceneBoundaries(flow->scene) + 1;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(s->entering, n));
  PetscCall(ScalarRates(flow, s->c, 1.0, s));
  for (PetscInt k = p->n_fluid; k < ParticlesOwn(p); k++)
    s->entering[(PetscInt)p->side[k]] -= s->rate[k];
  for (PetscInt q = 0; q < s->cells->border.n; q++) {
    PetscReal       own;
    const PetscReal value = ValueAt(p, s, q, &own);

    s->entering[s->cells->border.side[q]] += own * (s->part[q].given - s->part[q].rate * value);
  }
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, s->entering, (PetscMPIInt)n, MPIU_REAL, MPI_SUM, p->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarFree - Frees all that an assembly computes; collective */
PetscErrorCode ScalarFree(Scalar *s)
{
  PetscFunctionBegin;
  PetscCall(MatDestroy(&s->A));
  PetscCall(StrainDestroy(&s->cells));
  for (PetscInt w = 0; w < 2; w++) PetscCall(PatternFree(&s->columns[w]));
  PetscCall(FreeAll(&s->entry, &s->part, &s->rate, &s->D, &s->wall, &s->all));
  PetscFunctionReturn(PETSC_SUCCESS);
}
