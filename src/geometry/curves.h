/* Borders in the plane, of straight lines and arcs of ellipses; solids whose points are kept. */
#ifndef ISPH_GEOMETRY_CURVES_H
#define ISPH_GEOMETRY_CURVES_H

#include "shapes.h"

#define CURVE_NODES 64

/* A line from a to b, or the arc c + p cos(w) + q sin(w) with orthogonal half axes p, q. */
typedef struct {
  PetscReal a[2], b[2];                 /* ends [m] */
  PetscReal c[2], p[2], q[2];           /* centre and half axes of an arc [m] */
  PetscReal from, to;                   /* its angles w; equal: a line [rad] */
  PetscReal length;                     /* [m] */
  PetscReal length_to[CURVE_NODES + 1]; /* of arcs of ellipses: from a to nodes even in w [m] */
  PetscReal middle[2];                  /* the whole curve is within half its length of it [m] */
} Curve;

/* Closed loops of curves with the solid on their left, and the shapes that they are made of. */
typedef struct {
  PetscInt n, parts;
  Curve   *curve;
  Body    *part;
  char    *operation; /* of each part with all before: '+', '-' or '&' */
} Border;

Curve     CurveLine(const PetscReal a[2], const PetscReal b[2]);
Curve     CurveArc(const PetscReal c[2], const PetscReal p[2], const PetscReal q[2], PetscReal from,
                   PetscReal to);
Curve     CurvePart(const Curve *c, PetscReal from, PetscReal to);
void      CurveAt(const Curve *c, PetscReal s, PetscReal x[2], PetscReal tangent[2]);
PetscReal CurveNearest(const Curve *c, const PetscReal x[2], PetscReal most, PetscReal *s);
void      EllipseFoot(PetscInt dim, const PetscReal e[], const PetscReal y[], PetscReal foot[]);
PetscReal CurvePlace(const Curve *c, PetscReal share);
PetscErrorCode BorderMake(PetscInt n, Body *body, Border **border);
PetscReal      PartsDistance(const Border *border, const PetscReal x[], PetscReal normal[]);
PetscInt       BorderLoop(const Border *border, PetscInt loop, PetscInt *first);
const Border  *BodyBorder(const Body *body);
void           BorderSpan(const Body *body, PetscInt axis, PetscReal span[2]);
PetscReal      BorderDistance(const Body *body, const PetscReal x[], PetscReal normal[]);
PetscInt       BorderCount(const Body *body, PetscReal dx);
PetscReal      BorderPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[],
                           PetscReal normal[]);

#define SURFACE_POINT 7 /* numbers of a point: place, normal, area */

/* The points for a spacing. */
typedef struct SurfacePoints SurfacePoints;
struct SurfacePoints {
  PetscReal      dx;
  PetscInt       n, capacity;
  PetscReal     *number;
  SurfacePoints *next;
};

/* A solid with an axis of its own, and a meridian (r, z) about it without the axis; or a
   compound, or a surface from a file. */
typedef struct {
  void (*Fill)(const Body *body, SurfacePoints *points);
  SurfacePoints *points;
  PetscReal      origin[3], axis[3][3]; /* the last is the axis of the meridian */
  PetscInt       n;
  Curve          meridian[3];
  Border         border; /* parts of a compound */
  void          *mesh;   /* of a file */
} Solid;

const char *SolidCreate(void (*Fill)(const Body *body, SurfacePoints *points), Body *body);
void SolidAdd(const PetscReal x[], const PetscReal normal[], PetscReal area, SurfacePoints *points);
PetscInt  SolidCount(const Body *body, PetscReal dx);
PetscReal SolidPoint(const Body *body, PetscInt k, PetscReal dx, PetscReal x[], PetscReal normal[]);

#endif
