/* A uniform grid of cells over local particles, built by counting sort. Positions are copied in the
   order of the cells, so that a search reads contiguous memory. */
#include "impl.h"

/* Returns the index along axis a of the cell at coordinate x, or of the nearest cell if x is
   outside the grid. */
static inline PetscInt CellAlong(const Cells *cells, PetscInt a, PetscReal x)
{
  const PetscReal s = (x - cells->origin[a]) / cells->size;

  if (!(s >= 0.0)) return 0;
  return s < cells->count[a] ? (PetscInt)s : cells->count[a] - 1;
}

/* Sets up the grid around all local particles. Cells are enlarged if their number would far exceed
   the number of particles, for example because of a stray particle. */
static PetscErrorCode LayGrid(const Particles *p, PetscReal size, Cells *cells)
{
  PetscReal high[ISPH_MAX_DIM] = {0}, number;

  PetscFunctionBegin;
  cells->dim  = p->dim;
  cells->size = size;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    cells->origin[a] = 0.0;
    cells->count[a]  = 1;
    if (a >= p->dim || ParticlesAll(p) == 0) continue;
    cells->origin[a] = high[a] = p->x[a][0];
    for (PetscInt i = 1; i < ParticlesAll(p); i++) {
      cells->origin[a] = PetscMin(cells->origin[a], p->x[a][i]);
      high[a]          = PetscMax(high[a], p->x[a][i]);
    }
    PetscCheck(!PetscIsInfOrNanReal(high[a] - cells->origin[a]), PETSC_COMM_SELF, PETSC_ERR_FP,
               "The flow diverged: the position of a particle is not a finite number");
  }
  while (PETSC_TRUE) {
    number = 1.0;
    for (PetscInt a = 0; a < p->dim; a++) {
      number *= 1.0 + PetscFloorReal((high[a] - cells->origin[a]) / cells->size);
    }
    if (number <= 4.0 * ParticlesAll(p) + 64.0) break;
    cells->size *= 2.0;
  }
  for (PetscInt a = 0; a < p->dim; a++) {
    cells->count[a] = 1 + (PetscInt)((high[a] - cells->origin[a]) / cells->size);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CellsReserve(Cells *cells, PetscInt n_cells)
{
  PetscFunctionBegin;
  if (n_cells + 1 > cells->cells_capacity) {
    cells->cells_capacity = n_cells + 1 + n_cells / 2;
    PetscCall(PetscFree(cells->start));
    PetscCall(PetscMalloc1(cells->cells_capacity, &cells->start));
  }
  if (cells->n > cells->capacity) {
    cells->capacity = cells->n + cells->n / 4;
    PetscCall(PetscFree(cells->list));
    PetscCall(PetscMalloc1(cells->capacity, &cells->list));
    for (PetscInt a = 0; a < cells->dim; a++) {
      PetscCall(PetscFree(cells->x[a]));
      PetscCall(PetscMalloc1(cells->capacity, &cells->x[a]));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CellsBuild - Sorts all local particles, own and halo, into cells. Input: particles - the
   particles, with an up-to-date halo; size - edge of a cell [m]; enlarged if almost all cells would
   be empty. Output: cells - the cells; zero before the first call, which allocates storage that
   later calls reuse. Error: PETSC_ERR_FP if a position is not finite. */
PetscErrorCode CellsBuild(const Particles *particles, PetscReal size, Cells *cells)
{
  const Particles *p = particles;
  PetscInt         n_cells, *of;

  PetscFunctionBegin;
  PetscCheck(size > 0.0, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "Cell size %g, must be positive", (double)size);
  cells->n = ParticlesAll(p);
  PetscCall(LayGrid(p, size, cells));
  n_cells = cells->count[0] * cells->count[1] * cells->count[2];
  PetscCall(CellsReserve(cells, n_cells));
  PetscCall(PetscMalloc1(cells->n, &of));
  PetscCall(PetscArrayzero(cells->start, n_cells + 1));
  for (PetscInt i = 0; i < cells->n; i++) {
    PetscInt c = 0;
    for (PetscInt a = p->dim - 1; a >= 0; a--) {
      c = c * cells->count[a] + CellAlong(cells, a, p->x[a][i]);
    }
    of[i] = c;
    cells->start[c + 1]++;
  }
  for (PetscInt c = 0; c < n_cells; c++) cells->start[c + 1] += cells->start[c];
  for (PetscInt i = 0; i < cells->n; i++) {
    const PetscInt k = cells->start[of[i]]++;
    cells->list[k]   = i;
    for (PetscInt a = 0; a < p->dim; a++) cells->x[a][k] = p->x[a][i];
  }
  for (PetscInt c = n_cells; c > 0; c--) cells->start[c] = cells->start[c - 1];
  cells->start[0] = 0;
  PetscCall(PetscFree(of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CellsFree - Frees the arrays; the cells can be built again */
PetscErrorCode CellsFree(Cells *cells)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&cells->start, &cells->list));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(cells->x[a]));
  PetscCall(PetscMemzero(cells, sizeof(*cells)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SORT_SHORT 128 /* longest list sorted by insertion */

/* SortIndices - Sorts a list of different indices in ascending order. Particles are numbered by
   cells when an epoch starts, so that lists from cells are nearly in order. */
PetscErrorCode SortIndices(PetscInt n, PetscInt list[])
{
  PetscFunctionBegin;
  if (n > SORT_SHORT) {
    PetscCall(PetscSortInt(n, list));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 1; k < n; k++) {
    const PetscInt j = list[k];
    PetscInt       q = k;

    for (; q > 0 && list[q - 1] > j; q--) list[q] = list[q - 1];
    list[q] = j;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the particles of places [first, last) within a radius to a list of n, at most `max`; n
   counts all of them. No branch depends on a distance: it would be mispredicted too often. */
static inline void ListWithin(const Cells *cells, PetscInt first, PetscInt last,
                              const PetscReal x[], PetscReal radius, PetscInt max, PetscInt list[],
                              PetscInt *n)
{
  const PetscReal *x0 = cells->x[0], *x1 = cells->x[1], *x2 = cells->x[2];
  const PetscInt  *of    = cells->list;
  PetscInt         count = *n; /* in a register: the list cannot change it */

  for (PetscInt k = first; k < last; k++) {
    PetscReal r2 = PetscSqr(x0[k] - x[0]) + PetscSqr(x1[k] - x[1]);

    if (cells->dim == 3) r2 += PetscSqr(x2[k] - x[2]);
    if (count < max) list[count] = of[k];
    count += r2 < radius * radius ? 1 : 0;
  }
  *n = count;
}

/*
  CellsFind - Lists the local particles within a radius of a point

    |x_j - x| < radius

  Input: cells - the cells; x - the point [m]; radius - the radius, of any size [m]; max - size of
  list. Output: list - local indices, ascending; count - number of particles found. Note: distances
  refer to positions at CellsBuild(). Neighbors.cells may be older than the present positions:
  search them with radius + margin / 2, and test the present distances. Error:
  PETSC_ERR_ARG_OUTOFRANGE if there are more than max
*/
PetscErrorCode CellsFind(const Cells *cells, const PetscReal x[], PetscReal radius, PetscInt max,
                         PetscInt list[], PetscInt *count)
{
  PetscInt first[ISPH_MAX_DIM] = {0}, last[ISPH_MAX_DIM] = {0}, n = 0;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < cells->dim; a++) {
    first[a] = CellAlong(cells, a, x[a] - radius);
    last[a]  = CellAlong(cells, a, x[a] + radius);
  }
  for (PetscInt c2 = first[2]; c2 <= last[2]; c2++) {
    for (PetscInt c1 = first[1]; c1 <= last[1]; c1++) {
      const PetscInt row = cells->count[0] * (c1 + cells->count[1] * c2);

      ListWithin(cells, cells->start[row + first[0]], cells->start[row + last[0] + 1], x, radius,
                 max, list, &n);
      PetscCheck(n <= max, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
                 "More than %" PetscInt_FMT " particles within %g of a point", max, (double)radius);
    }
  }
  PetscCall(SortIndices(n, list));
  *count = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}
