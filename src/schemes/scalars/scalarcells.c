/* The rates of a scalar, from the gradients of cells and from the boundaries between them. */
#include "scalars.h"

/* Of a cell of particles that move [dx]: such cells are made in each step. With cells of a whole
   spacing values of neighbours part. */
#define EDGE (2.0 / 3.0)

/* Computes the values by local index: of own fluid from c, at own walls those that are given. */
PetscErrorCode ScalarValues(const Flow *flow, const PetscReal c[], Scalar *s)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(ParticlesAll(p) + 1), &s->all));
  PetscCall(PetscArraycpy(s->all, c, p->n_fluid));
  if (p->n_wall) PetscCall(PetscArraycpy(s->all + p->n_fluid, s->wall, p->n_wall));
  PetscCall(ParticlesHaloField(p, s->all));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarSetWalls - Sets the values of own points of walls at time t; zero where the boundary gives
   none; not collective */
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

/* Computes the cells and the pattern of the rates. */
static PetscErrorCode FindCells(Flow *flow, Scalar *s)
{
  const Particles     *p        = flow->particles;
  const StrainQuantity quantity = {.sets = 1, .gives = s->gives, .free = flow->ops->free};

  PetscFunctionBegin;
  PetscCall(NeighborsSearch(p, flow->neighbors)); /* fixed particles keep no lists of neighbours */
  PetscCall(StrainAssemble(flow->scene, p, flow->neighbors,
                           SceneMoves(flow->scene) ? EDGE : CELL_EDGE, flow->ops->forms.degree,
                           &quantity, &s->cells));
  if (!SceneMoves(flow->scene) && !flow->ops->free)
    PetscCall(NeighborsRelease(flow->neighbors)); /* as FlowAssemble() */
  PetscCall(MatDestroy(&s->A));
  PetscCall(MatDestroy(&s->J));
  for (PetscInt w = 0; w < 2; w++) PetscCall(PatternFree(&s->columns[w]));
  PetscCall(StrainPatterns(p, s->cells, s->columns));
  for (PetscInt w = 0; w < 2; w++)
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(s->columns[w].row[p->n_fluid] + 1),
                           &s->entry[w]));
  PetscCall(PatternMat(p->comm, &s->columns[0], p->n_fluid, p->n_fluid, s->entry[0], NULL, &s->A));
  PetscCall(MatDuplicate(s->A, MAT_DO_NOT_COPY_VALUES, &s->J));
  s->epoch = p->epoch;
  s->moved = p->moved;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ScalarFindVolumes - Sets the volumes of particles below a free surface to those of their weights
   in the cells at the start, and the amounts; collective */
PetscErrorCode ScalarFindVolumes(Flow *flow)
{
  Scalars *all = flow->state->scalars;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < all->n; k++) {
    Scalar   *s = &all->scalar[k];
    PetscReal amount[2];

    if (k == 0) PetscCall(FindCells(flow, s));
    if (k == 0) PetscCall(PetscArraycpy(all->volume, s->cells->mass, flow->particles->n_fluid));
    PetscCall(ScalarAmount(flow, s->c, amount));
    s->kept[KEPT_AMOUNT] = s->kept[KEPT_BEFORE] = amount[0];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the terms of the cells of own particle i. Input: slot - by local index. */
static void AddCells(const Flow *flow, PetscInt i, const PetscInt slot[], Scalar *s)
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = s->cells;
  const PetscReal   *w     = flow->state->scalars->flow;
  const PetscInt     d     = p->dim;
  PetscReal *const to[] = {s->entry[0] + s->columns[0].row[i], s->entry[1] + s->columns[1].row[i]};

  for (PetscInt k = cells->of[0][i]; k < cells->of[0][i + 1]; k++) {
    const PetscInt c = cells->cell[0][k], own = cells->at[0][k];
    PetscReal      g[ISPH_MAX_DIM], past      = 0.0;

    for (PetscInt b = 0; b < d; b++) g[b] = cells->volume[c] * cells->g[0][b][own];
    for (PetscInt e = cells->first[0][c]; w && e < cells->first[0][c + 1]; e++)
      for (PetscInt b = 0; b < d; b++) past += cells->mean[e] * g[b] * w[cells->j[0][e] * d + b];
    for (PetscInt e = cells->first[0][c]; e < cells->first[0][c + 1]; e++) {
      const PetscInt j   = cells->j[0][e];
      PetscReal      sum = 0.0;

      for (PetscInt b = 0; b < d; b++) sum -= s->D[c] * g[b] * cells->g[0][b][e];
      sum += past * cells->mean[e];
      to[ParticlesIsWall(p, j) ? 1 : 0][slot[j]] += sum;
    }
    s->one[i] += past; /* the means of 1 are 1, its gradients 0 */
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

/* The law of a part of the border: given - rate c enters, with the value c there [m^dim/s]. */
typedef struct {
  PetscReal given, rate, leaving; /* leaving: part of the rate that fluid carries out */
} PartLaw;

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

/* Adds the terms of the boundaries that do not give the value, at time t. */
static void AddBorder(const Flow *flow, PetscReal t, Scalar *s)
{
  const Particles    *p      = flow->particles;
  const StrainBorder *border = &s->cells->border;

  for (PetscInt q = 0; q < border->n; q++) {
    const PartLaw  law = LawAt(flow, s, t, q);
    const PetscInt row = border->row[q];

    for (PetscInt e = border->rows.start[row]; e < border->rows.start[row + 1]; e++) {
      const PetscInt i = border->rows.j[e];

      if (i >= p->n_fluid) continue;
      s->given_rate[i] += law.given * border->rows.w[e];
      s->one[i] -= law.leaving * border->rows.w[e];
      for (PetscInt f = border->rows.start[row]; f < border->rows.start[row + 1]; f++) {
        const PetscInt  j = border->rows.j[f], wall = ParticlesIsWall(p, j) ? 1 : 0;
        const PetscReal sum = -law.rate * border->rows.w[e] * border->rows.w[f];
        const Pattern  *col = &s->columns[wall];
        PetscInt        k;

        if (sum == 0.0) continue;
        (void)PetscFindInt(p->row[j], col->row[i + 1] - col->row[i], col->col + col->row[i], &k);
        s->entry[wall][col->row[i] + k] += sum;
      }
    }
  }
}

/*
  ScalarAssemble - Computes the rates A c + B c_w + given_rate of a scalar at the end of the step

  Collective.
*/
PetscErrorCode ScalarAssemble(Flow *flow, Scalar *s)
{
  const Particles *p = flow->particles;
  const PetscReal  t = flow->clock->t + flow->clock->dt;
  PetscInt        *slot;
  SparseRows       rows;

  PetscFunctionBegin;
  if (s->epoch != p->epoch || s->moved != p->moved) PetscCall(FindCells(flow, s));
  PetscCall(SetDiffusivities(flow, t, s));
  for (PetscInt w = 0; w < 2; w++)
    PetscCall(PetscArrayzero(s->entry[w], s->columns[w].row[p->n_fluid]));
  PetscCall(PetscFree2(s->given_rate, s->one));
  PetscCall(PetscCalloc2(p->n_fluid, &s->given_rate, p->n_fluid, &s->one));
  PetscCall(PetscMalloc1(ParticlesAll(p), &slot));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt w = 0; w < 2; w++)
      for (PetscInt k = s->cells->list[w].start[i]; k < s->cells->list[w].start[i + 1]; k++)
        slot[s->cells->list[w].local[k]] = s->cells->list[w].slot[k];
    AddCells(flow, i, slot, s);
  }
  AddBorder(flow, t, s);
  PetscCall(PetscFree(slot));
  rows = (SparseRows){
      .n = p->n_fluid, .row = s->columns[0].row, .col = s->columns[0].col, .value = s->entry[0]};
  PetscCall(PatternMatSet(&rows, s->A));
  s->shift = NAN;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds what enters through points of walls that give the value: the reactions of the cells. */
static void AddReactions(const Flow *flow, Scalar *s)
{
  const Particles   *p     = flow->particles;
  const StrainCells *cells = s->cells;
  const PetscReal   *w     = flow->state->scalars->flow;
  const PetscInt     d     = p->dim;

  for (PetscInt c = 0; c < cells->n; c++) {
    PetscReal flux[ISPH_MAX_DIM] = {0.0}, past[ISPH_MAX_DIM] = {0.0}, mean = 0.0;

    for (PetscInt e = cells->first[0][c]; e < cells->first[0][c + 1]; e++) {
      const PetscInt j = cells->j[0][e];

      mean += cells->mean[e] * s->all[j];
      for (PetscInt b = 0; b < d; b++) {
        flux[b] -= s->D[c] * cells->g[0][b][e] * s->all[j];
        if (w) past[b] += cells->mean[e] * w[j * d + b];
      }
    }
    for (PetscInt e = cells->first[0][c]; e < cells->first[0][c + 1]; e++) {
      const PetscInt j = cells->j[0][e];

      if (j < p->n_fluid || j >= ParticlesOwn(p)) continue;
      for (PetscInt b = 0; b < d; b++) /* the rate of the point is what it takes from the fluid */
        s->entering[(PetscInt)p->side[j]] -=
            cells->volume[c] * cells->g[0][b][e] * (flux[b] + past[b] * mean);
    }
  }
}

/*
  ScalarEntering - Computes what enters through each boundary per time, for the values of the end of
  the step: entering [m^dim/s times the unit of the scalar]

  Collective. From boundaries that give the value it is the reaction: minus the rate that the terms
  of the cells would give to points of the wall. It is consistent: the sum over boundaries and
  sources is the gain of the fluid.
*/
PetscErrorCode ScalarEntering(const Flow *flow, Scalar *s)
{
  const Particles    *p      = flow->particles;
  const StrainBorder *border = &s->cells->border;
  const PetscInt      n      = SceneBoundaries(flow->scene) + 1;
  const PetscReal     t      = flow->clock->t + flow->clock->dt;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(s->entering, n));
  AddReactions(flow, s);
  for (PetscInt q = 0; q < border->n; q++) {
    const PartLaw  law = LawAt(flow, s, t, q);
    const PetscInt row = border->row[q];
    PetscReal      own = 0.0, value = 0.0;

    for (PetscInt e = border->rows.start[row]; e < border->rows.start[row + 1]; e++) {
      value += border->rows.w[e] * s->all[border->rows.j[e]];
      if (border->rows.j[e] < p->n_fluid) own += border->rows.w[e];
    }
    s->entering[border->side[q]] += own * (law.given - law.rate * value);
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
  PetscCall(MatDestroy(&s->J));
  PetscCall(StrainDestroy(&s->cells));
  for (PetscInt w = 0; w < 2; w++) {
    PetscCall(PatternFree(&s->columns[w]));
    PetscCall(PetscFree(s->entry[w]));
  }
  PetscCall(PetscFree2(s->given_rate, s->one));
  PetscCall(PetscFree(s->D));
  PetscCall(PetscFree(s->wall));
  PetscCall(PetscFree(s->all));
  PetscFunctionReturn(PETSC_SUCCESS);
}
