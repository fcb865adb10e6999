/* Finds triangles that cross or touch others: such a surface has no clear inside. */
#include "mesh.h"

/* Returns true if the side from p to q passes through triangle t, away from its plane on both
   sides. */
static PetscBool Passes(const Mesh *mesh, PetscInt t, const PetscReal p[3], const PetscReal q[3])
{
  const PetscReal *corner = &mesh->x[3 * mesh->corner[3 * t]], tight = TIGHT * mesh->extent;
  PetscReal        from = 0.0, to = 0.0, x[3], foot[3];
  PetscInt         part;

  for (PetscInt a = 0; a < 3; a++) {
    from += (p[a] - corner[a]) * mesh->normal[3 * t + a];
    to += (q[a] - corner[a]) * mesh->normal[3 * t + a];
  }
  if (PetscMin(from, to) > -tight || PetscMax(from, to) < tight) return PETSC_FALSE;
  for (PetscInt a = 0; a < 3; a++) x[a] = p[a] + from / (from - to) * (q[a] - p[a]);
  return MeshFoot(mesh, t, x, foot, &part) < PetscSqr(0.1 * tight);
}

/* Returns true if triangles t and u cross or touch, but for a common corner or side. */
static PetscBool Cross(const Mesh *mesh, PetscInt t, PetscInt u)
{
  const PetscReal close  = PetscSqr(0.1 * TIGHT * mesh->extent);
  PetscInt        shared = 0, part;

  for (PetscInt k = 0; k < 9; k++)
    shared += mesh->corner[3 * t + k / 3] == mesh->corner[3 * u + k % 3];
  if (shared > 1) { /* folded: the normals are opposite */
    PetscReal along = 0.0;

    for (PetscInt a = 0; a < 3; a++) along += mesh->normal[3 * t + a] * mesh->normal[3 * u + a];
    return along < -1.0 + 1e-12;
  }
  for (PetscInt way = 0; way < 2; way++) {
    const PetscInt   one = way ? u : t, other = way ? t : u;
    const PetscReal *x[3];
    PetscReal        normal[3], foot[3], middle[3] = {0.0};

    (void)MeshTriangle(mesh, one, x, normal);
    for (PetscInt k = 0; k < 3; k++) {
      const PetscInt from = mesh->corner[3 * one + k], to = mesh->corner[3 * one + (k + 1) % 3];
      PetscBool      apart = PETSC_TRUE; /* without a corner of the other triangle */

      for (PetscInt q = 0; q < 3; q++)
        apart = apart && mesh->corner[3 * other + q] != from && mesh->corner[3 * other + q] != to;
      for (PetscInt a = 0; a < 3; a++) middle[a] += x[k][a] / 3.0;
      if (!apart) continue;
      if (Passes(mesh, other, x[k], x[(k + 1) % 3]) ||
          MeshFoot(mesh, other, x[k], foot, &part) < close)
        return PETSC_TRUE;
    }
    if (MeshFoot(mesh, other, middle, foot, &part) < close) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns the number of triangles behind t in the list that cross it. */
static PetscInt CrossingsOf(const Mesh *mesh, PetscInt t)
{
  const PetscReal tight = TIGHT * mesh->extent;
  PetscInt        stack[64], n = 0, found = 0;

  stack[n++] = 0;
  while (n) {
    const MeshNode *node  = &mesh->node[stack[--n]];
    PetscBool       apart = node->to <= t + 1;

    for (PetscInt a = 0; a < 3 && !apart; a++) {
      const PetscInt *c = &mesh->corner[3 * t];
      const PetscReal p = MeshAlong(node, a, &mesh->x[3 * c[0]]),
                      q = MeshAlong(node, a, &mesh->x[3 * c[1]]),
                      r = MeshAlong(node, a, &mesh->x[3 * c[2]]);

      apart = PetscMin(PetscMin(p, q), r) > node->hi[a] + tight ||
              PetscMax(PetscMax(p, q), r) < node->lo[a] - tight;
    }
    if (apart) continue;
    if (node->second) {
      stack[n++] = (PetscInt)(node - mesh->node) + 1;
      stack[n++] = node->second;
      continue;
    }
    for (PetscInt u = PetscMax(node->from, t + 1); u < node->to; u++) found += Cross(mesh, t, u);
  }
  return found;
}

/* MeshCrossings - Refuses a surface that crosses or touches itself, or is folded */
PetscErrorCode MeshCrossings(const Mesh *mesh, char fault[FAULT])
{
  PetscInt found = 0, first = 0;

  PetscFunctionBegin;
  for (PetscInt t = 0; t < mesh->triangles; t++) {
    const PetscInt n = CrossingsOf(mesh, t);

    if (n && !found) first = t;
    found += n;
  }
  if (found) {
    const PetscReal *x = &mesh->x[3 * mesh->corner[3 * first]];

    (void)snprintf(fault, FAULT,
                   "%" PetscInt_FMT " pairs of its triangles cross or touch, one at (%.4g, %.4g, "
                   "%.4g); unite its parts, or repair it with a program such as MeshLab or Blender",
                   found, (double)x[0], (double)x[1], (double)x[2]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
