/* Geometry: shapes of the plane and of space by the distance from their surface, bodies made of
   them, and points on surfaces. It knows neither a scene nor particles. */
#ifndef ISPH_GEOMETRY_H
#define ISPH_GEOMETRY_H

#include "isph/options.h"

/* Memory of shapes: blocks from PetscMalloc(), freed together. */
typedef struct {
  PetscInt n, capacity;
  void   **block;
} BodyStore;

/* The pose of a body: its place, its motion, and the load of the fluid. State of the run: undone
   with a step, kept in checkpoints. All members are real numbers. A point y of the body as it was
   typed, with centre c, is at x + R(turn) (y - c). */
typedef struct {
  PetscReal x[ISPH_MAX_DIM];    /* of the centre [m] */
  PetscReal turn[4];            /* attitude: a unit quaternion, real part first; 1,0,0,0 as typed */
  PetscReal u[ISPH_MAX_DIM];    /* velocity of the centre [m/s] */
  PetscReal spin[ISPH_MAX_DIM]; /* angular velocity [rad/s] */
  PetscReal rate[2][ISPH_MAX_DIM]; /* of both, of a free body [m/s^2], [rad/s^2] */
  PetscReal force[ISPH_MAX_DIM];   /* of the fluid on the body [N]; in 2D per depth, [N/m] */
  PetscReal torque[ISPH_MAX_DIM];  /* about the centre [N m]; in 2D [N] */
} Pose;

/* Solid bodies; with `around` the fluid is inside, and the solid surrounds it. */
typedef struct Body        Body;
typedef struct BodyMoments BodyMoments;
typedef struct ShapeRow    ShapeRow;
struct ShapeRow {
  const char     *name, *brief, *citation;
  PetscInt        fewest, most;   /* allowed numbers of parameters; most = 0: any number */
  PetscBool       plane;          /* of the plane, also in 3D */
  PetscBool       round;          /* invariant under rotation about an axis along z through its
                                         centre */
  const ShapeRow *outline;        /* in 3D: plane shape of a body along z, or of the meridian */
  PetscBool       revolves, ends; /* with an outline: it is a meridian; it ends inside the box */
  PetscErrorCode (*Read)(const char option[], const char text[],
                         Body *body); /* in place of numbers: reads the text after the name, sets
                                         data, centre and extent; collective; NULL: numbers */
  const char *(*Prepare)(Body *body); /* sets centre and extent; returns NULL or a fault */
  void (*Span)(const Body *body, PetscInt axis, PetscReal span[2]); /* see BodySpan() */
  PetscReal (*Distance)(const Body *body, const PetscReal x[],
                        PetscReal normal[]); /* outside > 0 */
  PetscReal (*Within)(const Body *body, const PetscReal x[], PetscReal most,
                      PetscReal normal[]);           /* see BodyWithin(); may be NULL */
  PetscInt (*Count)(const Body *body, PetscReal dx); /* points on the surface */
  PetscReal (*Point)(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                     PetscReal normal[]); /* returns the length, or area, of its surface part */
  void (*Moments)(const Body *body, BodyMoments *moments); /* NULL: from points */
};
struct Body {
  const ShapeRow *shape;
  PetscInt        n;
  PetscReal      *parameter; /* numbers of the shape, with a mirrored meridian, in `store` [m] */
  void           *data;      /* of shapes that are more than numbers, in `store` */
  BodyStore      *store;
  PetscReal       centre[ISPH_MAX_DIM]; /* [m] */
  PetscReal       extent; /* largest distance of the surface from it along an axis [m] */
  PetscReal       lo[ISPH_MAX_DIM], hi[ISPH_MAX_DIM]; /* box around the outline [m] */
  PetscReal       ends[2]; /* along z, of a shape with an outline in 3D [m] */
  PetscBool       around;
  Pose           *pose; /* of a body that moves; NULL: it stays as typed */
};

/* Moments of a body as it was typed; per length for solids that reach through the box. */
struct BodyMoments {
  PetscReal volume, error;                      /* area in 2D [m^dim]; relative error of it */
  PetscReal centroid[ISPH_MAX_DIM];             /* [m] */
  PetscReal second[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* int x_i x_j dV about it [m^(dim+2)] */
};

PetscInt       SurfaceTangents(PetscInt dim, const PetscReal n[], PetscReal t[][ISPH_MAX_DIM]);
void           BodyFindMoments(const Body *body, BodyMoments *moments);
PetscInt       BodyLoops(const Body *body);
PetscErrorCode BodyCorners(const Body *body, PetscReal spacing, PetscInt *n, PetscReal **x);
PetscErrorCode BodyCompound(PetscInt parts, const Body part[], const char operation[], Body *body,
                            const char **fault);
PetscErrorCode BodyStoreAdd(void *memory, BodyStore *store);
PetscErrorCode BodyStoreFree(BodyStore *store);
const char    *BodyNumbers(const ShapeRow *shape, PetscInt n, const PetscReal number[],
                           BodyStore *store, Body *body);
void           BodySetBox(Body *body);
PetscReal BodyWithin(const Body *body, const PetscReal x[], PetscReal most, PetscReal normal[]);
void      PoseStart(const Body *body, Pose *pose);
void      PoseTurn(const Pose *pose, PetscBool back, PetscReal v[ISPH_MAX_DIM]);
void      PoseInto(const Body *body, PetscReal x[ISPH_MAX_DIM]);
void      PoseOut(const Body *body, PetscReal x[ISPH_MAX_DIM]);
void      PoseRotate(const PetscReal angle[ISPH_MAX_DIM], Pose *pose);
PetscBool BodyReachesThrough(const Body *body, PetscInt axis);
PetscInt  BodyLines(const Body *body, PetscInt axis, PetscReal line[]);
PetscInt  ShapeRingCount(PetscReal r, PetscReal dx);
PetscReal BodyThickness(const Body *body, PetscReal dx, PetscReal limit,
                        PetscReal place[ISPH_MAX_DIM]);
void      BodySpan(const Body *body, PetscInt axis, PetscReal span[2]);
PetscInt  BodyPoints(const Body *body, PetscReal dx);
PetscReal BodyPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[]);

#endif
