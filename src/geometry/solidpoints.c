/* Points on the surfaces of solids whose numbers cannot be told one by one: all points for a
   spacing are computed when one is first asked for, and kept with the scene. */
#include "curves.h"

/* SolidCreate - Gives a body the data of a solid; returns NULL or a fault */
const char *SolidCreate(void (*Fill)(const Body *body, SurfacePoints *points), Body *body)
{
  Solid *solid;

  if (PetscNew(&solid) || BodyStoreAdd(solid, body->store)) return "there is no memory for it";
  solid->Fill = Fill;
  body->data  = solid;
  return NULL;
}

/* SolidAdd - Adds a point with its outward normal and its area [m^2] */
void SolidAdd(const PetscReal x[], const PetscReal normal[], PetscReal area, SurfacePoints *points)
{
  PetscReal *p;

  if (points->n == points->capacity) {
    points->capacity = 2 * points->capacity + 256;
    PetscCallAbort(
        PETSC_COMM_SELF,
        PetscRealloc(sizeof(*p) * SURFACE_POINT * (size_t)points->capacity, &points->number));
  }
  p = &points->number[SURFACE_POINT * points->n++];
  for (PetscInt a = 0; a < 3; a++) {
    p[a]     = x[a];
    p[3 + a] = normal[a];
  }
  p[6] = area;
}

static PetscErrorCode Make(const Body *body, PetscReal dx, SurfacePoints **made)
{
  Solid         *solid = (Solid *)body->data;
  SurfacePoints *points;

  PetscFunctionBegin;
  PetscCall(PetscNew(&points));
  points->dx = dx;
  solid->Fill(body, points);
  PetscCall(BodyStoreAdd(points, body->store));
  PetscCall(BodyStoreAdd(points->number, body->store));
  points->next  = solid->points;
  solid->points = points;
  *made         = points;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the points for a spacing; ends the run if there is no memory for them. */
static const SurfacePoints *PointsOf(const Body *body, PetscReal dx)
{
  SurfacePoints *points = ((Solid *)body->data)->points;

  while (points && points->dx != dx) points = points->next;
  if (!points) PetscCallAbort(PETSC_COMM_SELF, Make(body, dx, &points));
  return points;
}

/* SolidCount - Returns the number of points dx apart */
PetscInt SolidCount(const Body *body, PetscReal dx)
{
  return PointsOf(body, dx)->n;
}

/* SolidPoint - Computes point k; returns its area [m^2] */
PetscReal SolidPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[])
{
  const PetscReal *p = &PointsOf(body, dx)->number[SURFACE_POINT * k];

  for (PetscInt a = 0; a < 3; a++) {
    x[a]      = p[a];
    normal[a] = p[3 + a];
  }
  return p[6];
}
