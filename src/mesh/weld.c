/* Makes a closed surface of triangles that have no common corners yet: corners that are nearly at
   one place become one, triangles with two equal corners, and second ones on the same corners, are
   left out, and the surface is closed and checked. */
#include "mesh.h"
#include <stdlib.h>

/* A triangle by its corners in ascending order. */
typedef struct {
  PetscInt corner[3], t;
} Named;

static int Compare(const void *a, const void *b)
{
  const Named *p = (const Named *)a, *q = (const Named *)b;

  for (PetscInt k = 0; k < 3; k++)
    if (p->corner[k] != q->corner[k]) return p->corner[k] < q->corner[k] ? -1 : 1;
  return p->t < q->t ? -1 : p->t > q->t;
}

/* Leaves out triangles with equal corners, and triangles with the corners of an earlier one. */
static PetscErrorCode LeaveOut(Mesh *mesh)
{
  Named   *named;
  PetscInt n = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->triangles, &named));
  for (PetscInt t = 0; t < mesh->triangles; t++) {
    PetscInt *c = named[n].corner;

    for (PetscInt k = 0; k < 3; k++) c[k] = mesh->corner[3 * t + k];
    if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
    PetscCall(PetscSortInt(3, c));
    named[n++].t = t;
  }
  qsort(named, (size_t)n, sizeof(*named), Compare);
  for (PetscInt k = 0; k < mesh->triangles; k++) mesh->across[k] = 0;
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt *c = named[k].corner, *before = k ? named[k - 1].corner : NULL;

    mesh->across[named[k].t] =
        !before || c[0] != before[0] || c[1] != before[1] || c[2] != before[2];
  }
  n = 0;
  for (PetscInt t = 0; t < mesh->triangles; t++) {
    if (!mesh->across[t]) continue;
    for (PetscInt k = 0; k < 3; k++) mesh->corner[3 * n + k] = mesh->corner[3 * t + k];
    n++;
  }
  mesh->equal     = mesh->triangles - n;
  mesh->triangles = n;
  PetscCall(PetscFree(named));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives one number to all corners that are at one place. */
static PetscErrorCode Weld(const MeshFile *file, Mesh *mesh)
{
  const PetscReal tight = TIGHT * mesh->extent;
  MeshGrid        grid;

  PetscFunctionBegin;
  PetscCall(MeshGridCreate(file->n / 3, 4.0 * tight, &grid));
  for (PetscInt k = 0; k < file->n / 3; k++) {
    const PetscReal *x = &file->number[3 * k];
    PetscInt         c = MeshGridNearest(&grid, mesh->x, NULL, x, NULL, tight);

    if (c < 0) {
      c = mesh->corners++;
      for (PetscInt a = 0; a < 3; a++) mesh->x[3 * c + a] = x[a];
      MeshGridAdd(&grid, c, x);
    }
    mesh->corner[k] = c;
  }
  PetscCall(MeshGridFree(&grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeshCreate - Makes a closed surface of the triangles of a file; the same on all ranks. Output:
   mesh - in the memory of a store; file->fault - if the surface is not closed, or has no inside. */
PetscErrorCode MeshCreate(MeshFile *file, BodyStore *store, Mesh *mesh)
{
  PetscFunctionBegin;
  *mesh = (Mesh){.triangles = file->n / 9};
  for (PetscInt a = 0; a < 3; a++) {
    mesh->lo[a] = PETSC_INFINITY;
    mesh->hi[a] = -PETSC_INFINITY;
    for (PetscInt k = a; k < file->n; k += 3) {
      mesh->lo[a] = PetscMin(mesh->lo[a], file->number[k]);
      mesh->hi[a] = PetscMax(mesh->hi[a], file->number[k]);
    }
    mesh->extent = PetscMax(mesh->extent, mesh->hi[a] - mesh->lo[a]);
  }
  if (!(mesh->extent > 0.0 && mesh->extent < 1e30)) {
    MeshFail(file, "its triangles have no extent, or one above 1e30");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(file->n, &mesh->x));
  PetscCall(PetscMalloc1(file->n / 3, &mesh->corner));
  PetscCall(PetscMalloc1(file->n / 3, &mesh->across));
  PetscCall(Weld(file, mesh));
  PetscCall(PetscRealloc(sizeof(*mesh->x) * 3 * (size_t)mesh->corners, &mesh->x));
  PetscCall(LeaveOut(mesh));
  if (!mesh->triangles) MeshFail(file, "its triangles have no area");
  PetscCall(MeshSort(mesh));
  if (!*file->fault) PetscCall(MeshClose(mesh, file->fault));
  PetscCall(BodyStoreAdd(mesh->x, store));
  PetscCall(BodyStoreAdd(mesh->corner, store));
  PetscCall(BodyStoreAdd(mesh->across, store));
  if (*file->fault) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MeshTree(store, mesh));
  PetscCall(MeshCrossings(mesh, file->fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}
