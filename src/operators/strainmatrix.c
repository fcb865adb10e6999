/*
  The viscous matrix of strain cells. With the weights g of the velocity gradient in a cell, and the
  mass M_i of particle i, the derivative of the dissipation is

    (L u)_ia = -1/(nu_0 M_i) sum_c V_c nu_c sum_j (d_ab g_i.g_j + g_ib g_ja) u_jb

  with nu_0 of the scene. Times the masses it is symmetric and not positive: no velocity gains
  energy.
*/
#include "isph/operators.h"
#include "isph/strain.h"

/* StrainPlaces - Lists the places of own fluid in the cells, for each set of components */
PetscErrorCode StrainPlaces(const Particles *p, StrainCells *s)
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
    for (PetscInt c = 0; c < s->all; c++) {
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

/* Adds a particle to a list. */
static PetscErrorCode ListAdd(PetscInt j, StrainList *l)
{
  PetscFunctionBegin;
  if (l->n == l->room) {
    l->room = 2 * l->room + 1024;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)l->room, &l->local));
  }
  l->local[l->n++] = j;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds own fluid particle i and all that share a cell with it to its lists. Input: last - by local
   index, the last particle with it in its list. */
static PetscErrorCode AddNeighbors(const Particles *p, PetscInt i, PetscInt last[], StrainCells *s)
{
  PetscFunctionBegin;
  PetscCall(ListAdd(i, &s->list[0]));
  last[i] = i;
  for (PetscInt q = 0; q < s->sets; q++) {
    for (PetscInt k = s->of[q][i]; k < s->of[q][i + 1]; k++) {
      const PetscInt c = s->cell[q][k];

      for (PetscInt r = 0; r < s->sets; r++) {
        for (PetscInt e = s->first[r][c]; e < s->first[r][c + 1]; e++) {
          const PetscInt j = s->j[r][e];

          if (last[j] == i) continue;
          last[j] = i;
          PetscCall(ListAdd(j, &s->list[ParticlesIsWall(p, j) ? 1 : 0]));
        }
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Computes the columns of the particles of a list, and their slots. */
static PetscErrorCode SetSlots(const Particles *p, StrainList *l, Pattern *columns)
{
  PetscInt *col;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)(l->n + 1), &l->slot));
  PetscCall(PetscMalloc1(l->n, &col));
  for (PetscInt k = 0; k < l->n; k++) col[k] = p->row[l->local[k]];
  PetscCall(PatternBegin(columns, PETSC_TRUE, p->n_fluid, l->n));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscInt first = l->start[i], n = l->start[i + 1] - first;

    (void)PatternRow(columns, i, col + first, l->local + first, n, l->slot + first);
    for (PetscInt k = first; k < l->start[i + 1]; k++) l->slot[k] -= columns->row[i];
  }
  PetscCall(PetscFree(col));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the neighbours of own fluid, and their columns over fluid and over walls. */
static PetscErrorCode SetLists(const Particles *p, StrainCells *s, Pattern columns[2])
{
  PetscInt *last;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(ParticlesAll(p), &last));
  for (PetscInt j = 0; j < ParticlesAll(p); j++) last[j] = -1;
  for (PetscInt w = 0; w < 2; w++) {
    s->list[w].n = 0;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)(p->n_fluid + 1), &s->list[w].start));
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt w = 0; w < 2; w++) s->list[w].start[i] = s->list[w].n;
    PetscCall(AddNeighbors(p, i, last, s));
  }
  for (PetscInt w = 0; w < 2; w++) {
    s->list[w].start[p->n_fluid] = s->list[w].n;
    PetscCall(SetSlots(p, &s->list[w], &columns[w]));
  }
  PetscCall(PetscFree(last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainPatterns - Lists the places of own fluid in the cells, and its columns over fluid and over
   walls; not collective */
PetscErrorCode StrainPatterns(const Particles *p, StrainCells *s, Pattern columns[2])
{
  PetscFunctionBegin;
  PetscCall(StrainPlaces(p, s));
  PetscCall(SetLists(p, s, columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds cell c to the rows of component a of a particle. Input: own - weights of the particle in the
   gradient, times -V nu/(nu_0 M); slot - by local index; to - entries of the row over fluid and
   walls. */
static void AddCell(const Particles *p, const StrainCells *s, PetscInt c, PetscInt a,
                    const PetscReal own[], const PetscInt slot[], PetscReal *const to[])
{
  const PetscInt d = p->dim;

  for (PetscInt b = 0; b < d; b++) {
    const PetscInt r = s->sets == 1 ? 0 : b;

    for (PetscInt k = s->first[r][c]; k < s->first[r][c + 1]; k++) {
      const PetscInt j   = s->j[r][k];
      PetscReal      sum = own[b] * s->g[r][a][k];

      if (a == b)
        for (PetscInt x = 0; x < d; x++) sum += own[x] * s->g[r][x][k];
      to[ParticlesIsWall(p, j) ? 1 : 0][d * slot[j] + b] += sum;
    }
  }
}

/* StrainScale - Computes the entries of the viscous matrices for the present viscosities of cells.
   Collective. */
PetscErrorCode StrainScale(const Scene *scene, const Particles *p, const StrainCells *s, Mat A,
                           Mat B)
{
  const Mat   of[] = {A, B};
  SparseRows *rows[2];
  PetscInt   *slot;

  PetscFunctionBegin;
  for (PetscInt w = 0; w < (B ? 2 : 1); w++) {
    PetscCall(SparseRowsGet(of[w], MAT_VALUES, &rows[w]));
    PetscCall(PetscArrayzero(rows[w]->value, rows[w]->row[rows[w]->n]));
  }
  PetscCall(PetscMalloc1(ParticlesAll(p), &slot));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt w = 0; w < 2; w++)
      for (PetscInt k = s->list[w].start[i]; k < s->list[w].start[i + 1]; k++)
        slot[s->list[w].local[k]] = s->list[w].slot[k];
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscInt   q = s->sets == 1 ? 0 : a, row = p->dim * i + a;
      PetscReal *const to[] = {rows[0]->value + rows[0]->row[row],
                               B ? rows[1]->value + rows[1]->row[row] : NULL};

      for (PetscInt k = s->of[q][i]; k < s->of[q][i + 1]; k++) {
        const PetscInt  c      = s->cell[q][k];
        const PetscReal ratio  = scene->nu > 0.0 ? s->nu[c] / scene->nu : 1.0;
        const PetscReal factor = -s->volume[c] * ratio / s->mass[q][i];
        PetscReal       own[ISPH_MAX_DIM];

        for (PetscInt b = 0; b < p->dim; b++) own[b] = factor * s->g[q][b][s->at[q][k]];
        AddCell(p, s, c, a, own, slot, to);
      }
    }
  }
  PetscCall(PetscFree(slot));
  for (PetscInt w = 0; w < (B ? 2 : 1); w++) PetscCall(PatternMatSet(rows[w], of[w]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* StrainMatrices - Creates the viscous matrices over interlaced components of fluid and of walls
   (NULL: none) for the present cells and viscosities; collective */
PetscErrorCode StrainMatrices(const Scene *scene, const Particles *p, PetscBool walls,
                              StrainCells *s, Mat *A, Mat *B)
{
  Pattern columns[2] = {{NULL}};

  PetscFunctionBegin;
  PetscCall(StrainPatterns(p, s, columns));
  PetscCall(PatternBlocks(p, p->dim, &columns[0], p->n_fluid, A));
  if (walls) PetscCall(PatternBlocks(p, p->dim, &columns[1], p->n_wall, B));
  for (PetscInt w = 0; w < 2; w++) PetscCall(PatternFree(&columns[w]));
  PetscCall(StrainScale(scene, p, s, *A, walls ? *B : NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
