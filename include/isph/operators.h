/*
  Operators: sparse matrices from neighbours.

  An operator acts on an unknown field f on fluid particles and on given data e on wall particles:

    (op f)_i = sum_j A_ij f_j + sum_w B_iw e_w,

  A over fluid, B over wall particles. A row function computes the weights of each row from a
  gathered stencil. Weights act on differences f_j - f_i, so constants are in the null space. The
  wall treatment decides the equation of a wall neighbour in the row. Formulas: docs/theory.md,
  sections 3 to 6.
*/
#ifndef ISPH_OPERATORS_H
#define ISPH_OPERATORS_H

#include "isph/forms.h"

/* Vectors over own fluid or own wall particles; array NULL: the vector allocates its storage. */
PetscErrorCode FluidVec(const Particles *particles, PetscReal array[], Vec *v);
PetscErrorCode WallVec(const Particles *particles, Vec *v);
PetscErrorCode LocalValues(const Particles *particles, Vec f, Vec walls, PetscInt step,
                           PetscReal value[]);
PetscErrorCode FluidSum(const Particles *particles, Vec f, PetscBool squared, PetscReal *sum);
PetscErrorCode FluidRemoveMean(const Particles *particles, Vec f);

/* A sparsity pattern. All operators have the same neighbours and share it. */
typedef struct {
  PetscInt *row;   /* compressed rows, global columns ascending */
  PetscInt *col;   /* global columns; NULL: no matrix needs them */
  PetscInt *local; /* local index of a particle of each column */
  PetscInt  n, capacity;
} Pattern;

#define RUN_LANES 8 /* rows of a run that products treat together */

typedef struct FittedRows FittedRows; /* rows made from fits, see src/fits/fitted.c */

/* A row of fits that products make and no array stores; the gradient along axis a is
   FIT_GRADIENT + a. */
typedef enum { FIT_STORED, FIT_FILTER, FIT_GRADIENT } FitRow;

/* The rows of all operators, and the values of a field by local index that their products read. */
typedef struct {
  Pattern   fluid, walls;
  PetscBool has_columns; /* patterns have global columns, for matrices */
  PetscBool repeats;     /* equal rows of particles on a lattice are stored once */
  PetscInt *first;       /* of each row over fluid: its first weight in AffineOperator.a */
  PetscInt  n_weights;   /* of rows that are stored, if they repeat */
  PetscInt  n_runs, runs_capacity, (*run)[2]; /* first row and number of rows, see FindRuns() */
  PetscInt  weights_capacity;                 /* of AffineOperator.a, over its width */
  PetscInt  walls_capacity;                   /* of AffineOperator.b, over its width */
  PetscInt *apart;   /* of each row: its first slot in AffineOperator.apart; -1: shared */
  PetscInt  n_apart; /* slots of all rows apart */
  PetscInt  rows_capacity, apart_capacity;
  const Particles *particles; /* of the last assembly */
  PetscReal       *value;     /* of a field, for all local particles */
  PetscInt         capacity;  /* of value */
  FittedRows      *fitted;    /* NULL: all rows are stored */
} OperatorRows;

/* An operator: its values in the slots of the shared rows, and matrices if a solver needs them. Far
   from walls some operators have equal rows: one of them stores these, and is the twin of the
   others, which store rows apart only. See ShareAllRows(). */
typedef struct AffineOperator {
  PetscBool     needed;
  PetscInt      width; /* values in each slot of the pattern: 1, or dim^2 for coupled
                             components */
  PetscReal    *a, *b; /* over fluid, over walls */
  PetscReal    *apart; /* over fluid, of rows that neither the twin stores nor fits make */
  FitRow        fitted;
  PetscBool     has_matrices;
  Mat           A, B;                /* fluid x fluid, fluid x wall (NULL without walls) */
  OperatorRows *rows;                /* rows of products; NULL: products need the matrices */
  const struct AffineOperator *twin; /* stores the shared rows; NULL: the operator itself */
} AffineOperator;

/* Layout of a block of operators, and its units: scale times the factors of rows and of columns. */
typedef struct {
  PetscInt  rows, cols; /* interlaced components: 1 or dim */
  PetscReal scale;
  Vec       row_units, col_units; /* NULL: 1 */
} AffineLayout;

/* AffineRow - Returns the weights of row i over fluid, in the order of the pattern; not
   collective */
static inline PetscReal *AffineRow(const OperatorRows *rows, const AffineOperator *op, PetscInt i)
{
  if (op->apart && rows->apart[i] >= 0) return op->apart + rows->apart[i];
  return (op->twin ? op->twin : op)->a + op->width * rows->first[i];
}

/* Operators that the scheme and the scene need; no other operator is assembled. */
typedef enum {
  NEED_VISCOSITY     = 1 << 0, /* visc */
  NEED_PRESSURE      = 1 << 1, /* ppe, grad_p and div */
  NEED_GRADIENT_U    = 1 << 2, /* grad_u */
  NEED_FILTER_U      = 1 << 3, /* filter_u */
  NEED_FILTER_P      = 1 << 4, /* filter_p */
  NEED_CONCENTRATION = 1 << 5, /* concentration and its gradient */
  NEED_FREE_GRAD_P   = 1 << 6, /* grad_p from fluid alone: the wall pressure gradient is unknown */
  NEED_MATRICES      = 1 << 7, /* PETSc matrices of all operators */
  NEED_STREAMS       = 1 << 8, /* no operator: the scheme gathers stencils and applies rows itself,
                                  the rows of visc among them */
  NEED_CORRECTION    = 1 << 9  /* no operator: kernels are corrected by default */
} Need;

/* The chosen discretisation in space. */
typedef struct {
  const KernelRow     *kernel;
  LaplacianForm        visc, ppe;
  const CorrectionRow *correction; /* as typed; forms that do not accept it have none */
  const GradientRow   *gradient;
  const WallRow       *wall;               /* NULL: no walls */
  PetscBool            wall_surface;       /* a layer of particles on walls before the dummies */
  PetscBool            visc_is_laplacian;  /* visc is lap u */
  PetscBool            components_coupled; /* visc couples components: viscous_block.c */
  PetscInt             degree;             /* of least-squares fits */
  PetscInt             surface_degree;     /* of fits of particles below a free surface */
  PetscReal            h_over_dx;          /* smoothing length over a particle's spacing [-] */
  PetscReal            h, radius; /* of the coarsest particles; radius of the support [m] */
  PetscReal reach; /* largest distance at which assembly reads a particle; width of the halo [m] */
} OperatorForms;

/* Concentration of own fluid particles, C_i = sum_j V_j W_ij with the fluid beyond walls. */
typedef struct {
  PetscReal *value;                  /* C [-] */
  PetscReal *gradient[ISPH_MAX_DIM]; /* grad C [1/m] */
} Concentration;

/* Free surfaces at the present positions; arrays by local index, halo included. */
typedef struct {
  PetscInt   capacity;
  PetscReal *kind;      /* SurfaceKind of fluid particles, a whole number */
  PetscReal *normal;    /* out of the fluid, at [i dim + a]; of no meaning inside */
  PetscReal *curvature; /* sum of the principal curvatures, own particles [1/m] */
  PetscBool *contact;   /* of own particles: at a contact line, but in no nose */
  PetscBool  there;     /* a fluid particle of any rank is on the surface, or isolated */
  PetscBool  has_rough; /* a fluid particle of any rank is rough, or paired */
  PetscReal  tension;   /* surface tension; 0: none [N/m] */
  PetscBool  fitted; /* fits of the viscous term have its condition; else pair forces everywhere */
  PetscReal *paired; /* not 0: own particle has pair forces, see BurstSolve(); NULL: none */
} FreeSurface;

typedef struct Assembly Assembly; /* workspace of a row, see src/rows/assembly.h */

/* Operators of a velocity component; wall data: u_wall,c, or n.grad u_c if that is given. */
typedef struct {
  AffineOperator visc;                 /* lap u_c, or div(nu grad u_c)/scene->nu [m^-2] */
  AffineOperator grad_u[ISPH_MAX_DIM]; /* du_c/dx_a */
  AffineOperator filter_u;             /* residual of the fit of u_c [-] */
} VelocityOperators;

typedef struct {
  OperatorForms forms;
  unsigned      needs; /* bits of Need */

  VelocityOperators velocity[ISPH_MAX_DIM]; /* of component c: OperatorsOfVelocity() */
  PetscInt          n_velocity; /* 1, or dim if a boundary has equations for each component */
  AffineOperator    ppe;        /* -dx_i^2 lap p [-]; wall data: WallValues.p */
  Vec               ppe_scale;  /* of its rows, -dx_i^2 [m^2] */
  AffineOperator    grad_p[ISPH_MAX_DIM]; /* dp/dx_a; wall data: WallValues.p */
  AffineOperator    div[ISPH_MAX_DIM];    /* (D u)_i = sum_c div[c] u_c; wall data: u_wall,c */
  AffineOperator    filter_p;             /* residual of the fit of p [-]; wall data: p if given */
  AffineOperator    first_pass[ISPH_MAX_DIM];  /* G_a of a composed form, of each component [1/m] */
  AffineOperator    second_pass[ISPH_MAX_DIM]; /* D_a; not needed: that of the first pass */
  OperatorRows      rows;
  Concentration     concentration;
  FreeSurface      *free; /* NULL: the fluid has no free surface */

  PetscInt  epoch, moved;     /* stamps of the particles at the last assembly */
  PetscInt  assemblies;       /* stamp of the matrices: changes with each assembly */
  PetscInt  regularised_rows; /* fits of the last assembly whose points did not determine them */
  Assembly *work;
} Operators;

/* OperatorsOfVelocity - Returns the operators of velocity component c; not collective */
static inline const VelocityOperators *OperatorsOfVelocity(const Operators *ops, PetscInt c)
{
  return &ops->velocity[ops->n_velocity == 1 ? 0 : c];
}

/* PairViscosity - Returns the viscosity of a pair of particles, the harmonic mean of both
   viscosities: P. W. Cleary, J. J. Monaghan (1999); not collective */
static inline PetscReal PairViscosity(PetscReal own, PetscReal other)
{
  return 2.0 / (1.0 / own + 1.0 / other);
}

unsigned       SceneNeeds(const Scene *scene);
PetscErrorCode OperatorsCreate(const Scene *scene, unsigned needs, Operators **ops);
PetscErrorCode OperatorsDestroy(Operators **ops);
const char    *OperatorsCorrection(const Operators *ops);
PetscErrorCode OperatorsDegree(PetscInt *degree);
PetscErrorCode OperatorsPlacement(const Scene *scene, const Operators *ops, WallPlacement *walls);
PetscErrorCode OperatorsAssemble(const Scene *scene, const Particles *particles,
                                 const Neighbors *neighbors, Operators *ops, PetscBool *changed);

/* Rows as streams, see src/rows/stream.c. */
#define STREAM_MARGIN 0.6 /* approach of two particles within a step that the halo allows [dx] */
typedef PetscErrorCode (*StreamRow)(Stencil *stencil, void *ctx);
PetscErrorCode OperatorsStream(const Scene *scene, const Particles *particles,
                               const Neighbors *neighbors, const Operators *ops, StreamRow Row,
                               void *ctx);
PetscErrorCode OperatorsStreamFactors(const Scene *scene, const Particles *particles,
                                      const Neighbors *neighbors, Operators *ops);
void           KernelGradients(Stencil *stencil, unsigned correction, PetscReal *c[]);
void           StencilGradients(Stencil *stencil, unsigned correction);

PetscErrorCode AffineApply(const AffineOperator *op, Vec f, Vec walls, Vec y);
PetscErrorCode AffineApplyAdd(const AffineOperator *op, Vec f, Vec walls, Vec y);
PetscErrorCode AffineBlock(const Particles *particles, const OperatorRows *rows,
                           const AffineLayout *by, const AffineOperator op[], Mat *block);
PetscErrorCode AffineSystemCreate(const AffineOperator *op, MatType type, Mat *J);
PetscErrorCode AffineSystemSet(const AffineOperator *op, PetscReal shift, PetscReal scale, Mat J);
PetscErrorCode AffineSystemFlatten(Mat J, Mat *flat);
#define MAT_FLATTEN "MatFlatten_C" /* of a shell: creates a matrix with its entries */
PetscErrorCode AffineApplyWalls(const AffineOperator *op, Vec walls, Vec y);
PetscErrorCode AffineApplyAll(PetscInt n, const AffineOperator *const op[], Vec f, Vec walls,
                              const Vec y[]);

#define AFFINE_MOST (ISPH_MAX_DIM + 2) /* operators in one pass: a gradient, viscosity, filter */

/* Products of n operators with each of 1 or dim fields, which have wall data. */
typedef struct {
  PetscInt fields, n;
  const AffineOperator
      *op[ISPH_MAX_DIM][AFFINE_MOST]; /* at [field][operator]; of each kind alike */
  Vec  f[ISPH_MAX_DIM], walls[ISPH_MAX_DIM];
  Vec  y[ISPH_MAX_DIM][AFFINE_MOST];
} AffineProducts;
PetscErrorCode AffineApplyFields(const AffineProducts *products);

PetscErrorCode OperatorsScaleViscosity(const Scene *scene, const Particles *particles,
                                       Operators *ops);

/*
  Values at boundaries: the wall data e of the operators, an entry for each own wall particle, as
  its boundary gives them (SceneWallVelocity(), SceneWallPressure()). They are valid for an epoch.
*/
typedef struct {
  PetscInt  epoch;           /* epoch of the vectors; 0: no vectors */
  Vec       u[ISPH_MAX_DIM]; /* velocity [m/s], or n.grad of a component [1/s] */
  Vec       p;               /* n.grad p [Pa/m] or p [Pa] of the present pressure, as the boundary's
                                equation is */
  Vec       p_step;          /* its gain in the present step */
  PetscReal speed_bound;     /* largest speed that walls can have driven so far [m/s] */
} WallValues;

PetscErrorCode FreeSurfaceFind(const Scene *scene, const Particles *particles,
                               const Neighbors *neighbors, const OperatorForms *forms,
                               FreeSurface *free);
PetscErrorCode FreeSurfaceFree(FreeSurface *free);
PetscInt       FreeSurfaceOpenings(const Scene *scene, const Particles *particles,
                                   const Neighbors *neighbors, PetscInt i);
PetscBool      FreeSurfaceTouches(const Scene *scene, const Particles *particles,
                                  const Neighbors *neighbors, const FreeSurface *free, PetscInt i,
                                  PetscInt wall);
PetscInt       SurfaceTangents(PetscInt dim, const PetscReal normal[], PetscReal t[][ISPH_MAX_DIM]);
PetscInt       FreeSurfaceNearestWall(const Scene *scene, const Particles *particles,
                                      const Neighbors *neighbors, PetscInt i, PetscReal most);

/* FreeSurfaceHolds - Returns true if a fluid particle is on a free surface or isolated; free: NULL
   without free surfaces; not collective */
static inline PetscBool FreeSurfaceHolds(const FreeSurface *free, PetscInt i)
{
  return free && free->kind[i] != SURFACE_INSIDE;
}

/* FreeSurfacePressure - Returns the pressure of the surface tension at own particle i on a free
   surface; isolated particles have none [Pa]; not collective */
static inline PetscReal FreeSurfacePressure(const FreeSurface *free, PetscInt i)
{
  return free->tension == 0.0 || free->kind[i] == SURFACE_ISOLATED
             ? 0.0
             : free->tension * free->curvature[i];
}

/* FreeSurfaceIsPaired - Returns true if the present step has pair forces on own particle i in place
   of a fit, see BurstSolve(); not collective */
static inline PetscBool FreeSurfaceIsPaired(const FreeSurface *free, PetscInt i)
{
  return free->paired && free->paired[i] != 0.0 ? PETSC_TRUE : PETSC_FALSE;
}

/* FreeSurfaceIsRough - Returns true if a fluid particle is where no smooth surface passes; not
   collective */
static inline PetscBool FreeSurfaceIsRough(const FreeSurface *free, PetscInt i)
{
  return free->kind[i] == SURFACE_ROUGH || free->kind[i] == SURFACE_ISOLATED;
}
PetscBool OperatorsStressSurface(const Operators *ops);
PetscBool OperatorsBesideSurface(const Operators *ops, PetscInt i);
void      OperatorsForget(Operators *ops);

PetscErrorCode WallValuesRenumber(const Scene *scene, const Particles *particles,
                                  WallValues *walls);
PetscErrorCode WallValuesSetVelocity(const Scene *scene, Particles *particles, PetscReal t,
                                     PetscReal projection_factor, WallValues *walls);
PetscErrorCode WallValuesSetPressure(const Scene *scene, const Particles *particles, PetscReal t,
                                     PetscReal share, WallValues *walls);
PetscErrorCode WallValuesStepPressure(const Scene *scene, const Particles *particles, PetscReal t,
                                      WallValues *walls);
PetscErrorCode WallValuesFree(WallValues *walls);

/* Gradients of the velocity at own fluid particles first, ..., first + count - 1. */
typedef struct {
  PetscInt   first, count;
  PetscReal *gradient;   /* du_c/dx_a of particle first + i at [(i dim + c) dim + a] [1/s] */
  PetscReal *difference; /* of two fits, at [i] [1/s] */
} GradientComparison;

PetscErrorCode OperatorsCompareGradients(const Scene *scene, const Particles *particles,
                                         const Neighbors *neighbors, Operators *ops,
                                         const GradientComparison *of);
PetscErrorCode OperatorsStrainRate(const Operators *ops, const Particles *particles, const Vec u[],
                                   const Vec walls[], PetscReal g[]);
PetscErrorCode OperatorsFollowStrain(const Scene *scene, Particles *particles,
                                     const WallValues *walls, const Vec u[], Operators *ops);
PetscErrorCode VelocityVec(const Particles *particles, Vec *v);
PetscErrorCode VelocityVecRepeat(const Particles *particles, Vec factor, Vec *v);
PetscErrorCode WallVelocityVec(const Particles *particles, Vec *v);
PetscErrorCode UnknownsVec(const Particles *particles, Vec *v);
PetscErrorCode VectorsCheckType(MPI_Comm comm);

PetscErrorCode PatternBegin(Pattern *pattern, PetscBool has_columns, PetscInt rows,
                            PetscInt entries);
PetscBool PatternRow(Pattern *pattern, PetscInt i, const PetscInt cols[], const PetscInt local[],
                     PetscInt n, PetscInt slot[]);
PetscErrorCode PatternMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                          PetscReal values[], Mat *A);
PetscErrorCode PatternMatSet(const Pattern *pattern, const PetscReal values[], Mat A);
PetscErrorCode PatternFree(Pattern *pattern);

#endif
