/* Sides of triangles: neighbours across them, one orientation of all triangles of a part, triangles
   without area, which are turned to the other diagonal, and parts that touch in one corner. */
#include "mesh.h"
#include <stdlib.h>

/* A side by its corners in ascending order. */
typedef struct {
  PetscInt lo, hi, side; /* 3 times the triangle, and the number of the side in it */
} Side;

static int Compare(const void *a, const void *b)
{
  const Side *p = (const Side *)a, *q = (const Side *)b;

  if (p->lo != q->lo) return p->lo < q->lo ? -1 : 1;
  if (p->hi != q->hi) return p->hi < q->hi ? -1 : 1;
  return p->side < q->side ? -1 : p->side > q->side;
}

/* MeshConnect - Finds the triangle across each side. Output: open - number of sides without one;
   many - of sides with two or more; place - of one of these, otherwise of an open one. */
PetscErrorCode MeshConnect(Mesh *mesh, PetscInt *open, PetscInt *many, PetscReal place[3])
{
  const PetscInt n = 3 * mesh->triangles;
  Side          *side;

  PetscFunctionBegin;
  *open = *many = 0;
  PetscCall(PetscMalloc1(n, &side));
  for (PetscInt s = 0; s < n; s++) {
    const PetscInt p = mesh->corner[s], q = mesh->corner[s % 3 == 2 ? s - 2 : s + 1];

    side[s]         = (Side){PetscMin(p, q), PetscMax(p, q), s};
    mesh->across[s] = -1;
  }
  qsort(side, (size_t)n, sizeof(*side), Compare);
  for (PetscInt s = 0, next; s < n; s = next) {
    for (next = s + 1; next < n && side[next].lo == side[s].lo && side[next].hi == side[s].hi;)
      next++;
    if (next == s + 2) {
      mesh->across[side[s].side]     = side[s + 1].side / 3;
      mesh->across[side[s + 1].side] = side[s].side / 3;
      continue;
    }
    if (next == s + 1) (*open)++;
    else (*many)++;
    for (PetscInt a = 0; a < 3 && (next > s + 1 || !*many); a++)
      place[a] = 0.5 * (mesh->x[3 * side[s].lo + a] + mesh->x[3 * side[s].hi + a]);
  }
  PetscCall(PetscFree(side));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeshReverse - Reverses the order of the corners of a triangle */
void MeshReverse(Mesh *mesh, PetscInt t)
{
  PetscInt *c = &mesh->corner[3 * t], *n = &mesh->across[3 * t], kept = c[1];

  c[1] = c[2];
  c[2] = kept;
  kept = n[0];
  n[0] = n[2];
  n[2] = kept;
}

/* Returns the number of the corner of a triangle that is corner c. */
static PetscInt Place(const Mesh *mesh, PetscInt t, PetscInt c)
{
  return mesh->corner[3 * t] == c ? 0 : mesh->corner[3 * t + 1] == c ? 1 : 2;
}

/* MeshOrient - Gives neighbours one orientation, and numbers the parts that hang together; returns
   false if a part has one side only. Output: part - number of the part of each triangle; parts -
   their number */
PetscErrorCode MeshOrient(Mesh *mesh, PetscInt part[], PetscInt *parts, PetscBool *good)
{
  PetscInt *list, n = 0;

  PetscFunctionBegin;
  *good  = PETSC_TRUE;
  *parts = 0;
  PetscCall(PetscMalloc1(mesh->triangles, &list));
  for (PetscInt t = 0; t < mesh->triangles; t++) part[t] = -1;
  for (PetscInt first = 0; first < mesh->triangles; first++) {
    if (part[first] >= 0) continue;
    part[first] = (*parts)++;
    list[n++]   = first;
    while (n) {
      const PetscInt t = list[--n];

      for (PetscInt k = 0; k < 3; k++) {
        const PetscInt u = mesh->across[3 * t + k];
        PetscBool      same;

        if (u < 0) continue;
        same = mesh->corner[3 * u + (Place(mesh, u, mesh->corner[3 * t + k]) + 1) % 3] ==
               mesh->corner[3 * t + (k + 1) % 3];
        if (part[u] >= 0) {
          if (same) *good = PETSC_FALSE;
          continue;
        }
        if (same) MeshReverse(mesh, u);
        part[u]   = part[t];
        list[n++] = u;
      }
    }
  }
  PetscCall(PetscFree(list));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Turns the common side k of triangles t and u to the other diagonal: a c b and c a d become a d b
   and d c b. Returns false if one of them has been turned since neighbours were found. */
static PetscBool Turn(Mesh *mesh, PetscInt t, PetscInt k)
{
  const PetscInt u = mesh->across[3 * t + k], a = mesh->corner[3 * t + k],
                 c = mesh->corner[3 * t + (k + 1) % 3], b = mesh->corner[3 * t + (k + 2) % 3],
                 j         = u < 0 ? 0 : Place(mesh, u, c),
                 d         = u < 0 ? 0 : mesh->corner[3 * u + (j + 2) % 3];
  const PetscInt corner[6] = {a, d, b, d, c, b};

  if (u < 0 || mesh->across[3 * u + j] != t) return PETSC_FALSE;
  for (PetscInt q = 0; q < 3; q++) {
    mesh->corner[3 * t + q] = corner[q];
    mesh->corner[3 * u + q] = corner[3 + q];
    mesh->across[3 * t + q] = mesh->across[3 * u + q] = -1;
  }
  mesh->flat++;
  return PETSC_TRUE;
}

/* Returns the number of the longest side of a triangle without area, -1 for other triangles. */
static PetscInt LongSide(const Mesh *mesh, PetscInt t)
{
  const PetscReal *x[3];
  PetscReal        normal[3], longest = 0.0;
  const PetscReal  area = MeshTriangle(mesh, t, x, normal);
  PetscInt         side = -1;

  for (PetscInt k = 0; k < 3; k++) {
    PetscReal square = 0.0;

    for (PetscInt a = 0; a < 3; a++) square += PetscSqr(x[(k + 1) % 3][a] - x[k][a]);
    if (square <= longest) continue;
    longest = square;
    side    = k;
  }
  return 2.0 * area > 0.5 * TIGHT * mesh->extent * PetscSqrtReal(longest) ? -1 : side;
}

/* MeshTurnFlat - Turns triangles whose corners are on one line, and their neighbour across the
   longest side, to two triangles with area. Output: left - number of those that cannot be turned;
   open, many - see MeshConnect() */
PetscErrorCode MeshTurnFlat(Mesh *mesh, PetscInt *left, PetscInt *open, PetscInt *many,
                            PetscReal place[3])
{
  PetscInt turned;

  PetscFunctionBegin;
  do {
    turned = mesh->flat;
    *left  = 0;
    for (PetscInt t = 0; t < mesh->triangles; t++) {
      const PetscInt k = LongSide(mesh, t);

      if (k < 0) continue;
      if (mesh->across[3 * t + k] < 0 || LongSide(mesh, mesh->across[3 * t + k]) >= 0 ||
          !Turn(mesh, t, k))
        (*left)++;
    }
    if (mesh->flat > turned) PetscCall(MeshConnect(mesh, open, many, place));
  } while (mesh->flat > turned && mesh->flat < 10 * mesh->triangles && !*open && !*many);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeshFindPinch - Finds a corner in which two parts of a surface touch; returns its number, or
   -1 */
PetscErrorCode MeshFindPinch(const Mesh *mesh, PetscInt *pinch)
{
  PetscBool *walked, *seen;

  PetscFunctionBegin;
  *pinch = -1;
  PetscCall(PetscCalloc2(3 * mesh->triangles, &walked, mesh->corners, &seen));
  for (PetscInt s = 0; s < 3 * mesh->triangles; s++) {
    const PetscInt c  = mesh->corner[s];
    PetscInt       at = s;

    if (walked[s]) continue;
    if (seen[c]) *pinch = c;
    seen[c] = PETSC_TRUE;
    while (!walked[at]) {
      walked[at] = PETSC_TRUE;
      at         = 3 * mesh->across[at];
      at += Place(mesh, at / 3, c);
    }
  }
  PetscCall(PetscFree2(walked, seen));
  PetscFunctionReturn(PETSC_SUCCESS);
}
