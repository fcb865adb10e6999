/* Cells of space by a hash of their place: the nearest of many points within a short distance. */
#include "mesh.h"
#include <stdint.h>

/* MeshGridCreate - Creates cells for n points; a search is quick up to a distance of half a cell */
PetscErrorCode MeshGridCreate(PetscInt n, PetscReal cell, MeshGrid *grid)
{
  PetscFunctionBegin;
  *grid = (MeshGrid){.cell = cell, .slots = 16};
  while (grid->slots < n) grid->slots *= 2;
  PetscCall(PetscMalloc2(grid->slots, &grid->head, n, &grid->next));
  for (PetscInt k = 0; k < grid->slots; k++) grid->head[k] = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeshGridFree - Frees the cells */
PetscErrorCode MeshGridFree(MeshGrid *grid)
{
  PetscFunctionBegin;
  PetscCall(PetscFree2(grid->head, grid->next));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt Slot(const MeshGrid *grid, const int64_t place[3])
{
  uint64_t hash = 0;

  for (PetscInt a = 0; a < 3; a++) hash = (hash ^ (uint64_t)place[a]) * 0x9E3779B97F4A7C15u;
  return (PetscInt)((hash >> 32) & (uint64_t)(grid->slots - 1));
}

/* MeshGridAdd - Adds point k */
void MeshGridAdd(MeshGrid *grid, PetscInt k, const PetscReal x[3])
{
  int64_t  place[3];
  PetscInt slot;

  for (PetscInt a = 0; a < 3; a++) place[a] = (int64_t)PetscFloorReal(x[a] / grid->cell);
  slot             = Slot(grid, place);
  grid->next[k]    = grid->head[slot];
  grid->head[slot] = k;
}

/* MeshGridNearest - Returns the number of the point nearest to x within a distance, among those
   whose normals are less than 45 degrees from one if normals are given; -1 if there is none */
PetscInt MeshGridNearest(const MeshGrid *grid, const PetscReal points[], const PetscReal normals[],
                         const PetscReal x[3], const PetscReal normal[3], PetscReal most)
{
  PetscReal best    = PetscSqr(most);
  PetscInt  nearest = -1;
  int64_t   lo[3], hi[3], c[3];

  for (PetscInt a = 0; a < 3; a++) {
    lo[a] = (int64_t)PetscFloorReal((x[a] - most) / grid->cell);
    hi[a] = (int64_t)PetscFloorReal((x[a] + most) / grid->cell);
  }
  for (c[0] = lo[0]; c[0] <= hi[0]; c[0]++) {
    for (c[1] = lo[1]; c[1] <= hi[1]; c[1]++) {
      for (c[2] = lo[2]; c[2] <= hi[2]; c[2]++) {
        for (PetscInt k = grid->head[Slot(grid, c)]; k >= 0; k = grid->next[k]) {
          PetscReal square = 0.0, along = 0.0;

          for (PetscInt a = 0; a < 3; a++) {
            square += PetscSqr(points[3 * k + a] - x[a]);
            along += normals ? normals[3 * k + a] * normal[a] : 1.0;
          }
          if (square > best || along < PETSC_SQRT2 / 2.0 || (square == best && nearest >= 0))
            continue;
          best    = square;
          nearest = k;
        }
      }
    }
  }
  return nearest;
}
