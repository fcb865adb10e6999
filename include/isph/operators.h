/*
  Operators: from neighbours to sparse matrices.

  A quantity on fluid particles f (unknown) and data e on wall particles (given) are joined by

    (op f)_i = sum_j A_ij f_j + sum_w B_iw e_w,

  A over fluid, B over wall particles. Every row is made by one row function from one gathered
  stencil, on differences f_j - f_i, so that constants are in the null space; the wall treatment
  says what a wall neighbour means in it.
*/
#ifndef ISPH_OPERATORS_H
#define ISPH_OPERATORS_H

#include "isph/particles.h"

/* Kernels W(r) = sigma_d/h^d w(r/h), W = 0 for r >= support h. */
typedef struct {
  const char *name, *brief, *citation;
  PetscReal   support;                        /* radius of the support [h] */
  PetscReal   sigma[3];                       /* normalisation in 1, 2, 3 dimensions */
  void (*Shape)(PetscReal q, PetscReal w[3]); /* w, dw/dq, d2w/dq2 */
} KernelRow;
extern const Table KernelTable;

void KernelEvaluate(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscReal r,
                    PetscReal w[3]);

/* What the equation of a neighbour in a least-squares fit of f about particle i says. */
typedef enum {
  ROLE_VALUE,             /* f at X is the neighbour's: unknown of fluid, given on walls */
  ROLE_NORMAL_DERIVATIVE, /* n.grad f at X is given; n.f of vectors: GradientRow.DivergenceFit */
  ROLE_NONE               /* of a wall nothing is known: the fit is one of fluid alone */
} Role;

#define MLS_MAX_TERMS       19 /* X_a, X_a X_b, X_a X_b X_c, c <= b <= a, in 3D */
#define MLS_QUADRATIC_TERMS 9  /* the first two of these */
typedef struct {
  PetscBool valid;
  PetscInt  degree, terms;
  PetscReal factor[MLS_MAX_TERMS * MLS_MAX_TERMS]; /* Cholesky factor of the moment matrix */
} MlsFit;

/* The neighbourhood of one particle, gathered once and read by every row function. */
typedef struct {
  PetscInt   i, dim, n, n_wall; /* particle, neighbours, wall particles among them */
  PetscInt   capacity;
  PetscReal  radius;          /* of the support [m] */
  PetscReal  scale;           /* of equations of derivatives in fits: n.grad f times this [m] */
  PetscInt  *j;               /* local index of each neighbour */
  PetscReal *X[ISPH_MAX_DIM]; /* x_j - x_i [m] */
  PetscReal *r, *V;           /* distance [m], volume [m^dim] */
  PetscReal *W, *dW, *ddW;    /* kernel and its r-derivatives [m^-dim, ...] */
  PetscReal *corrected[2];    /* room for corrected dW and ddW */
  PetscBool *wall;            /* neighbour is a wall particle */
  PetscReal *normal[ISPH_MAX_DIM]; /* of wall neighbours, into the fluid */
  PetscInt  *side;                 /* of wall neighbours: which wall */
  PetscReal *beta;  /* of wall neighbours: f_j - f_i = beta (f_wall - f_i), see wall_points.c */
  PetscReal *share; /* of wall neighbours: in their wall's velocity at the foot of i */
  PetscBool  fits_walls;  /* wall neighbours enter fits by role, else as plain points */
  Role       role;        /* of the wall neighbours in the fit at hand */
  MlsFit     fit;         /* quadratic, of that role; shared by gradient and Laplacian */
  PetscReal  volume;      /* of the particle itself [m^dim] */
  PetscReal  self[3];     /* W, dW/dr and d2W/dr2 at r = 0 [m^-dim, ...] */
  PetscInt   regularised; /* fits so far whose points did not determine them */
} Stencil;

PetscErrorCode StencilCreate(PetscInt dim, PetscReal radius, PetscReal scale, Stencil **stencil);
PetscErrorCode StencilDestroy(Stencil **stencil);
PetscErrorCode StencilReserve(Stencil *stencil, PetscInt n);
void           StencilSetRole(Stencil *stencil, Role role);

/* What a form is declared to be; decides defaults and refusals, and the tests try every word. */
typedef enum {
  FORM_NULL_CONSTANTS  = 1 << 0, /* constants vanish */
  FORM_SYMMETRIC       = 1 << 1, /* the matrix is, with equal volumes, uncorrected */
  FORM_EXACT_LINEAR    = 1 << 2, /* on any arrangement of particles */
  FORM_EXACT_QUADRATIC = 1 << 3, /* on any arrangement of particles */
  FORM_FULL_SUPPORT    = 1 << 4, /* wants particles behind walls; cannot take wall roles */
  FORM_SAFE_IMPLICIT   = 1 << 5, /* the eigenvalues of -L have positive real parts */
  FORM_VARYING         = 1 << 6, /* takes a viscosity that varies, by the means of pairs */
  FORM_COUPLES         = 1 << 7  /* velocity components: a stress, no Laplacian of each */
} FormProperty;
#define FORM_PROPERTY_COUNT 8
extern const char *const FormPropertyNames[FORM_PROPERTY_COUNT]; /* bit order of FormProperty */

/* Corrections of the kernel that a row reads; bits that a row lists as those it can take. */
typedef enum { CORRECTION_SHEPARD = 1 << 0, CORRECTION_FIRST_ORDER = 1 << 1 } CorrectionBit;
typedef struct {
  const char *name, *brief, *citation;
  unsigned    bit;                                            /* of CorrectionBit; 0: none */
  void (*Kernel)(Stencil *, PetscReal dW[], PetscReal ddW[]); /* in place of st->dW, st->ddW */
} CorrectionRow;
extern const Table CorrectionTable;

/*
  Laplacians: w[k] multiplies f_k - f_i of neighbour k, or in a fit with wall roles the given n.grad
  f of wall neighbour k. Of forms that couple components w[(k dim + a) dim + b] multiplies
  (u_k - u_i)_b in component a.
*/
typedef struct {
  const char *name, *brief, *citation;
  unsigned    properties;  /* bits of FormProperty */
  unsigned    corrections; /* bits of CorrectionBit it can take */
  PetscErrorCode (*Row)(Stencil *stencil, PetscReal w[]);
} LaplacianRow;
extern const Table LaplacianTable;

/* A Laplacian as chosen. */
typedef struct {
  const LaplacianRow  *row;        /* NULL: not needed */
  const CorrectionRow *correction; /* NULL: none */
  PetscBool            extended;   /* walls' values follow from the fluid: no longer symmetric */
} LaplacianForm;
PetscBool      LaplacianIs(const LaplacianForm *form, FormProperty property);
PetscInt       LaplacianWidth(const LaplacianForm *form, PetscInt dim);
PetscReal      LaplacianDilatation(const LaplacianForm *form);
PetscErrorCode LaplacianWeights(const LaplacianForm *form, Stencil *stencil, PetscReal w[]);

/*
  Gradients and their divergences. Row: g[a][k] multiplies f_k - f_i in df/dx_a. DivergenceFit:
  d[a][k] multiplies (u_k - u_i)_a of fluid, m[k] the normal component n.(u_k - u_i) of wall
  neighbour k.
*/
typedef struct {
  const char *name, *brief, *citation;
  unsigned    properties; /* bits of FormProperty; of constants, exactness and support */
  PetscErrorCode (*Row)(Stencil *stencil, PetscReal *g[]);
  PetscErrorCode (*DivergenceFit)(Stencil *stencil, PetscReal *d[], PetscReal m[]); /* or NULL */
} GradientRow;
extern const Table GradientTable;

/*
  Wall treatments. Those with Extend give each wall particle one velocity, whatever reads it,

    u_w = u_wall + sum_j E_wj (u_j - u_wall),   j over fluid near the wall,

  and Extend writes row w of E; without it, and for other quantities, Beta says what fluid reads.
*/
typedef struct Extension Extension;
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   on_surface; /* one layer of particles on the wall, entering fits by role */
  PetscReal (*Beta)(const Scene *scene, PetscReal distance, PetscReal depth);
  PetscErrorCode (*Extend)(Extension *extension); /* or NULL */
  PetscReal radii, spacings;                      /* Extend looks no further [radius], + [dx] */
  PetscErrorCode (*Check)(const Scene *scene);    /* refuses scenes; NULL: takes any */
} WallRow;
extern const Table   WallTable;
extern const WallRow WallGiven; /* of patch tests, not to be chosen */

/* Vectors over own fluid or own wall particles; array NULL: storage of their own. */
PetscErrorCode FluidVec(const Particles *particles, PetscReal array[], Vec *v);
PetscErrorCode WallVec(const Particles *particles, Vec *v);
PetscErrorCode VecRemoveMean(Vec v);

void      DenseEliminate(PetscInt n, PetscReal A[], PetscInt rows, PetscReal B[]);
PetscInt  DenseCholesky(PetscInt n, PetscReal a[]);
void      DenseCholeskyRidge(PetscInt n, const PetscReal a[], PetscReal ridge, PetscReal factor[]);
void      DenseCholeskySolve(PetscInt n, const PetscReal factor[], PetscReal x[]);
PetscBool MomentInverse(const Stencil *stencil, const PetscReal weight[], PetscReal inverse[]);
void      ConcentrationRow(const Scene *scene, const KernelRow *kernel, PetscReal h,
                           const Stencil *stencil, const PetscReal x[], PetscBool mirrored,
                           PetscReal *concentration, PetscReal gradient[]);

/* One operator: its two matrices, their values in the shared pattern, and their scale. */
typedef struct {
  PetscBool  needed;
  PetscInt   width; /* values in each slot of the pattern: 1, dim^2 where components couple */
  Mat        A, B;  /* fluid x fluid, fluid x wall (NULL without walls) */
  PetscReal *a, *b;
} AffineOperator;

/* Columns of the rows of all operators: they share neighbours, so they share the pattern. */
typedef struct {
  PetscInt *row, *col; /* compressed rows, global columns ascending */
  PetscInt  n, capacity;
} Pattern;

/* Operators that a run needs; the scheme and the scene say which, and nothing else is assembled. */
typedef enum {
  NEED_VISCOSITY     = 1 << 0, /* visc */
  NEED_PRESSURE      = 1 << 1, /* ppe, grad_p and div */
  NEED_GRADIENT_U    = 1 << 2, /* grad_u */
  NEED_FILTER_U      = 1 << 3, /* filter_u */
  NEED_FILTER_P      = 1 << 4, /* filter_p */
  NEED_CONCENTRATION = 1 << 5, /* concentration and its gradient */
  NEED_FREE_GRAD_P   = 1 << 6  /* grad_p from the fluid alone: n.grad p at walls is not known */
} Need;

/* The discretisation in space as chosen from the tables. */
typedef struct {
  const KernelRow   *kernel;
  LaplacianForm      visc, ppe;
  const GradientRow *gradient;
  const WallRow     *wall;               /* NULL: no walls */
  PetscBool          wall_surface;       /* particles on the walls' surface before the dummies */
  PetscBool          visc_is_laplacian;  /* visc is lap u */
  PetscBool          components_coupled; /* visc acts on all components together: viscous_block.c */
  PetscReal          h;                  /* smoothing length [m] */
  PetscReal          radius;             /* radius of the kernel's support [m] */
  PetscReal reach; /* largest distance at which assembly reads a particle, for the halo [m] */
} OperatorForms;

/* The particle concentration of own fluid, C_i = sum_j V_j W_ij without the deficit at walls. */
typedef struct {
  PetscReal *value;                  /* C [-] */
  PetscReal *gradient[ISPH_MAX_DIM]; /* grad C [1/m] */
} Concentration;

typedef struct Assembly Assembly; /* the workspace of one row, see src/operators/assembly.h */

typedef struct {
  OperatorForms forms;
  unsigned      needs; /* bits of Need */

  AffineOperator visc; /* lap u, or div(nu grad u)/scene->nu [m^-2]; wall data: u_wall,c */
  AffineOperator ppe;  /* -dx^2 lap p [-]; wall data: n.grad p */
  AffineOperator grad_p[ISPH_MAX_DIM]; /* dp/dx_a; wall data: n.grad p */
  AffineOperator grad_u[ISPH_MAX_DIM]; /* du_c/dx_a; wall data: u_wall,c */
  AffineOperator div[ISPH_MAX_DIM];    /* (D u)_i = sum_c div[c] u_c; wall data: u_wall,c */
  AffineOperator filter_u;             /* u_c less its quadratic fit [-]; wall data: u_wall,c */
  AffineOperator filter_p;             /* p less its quadratic fit [-]; no wall data */
  Pattern        fluid, walls;
  PetscInt      *neighbor_of_slot; /* local index, where components are coupled */
  Concentration  concentration;

  PetscInt  epoch, moved;     /* stamps of the particles the operators were assembled from */
  PetscInt  assemblies;       /* stamp of the matrices: changes when they do */
  PetscInt  regularised_rows; /* fits of the last assembly that their points did not determine */
  Assembly *work;
} Operators;

unsigned       SceneNeeds(const Scene *scene);
PetscErrorCode OperatorsCreate(const Scene *scene, unsigned needs, Operators **ops);
PetscErrorCode OperatorsDestroy(Operators **ops);
const char    *OperatorsCorrection(const Operators *ops);
PetscErrorCode OperatorsPlacement(const Scene *scene, const Operators *ops, WallPlacement *walls);
PetscErrorCode OperatorsAssemble(const Scene *scene, const Particles *particles,
                                 const Neighbors *neighbors, Operators *ops, PetscBool *changed);
PetscErrorCode AffineApply(const AffineOperator *op, Vec f, Vec walls, Vec y);
PetscErrorCode AffineApplyAdd(const AffineOperator *op, Vec f, Vec walls, Vec y);

PetscErrorCode OperatorsScaleViscosity(const Scene *scene, const Particles *particles,
                                       Operators *ops);

/*
  Values at walls, one entry for each own wall particle: the wall data e of the operators. They
  belong to one epoch.
*/
typedef struct {
  PetscInt  epoch;           /* of the vectors; 0: there are none */
  Vec       u[ISPH_MAX_DIM]; /* velocity [m/s] */
  Vec       dpdn;            /* n.grad p that the pressure has [Pa/m] */
  Vec       dpdn_step;       /* gain of n.grad p in the present step [Pa/m] */
  PetscReal speed_bound;     /* fastest flow that walls have been able to make [m/s] */
} WallValues;

PetscErrorCode WallValuesRenumber(const Scene *scene, const Particles *particles,
                                  WallValues *walls);
PetscErrorCode WallValuesSetVelocity(const Scene *scene, Particles *particles, PetscReal t,
                                     PetscReal projection_factor, WallValues *walls);
PetscErrorCode WallValuesFree(WallValues *walls);

PetscErrorCode OperatorsFollowStrain(const Scene *scene, Particles *particles,
                                     const WallValues *walls, const Vec u[], Operators *ops);
PetscErrorCode VelocityVec(const Particles *particles, Vec *v);
PetscErrorCode WallVelocityVec(const Particles *particles, Vec *v);

PetscErrorCode PatternBegin(Pattern *pattern, PetscInt rows, PetscInt entries);
void PatternRow(Pattern *pattern, PetscInt i, const PetscInt cols[], PetscInt n, PetscInt slot[]);
PetscErrorCode PatternMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                          PetscReal values[], Mat *A);
PetscErrorCode PatternFree(Pattern *pattern);

#endif
