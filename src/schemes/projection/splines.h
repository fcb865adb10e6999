/*
  The pressure on quadratic B-splines of a lattice that is fixed in space and coarser than the
  particles:

    p(x) = sum_q p_q psi_q(x),   G p = grad p(x_i)
    (D u)_q = -int grad psi_q . u dV + int psi_q u_w.n dA

  u in the integral is the least-squares fit of the particles' velocities at Gauss points. The
  splines sum to 1, so D conserves volume exactly: errors of single particles cancel in sums over
  splines. See docs/theory.md, section 8.
*/
#ifndef ISPH_SPLINES_H
#define ISPH_SPLINES_H

#include "projection.h"

/* A lattice of cells over the box, and its splines; spline i of an axis covers three cells. */
typedef struct {
  PetscInt  dim, cells[ISPH_MAX_DIM], count[ISPH_MAX_DIM]; /* cells and splines along each axis */
  PetscReal lo[ISPH_MAX_DIM], side[ISPH_MAX_DIM]; /* corner of the box, and of a cell [m] */
  PetscBool periodic[ISPH_MAX_DIM];
  PetscInt  N; /* all splines */
} SplineLattice;

#define SPLINES_AT 27 /* splines that are not zero at a point in 3D */

/* The splines at a point. */
typedef struct {
  PetscInt  n;                                  /* 3^dim */
  PetscInt  index[SPLINES_AT][ISPH_MAX_DIM];    /* along each axis */
  PetscReal value[SPLINES_AT];                  /* psi_q [-] */
  PetscReal gradient[ISPH_MAX_DIM][SPLINES_AT]; /* of psi_q [1/m] */
} SplineValues;

PetscErrorCode SplineLatticeSet(const Scene *scene, PetscReal ratio, SplineLattice *lattice);
PetscInt       SplineNatural(const SplineLattice *lattice, const PetscInt index[]);
void           SplineCentre(const SplineLattice *lattice, const PetscInt index[], PetscReal x[]);
void           SplinesAt(const SplineLattice *lattice, const PetscReal x[], SplineValues *values);

/* The splines of a rank: those whose centres are in its box of space. */
typedef struct {
  PetscInt first[ISPH_MAX_DIM], n[ISPH_MAX_DIM]; /* along each axis */
  PetscInt start, size;                          /* their global numbers */
} SplineBlock;

/* Points of quadrature of this rank, inside the fluid or on its boundary. */
typedef struct {
  PetscInt   n, capacity;
  PetscReal *x[ISPH_MAX_DIM]; /* [m] */
  PetscReal *weight;          /* volume over that of a cell, or area over that of its face [-] */
  PetscInt  *side;            /* of points on the boundary: side of the box */
} SplinePoints;

/* Points of Gauss from the centre of a cell, over its edge: 1/(2 sqrt(3)). */
#define GAUSS 0.28867513459481287

struct Splines {
  SplineLattice lattice;
  PetscReal     scale; /* edge of a cell of the same volume [m] */
  SplineBlock  *block; /* of all ranks */
  SplineBlock   own;
  SplinePoints  inside, boundary;

  PetscInt  epoch, moved;                       /* stamps of the particles at the last assembly */
  PetscReal lo[ISPH_MAX_DIM], hi[ISPH_MAX_DIM]; /* the rank's box when the splines were numbered */

  Mat T[ISPH_MAX_DIM]; /* points x splines: weight scale dpsi_q/dx_a */
  Mat S;               /* boundary points x splines: weight psi_q; NULL: a periodic box */
  Mat K;               /* stiffness, scale^2 int grad psi . grad psi, for the preconditioner */
  Vec mass;            /* int psi_q, over the volume of a cell */
  Mat J[ISPH_MAX_DIM]; /* fluid -> points: fit of velocity component a; a set unless components
                          differ at a boundary */
  Mat W[ISPH_MAX_DIM]; /* walls -> points */
  Mat G[ISPH_MAX_DIM]; /* splines -> fluid: gradient [1/m] */
  Mat V;               /* splines -> fluid: value */
  Mat A;               /* -scale^2 D G, as a shell */

  Vec        p, phi, b, divergence; /* coefficients: pressure [Pa], its increment, right-hand side,
                                       div u* [1/s] */
  Vec        natural;               /* the pressure in the order of the lattice: the kept state */
  VecScatter renumber;              /* p -> natural */
  Vec        points, wall_flux;     /* work: at points inside and on the boundary */
  Vec        fluid;                 /* work: at particles */
  PetscInt   fluid_epoch;           /* of the last vector */

  Pattern    fluid_pattern[ISPH_MAX_DIM], wall_pattern[ISPH_MAX_DIM], at_particles;
  PetscReal *fluid_weight[ISPH_MAX_DIM], *wall_weight[ISPH_MAX_DIM];
  PetscReal *value, *gradient[ISPH_MAX_DIM];
  PetscInt   capacity;              /* of value and gradient */
  PetscInt   assemblies, numbering; /* stamps of the matrices, and of the splines' numbers */
};

/* splinepoints.c */
PetscErrorCode SplinePointsSet(Splines *s, const Particles *p);
PetscErrorCode SplinePointsFree(SplinePoints *points);

/* splines.c, splinerows.c */
PetscErrorCode SplinesNumber(Flow *flow, Splines *s, PetscBool *changed);
PetscErrorCode SplineRowsFree(Splines *s);
PetscErrorCode SplinesAssemble(Flow *flow, Splines *s);
PetscInt       SplinesGlobal(const Splines *s, const Particles *p, const PetscInt index[]);
PetscErrorCode SplinesFree(Splines *s);

/* splinestep.c */
PetscErrorCode SplinesCreate(Flow *flow, PetscReal ratio, Splines **splines);
PetscErrorCode SplinesDestroy(Splines **splines);
PetscErrorCode SplinesStart(const Flow *flow, Splines *s);
PetscErrorCode SplinesBegin(Splines *s);
PetscErrorCode SplinesDivergence(Flow *flow, Splines *s, const Vec u[], PetscReal t, Vec d);
PetscErrorCode SplinesMatrix(Flow *flow, Splines *s);
PetscErrorCode SplinesProject(Flow *flow);
PetscErrorCode SplinesView(const Splines *s, PetscViewer viewer);

#endif
