/*
  The viscous matrix of strain cells. With the weights g of the velocity gradient in a cell, and the
  mass M_i of particle i, the derivative of the dissipation is

    (L u)_ia = -1/(nu_0 M_i) sum_c V_c nu_c sum_j (d_ab g_i.g_j + g_ib g_ja) u_jb

  with nu_0 of the scene. Times the masses it is symmetric and not positive: no velocity gains
  energy.
*/
#include "isph/operators.h"
#include "isph/strain.h"

/* Lists the places of own fluid in the cells, for each set of components. */
static PetscErrorCode ListCells(const Particles *p, StrainCells *s)
{
  PetscFunctionBegin;
  for (PetscInt q = 0; q < s->sets; q++) {
    const PetscInt n = s->n_entries[q];
    PetscInt      *of;

    PetscCall(PetscFree(s->of[q]));
    PetscCall(PetscFree2(s->at[q], s->cell[q]));
    PetscCall(PetscCalloc1(p->n_fluid + 2, &of));
    for (PetscInt e = 0; e < n; e++) of[PetscMin(s->j[q][e], p->n_fluid) + 1] += 1;
    for (PetscInt i = 0; i <= p->n_fluid; i++) of[i + 1] += of[i];
    PetscCall(PetscMalloc2(n, &s->at[q], n, &s->cell[q]));
    for (PetscInt c = 0; c < s->n; c++) {
      for (PetscInt e = s->first[q][c]; e < s->first[q][c + 1]; e++) {
        const PetscInt i = PetscMin(s->j[q][e], p->n_fluid);

        s->at[q][of[i]]     = e;
        s->cell[q][of[i]++] = c;
      }
    }
    for (PetscInt i = p->n_fluid; i >= 0; i--) of[i + 1] = of[i];
    of[0]    = 0;
    s->of[q] = of;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The neighbours of a row, fluid and walls apart. */
typedef struct {
  PetscInt *place; /* by local index: -1, or its place in the list */
  PetscInt  n[2], *local[2], *col[2], *slot[2];
} RowColumns;

/* Lists all particles that share a cell with own fluid particle i. */
static void FindColumns(const Particles *p, const StrainCells *s, PetscInt i, RowColumns *to)
{
  to->n[0] = to->n[1] = 0;
  for (PetscInt q = 0; q < s->sets; q++) {
    for (PetscInt k = s->of[q][i]; k < s->of[q][i + 1]; k++) {
      const PetscInt c = s->cell[q][k];

      for (PetscInt r = 0; r < s->sets; r++) {
        for (PetscInt e = s->first[r][c]; e < s->first[r][c + 1]; e++) {
          const PetscInt j = s->j[r][e], w = ParticlesIsWall(p, j) ? 1 : 0;

          if (to->place[j] >= 0) continue;
          to->place[j]             = to->n[w];
          to->col[w][to->n[w]]     = p->row[j];
          to->local[w][to->n[w]++] = j;
        }
      }
    }
  }
}

static void ForgetColumns(RowColumns *to)
{
  for (PetscInt w = 0; w < 2; w++)
    for (PetscInt k = 0; k < to->n[w]; k++) to->place[to->local[w][k]] = -1;
}

static PetscErrorCode ColumnsCreate(const Particles *p, RowColumns *to)
{
  const PetscInt all = ParticlesAll(p);

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(all, &to->place));
  for (PetscInt j = 0; j < all; j++) to->place[j] = -1;
  for (PetscInt w = 0; w < 2; w++)
    PetscCall(PetscMalloc3(all, &to->local[w], all, &to->col[w], all, &to->slot[w]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ColumnsDestroy(RowColumns *to)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(to->place));
  for (PetscInt w = 0; w < 2; w++) PetscCall(PetscFree3(to->local[w], to->col[w], to->slot[w]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for n further entries of a pattern. */
static PetscErrorCode PatternGrow(PetscInt n, PetscInt used, Pattern *pattern)
{
  PetscFunctionBegin;
  if (used + n <= pattern->capacity) PetscFunctionReturn(PETSC_SUCCESS);
  pattern->capacity = used + n + used / 2 + 1024;
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)pattern->capacity, &pattern->local));
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)pattern->capacity, &pattern->col));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes a pattern of blocks from one of particles: dim rows of dim columns in each. */
static PetscErrorCode BlockPattern(PetscInt d, const Pattern *from, Pattern *to)
{
  PetscInt q = 0;

  PetscFunctionBegin;
  PetscCall(PatternFree(to));
  to->n = d * from->n;
  PetscCall(PetscMalloc1(to->n + 1, &to->row));
  PetscCall(PetscMalloc1(d * d * from->row[from->n] + 1, &to->col));
  to->row[0] = 0;
  for (PetscInt r = 0; r < to->n; r++) {
    for (PetscInt k = from->row[r / d]; k < from->row[r / d + 1]; k++)
      for (PetscInt b = 0; b < d; b++) to->col[q++] = d * from->col[k] + b;
    to->row[r + 1] = q;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the columns of all rows. */
static PetscErrorCode SetPatterns(const Particles *p, StrainCells *s)
{
  Pattern    particles[2] = {{NULL}}, *blocks[2] = {&s->fluid_rows, &s->wall_rows};
  RowColumns columns;

  PetscFunctionBegin;
  PetscCall(ColumnsCreate(p, &columns));
  for (PetscInt w = 0; w < 2; w++) {
    particles[w].n = p->n_fluid;
    PetscCall(PetscCalloc1(p->n_fluid + 1, &particles[w].row));
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    FindColumns(p, s, i, &columns);
    for (PetscInt w = 0; w < 2; w++) {
      PetscCall(PatternGrow(columns.n[w], particles[w].row[i], &particles[w]));
      (void)PatternRow(&particles[w], i, columns.col[w], columns.local[w], columns.n[w],
                       columns.slot[w]);
    }
    ForgetColumns(&columns);
  }
  for (PetscInt w = 0; w < 2; w++) {
    PetscCall(BlockPattern(p->dim, &particles[w], blocks[w]));
    PetscCall(PetscFree(s->value[w]));
    PetscCall(PetscCalloc1(blocks[w]->row[blocks[w]->n] + 1, &s->value[w]));
    PetscCall(PatternFree(&particles[w]));
  }
  PetscCall(ColumnsDestroy(&columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets the place of each neighbour of particle i to its slot among the columns of a row. */
static PetscErrorCode PlaceSlots(const Particles *p, const Pattern *const blocks[], PetscInt i,
                                 RowColumns *to)
{
  PetscFunctionBegin;
  for (PetscInt w = 0; w < 2; w++) {
    const PetscInt *col = &blocks[w]->col[blocks[w]->row[p->dim * i]];
    const PetscInt  n   = (blocks[w]->row[p->dim * i + 1] - blocks[w]->row[p->dim * i]) / p->dim;

    for (PetscInt k = 0; k < to->n[w]; k++) {
      PetscInt low = 0, high = n - 1;

      while (low < high) {
        const PetscInt middle = (low + high) / 2;

        if (col[p->dim * middle] < p->dim * to->col[w][k]) low = middle + 1;
        else high = middle;
      }
      to->place[to->local[w][k]] = low;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The weight of a cell in the rows of a particle. */
typedef struct {
  PetscInt  c;
  PetscReal factor; /* -V nu/(nu_0 M) */
} CellWeight;

/* Adds a cell to the rows of a component of particle i. Input: q, e - its set and place; to -
   entries of the row of component a over fluid and walls; place - slots. */
static void AddCell(const Particles *p, const StrainCells *s, const CellWeight *by, PetscInt a,
                    PetscInt q, PetscInt e, const PetscInt place[], PetscReal *const to[])
{
  const PetscInt d = p->dim, c = by->c;
  PetscReal      own[ISPH_MAX_DIM] = {0.0};

  for (PetscInt b = 0; b < d; b++) own[b] = s->g[q][b][e];
  for (PetscInt b = 0; b < d; b++) {
    const PetscInt r = s->sets == 1 ? 0 : b;

    for (PetscInt k = s->first[r][c]; k < s->first[r][c + 1]; k++) {
      const PetscInt j   = s->j[r][k];
      PetscReal      sum = by->factor * own[b] * s->g[r][a][k];

      if (a == b)
        for (PetscInt x = 0; x < d; x++) sum += by->factor * own[x] * s->g[r][x][k];
      to[ParticlesIsWall(p, j) ? 1 : 0][d * place[j] + b] += sum;
    }
  }
}

/*
  StrainScale - Computes the entries of the viscous matrices for the present viscosities of cells

  Collective.
*/
PetscErrorCode StrainScale(const Scene *scene, const Particles *p, StrainCells *s, Mat A, Mat B)
{
  const Pattern *const blocks[2] = {&s->fluid_rows, &s->wall_rows};
  RowColumns           columns;

  PetscFunctionBegin;
  PetscCall(ColumnsCreate(p, &columns));
  for (PetscInt w = 0; w < 2; w++)
    PetscCall(PetscArrayzero(s->value[w], blocks[w]->row[blocks[w]->n]));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscReal mass = s->mass[i];

    FindColumns(p, s, i, &columns);
    PetscCall(PlaceSlots(p, blocks, i, &columns));
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscInt   q = s->sets == 1 ? 0 : a, row = p->dim * i + a;
      PetscReal *const to[] = {s->value[0] + blocks[0]->row[row],
                               s->value[1] + blocks[1]->row[row]};

      for (PetscInt k = s->of[q][i]; k < s->of[q][i + 1]; k++) {
        const PetscInt  c     = s->cell[q][k];
        const PetscReal ratio = scene->nu > 0.0 ? s->nu[c] / scene->nu : 1.0;
        CellWeight      by    = {.c = c, .factor = -s->volume[c] * ratio / mass};

        AddCell(p, s, &by, a, q, s->at[q][k], columns.place, to);
      }
    }
    ForgetColumns(&columns);
  }
  PetscCall(ColumnsDestroy(&columns));
  PetscCall(PatternMatSet(blocks[0], s->value[0], A));
  if (B) PetscCall(PatternMatSet(blocks[1], s->value[1], B));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainMatrices - Creates the viscous matrices over interlaced components of fluid and of walls
   (NULL: none) for the present cells and viscosities; collective */
PetscErrorCode StrainMatrices(const Scene *scene, const Particles *p, PetscBool walls,
                              StrainCells *s, Mat *A, Mat *B)
{
  const PetscInt d = p->dim;

  PetscFunctionBegin;
  PetscCall(ListCells(p, s));
  PetscCall(SetPatterns(p, s));
  PetscCall(
      PatternMat(p->comm, &s->fluid_rows, d * p->n_fluid, d * p->n_fluid, s->value[0], NULL, A));
  PetscCall(MatSetBlockSizes(*A, d, d));
  if (walls)
    PetscCall(
        PatternMat(p->comm, &s->wall_rows, d * p->n_fluid, d * p->n_wall, s->value[1], NULL, B));
  PetscCall(StrainScale(scene, p, s, *A, walls ? *B : NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
