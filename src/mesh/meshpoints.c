/* Points on a surface of triangles, about dx apart, by a centroidal partition: the surface is
   divided into small pieces, each piece belongs to the nearest of the points whose normal is near
   to its own, and each point moves to the middle of its pieces. Areas of points are those of their
   pieces, so that their sum is the area of the surface. References: Q. Du, V. Faber, M. Gunzburger,
   SIAM Rev. 41 (1999) 637-676; S. Valette, J.-M. Chassery, Comput. Graph. Forum 23 (2004)
   381-389. */
#include "mesh.h"

#define PIECES 4.0  /* pieces along dx */
#define APART  0.80 /* least distance of the first points; for random packing the mean is then dx */
#define ROUNDS 12
#define REACH  1.5 /* search of the point of a piece [dx] */

/* Pieces of the surface, and points on it: places, outward normals of length 1, areas. */
typedef struct {
  PetscInt   n, capacity;
  PetscReal *x, *normal, *area;
} Pieces;

static PetscErrorCode Add(const PetscReal x[3], const PetscReal normal[3], PetscReal area,
                          Pieces *p)
{
  PetscFunctionBegin;
  if (p->n == p->capacity) {
    p->capacity = 2 * p->capacity + 1024;
    PetscCall(PetscRealloc(sizeof(PetscReal) * 3 * (size_t)p->capacity, &p->x));
    PetscCall(PetscRealloc(sizeof(PetscReal) * 3 * (size_t)p->capacity, &p->normal));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)p->capacity, &p->area));
  }
  for (PetscInt a = 0; a < 3; a++) {
    p->x[3 * p->n + a]      = x[a];
    p->normal[3 * p->n + a] = normal[a];
  }
  p->area[p->n++] = area;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FreePieces(Pieces *p)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&p->x, &p->normal, &p->area));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds small triangles that follow each other, with like normals, as one piece of at most an area;
   returns the number of them, 0 if the first one is larger. */
static PetscErrorCode Join(const Mesh *mesh, PetscInt first, PetscReal most, Pieces *p, PetscInt *n)
{
  PetscReal sum = 0.0, middle[3] = {0.0}, out[3] = {0.0}, size;

  PetscFunctionBegin;
  for (*n = 0; first + *n < mesh->triangles; (*n)++) {
    const PetscReal *x[3];
    PetscReal        normal[3], along = 0.0, apart = 0.0;
    const PetscReal  area = MeshTriangle(mesh, first + *n, x, normal);

    for (PetscInt a = 0; a < 3; a++) {
      const PetscReal y = (x[0][a] + x[1][a] + x[2][a]) / 3.0;

      along += normal[a] * out[a];
      apart += *n ? PetscSqr(y - middle[a] / sum) : 0.0;
    }
    if (sum + area > most || apart > 2.0 * most || (*n && along < 0.9 * sum)) break;
    sum += area;
    for (PetscInt a = 0; a < 3; a++) {
      middle[a] += area * (x[0][a] + x[1][a] + x[2][a]) / 3.0;
      out[a] += area * normal[a];
    }
  }
  if (*n == 0) PetscFunctionReturn(PETSC_SUCCESS);
  size = PetscSqrtReal(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  for (PetscInt a = 0; a < 3; a++) {
    middle[a] /= sum;
    out[a] /= size;
  }
  PetscCall(Add(middle, out, sum, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Divides a triangle of area A into rows parallel to its longest side, and rows into pieces between
  lines through the corner C beyond: with P = (1 - h) (A + s (B - A)) + h C

    dA = 2 A (1 - h) dh ds
*/
static PetscErrorCode Divide(const Mesh *mesh, PetscInt t, PetscReal step, Pieces *p)
{
  const PetscReal *x[3];
  PetscReal        normal[3], longest = 0.0;
  const PetscReal  area = MeshTriangle(mesh, t, x, normal);
  PetscInt         side = 0, rows;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 3; k++) {
    PetscReal square = 0.0;

    for (PetscInt a = 0; a < 3; a++) square += PetscSqr(x[(k + 1) % 3][a] - x[k][a]);
    if (square <= longest) continue;
    longest = square;
    side    = k;
  }
  longest = PetscSqrtReal(longest);
  rows    = ShapeLineCount(2.0 * area / longest, step, 1);
  for (PetscInt row = 0; row < rows; row++) {
    const PetscReal h0 = (PetscReal)row / rows, h1 = (row + 1.0) / rows;
    const PetscReal part = (h1 - h0) * (1.0 - 0.5 * (h0 + h1)); /* int (1 - h) dh */
    const PetscReal h    = (0.5 * (h1 * h1 - h0 * h0) - (h1 * h1 * h1 - h0 * h0 * h0) / 3.0) / part;
    const PetscInt  n    = ShapeLineCount(longest * (1.0 - h), step, 1);

    for (PetscInt q = 0; q < n; q++) {
      const PetscReal s = (q + 0.5) / n;
      PetscReal       y[3];

      for (PetscInt a = 0; a < 3; a++)
        y[a] = (1.0 - h) * ((1.0 - s) * x[side][a] + s * x[(side + 1) % 3][a]) +
               h * x[(side + 2) % 3][a];
      PetscCall(Add(y, normal, 2.0 * area * part / n, p));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses pieces that are at least a distance apart, or have other normals, as the first points;
   they are tried in an order that jumps over the surface. */
static PetscErrorCode Choose(const Pieces *pieces, PetscReal dx, Pieces *points)
{
  PetscInt stride = (PetscInt)(0.6180339887498949 * pieces->n) | 1, at = 0, p, q = 0;
  MeshGrid grid;

  PetscFunctionBegin;
  for (; q != 1; stride += q != 1 ? 2 : 0) { /* without a common divisor */
    PetscInt rest;

    for (p = pieces->n, q = stride; (rest = p % q) != 0; q = rest) p = q;
  }
  PetscCall(MeshGridCreate(pieces->n, 2.0 * dx, &grid));
  for (PetscInt k = 0; k < pieces->n; k++, at = (at + stride) % pieces->n) {
    const PetscReal *x = &pieces->x[3 * at], *normal = &pieces->normal[3 * at];

    if (MeshGridNearest(&grid, points->x, points->normal, x, normal, APART * dx) >= 0) continue;
    PetscCall(Add(x, normal, 0.0, points));
    MeshGridAdd(&grid, points->n - 1, x);
  }
  PetscCall(MeshGridFree(&grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Gives each piece to a point, and moves the points to the middle of their pieces. */
static PetscErrorCode Move(const Mesh *mesh, const Pieces *pieces, PetscReal dx, PetscInt owner[],
                           Pieces *points)
{
  MeshGrid grid;

  PetscFunctionBegin;
  PetscCall(MeshGridCreate(points->n, 2.0 * dx, &grid));
  for (PetscInt k = 0; k < points->n; k++) MeshGridAdd(&grid, k, &points->x[3 * k]);
  for (PetscInt q = 0; q < pieces->n; q++) {
    const PetscInt k = MeshGridNearest(&grid, points->x, points->normal, &pieces->x[3 * q],
                                       &pieces->normal[3 * q], REACH * dx);

    if (k >= 0) owner[q] = k;
  }
  PetscCall(MeshGridFree(&grid));
  for (PetscInt k = 0; k < 3 * points->n; k++)
    points->x[k] = points->normal[k] = points->area[k / 3] = 0.0;
  for (PetscInt q = 0; q < pieces->n; q++) {
    const PetscInt k = owner[q];

    points->area[k] += pieces->area[q];
    for (PetscInt a = 0; a < 3; a++) {
      points->x[3 * k + a] += pieces->area[q] * pieces->x[3 * q + a];
      points->normal[3 * k + a] += pieces->area[q] * pieces->normal[3 * q + a];
    }
  }
  for (PetscInt k = 0; k < points->n; k++) {
    PetscReal *x = &points->x[3 * k], *n = &points->normal[3 * k], foot[3], out[3];
    PetscReal  size = PetscSqrtReal(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);

    if (points->area[k] == 0.0) continue;
    for (PetscInt a = 0; a < 3; a++) {
      x[a] /= points->area[k];
      n[a] /= size;
    }
    (void)MeshNearest(mesh, x, foot, out);
    for (PetscInt a = 0; a < 3; a++) x[a] = foot[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeshPoints - Computes the points dx apart on a surface */
PetscErrorCode MeshPoints(const Mesh *mesh, SurfacePoints *surface)
{
  Pieces    pieces = {.n = 0}, points = {.n = 0};
  PetscInt *owner;

  PetscFunctionBegin;
  for (PetscInt t = 0, n; t < mesh->triangles; t += PetscMax(n, 1)) {
    PetscCall(Join(mesh, t, PetscSqr(surface->dx / PIECES), &pieces, &n));
    if (n == 0) PetscCall(Divide(mesh, t, surface->dx / PIECES, &pieces));
  }
  PetscCall(Choose(&pieces, surface->dx, &points));
  PetscCall(PetscCalloc1(pieces.n, &owner));
  for (PetscInt round = 0; round < ROUNDS; round++)
    PetscCall(Move(mesh, &pieces, surface->dx, owner, &points));
  for (PetscInt k = 0; k < points.n; k++)
    if (points.area[k] > 0.0)
      SolidAdd(&points.x[3 * k], &points.normal[3 * k], points.area[k], surface);
  PetscCall(PetscFree(owner));
  PetscCall(FreePieces(&pieces));
  PetscCall(FreePieces(&points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
