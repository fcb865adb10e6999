/* Distances from a surface of triangles by a tree of boxes. The sign is that of the pseudonormal of
   the nearest feature: the normal of a face, the sum of two normals at a side, the sum of normals
   weighted by their angles at a corner. It is right for every closed surface. Reference: J. A.
   Baerentzen, H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253. */
#include "mesh.h"

#define LEAF 4
#define DEEP 64 /* branches on the way to a leaf */

/* A triangle and its middle. */
typedef struct {
  PetscReal middle[3];
  PetscInt  corner[3];
} Placed;

/* Sorts triangles from <= t < to so that those before the half of them have the smaller coordinates
   along the longest side of the box around their middles, and each half alike (C. A. R. Hoare,
   Commun. ACM 4 (1961) 321-322). */
static void Split(Placed placed[], PetscInt from, PetscInt to)
{
  const PetscInt half = from + (to - from) / 2;
  PetscInt       low = from, high = to - 1, axis = 0;
  PetscReal      longest = -1.0;

  if (to - from <= LEAF) return;
  for (PetscInt a = 0; a < 3; a++) {
    PetscReal lo = PETSC_INFINITY, hi = -PETSC_INFINITY;

    for (PetscInt t = from; t < to; t++) {
      lo = PetscMin(lo, placed[t].middle[a]);
      hi = PetscMax(hi, placed[t].middle[a]);
    }
    if (hi - lo <= longest) continue;
    longest = hi - lo;
    axis    = a;
  }
  while (low < high) {
    const PetscReal pivot = placed[low + (high - low) / 2].middle[axis];
    PetscInt        i = low, j = high;

    while (i <= j) {
      while (placed[i].middle[axis] < pivot) i++;
      while (placed[j].middle[axis] > pivot) j--;
      if (i > j) break;
      {
        const Placed kept = placed[i];

        placed[i++] = placed[j];
        placed[j--] = kept;
      }
    }
    if (half <= j) high = j;
    else if (half >= i) low = i;
    else break;
  }
  Split(placed, from, half);
  Split(placed, half, to);
}

/* MeshSort - Sorts triangles so that neighbours in the list are neighbours in space */
PetscErrorCode MeshSort(Mesh *mesh)
{
  Placed *placed;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->triangles, &placed));
  for (PetscInt k = 0; k < 3 * mesh->triangles; k++) {
    const PetscReal *x = &mesh->x[3 * mesh->corner[k]];

    for (PetscInt a = 0; a < 3; a++)
      placed[k / 3].middle[a] = x[a] / 3.0 + (k % 3 ? placed[k / 3].middle[a] : 0.0);
    placed[k / 3].corner[k % 3] = mesh->corner[k];
  }
  Split(placed, 0, mesh->triangles);
  for (PetscInt k = 0; k < 3 * mesh->triangles; k++) mesh->corner[k] = placed[k / 3].corner[k % 3];
  PetscCall(PetscFree(placed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sets axes of a box around triangles: their mean normal, and two across it. */
static void SetAxes(const Mesh *mesh, MeshNode *node)
{
  PetscReal *n = node->axis[0], size = 0.0;
  PetscInt   least = 0;

  for (PetscInt t = node->from; t < node->to; t++) {
    const PetscReal *x[3];
    PetscReal        normal[3];
    const PetscReal  area = MeshTriangle(mesh, t, x, normal);

    for (PetscInt a = 0; a < 3; a++) n[a] += area * normal[a];
    size += area;
  }
  if (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < 0.01 * size * size) n[0] += size;
  size = PetscSqrtReal(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (PetscInt a = 0; a < 3; a++) {
    n[a] /= size;
    if (PetscAbsReal(n[a]) < PetscAbsReal(n[least])) least = a;
  }
  size = PetscSqrtReal(1.0 - PetscSqr(n[least]));
  for (PetscInt a = 0; a < 3; a++) node->axis[1][a] = ((a == least) - n[least] * n[a]) / size;
  for (PetscInt a = 0; a < 3; a++)
    node->axis[2][a] =
        n[(a + 1) % 3] * node->axis[1][(a + 2) % 3] - n[(a + 2) % 3] * node->axis[1][(a + 1) % 3];
}

/* MeshAlong - Returns the coordinate of x along an axis of a box */
PetscReal MeshAlong(const MeshNode *node, PetscInt axis, const PetscReal x[])
{
  return node->axis[axis][0] * x[0] + node->axis[axis][1] * x[1] + node->axis[axis][2] * x[2];
}

/* Builds the node of triangles from <= t < to; returns the number of nodes. */
static PetscInt Build(Mesh *mesh, PetscInt at, PetscInt from, PetscInt to)
{
  MeshNode *node = &mesh->node[at];
  PetscInt  next = at + 1;

  *node = (MeshNode){.from = from, .to = to};
  SetAxes(mesh, node);
  for (PetscInt a = 0; a < 3; a++) {
    node->lo[a] = PETSC_INFINITY;
    node->hi[a] = -PETSC_INFINITY;
    for (PetscInt k = 3 * from; k < 3 * to; k++) {
      const PetscReal along = MeshAlong(node, a, &mesh->x[3 * mesh->corner[k]]);

      node->lo[a] = PetscMin(node->lo[a], along);
      node->hi[a] = PetscMax(node->hi[a], along);
    }
  }
  if (to - from > LEAF) {
    node->second = Build(mesh, next, from, from + (to - from) / 2);
    next         = Build(mesh, node->second, from + (to - from) / 2, to);
  }
  return next;
}

/* MeshTree - Builds the tree of a surface, and its normals */
PetscErrorCode MeshTree(BodyStore *store, Mesh *mesh)
{
  PetscFunctionBegin;
  PetscCall(PetscMalloc1(mesh->triangles + 1, &mesh->node));
  PetscCall(BodyStoreAdd(mesh->node, store));
  (void)Build(mesh, 0, 0, mesh->triangles);
  PetscCall(PetscMalloc1(3 * mesh->triangles, &mesh->normal));
  PetscCall(BodyStoreAdd(mesh->normal, store));
  PetscCall(PetscCalloc1(3 * mesh->corners, &mesh->around));
  PetscCall(BodyStoreAdd(mesh->around, store));
  for (PetscInt t = 0; t < mesh->triangles; t++) {
    const PetscReal *x[3];
    PetscReal       *n = &mesh->normal[3 * t];

    (void)MeshTriangle(mesh, t, x, n);
    for (PetscInt k = 0; k < 3; k++) {
      const PetscReal *p = x[k], *q = x[(k + 1) % 3], *r = x[(k + 2) % 3];
      PetscReal        along = 0.0, one = 0.0, two = 0.0, angle;

      for (PetscInt a = 0; a < 3; a++) {
        along += (q[a] - p[a]) * (r[a] - p[a]);
        one += PetscSqr(q[a] - p[a]);
        two += PetscSqr(r[a] - p[a]);
      }
      angle = PetscAcosReal(PetscMax(-1.0, PetscMin(1.0, along / PetscSqrtReal(one * two))));
      for (PetscInt a = 0; a < 3; a++)
        mesh->around[3 * mesh->corner[3 * t + k] + a] += angle * n[a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeshTriangle - Gets the corners of a triangle; returns its area [m^2]. Output: normal - of length
   1, zero for one without area */
PetscReal MeshTriangle(const Mesh *mesh, PetscInt t, const PetscReal *x[3], PetscReal normal[3])
{
  PetscReal size = 0.0;

  for (PetscInt k = 0; k < 3; k++) x[k] = &mesh->x[3 * mesh->corner[3 * t + k]];
  for (PetscInt a = 0; a < 3; a++) {
    const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

    normal[a] =
        (x[1][b] - x[0][b]) * (x[2][c] - x[0][c]) - (x[1][c] - x[0][c]) * (x[2][b] - x[0][b]);
    size += PetscSqr(normal[a]);
  }
  size = PetscSqrtReal(size);
  for (PetscInt a = 0; a < 3; a++) normal[a] = size > 0.0 ? normal[a] / size : 0.0;
  return 0.5 * size;
}

/* Computes the nearest point on the line from a to b; returns the square of its distance. Output:
   end - 0 or 1 at an end, otherwise -1. */
static PetscReal FootOnSide(const PetscReal a[3], const PetscReal b[3], const PetscReal x[],
                            PetscReal foot[3], PetscInt *end)
{
  PetscReal along = 0.0, length = 0.0, square = 0.0;

  for (PetscInt c = 0; c < 3; c++) {
    along += (x[c] - a[c]) * (b[c] - a[c]);
    length += PetscSqr(b[c] - a[c]);
  }
  *end = along <= 0.0 ? 0 : along >= length ? 1 : -1;
  for (PetscInt c = 0; c < 3; c++) {
    foot[c] = *end == 0 ? a[c] : *end == 1 ? b[c] : a[c] + along / length * (b[c] - a[c]);
    square += PetscSqr(x[c] - foot[c]);
  }
  return square;
}

/* MeshFoot - Computes the point of triangle t that is nearest to x; returns the square of its
   distance [m^2]. Output: part - 0, 1, 2: on the side from this corner; 3, 4, 5: the corner; 6:
   within */
PetscReal MeshFoot(const Mesh *mesh, PetscInt t, const PetscReal x[], PetscReal foot[3],
                   PetscInt *part)
{
  const PetscReal *y[3], *n = &mesh->normal[3 * t];
  PetscReal        best = PETSC_INFINITY, height = 0.0;
  PetscBool        within = PETSC_TRUE;

  for (PetscInt k = 0; k < 3; k++) y[k] = &mesh->x[3 * mesh->corner[3 * t + k]];
  for (PetscInt a = 0; a < 3; a++) height += (x[a] - y[0][a]) * n[a];
  for (PetscInt k = 0; k < 3; k++) {
    const PetscReal *p = y[k], *q = y[(k + 1) % 3];
    PetscReal        inward = 0.0, f[3], square;
    PetscInt         end;

    for (PetscInt a = 0; a < 3; a++) {
      const PetscInt b = (a + 1) % 3, c = (a + 2) % 3;

      inward += (x[a] - p[a]) * (n[b] * (q[c] - p[c]) - n[c] * (q[b] - p[b]));
    }
    if (inward > 0.0) continue;
    within = PETSC_FALSE;
    square = FootOnSide(p, q, x, f, &end);
    if (square >= best) continue;
    best  = square;
    *part = end < 0 ? k : 3 + (k + end) % 3;
    for (PetscInt a = 0; a < 3; a++) foot[a] = f[a];
  }
  if (!within) return best;
  *part = 6;
  for (PetscInt a = 0; a < 3; a++) foot[a] = x[a] - height * n[a];
  return PetscSqr(height);
}

/* Returns the square of the distance of x from the box of a node. */
static PetscReal ToBox(const MeshNode *node, const PetscReal x[])
{
  PetscReal square = 0.0;

  for (PetscInt a = 0; a < 3; a++) {
    const PetscReal along = MeshAlong(node, a, x);

    square += PetscSqr(PetscMax(0.0, PetscMax(node->lo[a] - along, along - node->hi[a])));
  }
  return square;
}

/* MeshNearest - Returns the signed distance of x from a surface, positive outside [m]. Output: foot
   - the nearest point; normal - out of the solid. */
PetscReal MeshNearest(const Mesh *mesh, const PetscReal x[], PetscReal foot[3], PetscReal normal[3])
{
  PetscReal best = PETSC_INFINITY, d, along = 0.0;
  PetscInt  stack[DEEP], n = 0, on = 0, at = 0, part = 6;

  stack[n++] = 0;
  while (n) {
    const MeshNode *node = &mesh->node[stack[--n]];

    if (ToBox(node, x) >= best) continue;
    if (node->second) {
      const PetscInt  first  = (PetscInt)(node - mesh->node) + 1;
      const PetscBool second = ToBox(&mesh->node[node->second], x) < ToBox(&mesh->node[first], x);

      stack[n++] = second ? first : node->second;
      stack[n++] = second ? node->second : first;
      continue;
    }
    for (PetscInt t = node->from; t < node->to; t++) {
      const PetscReal *c = &mesh->x[3 * mesh->corner[3 * t]], *normal_t = &mesh->normal[3 * t];
      PetscReal        f[3], height                                     = 0.0, square;

      for (PetscInt a = 0; a < 3; a++) height += (x[a] - c[a]) * normal_t[a];
      if (PetscSqr(height) >= best) continue;
      square = MeshFoot(mesh, t, x, f, &at);
      if (square >= best) continue;
      best = square;
      on   = t;
      part = at;
      for (PetscInt a = 0; a < 3; a++) foot[a] = f[a];
    }
  }
  d = PetscSqrtReal(best);
  for (PetscInt a = 0; a < 3; a++) {
    normal[a] = part < 3
                    ? mesh->normal[3 * on + a] + mesh->normal[3 * mesh->across[3 * on + part] + a]
                : part < 6 ? mesh->around[3 * mesh->corner[3 * on + part - 3] + a]
                           : mesh->normal[3 * on + a];
    along += (x[a] - foot[a]) * normal[a];
  }
  d *= along < 0.0 ? -1.0 : 1.0;
  if (PetscAbsReal(d) > 1e-9 * mesh->extent) {
    for (PetscInt a = 0; a < 3; a++) normal[a] = (x[a] - foot[a]) / d;
  } else {
    const PetscReal size =
        PetscSqrtReal(PetscSqr(normal[0]) + PetscSqr(normal[1]) + PetscSqr(normal[2]));

    for (PetscInt a = 0; a < 3; a++)
      normal[a] = size > 0.0 ? normal[a] / size : mesh->normal[3 * on + a];
  }
  return d;
}
