/*
  Rows: the forms of Laplacians and gradients, whose functions compute the weights of a row from a
  stencil, and the operators that store the rows, so that rows can write them; functions of
  operators are in operators.h.

  An operator acts on an unknown field f on fluid particles and on given data e on wall particles:

    (op f)_i = sum_j A_ij f_j + sum_w B_iw e_w,

  A over fluid, B over wall particles. Weights act on differences f_j - f_i, so constants are in the
  null space. The wall treatment decides the equation of a wall neighbour in the row. Formulas:
  theory.md, sections 3 to 6.
*/
#ifndef ISPH_ROWS_H
#define ISPH_ROWS_H

#include "isph/fits.h"

PetscErrorCode StencilCreate(PetscInt dim, Stencil **stencil);
PetscErrorCode StencilDestroy(Stencil **stencil);
PetscErrorCode StencilReserve(Stencil *stencil, PetscInt n);
void           StencilFinish(Stencil *stencil);
void StencilSetSize(const KernelRow *kernel, PetscReal h_over_dx, PetscReal dx, Stencil *stencil);
void StencilSetQuantity(const Scene *scene, FitQuantity quantity, Stencil *stencil);
void StencilSetVelocity(const Scene *scene, PetscInt c, Stencil *stencil);

/* Properties that a form of a Laplacian or a gradient declares. They decide which forms are
   chosen by default and which are refused. Tests check each property. */
typedef enum {
  FORM_NULL_CONSTANTS  = 1 << 0, /* constants vanish */
  FORM_SYMMETRIC       = 1 << 1, /* symmetric matrix for equal sizes and an uncorrected kernel */
  FORM_EXACT_LINEAR    = 1 << 2, /* on any arrangement of particles */
  FORM_EXACT_QUADRATIC = 1 << 3, /* on any arrangement of particles */
  FORM_FULL_SUPPORT    = 1 << 4, /* needs particles behind walls; ignores Stencil.equation */
  FORM_SAFE_IMPLICIT   = 1 << 5, /* the eigenvalues of -L have positive real parts */
  FORM_VARYING         = 1 << 6, /* admits a varying viscosity, averaged over each pair */
  FORM_COUPLES         = 1 << 7, /* divergence of a stress, which couples velocity components */
  FORM_MOMENTUM   = 1 << 8, /* no net force on a free cloud of equal volumes, for any velocity */
  FORM_ANGULAR    = 1 << 9, /* no net torque on it */
  FORM_DISSIPATES = 1 << 10 /* no velocity gains kinetic energy on it */
} FormProperty;
#define FORM_PROPERTY_COUNT 11
extern const char *const FormPropertyNames[FORM_PROPERTY_COUNT]; /* bit order of FormProperty */

/* Corrections of the kernel; a row of a Laplacian lists, as bits, the corrections that it
   accepts. */
typedef enum {
  CORRECTION_SHEPARD     = 1 << 0,
  CORRECTION_FIRST_ORDER = 1 << 1,
  CORRECTION_MIXED       = 1 << 2 /* first order of Shepard's kernel */
} CorrectionBit;
typedef struct {
  const char *name, *brief, *citation;
  unsigned    bit;                                            /* of CorrectionBit; 0: none */
  void (*Kernel)(Stencil *, PetscReal dW[], PetscReal ddW[]); /* in place of st->dW, st->ddW */
} CorrectionRow;
extern const Table CorrectionTable;

/*
  A form of two passes: the divergence D(S(G u)) of the local stress

    S_i = nu (g + g^T - t tr(g) I),   g = (G u)_i the velocity gradient,   t = ComposedTrace()

    (D S)_i = sum_j (S_j - S_i) c_ij,              c_ij = V_j grad_i W, corrected as in G
    (D S)_i = sum_j S_i c_ij - V_j/V_i S_j c_ji,   transposed: D = -V^-1 G^T V

  Explicit steps have such forms only; for walls see stress.c.
*/
typedef enum { GRADIENT_SPH, GRADIENT_FIRST_ORDER, GRADIENT_COUPLED } GradientChoice;
typedef struct {
  GradientChoice gradient;   /* coupled: of first order beside walls and free surfaces only */
  PetscBool      transposed; /* F = -V^-1 G^T V tau */
  PetscBool      planar;     /* in 2D the stress has no trace in the plane, otherwise none in 3D */
} ComposedForm;

/* Laplacians. w[k] multiplies f_k - f_i of neighbour k, or the given n.grad f if that is its
   equation. If the form couples components, w[(k dim + a) dim + b] multiplies (u_k - u_i)_b in
   component a. Such a form without FORM_NULL_CONSTANTS also sets own[a dim + b] of the stencil,
   which multiplies (u_i)_b. Factor() computes a number of a particle from its stencil, with the
   uncorrected kernel. It is called for all fluid particles before the rows, which then read
   st->factor of each neighbour. */
typedef struct {
  const char *name, *brief, *citation;
  unsigned    properties;  /* bits of FormProperty */
  unsigned    corrections; /* accepted corrections: bits of CorrectionBit */
  PetscErrorCode (*Row)(Stencil *stencil, PetscReal w[]);
  PetscReal (*Factor)(const Stencil *stencil); /* or NULL */
  PetscReal           grad_div; /* b of a form of one pass that approximates lap u + b grad div u */
  const ComposedForm *composed; /* NULL: one pass, by Row(); otherwise Row is NULL */
  PetscBool           weak;     /* dissipation of cells, see isph/strain.h; Row is NULL */
} LaplacianRow;
extern const Table LaplacianTable;

/* The chosen Laplacian with its correction. */
typedef struct {
  const LaplacianRow  *row;        /* NULL: not needed */
  const CorrectionRow *correction; /* NULL: none */
  PetscBool            graded;     /* particles of a pair may differ in size: unsymmetric */
  PetscReal           *factor;     /* row->Factor() by local index; NULL: none */
  PetscReal            scale;      /* multiplies all weights; 0: 1 */
} LaplacianForm;
PetscBool      LaplacianIs(const LaplacianForm *form, FormProperty property);
PetscInt       LaplacianWidth(const LaplacianForm *form, PetscInt dim);
PetscReal      ComposedTrace(const ComposedForm *form, PetscInt dim);
PetscReal      LaplacianDilatation(const LaplacianForm *form, PetscInt dim);
PetscErrorCode LaplacianWeights(const LaplacianForm *form, Stencil *stencil, PetscReal w[]);
PetscBool      LaplacianFollowsSlopes(const LaplacianForm *form, unsigned correction);

/* Gradients and divergences. Row() computes the weights g[a][k] of f_k - f_i in df/dx_a.
   DivergenceFit() computes the weights d[a][k] of (u_k - u_i)_a of fluid neighbour k, and the
   weights m[k] of the normal component n.(u_k - u_i) of wall neighbour k. */
typedef struct {
  const char *name, *brief, *citation;
  unsigned    properties; /* bits of FormProperty: constants, exactness, support */
  PetscErrorCode (*Row)(Stencil *stencil, PetscReal *g[]);
  PetscErrorCode (*DivergenceFit)(Stencil *stencil, PetscReal *d[], PetscReal m[]); /* or NULL */
} GradientRow;

extern const Table GradientTable;

void      MomentWeights(const Stencil *stencil, PetscBool walls, PetscReal weight[]);
PetscBool MomentInverse(const Stencil *stencil, const PetscReal weight[], PetscReal inverse[]);
void      ConcentrationRow(const Scene *scene, const KernelRow *kernel, const Stencil *stencil,
                           const PetscReal x[], PetscBool mirrored, PetscReal *concentration,
                           PetscReal gradient[]);

/* Wall treatments. Beta gives the velocity of a dummy in the row of each fluid particle. */
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   on_surface; /* a layer of particles on the wall, which have equations in fits */
  PetscReal (*Beta)(const Scene *scene, PetscReal distance, PetscReal depth);
  PetscBool dynamic; /* dummies have densities of their own, which -scheme wcsph computes */
} WallRow;

/* A sparsity pattern. All operators have the same neighbours and share it. */
typedef struct {
  PetscInt *row;   /* compressed rows, global columns ascending */
  PetscInt *col;   /* global columns; NULL: no matrix needs them */
  PetscInt *local; /* local index of a particle of each column */
  PetscInt  n, capacity;
} Pattern;

#define RUN_LANES 8 /* rows of a run that products treat together */

typedef struct FittedRows FittedRows; /* rows made from fits, see src/operators/fitted.c */

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
  PetscInt         rows, cols; /* interlaced components: 1 or dim */
  PetscReal        scale;
  Vec              row_units, col_units; /* NULL: 1 */
  const PetscReal *only; /* by local index: rows of 1 component, or else columns, of particles with
                            0 have no entries; NULL: all have */
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
  PetscReal            h_over_dx;          /* smoothing length over a particle's spacing [-] */
  PetscReal            h, radius; /* of the coarsest particles; radius of the support [m] */
  PetscReal reach; /* largest distance at which assembly reads a particle; width of the halo [m] */
} OperatorForms;

/* FormsKernel - Returns the chosen kernel and its size; not collective */
static inline KernelSize FormsKernel(const OperatorForms *forms)
{
  return (KernelSize){forms->kernel, forms->h_over_dx, forms->h, forms->radius};
}

/* Concentration of own fluid particles, C_i = sum_j V_j W_ij with the fluid beyond walls. */
typedef struct {
  PetscReal *value;                  /* C [-] */
  PetscReal *gradient[ISPH_MAX_DIM]; /* grad C [1/m] */
} Concentration;

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

  VelocityOperators   velocity[ISPH_MAX_DIM]; /* of component c: OperatorsOfVelocity() */
  PetscInt            n_velocity; /* 1, or dim if a boundary has equations for each component */
  AffineOperator      ppe;        /* -dx_i^2 lap p [-]; wall data: WallValues.p */
  Vec                 ppe_scale;  /* of its rows, -dx_i^2 [m^2] */
  AffineOperator      grad_p[ISPH_MAX_DIM]; /* dp/dx_a; wall data: WallValues.p */
  AffineOperator      div[ISPH_MAX_DIM];    /* (D u)_i = sum_c div[c] u_c; wall data: u_wall,c */
  AffineOperator      filter_p; /* residual of the fit of p [-]; wall data: p if given */
  OperatorRows        rows;
  Concentration       concentration;
  struct StrainCells *strain;      /* of a weak form; NULL: none */
  PetscBool           cut_surface; /* its cells end at the free surface */
  Mat                 cut_part[2]; /* of visc.A if its viscosity varies: cells, tension; or NULL */

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

/* OperatorsCutFluids - Returns true if the viscous form is cut at interfaces of fluids, so that the
   divergence in each fluid has a penalty; not collective */
static inline PetscBool OperatorsCutFluids(const Scene *scene, const Operators *ops)
{
  if (ops->cut_surface) return PETSC_TRUE;
  return SceneFluids(scene) > 1 && !SceneMixes(scene) && ops->forms.visc.row &&
         ops->forms.visc.row->weak;
}

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

/* Gradients of the velocity at own fluid particles first, ..., first + count - 1. */
typedef struct {
  PetscInt   first, count;
  PetscReal *gradient;   /* du_c/dx_a of particle first + i at [(i dim + c) dim + a] [1/s] */
  PetscReal *difference; /* of two fits, at [i] [1/s] */
} GradientComparison;

PetscErrorCode OperatorsCompareGradients(const Scene *scene, const Particles *particles,
                                         const Neighbors *neighbors, Operators *ops,
                                         const GradientComparison *of);

/* Kinds of fields, by what their fits assume. */
typedef enum {
  FIELD_WHOLE_VELOCITY, /* the equations of boundaries */
  FIELD_VELOCITY,       /* the same, one-sided beside another fluid */
  FIELD_STRESS          /* no equations of boundaries; the softer of two fluids counts */
} FieldKind;

/* Gradients of fields at own fluid particles first, ..., first + count - 1 by fits. Field f of
   local particle j is value[f][j stride]. */
typedef struct {
  FieldKind        kind; /* of velocities, the fields are its components */
  PetscInt         first, count, degree, n_fields, stride;
  PetscReal        weak; /* pivot over its diagonal entry below which a degree is not determined; 0:
                            that of the operators [-] */
  const PetscReal *value[ISPH_MAX_DIM * ISPH_MAX_DIM];
  PetscReal       *gradient;   /* d f/dx_a of particle first + i at [(i n_fields + f) dim + a] */
  PetscReal       *laplacian;  /* lap f at [i n_fields + f]; NULL: not computed */
  PetscBool       *determined; /* at [i]: the points determine the degree; NULL: not wanted */
} FieldGradients;
PetscErrorCode OperatorsFitGradients(const Scene *scene, const Particles *particles,
                                     const Neighbors *neighbors, Operators *ops,
                                     const FieldGradients *of);

#endif
