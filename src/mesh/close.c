/* Closes a surface of triangles at small holes and turns its parts outward. A hole gets the
   triangles between its rim and the first corner of the rim. A part that is inside an odd number of
   others is a cavity: its inside is fluid. Parts are counted by solid angles, A. Van Oosterom, J.
   Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125-126. */
#include "mesh.h"

#define LARGEST    0.01 /* area of all holes [area of the surface] */
#define MOST_PARTS 2000
#define REPAIR     "; repair it with a program such as MeshLab or Blender"

static void Fail(char fault[FAULT], const char what[], PetscInt n, const PetscReal place[3])
{
  (void)snprintf(fault, FAULT, "it has %" PetscInt_FMT " %s, one at (%.4g, %.4g, %.4g)" REPAIR, n,
                 what, (double)place[0], (double)place[1], (double)place[2]);
}

/* Adds the triangles that close a rim of n corners in the order along its open sides; returns their
   area [m^2]. */
static PetscReal CloseRim(Mesh *mesh, PetscInt n, const PetscInt rim[])
{
  PetscReal area = 0.0, normal[3];

  for (PetscInt k = 1; k + 1 < n; k++) {
    const PetscReal *x[3];
    PetscInt        *corner = &mesh->corner[3 * mesh->triangles];

    corner[0] = rim[0];
    corner[1] = rim[k + 1];
    corner[2] = rim[k];
    area += MeshTriangle(mesh, mesh->triangles++, x, normal);
    mesh->closed++;
  }
  return area;
}

/* Closes all holes: follows open sides from corner to corner, and closes a rim when a corner is met
   again. */
static PetscErrorCode CloseRims(Mesh *mesh, PetscInt open)
{
  const PetscInt given = mesh->triangles;
  PetscInt      *side, *next, *path, *place, n = 0; /* place: of a corner in the path, from 1 */
  PetscReal      area = 0.0, hole = 0.0, normal[3];

  PetscFunctionBegin;
  PetscCall(
      PetscMalloc4(mesh->corners, &side, 3 * given, &next, open + 1, &path, mesh->corners, &place));
  PetscCall(PetscRealloc(sizeof(PetscInt) * 3 * (size_t)(given + open), &mesh->corner));
  PetscCall(PetscRealloc(sizeof(PetscInt) * 3 * (size_t)(given + open), &mesh->across));
  for (PetscInt c = 0; c < mesh->corners; c++) {
    side[c]  = -1;
    place[c] = 0;
  }
  for (PetscInt s = 0; s < 3 * given; s++) {
    const PetscReal *x[3];

    if (s % 3 == 0) area += MeshTriangle(mesh, s / 3, x, normal);
    if (mesh->across[s] >= 0) continue;
    next[s]               = side[mesh->corner[s]];
    side[mesh->corner[s]] = s;
  }
  for (PetscInt first = 0; first < mesh->corners; first++) {
    if (side[first] < 0) continue;
    for (PetscInt c = first; side[c] >= 0;) {
      const PetscInt s = side[c], to = mesh->corner[s % 3 == 2 ? s - 2 : s + 1];

      if (!place[c]) {
        path[n++] = c;
        place[c]  = n;
      }
      side[c] = next[s];
      c       = to;
      if (!place[to]) continue;
      hole += CloseRim(mesh, n - place[to] + 1, &path[place[to] - 1]);
      for (const PetscInt kept = place[to] - 1; n > kept;) place[path[--n]] = 0;
    }
  }
  mesh->hole = hole / area;
  PetscCall(PetscFree4(side, next, path, place));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the solid angle of a triangle as seen from x, over 4 pi. */
static PetscReal SolidAngle(const Mesh *mesh, PetscInt t, const PetscReal x[3])
{
  PetscReal r[3][3], size[3], dot[3], triple = 0.0;

  for (PetscInt k = 0; k < 3; k++) {
    const PetscReal *c = &mesh->x[3 * mesh->corner[3 * t + k]];

    for (PetscInt a = 0; a < 3; a++) r[k][a] = c[a] - x[a];
    size[k] = PetscSqrtReal(PetscSqr(r[k][0]) + PetscSqr(r[k][1]) + PetscSqr(r[k][2]));
  }
  for (PetscInt k = 0; k < 3; k++) {
    const PetscInt b = (k + 1) % 3, c = (k + 2) % 3;

    dot[k] = r[b][0] * r[c][0] + r[b][1] * r[c][1] + r[b][2] * r[c][2];
    triple += r[0][k] * (r[1][b] * r[2][c] - r[1][c] * r[2][b]);
  }
  return PetscAtan2Real(triple, size[0] * size[1] * size[2] + dot[0] * size[0] + dot[1] * size[1] +
                                    dot[2] * size[2]) /
         (2.0 * PETSC_PI);
}

/* Turns parts with a negative volume, and then cavities, around. */
static PetscErrorCode TurnOutward(Mesh *mesh, PetscInt parts, const PetscInt part[],
                                  char fault[FAULT])
{
  PetscReal *volume, *inside;
  PetscInt  *first;

  PetscFunctionBegin;
  PetscCall(PetscCalloc3(parts, &volume, parts, &inside, parts, &first));
  for (PetscInt t = mesh->triangles - 1; t >= 0; t--) {
    const PetscReal *x[3];
    PetscReal        normal[3];
    const PetscReal  area = MeshTriangle(mesh, t, x, normal);

    for (PetscInt a = 0; a < 3; a++)
      volume[part[t]] += area * normal[a] * (x[0][a] - mesh->lo[a]) / 3.0;
    first[part[t]] = t;
  }
  for (PetscInt t = 0; t < mesh->triangles; t++)
    if (volume[part[t]] < 0.0) MeshReverse(mesh, t);
  for (PetscInt p = 0; p < parts; p++) {
    const PetscReal *x = &mesh->x[3 * mesh->corner[3 * first[p]]];

    if (PetscAbsReal(volume[p]) < 1e-12 * PetscPowRealInt(mesh->extent, 3))
      Fail(fault, "parts without volume", 1, x);
    for (PetscInt t = 0; t < mesh->triangles && parts > 1; t++)
      if (part[t] != p) inside[p] += SolidAngle(mesh, t, x);
  }
  for (PetscInt t = 0; t < mesh->triangles; t++)
    if ((PetscInt)PetscFloorReal(inside[part[t]] + 0.5) % 2) MeshReverse(mesh, t);
  PetscCall(PetscFree3(volume, inside, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks a surface without open sides, and turns it outward. */
static PetscErrorCode Finish(Mesh *mesh, PetscInt parts, const PetscInt part[], char fault[FAULT])
{
  PetscInt  open = 0, many = 0, left, pinch;
  PetscReal place[3];

  PetscFunctionBegin;
  PetscCall(MeshTurnFlat(mesh, &left, &open, &many, place));
  if (left || open || many) {
    Fail(fault, "triangles without area that cannot be left out", PetscMax(left, open + many),
         mesh->x);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MeshFindPinch(mesh, &pinch));
  if (pinch >= 0) Fail(fault, "corners in which parts touch", 1, &mesh->x[3 * pinch]);
  else if (parts > MOST_PARTS) Fail(fault, "parts, over 2000", parts, mesh->x);
  else PetscCall(TurnOutward(mesh, parts, part, fault));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MeshClose - Closes the small holes of a surface, gives its triangles one orientation, and turns
   it outward. Output: fault - if holes are larger than 1 % of the area, more than two triangles
   meet at a side, a part has one side only or no volume, or parts touch in a corner. */
PetscErrorCode MeshClose(Mesh *mesh, char fault[FAULT])
{
  PetscInt  open, many, parts, *part;
  PetscReal place[3];
  PetscBool good;

  PetscFunctionBegin;
  PetscCall(MeshConnect(mesh, &open, &many, place));
  PetscCall(PetscMalloc1(mesh->triangles + open, &part));
  PetscCall(MeshOrient(mesh, part, &parts, &good));
  if (open && good && !many) {
    const PetscInt sides = open;

    PetscCall(CloseRims(mesh, open));
    if (mesh->hole > LARGEST) {
      Fail(fault, "open sides, of holes above 1 % of its area", sides, place);
    } else {
      PetscCall(MeshConnect(mesh, &open, &many, place));
      PetscCall(MeshOrient(mesh, part, &parts, &good));
      if (open) Fail(fault, "open sides", sides, place);
    }
  }
  if (many) Fail(fault, "sides where more than two triangles meet", many, place);
  else if (!good) Fail(fault, "part with one side only, as a Moebius strip has", 1, mesh->x);
  if (!*fault) PetscCall(Finish(mesh, parts, part, fault));
  PetscCall(PetscFree(part));
  PetscFunctionReturn(PETSC_SUCCESS);
}
