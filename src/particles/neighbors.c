/* Lists of neighbours: a row for each own fluid particle. If particles move little in a step, the
   search radius has a margin, and rows are kept until displacements use it up. */
#include "impl.h"

#define MARGIN_LARGEST 0.15        /* of the radius */
#define MARGIN_STEPS   10          /* number of steps that a margin should last */
#define STEP_TOO_LONG  (0.1 / 2.6) /* of the radius: a margin would last two steps or fewer */

/* NeighborsCreate - Creates an empty set of rows. Input: radius - largest radius of a particle, at
   most Particles.halo_width [m]; two particles are neighbours if they are closer than the larger of
   their radii; spacing - largest edge of the cells of particles with this radius [m]; radii are in
   proportion to these edges. Output: neighbors - the rows; NeighborsUpdate() fills them. */
PetscErrorCode NeighborsCreate(PetscReal radius, PetscReal spacing, Neighbors **neighbors)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(neighbors));
  (*neighbors)->radius  = radius;
  (*neighbors)->spacing = spacing;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* NeighborsDestroy - Frees the neighbours */
PetscErrorCode NeighborsDestroy(Neighbors **neighbors)
{
  PetscFunctionBegin;
  if (!*neighbors) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(NeighborsRelease(*neighbors));
  PetscCall(PetscFree(*neighbors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* NeighborsRelease - Frees rows and cells; the next update builds them */
PetscErrorCode NeighborsRelease(Neighbors *nb)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&nb->row, &nb->col, &nb->reach2));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(nb->x_built[a]));
  PetscCall(CellsFree(&nb->cells));
  nb->row_capacity = nb->col_capacity = nb->epoch = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReserveRows(PetscInt n, Neighbors *nb)
{
  PetscFunctionBegin;
  if (n + 1 <= nb->row_capacity) PetscFunctionReturn(PETSC_SUCCESS);
  nb->row_capacity = n + 1 + n / 4;
  PetscCall(PetscFree(nb->row));
  PetscCall(PetscMalloc1(nb->row_capacity, &nb->row));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(nb->x_built[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the positions, from which the use of the margin is measured. */
static PetscErrorCode KeepPositions(const Particles *p, Neighbors *nb)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)(ParticlesOwn(p) + 1), &nb->x_built[a]));
    PetscCall(PetscArraycpy(nb->x_built[a], p->x[a], ParticlesOwn(p)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReserveColumns(PetscInt n, Neighbors *nb)
{
  PetscFunctionBegin;
  if (n <= nb->col_capacity) PetscFunctionReturn(PETSC_SUCCESS);
  nb->col_capacity = (PetscInt)PetscMin((PetscInt64)n + n / 2, PETSC_INT_MAX);
  PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)nb->col_capacity, &nb->col));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes to col those particles of entries [begin, end) of the cell list, except i, that are closer
   to x than the larger of both reaches, own2^(1/2) and reach2^(1/2); returns their number. */
static inline PetscInt ScanRun(const Cells *cells, const PetscReal reach2[], PetscInt begin,
                               PetscInt end, const PetscReal x[], PetscReal own2, PetscInt i,
                               PetscInt col[])
{
  const PetscReal *x0 = cells->x[0], *x1 = cells->x[1], *x2 = cells->x[2];
  PetscInt         n = 0;

  if (cells->dim == 2) {
    for (PetscInt k = begin; k < end; k++) {
      const PetscReal d0 = x0[k] - x[0], d1 = x1[k] - x[1];
      col[n] = cells->list[k];
      n += (d0 * d0 + d1 * d1 < PetscMax(own2, reach2[k])) & (col[n] != i);
    }
  } else {
    for (PetscInt k = begin; k < end; k++) {
      const PetscReal d0 = x0[k] - x[0], d1 = x1[k] - x[1], d2 = x2[k] - x[2];
      col[n] = cells->list[k];
      n += (d0 * d0 + d1 * d1 + d2 * d2 < PetscMax(own2, reach2[k])) & (col[n] != i);
    }
  }
  return n;
}

/* Returns the square of radius and margin of local particle i, theory.md, (particles:neighbours)
   [m^2]. */
static inline PetscReal Reach2(const Particles *p, const Neighbors *nb, PetscInt i)
{
  return PetscSqr(nb->radius * (ParticlesLargestEdge(p, i) / nb->spacing) + nb->margin);
}

/* Appends row i. Cells along the first axis are contiguous in the list and scanned together. */
static PetscErrorCode BuildRow(const Particles *p, PetscInt i, Neighbors *nb)
{
  const Cells *cells               = &nb->cells;
  PetscInt     first[ISPH_MAX_DIM] = {0}, last[ISPH_MAX_DIM] = {0}, n = nb->row[i];
  PetscReal    x[ISPH_MAX_DIM], own2 = Reach2(p, nb, i);

  PetscFunctionBegin;
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscInt c;

    x[a]     = p->x[a][i];
    c        = (PetscInt)((x[a] - cells->origin[a]) / cells->size);
    first[a] = PetscMax(c - 1, 0);
    last[a]  = PetscMin(c + 1, cells->count[a] - 1);
  }
  for (PetscInt c2 = first[2]; c2 <= last[2]; c2++) {
    for (PetscInt c1 = first[1]; c1 <= last[1]; c1++) {
      const PetscInt cell  = cells->count[0] * (c1 + cells->count[1] * c2);
      const PetscInt begin = cells->start[cell + first[0]], end = cells->start[cell + last[0] + 1];

      PetscCall(ReserveColumns(n + end - begin + 1, nb));
      n += ScanRun(cells, nb->reach2, begin, end, x, own2, i, &nb->col[n]);
    }
  }
  PetscCall(SortIndices(n - nb->row[i], &nb->col[nb->row[i]]));
  nb->row[i + 1] = n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts particles into cells and makes room for the beginnings of all rows. */
static PetscErrorCode BeginSearch(const Particles *p, Neighbors *nb)
{
  PetscFunctionBegin;
  PetscCall(CellsBuild(p, nb->radius + nb->margin, &nb->cells));
  PetscCall(ReserveRows(p->n_fluid, nb));
  PetscCall(PetscFree(nb->reach2));
  PetscCall(PetscMalloc1(nb->cells.n, &nb->reach2));
  for (PetscInt k = 0; k < nb->cells.n; k++) nb->reach2[k] = Reach2(p, nb, nb->cells.list[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Builds all rows for present positions. */
static PetscErrorCode BuildRows(const Particles *p, PetscReal step_length, Neighbors *nb)
{
  PetscFunctionBegin;
  nb->margin = PetscMin(MARGIN_LARGEST * nb->radius, 2.0 * MARGIN_STEPS * step_length);
  if (step_length > STEP_TOO_LONG * nb->radius) nb->margin = 0.0;
  PetscCall(BeginSearch(p, nb));
  nb->row[0] = 0;
  for (PetscInt i = 0; i < p->n_fluid; i++) PetscCall(BuildRow(p, i, nb));
  PetscCall(PetscFree(nb->reach2));
  if (nb->margin > 0.0) PetscCall(KeepPositions(p, nb));
  nb->epoch = p->epoch;
  nb->moved = p->moved;
  nb->builds++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  NeighborsUpdate - Rebuilds the rows if particles have moved too far since the last build

    rows are kept while  (2 + slope) max_i |x_i - x_i(last build)| <= margin

  Collective. Input: particles - the particles, with an up-to-date halo; step_length - bound of the
  largest displacement in a step [m], the same on all ranks. The margin lasts for ten such steps,
  but is at most 0.15 radius; it is zero if the bound is zero or above 0.1/2.6 of the radius.
  Output: neighbors - row and col; the cells hold positions at the time of the build. Note: all
  pairs closer than radius are in the rows, also in kept rows. For a search in kept cells see
  CellsFind().
*/
PetscErrorCode NeighborsUpdate(const Particles *particles, PetscReal step_length,
                               Neighbors *neighbors)
{
  const Particles *p  = particles;
  Neighbors       *nb = neighbors;
  PetscReal        move;

  PetscFunctionBegin;
  PetscCheck(nb->radius <= p->halo_width * (1.0 + 1e-12), p->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "Radius %g of neighbours exceeds halo_width = %g of the particles", (double)nb->radius,
             (double)p->halo_width);
  if (nb->epoch == p->epoch) {
    if (nb->moved == p->moved) PetscFunctionReturn(PETSC_SUCCESS);
    if (nb->margin > 0.0) {
      PetscCall(ParticlesLargestMove(p, nb->x_built, &move));
      if ((2.0 + nb->slope) * move <= nb->margin) PetscFunctionReturn(PETSC_SUCCESS);
    }
  }
  PetscCall(BuildRows(p, step_length, nb));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* NeighborsSearch - Prepares NeighborsFindRows(), which needs much less memory than all rows at
   once. Does nothing if the rows of the present positions are there; otherwise previous rows are
   lost. NeighborsRelease() ends the search. */
PetscErrorCode NeighborsSearch(const Particles *p, Neighbors *nb)
{
  PetscFunctionBegin;
  if (nb->epoch == p->epoch && nb->moved == p->moved) PetscFunctionReturn(PETSC_SUCCESS);
  nb->epoch  = 0;
  nb->margin = 0.0;
  PetscCall(BeginSearch(p, nb));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* NeighborsFindRows - Makes the rows of own fluid particles first, ..., first + count - 1
   available; a search loses other rows. To be called after NeighborsSearch(). */
PetscErrorCode NeighborsFindRows(const Particles *p, PetscInt first, PetscInt count, Neighbors *nb)
{
  PetscFunctionBegin;
  if (!nb->reach2) PetscFunctionReturn(PETSC_SUCCESS);
  nb->row[first] = 0;
  for (PetscInt i = first; i < first + count; i++) PetscCall(BuildRow(p, i, nb));
  PetscFunctionReturn(PETSC_SUCCESS);
}
