/*
  Geometry: shapes of the plane and of space by the distance from their surface, bodies made of
  them, and points on surfaces. It knows neither a scene nor particles.
*/
#ifndef ISPH_GEOMETRY_H
#define ISPH_GEOMETRY_H

#include "isph/options.h"

#define BODY_PARAMETERS 64

/* Solid bodies; with `around` the fluid is inside, and the solid surrounds it. */
typedef struct Body     Body;
typedef struct ShapeRow ShapeRow;
struct ShapeRow {
  const char     *name, *brief, *citation;
  PetscInt        fewest, most;   /* allowed numbers of parameters, at most BODY_PARAMETERS */
  PetscBool       round;          /* invariant under rotation about an axis along z through its
                                         centre */
  const ShapeRow *outline;        /* in 3D: plane shape of a body along z, or of the meridian */
  PetscBool       revolves, ends; /* with an outline: it is a meridian; it ends inside the box */
  const char *(*Prepare)(Body *body); /* sets centre and extent; returns NULL or a fault */
  void (*Span)(const Body *body, PetscInt axis, PetscReal span[2]); /* see BodySpan() */
  PetscReal (*Distance)(const Body *body, const PetscReal x[],
                        PetscReal normal[]);         /* outside > 0 */
  PetscInt (*Count)(const Body *body, PetscReal dx); /* points on the surface */
  PetscReal (*Point)(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                     PetscReal normal[]); /* returns the length, or area, of its surface part */
};
extern const Table ShapeTable, SolidTable; /* of the plane, and of space */
struct Body {
  const ShapeRow *shape;
  PetscInt        n;
  PetscReal       parameter[2 * BODY_PARAMETERS]; /* of the shape; with a mirrored meridian [m] */
  PetscReal       centre[ISPH_MAX_DIM];           /* [m] */
  PetscReal       extent;                         /* largest distance of the surface from it [m] */
  PetscReal       ends[2]; /* along z, of a shape with an outline in 3D [m] */
  PetscBool       around;
};

PetscBool BodyReachesThrough(const Body *body, PetscInt axis);
PetscInt  BodyLines(const Body *body, PetscInt axis, PetscReal line[]);
PetscInt  ShapeRingCount(PetscReal r, PetscReal dx);
PetscReal BodyThickness(const Body *body, PetscReal dx, PetscReal limit,
                        PetscReal place[ISPH_MAX_DIM]);
void      BodySpan(const Body *body, PetscInt axis, PetscReal span[2]);
PetscInt  BodyPoints(const Body *body, PetscReal dx);
PetscReal BodyPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[]);

#endif
