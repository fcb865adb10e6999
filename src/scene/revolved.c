/*
  Bodies in 3D that revolve about an axis along z: balls, and shapes whose coordinates are the
  distance from the axis and the height.
*/
#include "isph/scene.h"

/* BodyBall - Sets a body to a circle about (x, y), which in 3D is a ball about (x, y, 0), in a box
   without periodic sides [m]; not collective */
void BodyBall(Body *body, PetscReal x, PetscReal y, PetscReal r)
{
  BodyCircle(body, x, y, r);
  body->ball = PETSC_TRUE;
}

/* Returns the distance from the surface of a body that revolves about the axis z, and its outward
   normal. */
static PetscReal MeridianDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  const PetscReal r    = PetscSqrtReal(PetscSqr(x[0]) + PetscSqr(x[1]));
  const PetscReal y[2] = {r, x[2]};
  PetscReal       n[ISPH_MAX_DIM];
  const PetscReal distance = body->shape->Distance(body, y, n);

  normal[0] = r > 0.0 ? n[0] * x[0] / r : n[0];
  normal[1] = r > 0.0 ? n[0] * x[1] / r : 0.0;
  normal[2] = n[1];
  return distance;
}

/* Returns the distance from the surface of a ball in 3D, and its outward normal. */
static PetscReal BallDistance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  PetscReal r = 0.0;

  for (PetscInt a = 0; a < 3; a++) {
    normal[a] = x[a] - (a < 2 ? body->centre[a] : 0.0);
    r += PetscSqr(normal[a]);
  }
  r = PetscSqrtReal(r);
  for (PetscInt a = 0; a < 3; a++) normal[a] = r > 0.0 ? normal[a] / r : a == 0;
  return r - body->extent;
}

/* BodyRevolved - Returns the distance from the surface of a ball or of a body that revolves, and
   its outward normal; not collective */
PetscReal BodyRevolved(const Body *body, const PetscReal x[], PetscReal normal[])
{
  return body->ball ? BallDistance(body, x, normal) : MeridianDistance(body, x, normal);
}
