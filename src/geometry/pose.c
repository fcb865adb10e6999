/* Poses of bodies: places and attitudes, and the map between a body as typed and as it is now. */
#include "isph/geometry.h"

/* PoseStart - Sets the pose of a body as it was typed, at rest */
void PoseStart(const Body *body, Pose *pose)
{
  *pose = (Pose){.turn = {1.0}};
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) pose->x[a] = body->centre[a];
}

/* Computes a x b. */
static void Cross(const PetscReal a[], const PetscReal b[], PetscReal c[])
{
  for (PetscInt k = 0; k < 3; k++)
    c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* PoseTurn - Turns a direction of the body as typed to its present one, v + 2 q x (q x v + w v)
   with the quaternion (w, q); or back */
void PoseTurn(const Pose *pose, PetscBool back, PetscReal v[ISPH_MAX_DIM])
{
  const PetscReal w = back ? -pose->turn[0] : pose->turn[0];
  PetscReal       first[3], second[3];

  Cross(&pose->turn[1], v, first);
  for (PetscInt a = 0; a < 3; a++) first[a] += w * v[a];
  Cross(&pose->turn[1], first, second);
  for (PetscInt a = 0; a < 3; a++) v[a] += 2.0 * second[a];
}

/* PoseInto - Moves a point as if its body were where it was typed */
void PoseInto(const Body *body, PetscReal x[ISPH_MAX_DIM])
{
  if (!body->pose) return;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] -= body->pose->x[a];
  PoseTurn(body->pose, PETSC_TRUE, x);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] += body->centre[a];
}

/* PoseOut - Moves a point of a body as typed to its present place */
void PoseOut(const Body *body, PetscReal x[ISPH_MAX_DIM])
{
  if (!body->pose) return;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] -= body->centre[a];
  PoseTurn(body->pose, PETSC_FALSE, x);
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) x[a] += body->pose->x[a];
}

/* PoseRotate - Rotates a body about its centre by an angle about an axis, both in one vector
   [rad] */
void PoseRotate(const PetscReal angle[ISPH_MAX_DIM], Pose *pose)
{
  PetscReal size = 0.0, by[4], *q = pose->turn, turned[4], length = 0.0;

  for (PetscInt a = 0; a < 3; a++) size += PetscSqr(angle[a]);
  size = PetscSqrtReal(size);
  if (size == 0.0) return;
  by[0] = PetscCosReal(0.5 * size);
  for (PetscInt a = 0; a < 3; a++) by[1 + a] = PetscSinReal(0.5 * size) * angle[a] / size;
  Cross(&by[1], &q[1], &turned[1]);
  turned[0] = by[0] * q[0];
  for (PetscInt a = 1; a < 4; a++) {
    turned[0] -= by[a] * q[a];
    turned[a] += by[0] * q[a] + q[0] * by[a];
  }
  for (PetscInt a = 0; a < 4; a++) length += PetscSqr(turned[a]);
  for (PetscInt a = 0; a < 4; a++) q[a] = turned[a] / PetscSqrtReal(length);
}
