/*
  The pressure on B-splines of a lattice that is fixed in space and coarser than the particles:

    p(x) = sum_q p_q chi_q(x),   G p = grad p(x_i)
    (D u)_q = -int grad psi_q . u dV + int psi_q u_w.n dA

  u in the integral is the least-squares fit of the particles' velocities at Gauss points. psi_q are
  quadratic, and chi_q too, but cubic with quartic fits, see SplinesSet(). psi_q sum to 1, so D
  conserves volume exactly: errors of single particles cancel in sums over splines. Beside bodies
  the splines are extended, see splineextend.c; theory.md, section 8.
*/
#ifndef ISPH_SPLINES_H
#define ISPH_SPLINES_H

#include "isph/flow.h"
#include "isph/strain.h"

/* A lattice of cells over the box, and its splines, with centres in the middle of cells: quadratic
   splines with knots between cells, or cubic splines with knots at the centres. With -spacing_wall
   the lattice is uniform in the coordinates of SceneToUniform(). */
typedef struct {
  const Scene *scene;
  PetscInt     degree;                                     /* of the splines, 2 or 3 */
  PetscInt  dim, cells[ISPH_MAX_DIM], count[ISPH_MAX_DIM]; /* cells and splines along each axis */
  PetscReal lo[ISPH_MAX_DIM], side[ISPH_MAX_DIM]; /* corner of the box, and of a cell [m] */
  PetscBool periodic[ISPH_MAX_DIM];
  PetscBool given[2 * ISPH_MAX_DIM]; /* the side gives the pressure */
  PetscInt  N;                       /* all splines */
} SplineLattice;

#define SPLINES_ALONG        4  /* splines of an axis that are not zero at a point, at most */
#define SPLINES_AT           64 /* in 3D */
#define SPLINES_AT_QUADRATIC 27
#define SPLINES_IN_PLANE     9 /* quadratic splines of the plane that are not zero at a point */

/* Returns the number of splines that are not zero at a point. */
static inline PetscInt SplinesAtPoint(const SplineLattice *lattice)
{
  const PetscInt along = lattice->degree + 1;

  return lattice->dim == 2 ? along * along : along * along * along;
}

/* The splines at a point. */
typedef struct {
  PetscInt  n;                                  /* (degree + 1)^dim */
  PetscInt  index[SPLINES_AT][ISPH_MAX_DIM];    /* along each axis */
  PetscReal value[SPLINES_AT];                  /* psi_q or chi_q [-] */
  PetscReal gradient[ISPH_MAX_DIM][SPLINES_AT]; /* of them [1/m] */
} SplineValues;

PetscErrorCode SplineLatticeSet(const Scene *scene, PetscReal ratio, SplineLattice *lattice);
PetscInt       SplineNatural(const SplineLattice *lattice, const PetscInt index[]);
void           SplineIndex(PetscInt dim, const PetscInt first[], const PetscInt n[], PetscInt k,
                           PetscInt index[]);
void           SplineCentre(const SplineLattice *lattice, const PetscInt index[], PetscReal x[]);
void           SplinePlace(const SplineLattice *lattice, const PetscInt index[], PetscReal x[]);
void           SplinesAt(const SplineLattice *lattice, const PetscReal x[], SplineValues *values);
PetscInt       SplineFirstAlong(const SplineLattice *lattice, PetscInt a, PetscReal distance);
void SplinePlaceAlong(const SplineLattice *lattice, PetscInt a, PetscReal x, PetscInt *first,
                      PetscReal *t, PetscReal *per_edge);

/* Computes the polynomials of the splines between two knots of an axis, and their derivatives. */
static inline void SplineBasis(PetscInt degree, PetscReal t, PetscReal per_edge,
                               PetscReal value[SPLINES_ALONG], PetscReal derivative[SPLINES_ALONG])
{
  const PetscReal s = 1.0 - t;

  if (degree == 3) {
    value[0]      = s * s * s / 6.0;
    value[1]      = 2.0 / 3.0 - t * t * (1.0 - 0.5 * t);
    value[2]      = 2.0 / 3.0 - s * s * (1.0 - 0.5 * s);
    value[3]      = t * t * t / 6.0;
    derivative[0] = -0.5 * s * s * per_edge;
    derivative[1] = t * (1.5 * t - 2.0) * per_edge;
    derivative[2] = s * (2.0 - 1.5 * s) * per_edge;
    derivative[3] = 0.5 * t * t * per_edge;
    return;
  }
  value[0]      = 0.5 * (1.0 - t) * (1.0 - t);
  value[1]      = 0.5 + t - t * t;
  value[2]      = 0.5 * t * t;
  derivative[0] = (t - 1.0) * per_edge;
  derivative[1] = (1.0 - 2.0 * t) * per_edge;
  derivative[2] = t * per_edge;
}

#define SPLINE_MASTERS   (27 + ISPH_MAX_DIM)                     /* of a spline, at most */
#define SPLINES_EXTENDED (SPLINE_MASTERS * SPLINES_AT_QUADRATIC) /* the most, if all have masters */

/* The splines at a point, without those that have masters. */
typedef struct {
  PetscInt  n, number[SPLINES_EXTENDED];              /* global numbers */
  PetscReal value[SPLINES_EXTENDED];                  /* [-] */
  PetscReal gradient[ISPH_MAX_DIM][SPLINES_EXTENDED]; /* [1/m] */
} SplineRow;

/* A cell that a body cuts: its 2^dim nodes, and the integrals over its fluid of the linear function
   of each node times the splines of the cell and their derivatives, over the volume of a cell.
   Nodes are centre +- reach_a in the plane, and centre +- reach_x +- reach_y +- reach_z in space.
   The integrals of spline k are at (node (1 + dim) + e) 3^dim + k, with e = 0 for the value and 1 +
   a for the derivative along axis a. */
typedef struct {
  PetscReal  centre[ISPH_MAX_DIM], reach[ISPH_MAX_DIM][ISPH_MAX_DIM]; /* [m] */
  PetscReal *integral;                                                /* [-], [1/m] */
} SplineCut;

/* The part of a boundary in a cell in 3D: integrals of the linear functions of four nodes times the
   splines of the cell and n dA, over the area of a face of a cell. */
typedef struct {
  PetscInt  cell, side;
  PetscReal x[4][ISPH_MAX_DIM]; /* nodes [m] */
  PetscReal integral[4][ISPH_MAX_DIM][SPLINES_AT_QUADRATIC];
} SplinePatch;

/* A straight part of the surface of a body in a cell of the plane. */
typedef struct {
  PetscInt  cell, side;             /* number of the boundary */
  PetscReal from[2], to[2], length; /* [m] */
  PetscReal normal[2];              /* out of the fluid */
} SplineSurface;

/* A spline whose coefficient is a sum of weights times the numbers of its masters. A spline beside
   a side that gives the pressure is a master of its own: its number is given, see
   splineextend.c. */
typedef struct {
  PetscBool composed;                              /* work: no master is a slave */
  PetscInt  n, step[SPLINE_MASTERS][ISPH_MAX_DIM]; /* masters: indices relative to the spline */
  PetscInt  master[SPLINE_MASTERS][ISPH_MAX_DIM];  /* their indices along the axes */
  PetscReal weight[SPLINE_MASTERS];
} SplineSlave;

/* Indices of the splines that add to a spline, relative to it. */
typedef struct {
  PetscInt low[ISPH_MAX_DIM], high[ISPH_MAX_DIM];
} SplineRange;

/* All splines that have masters. */
typedef struct {
  PetscInt    *slave; /* number of each spline in slaves, or SPLINE_UNUSED, SPLINE_FREE */
  PetscInt     n, capacity;
  SplineSlave *slaves;
  SplineRange *range; /* of each spline */
  PetscInt    *width; /* of each cell: extended splines that are not zero in it */
} SplineExtension;

enum { SPLINE_FAR = -2, SPLINE_NEAR = -1 };    /* cells that no body cuts: far from it, beside it */
enum { SPLINE_UNUSED = -2, SPLINE_FREE = -1 }; /* splines without masters: no fluid, an unknown */

/* Bodies in the lattice. */
typedef struct {
  PetscReal     *fraction; /* of fluid in each cell [-] */
  PetscInt      *cut;      /* number of each cell in cuts, or SPLINE_FAR, SPLINE_NEAR */
  PetscInt       n_cut, cut_capacity;
  SplineCut     *cuts;
  PetscInt       n_points, capacity;
  PetscReal     *x[2], *weight; /* work: points of quadrature in a cell of the plane [m] */
  PetscInt       n_surface, surface_capacity;
  SplineSurface *surface; /* of the plane */
  PetscInt       n_patches, patch_capacity;
  SplinePatch   *patches; /* of space */
} SplineBodies;

/* Fits of the velocity at points of quadrature: sums over particles by local index. */
typedef struct {
  PetscInt   n, capacity, *j; /* entries of all fits: particles */
  PetscReal *w;               /* their weights */
  PetscInt   points;
  PetscInt   sets;    /* components with fits of their own: 1 if boundaries make no difference */
  PetscBool  coupled; /* fits of a component have entries of the others */
  /* entries [first, last) of the fit of component [a] from component [b] at each point */
  PetscInt  *first[ISPH_MAX_DIM][ISPH_MAX_DIM], *last[ISPH_MAX_DIM][ISPH_MAX_DIM];
  PetscReal *value; /* velocity component a of the particle of local index j at [j dim + a]; work */
  PetscInt   value_capacity;
} SplineFits;

/* The splines that are not zero at the particles of a rank: a block of the lattice. In periodic
   directions its indices continue beyond the period. */
typedef struct {
  PetscInt   first[ISPH_MAX_DIM], n[ISPH_MAX_DIM], size;
  PetscReal *value; /* coefficients: sums of weight times those of the sources; work */
  PetscInt  *start, *source;
  PetscReal *weight;
  PetscInt  *number;       /* global numbers of all sources, ascending */
  Vec        coefficients; /* of all sources; work */
  VecScatter collect;      /* p -> coefficients */
} SplineWindow;

/* Places of own fluid particles or of points of quadrature in the window. */
typedef struct {
  PetscInt   n, capacity, *base;                       /* first spline that is not zero there */
  PetscReal *t[ISPH_MAX_DIM], *per_edge[ISPH_MAX_DIM]; /* see SplinePlaceAlong() [-], [1/m] */
} SplinePlaces;

/* The splines of a rank: those whose centres are in its box of space. */
typedef struct {
  PetscInt first[ISPH_MAX_DIM], n[ISPH_MAX_DIM]; /* along each axis */
  PetscInt start, size;                          /* their global numbers */
} SplineBlock;

/* Points of quadrature of this rank, inside the fluid or on its boundary. */
typedef struct {
  PetscInt   n, capacity;
  PetscReal *x[ISPH_MAX_DIM]; /* [m] */
  /* of points inside: stretch of axes about the point, by which a cell has the largest edge of all
     cells [-]; NULL: all are 1 */
  PetscReal *stretch[ISPH_MAX_DIM];
  PetscReal *weight; /* volume over that of a cell, or area over that of its face [-] */
  PetscInt  *patch;  /* of points on the boundary: row of a patch, -1: none */
  PetscReal *normal[ISPH_MAX_DIM]; /* of points on the boundary: out of the fluid; NULL: inside */
  PetscInt  *side; /* of points on the boundary: its number; of nodes in cut cells: 2^dim times
                                 the number of the cut, plus that of the node; otherwise -1 */
} SplinePoints;

/* Points of Gauss from the centre of a cell, over its edge: 1/(2 sqrt(3)). */
#define GAUSS 0.28867513459481287

/* Fluids of several densities, see splinemixture.c. */
typedef struct {
  Vec        volume;    /* W of splines [m^dim] */
  Vec        share;     /* work: of a fluid in splines [-] */
  Vec        potential; /* work: of the forces of its surface [Pa] */
  Vec        density;   /* of splines, over that of fluid 0; NULL: uniform [-] */
  Vec        all;       /* work: numbers of all splines on each rank */
  VecScatter collect;
  PetscReal *inertia;    /* rho(x_i)/rho_0 of own particles; NULL: uniform [-] */
  PetscInt   numbering;  /* stamp of the vectors */
  PetscInt   assemblies; /* stamp of the last computation */
} SplineMixture;

struct Splines {
  SplineLattice    lattice;   /* with the splines psi_q of the divergence */
  SplineLattice    pressure;  /* the same with the splines chi_q of the pressure */
  SplineBodies    *bodies;    /* NULL: none */
  SplineExtension *extension; /* NULL: no spline has masters */
  PetscBool        in_cells;  /* strain cells, cut by bodies and a free surface, have the fluid */
  PetscReal        scale;     /* edge of a cell of the same volume [m] */
  SplineBlock     *block;     /* of all ranks */
  SplineBlock      own;
  SplinePoints     inside, boundary;

  PetscInt  epoch, moved;                       /* stamps of the particles at the last assembly */
  PetscReal lo[ISPH_MAX_DIM], hi[ISPH_MAX_DIM]; /* the rank's box when the splines were numbered */

  Mat        S;            /* boundary points x splines: weight psi_q; NULL: a periodic box */
  Mat        K;            /* stiffness, scale^2 int grad psi . grad psi, for the preconditioner */
  PetscBool  has_products; /* M is needed */
  Mat        M;            /* int psi_q psi_r over the volume of a cell; NULL: not needed */
  PetscInt   products;     /* stamp of K and M */
  Vec        mass;   /* int psi_q, with bodies sum_r |int psi_q psi_r|, over the volume of a cell */
  Mat        cut[3]; /* G, D and D_w from strain cells, beside interfaces; NULL: not used */
  Mat        values; /* P E: splines -> own fluid; NULL: not needed */
  Mat        slopes; /* stiffness of velocities on splines; NULL: not needed [1/m^2] */
  Mat        surface; /* E of splinesurface.c; NULL: no free surface */
  PetscBool *slave;   /* own splines that are no unknowns there, of each fluid */
  PetscBool *layered; /* splines of each fluid, in the order of the lattice: unknowns of layers */
  Vec        layer;   /* stress of the layers, at the numbers of splines [Pa] */
  PetscInt   fluids;  /* fluids with splines of their own, below a free surface; else 1 */
  Mat        joint;   /* M of the splines of velocities, which all fluids share; NULL: M itself */
  Vec        cut_gradient; /* work: at particles */
  PetscInt   n_jumps;      /* fluids in which the pressure differs by a jump; 0: none */
  Mat (*jump)[2];          /* their jumps over fluid and walls, negative, over the density [m/s] */
  Vec *jumps;              /* coefficients of the jump in each, over fluid 0 [Pa] */
  Mat  A;                  /* -scale^2 D G; a shell for moving particles */

  SplineWindow  window;
  SplinePlaces  at, inside_at; /* chi_q at particles, psi_q at points inside */
  SplineFits    fits;
  SplineMixture mixture;

  Vec p, phi, divergence; /* coefficients: pressure, in fluid 0 [Pa], increment, div u* [1/s] */
  Vec all, b;             /* pressure, right-hand side: on a rank of its splines for each fluid */
  Vec kept;               /* state in the order of the lattice: the pressure of each spline [Pa] */
  Vec natural;            /* work: a number of each spline in the order of the lattice */
  VecScatter renumber;    /* p -> natural */
  Vec        wall_flux;   /* work: at points on the boundary */
  PetscInt   n_unused, *unused; /* own splines that are no unknowns: their equation is phi = 0 */

  PetscInt assemblies, numbering; /* stamps of fits and places, and of the splines' numbers */
  PetscInt product;               /* stamp of the fits in A */
  PetscInt in_cut;                /* stamp of the operators with `cut` */
};

/* splinebodies.c, splinesolids.c, splineextend.c */
PetscErrorCode SplineCutAdd(PetscInt dim, SplineBodies *s, SplineCut **cut);
PetscErrorCode SplineSolidsSet(const SplineLattice *l, SplineBodies *s);
PetscErrorCode SplineBodiesCreate(const Scene *scene, const SplineLattice *lattice,
                                  SplineBodies **bodies);
PetscErrorCode SplineBodiesDestroy(SplineBodies **bodies);
PetscErrorCode SplineExtensionCreate(const SplineLattice *lattice, const SplineBodies *bodies,
                                     SplineExtension **extension);
PetscErrorCode SplineExtensionDestroy(SplineExtension **extension);
PetscInt SplineOfCell(const SplineLattice *l, const PetscInt cell[], PetscInt k, PetscInt index[]);
PetscInt SplinesInCell(const SplineLattice *l, const SplineExtension *extension,
                       const PetscInt cell[], PetscInt number[]);
void     SplineRowOfPatch(const Splines *s, const Particles *p, PetscInt number, SplineRow *row);
void SplineRowAt(const Splines *s, const SplineLattice *l, const Particles *p, const PetscReal x[],
                 SplineRow *row);
PetscReal SplineSumAt(const Splines *s, const Particles *p, const PetscScalar all[],
                      const PetscReal x[], PetscReal gradient[]);
PetscInt  SplineRowWidth(const Splines *s, const SplineLattice *l, const PetscReal x[]);
PetscBool SplineNearMasters(const SplineLattice *l, const PetscBool enough[],
                            const PetscInt piece[], PetscInt q, SplineSlave *slave);
PetscBool SplineSideGives(const SplineLattice *l);
PetscBool SplineIsGiven(const SplineLattice *l, const PetscInt index[], PetscInt *side);

/* Divides the gradients of a pressure at own particles by their densities over rho_0. */
static inline void SplinesDivideByInertia(const Splines *s, PetscReal gradient[])
{
  const PetscReal *inertia = s->mixture.inertia;
  const PetscInt   dim     = s->lattice.dim;

  for (PetscInt i = 0; inertia && i < s->at.n; i++)
    for (PetscInt a = 0; a < dim; a++) gradient[dim * i + a] /= inertia[i];
}

/* Divides the rows of the velocities of particles by their densities over rho_0; collective. */
static inline PetscErrorCode SplinesDivideRows(const Splines *s, const Particles *p, Mat rows)
{
  PetscReal *const inertia[] = {s->mixture.inertia, s->mixture.inertia, s->mixture.inertia};

  return VelocityRowsDivide(p, inertia, 1.0, rows);
}

/* Computes the place of a node of a cut cell [m]. */
static inline void SplineCutNode(PetscInt dim, const SplineCut *cut, PetscInt node, PetscReal x[])
{
  for (PetscInt a = 0; a < dim; a++) {
    x[a] = cut->centre[a];
    if (dim == 2) x[a] += (node % 2 ? 1.0 : -1.0) * cut->reach[node / 2][a];
    for (PetscInt r = 0; dim == 3 && r < 3; r++)
      x[a] += ((node >> r) % 2 ? 1.0 : -1.0) * cut->reach[r][a];
  }
}

/* Returns the number of the cell that holds a point, or of the nearest one. */
static inline PetscInt SplineCellAt(const SplineLattice *lattice, const PetscReal x[])
{
  PetscInt number = 0;

  for (PetscInt a = lattice->dim - 1; a >= 0; a--) {
    const PetscReal y    = SceneToUniform(lattice->scene, a, x[a]);
    const PetscInt  cell = (PetscInt)((y - lattice->lo[a]) / lattice->side[a]);

    number = number * lattice->cells[a] + PetscMin(PetscMax(cell, 0), lattice->cells[a] - 1);
  }
  return number;
}

/* Returns the masters of a spline, NULL if it has none. */
static inline const SplineSlave *SplineSlaveAt(const Splines *s, const PetscInt index[])
{
  const PetscInt k =
      s->extension ? s->extension->slave[SplineNatural(&s->lattice, index)] : SPLINE_FREE;

  return k >= 0 ? &s->extension->slaves[k] : NULL;
}

/* splinepoints.c */
PetscReal      SplinePoint(const Splines *s, const PetscInt cell[], PetscInt corner, PetscReal x[],
                           PetscInt *node);
PetscErrorCode SplinePointsSet(Splines *s, const Particles *p);
PetscErrorCode SplinePointsFree(SplinePoints *points);

/* splinewindow.c */
PetscErrorCode SplineWindowSet(Splines *s, const Particles *p);
PetscErrorCode SplineWindowFree(SplineWindow *w);
PetscErrorCode SplineWindowSum(SplineWindow *w, Vec sum);
PetscErrorCode SplinePlacesSet(const Particles *p, Splines *s);
PetscErrorCode SplinePointPlacesSet(Splines *s);
PetscErrorCode SplinePlacesFree(SplinePlaces *at);
PetscErrorCode SplinesValue(Splines *s, Vec p, Vec value);
PetscErrorCode SplinesGradient(Splines *s, Vec p, PetscReal gradient[]);
PetscErrorCode SplinesGradientAtPoints(Splines *s, Vec p, PetscReal gradient[]);
PetscErrorCode SplinesAccelerate(Splines *s, Vec p, PetscReal factor, const Vec u[]);

/* splinefits.c, splineintegrals.c */
PetscErrorCode SplineFitsAssemble(Flow *flow, Splines *s);
PetscErrorCode SplineFitsFree(SplineFits *fits);
PetscErrorCode SplineFitsReserve(const Particles *p, SplineFits *fits);
PetscErrorCode SplinesIntegrate(const Particles *p, Splines *s, Vec d);
PetscErrorCode SplinesIntegrateField(Splines *s, const PetscReal u[], Vec d);
PetscErrorCode SplineGradientMat(const Particles *p, const Splines *s, PetscInt a, Mat *T);

/* splines.c, splinestiffness.c */
PetscErrorCode SplineMat(MPI_Comm comm, PetscInt rows, PetscInt cols, const PetscInt width[],
                         Mat *A);
PetscErrorCode SplineMatFinish(Mat A);
PetscBool      SplineOwn(const Splines *s, PetscInt k, PetscInt index[]);
PetscErrorCode SplineStiffness(Splines *s, const Particles *p);
PetscErrorCode SplineStiffnessFollow(Splines *s, const Particles *p);
PetscErrorCode SplineUnusedRows(const Splines *s, Mat A);
PetscErrorCode SplineClear(const Splines *s, PetscBool columns, PetscReal diagonal, Mat A);
PetscErrorCode SplinesAssemble(Flow *flow, Splines *s);
PetscInt       SplinesGlobal(const Splines *s, const Particles *p, const PetscInt index[]);
PetscErrorCode SplineMixtureFree(SplineMixture *m);
PetscErrorCode SplinesFree(Splines *s);

/* splinematrix.c */
PetscErrorCode SplinesBlocks(const Particles *particles, const Splines *s, Mat *G, Mat *D);
PetscErrorCode SplinesMatrix(const Particles *particles, Splines *s);
PetscErrorCode SplineProductMat(Mat left, Mat right, Mat *product);
PetscErrorCode SplineGathered(Mat P, Mat T, Mat *D);
PetscErrorCode SplineCellVolumes(const Particles *p, const StrainCells *cells, Mat all,
                                 Vec *volume);
PetscErrorCode SplinesCutAssemble(Flow *flow, Splines *s);
PetscErrorCode SplinesCutFree(Splines *s);
PetscErrorCode SplinesOfVelocity(const Flow *flow, const Mat D[2], const Vec u[], Vec d);
PetscErrorCode SplineLayerSet(const Splines *s, PetscReal base, Vec all);
PetscErrorCode SplinesExcess(const Splines *s, Vec p, Vec *excess);
PetscErrorCode SplinesPressOnWalls(const Splines *s, Vec p, PetscReal force[]);
PetscErrorCode SplinesSetJumps(const Flow *flow, const Vec u[], Splines *s);
PetscErrorCode SplinesShareOut(Splines *s);
PetscErrorCode SplinesSumFluids(const Splines *s, Vec all, Vec sum);

/* SplineIsOf - Returns true if a cell is in the fluid with the splines f; those past all fluids are
   of all */
static inline PetscBool SplineIsOf(const Splines *s, const StrainCells *cells, PetscInt c,
                                   PetscInt f)
{
  return s->fluids == 1 || f == s->fluids || cells->fluid[c] == f ? PETSC_TRUE : PETSC_FALSE;
}

/* splinelayer.c */
PetscErrorCode SplineCollect(const Particles *particles, const Splines *s, Vec own, PetscReal to[]);
PetscErrorCode SplineJoinFluids(const Splines *s, PetscBool diagonal, Mat part[], Mat *whole);
PetscErrorCode SplineLayerChoose(const Particles *particles, const StrainCells *cells, PetscInt f,
                                 const PetscReal share[], const PetscBool enough[], Splines *s);
PetscErrorCode SplineLayersAdd(const Particles *particles, const Splines *s,
                               const StrainCells *cells, PetscReal factor, PetscBool products,
                               PetscBool walls, Mat *to);

/* splinesurface.c */
PetscErrorCode SplineSurfaceRows(const Flow *flow, PetscInt n, const Mat of_fluid[], const Mat T[2],
                                 Splines *s);
PetscErrorCode SplineSurfaceStiffness(Splines *s);
PetscErrorCode SplineSurfaceFill(Splines *s, Vec p);

/* splinemixture.c */
PetscErrorCode SplinesMix(Flow *flow, Splines *s);

/* splineinverse.c */
typedef struct SplineInverse SplineInverse;

PetscErrorCode SplineInverseCreate(const Splines *s, SplineInverse **inverse);
PetscErrorCode SplineInverseDestroy(SplineInverse **inverse);
PetscErrorCode SplineInverseNumber(const Splines *s, const Particles *p, SplineInverse *inverse);
PetscErrorCode SplineInverseApply(SplineInverse *inverse, Vec b, Vec x);
PetscErrorCode SplineInverseColumn(const Splines *s, Mat column);
PetscErrorCode SplineInversePC(SplineInverse *inverse, PC pc);

/* splinestep.c */
PetscErrorCode SplinesSet(const Scene *scene, PetscReal ratio, PetscInt degree, Splines *s);
PetscErrorCode SplinesCreate(Flow *flow, PetscReal ratio, Splines **splines);
PetscErrorCode SplinesDestroy(Splines **splines);
PetscErrorCode SplinesStart(const Flow *flow, Splines *s);
PetscErrorCode SplinesBegin(Splines *s);
PetscErrorCode SplinesDivergence(Flow *flow, Splines *s, const Vec u[], PetscReal t, Vec d);
PetscErrorCode SplinesGivePressure(PetscReal t, PetscBool increment, const Splines *s, Vec v);
PetscErrorCode SplinesFollow(Splines *s);
PetscErrorCode SplinesSpread(Flow *flow, Splines *s);
PetscErrorCode SplinesLayerStress(const Flow *flow, Splines *s, Vec *stress);
PetscErrorCode SplinesPressure(const Splines *s, const Particles *particles, const PetscReal x[],
                               PetscReal *p);
PetscErrorCode SplinesView(const Splines *s, PetscViewer viewer);

/* ---- splinesearch.c: particles around the points of quadrature in a cell of the splines ---- */

#define SPLINE_ALL (-1) /* components of the velocity */

/* Points of quadrature in a cell, and the particles around them in ascending order. */
typedef struct {
  PetscInt  m;                            /* number of points */
  PetscReal at[ISPH_MAX_DIM][POINT_FITS]; /* the points [m] */
  /* of the axes about each point; stretched cells have the largest edge of all cells [-] */
  PetscReal  stretch[ISPH_MAX_DIM][POINT_FITS];
  PetscReal  reach; /* distance from each point within which all particles are listed [m] */
  PetscInt   n, walls, capacity, *j;
  PetscReal *x[ISPH_MAX_DIM]; /* positions; of wall particles: their points on the wall [m] */
  PetscBool *wall;
  PetscReal *r2,
      *part; /* of a point: squared distances, stretched [m^2], and shares in the number wanted */
  PetscInt *found; /* particles of a fit, numbers in this list */
  PetscReal last2; /* squared radius of the last fit [m^2]; 0: none */
} SplineAround;

PetscInt       SplineLeast(PetscInt dim, PetscInt degree);
PetscErrorCode SplineAroundCreate(const Flow *flow, SplineAround *around);
PetscErrorCode SplineAroundFree(SplineAround *around);
PetscErrorCode SplineAroundSet(const Flow *flow, const Splines *s, PetscInt first,
                               SplineAround *around);
PetscErrorCode SplineNearest(const Flow *flow, PetscInt i, PetscInt c, PetscInt wanted,
                             SplineAround *around, PetscReal *reach, PetscInt *n, PetscReal *R,
                             PetscBool *found);
PetscBool      SplineIsNearOblique(const Flow *flow, PetscInt i, const SplineAround *around);
PetscBool SplineFitIsShared(const Particles *p, PetscInt i, PetscInt a, PetscInt b, PetscReal R,
                            const SplineAround *around);

/* ---- splinelattice.c: the stiffness of the splines of a box in the basis that makes it diagonal
   ---- */

/* A matrix of an axis, in both orders: row by row and column by column. */
typedef struct {
  PetscInt   n;
  PetscReal *V, *transposed; /* columns of V: eigenvectors, V^T M V = I */
  PetscReal *lambda;         /* their eigenvalues, scale^2 L [-] */
} SplineAxis;

typedef struct {
  PetscInt   dim;
  PetscBool  floats; /* no side gives the pressure */
  SplineAxis axis[ISPH_MAX_DIM];
} SplineTensor;

/* splinelattice.c */
PetscErrorCode SplineTensorSet(const SplineLattice *lattice, PetscReal scale, SplineTensor *t);
PetscErrorCode SplineTensorFree(SplineTensor *t);
void SplineTensorAlong(const SplineTensor *t, const PetscInt n[], PetscInt a, PetscBool back,
                       const PetscReal from[], PetscReal to[]);
void SplineTensorDivide(const SplineTensor *t, const PetscInt first[], const PetscInt n[],
                        PetscReal value[]);

#endif
