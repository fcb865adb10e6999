/*
  Forms of operators: kernels, stencils with fits, and the rows of the tables of Laplacians,
  gradients and wall treatments. Formulas: docs/theory.md, sections 3 to 6.
*/
#ifndef ISPH_FORMS_H
#define ISPH_FORMS_H

#include "isph/lanes.h"
#include "isph/particles.h"

/* Kernels W(r) = sigma_d/h^d w(r/h), W = 0 for r >= support h. */
typedef struct {
  const char *name, *brief, *citation;
  PetscReal   support;  /* radius of the support [h] */
  PetscReal   sigma[3]; /* normalisation in 1, 2, 3 dimensions */
  /* Replaces n values of q in w by w(q); computes dw/dq and d2w/dq2. */
  void (*Shape)(PetscInt n, PetscReal w[], PetscReal dw[], PetscReal ddw[]);
} KernelRow;
extern const Table KernelTable;

void KernelEvaluate(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscReal r,
                    PetscReal w[3]);
void KernelEvaluateAll(const KernelRow *kernel, PetscInt dim, PetscReal h, PetscInt n,
                       const PetscReal r[], PetscReal W[], PetscReal dW[], PetscReal ddW[]);

#define MLS_MAX_DEGREE      4
#define MLS_MAX_TERMS       34    /* monomials of degree 1 to 4 in 3D */
#define MLS_QUADRATIC_TERMS 9     /* X_a, X_a X_b in 3D */
#define MLS_WEAK            1e-10 /* pivot over its diagonal entry below which a fit is weak */

/* Least-squares fits for the present equations of the neighbours, see src/fits/mls.c. */
typedef struct {
  PetscReal *phi;                /* basis: phi[t capacity + k] of neighbour k */
  PetscReal *W;                  /* weights of the equations */
  PetscReal *value, *weighted;   /* workspace */
  PetscInt   wanted, degree;     /* degree asked for and reached; wanted 0: no rows yet */
  PetscReal *laplacian, *filter; /* rows of the fit */
  PetscReal *gradient[ISPH_MAX_DIM];
  PetscReal *coefficient; /* a batch sets these in place of gradient and filter; NULL: rows */
  PetscBool  with_filter; /* those of the filter too */
  PetscBool  fitted;      /* the coefficients are set, and the rows are not valid */
} MlsFit;

/* Place of a particle with respect to free surfaces. */
typedef enum {
  SURFACE_INSIDE,
  SURFACE_SMOOTH,
  SURFACE_ROUGH,   /* no smooth surface passes through the particles nearby */
  SURFACE_ISOLATED /* too few neighbours */
} SurfaceKind;

#define SLOPE_NONE ~0u /* Stencil.slope is not computed */

/* Neighbours of a particle with the quantities that row functions read. */
typedef struct {
  PetscInt    i, dim, n, n_wall; /* particle, neighbours, number of wall particles among them */
  PetscInt    capacity;
  PetscReal   dx, h, radius;         /* spacing of the particle, smoothing length, support [m] */
  PetscReal   scale;                 /* multiplies equations of derivatives in fits [m] */
  PetscReal   stretch[ISPH_MAX_DIM]; /* of the axes about the particle, SceneStretch() [-] */
  PetscInt   *j;                     /* local index of each neighbour */
  PetscInt   *walls;                 /* the n_wall numbers of wall neighbours */
  PetscReal  *X[ISPH_MAX_DIM];       /* x_j - x_i, times stretch [m] */
  PetscReal  *r, *V;                 /* distance [m], volume [m^dim] */
  PetscReal  *W, *dW, *ddW;          /* kernel and its derivatives in r [m^-dim, ...] */
  PetscReal  *corrected[2];          /* storage for corrected dW and ddW */
  PetscBool  *wall;                  /* neighbour is a wall particle */
  PetscReal  *normal[ISPH_MAX_DIM];  /* of wall neighbours, into the fluid; of neighbours on a free
                                       surface, out of it */
  PetscInt   *side;                  /* side or body of wall neighbours */
  PetscReal  *beta;         /* of dummies: factor of u_wall,i - u_i, docs/theory.md, (49) */
  PetscReal  *share;        /* of dummies: weight in u_wall,i, docs/theory.md, (50) */
  PetscReal  *factor;       /* mean of the factors of the pair; of the particle alone with a wall */
  PetscBool   fits_walls;   /* wall neighbours have equations of their own, otherwise values */
  Equation   *equation;     /* of each neighbour in the present fit; fluid gives a value */
  PetscInt    degree;       /* of fits, 2 to MLS_MAX_DEGREE */
  PetscInt    least_degree; /* of fits whose points do not determine `degree` */
  PetscInt    surface_degree; /* of fits of particles below a free surface, 2 or 3 */
  PetscReal   weak;           /* pivot over its diagonal entry at which they do not */
  MlsFit      fit;            /* of these equations, shared by Laplacian, gradient and filter */
  PetscReal   volume;         /* of the particle itself [m^dim] */
  PetscReal   self[3];        /* W, dW/dr and d2W/dr2 at r = 0 [m^-dim, ...] */
  PetscInt    regularised;    /* number of fits so far whose points did not determine them */
  PetscBool  *surface;        /* neighbour is on a free surface, where fits have its condition */
  SurfaceKind kind;           /* of the particle */
  PetscBool   near_surface;   /* the particle or a neighbour is on a smooth part of it */
  PetscBool   beside_surface; /* the same on any part of it */
  PetscBool   paired;         /* pair forces in place of a fit, whatever the neighbours */
  PetscReal   own_normal[ISPH_MAX_DIM]; /* of the particle, out of the fluid */
  unsigned    correction; /* CorrectionBit of the present row, for forms that couple components */
  PetscReal   own[ISPH_MAX_DIM * ISPH_MAX_DIM]; /* weight of u_i itself, see LaplacianRow */
  PetscReal  *slope[ISPH_MAX_DIM]; /* of KernelGradients(), kept by StencilGradients() [1/m] */
  PetscReal  *radial;              /* -V_k W'/r of the same volumes, without correction [1/m^2] */
  unsigned    sloped;              /* CorrectionBit of slope, or SLOPE_NONE */
  PetscReal  *normal_strain[ISPH_MAX_DIM]; /* row of 2 n.E n of a particle on it [1/m] */

  const Scene *scene; /* of the equations of walls */
  PetscBool    slips; /* a neighbour is on a wall along which the fluid slides */
} Stencil;

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

  LaplacianGradient() computes c_ij. For walls see composed.c.
*/
typedef enum { GRADIENT_SPH, GRADIENT_FIRST_ORDER, GRADIENT_COUPLED } GradientChoice;
typedef struct {
  GradientChoice gradient;   /* coupled: of first order beside walls and free surfaces only */
  PetscBool      transposed; /* F = -V^-1 G^T V tau */
  PetscBool      planar;     /* in 2D the stress has no trace in the plane, otherwise none in 3D */
} ComposedForm;

/*
  Laplacians. w[k] multiplies f_k - f_i of neighbour k, or the given n.grad f if that is its
  equation. If the form couples components, w[(k dim + a) dim + b] multiplies (u_k - u_i)_b in
  component a. Such a form without FORM_NULL_CONSTANTS also sets own[a dim + b] of the stencil,
  which multiplies (u_i)_b.

  Factor() computes a number of a particle from its stencil, with the uncorrected kernel. It is
  called for all fluid particles before the rows, which then read st->factor of each neighbour.
*/
typedef struct {
  const char *name, *brief, *citation;
  unsigned    properties;  /* bits of FormProperty */
  unsigned    corrections; /* accepted corrections: bits of CorrectionBit */
  PetscErrorCode (*Row)(Stencil *stencil, PetscReal w[]);
  PetscReal (*Factor)(const Stencil *stencil); /* or NULL */
  PetscReal           grad_div; /* b of a form of one pass that approximates lap u + b grad div u */
  const ComposedForm *composed; /* NULL: one pass, by Row(); otherwise Row is NULL */
} LaplacianRow;
extern const Table LaplacianTable;

/* The chosen Laplacian with its correction. */
typedef struct {
  const LaplacianRow  *row;        /* NULL: not needed */
  const CorrectionRow *correction; /* NULL: none */
  PetscBool            extended;   /* wall values are extrapolated from the fluid: unsymmetric */
  PetscBool            graded;     /* particles of a pair may differ in size: unsymmetric */
  PetscBool  continued; /* stresses of dummies are continued from the fluid: unsymmetric */
  PetscReal *factor;    /* row->Factor() by local index; NULL: none */
  PetscReal  scale;     /* multiplies all weights; 0: 1 */
} LaplacianForm;
PetscBool      LaplacianIs(const LaplacianForm *form, FormProperty property);
PetscInt       LaplacianWidth(const LaplacianForm *form, PetscInt dim);
PetscReal      ComposedTrace(const ComposedForm *form, PetscInt dim);
PetscReal      LaplacianDilatation(const LaplacianForm *form, PetscInt dim);
PetscErrorCode LaplacianWeights(const LaplacianForm *form, Stencil *stencil, PetscReal w[]);
void           LaplacianGradient(const LaplacianForm *form, Stencil *stencil, PetscReal *c[]);
PetscBool      LaplacianFollowsSlopes(const LaplacianForm *form, unsigned correction);

/*
  Gradients and divergences. Row() computes the weights g[a][k] of f_k - f_i in df/dx_a.
  DivergenceFit() computes the weights d[a][k] of (u_k - u_i)_a of fluid neighbour k, and the
  weights m[k] of the normal component n.(u_k - u_i) of wall neighbour k.
*/
typedef struct {
  const char *name, *brief, *citation;
  unsigned    properties; /* bits of FormProperty: constants, exactness, support */
  PetscErrorCode (*Row)(Stencil *stencil, PetscReal *g[]);
  PetscErrorCode (*DivergenceFit)(Stencil *stencil, PetscReal *d[], PetscReal m[]); /* or NULL */
} GradientRow;
extern const Table GradientTable;

/*
  Wall treatments. A treatment with Extend gives each wall particle a velocity that all rows use,

    u_w = u_wall + sum_j E_wj (u_j - u_wall),   j over fluid near the wall.

  Extend writes row w of E. Without Extend, and for the divergence, Beta gives the dummy's velocity
  in the row of each fluid particle.
*/
typedef struct Extension Extension;
typedef struct {
  const char *name, *brief, *citation;
  PetscBool   on_surface; /* a layer of particles on the wall, which have equations in fits */
  PetscReal (*Beta)(const Scene *scene, PetscReal distance, PetscReal depth);
  PetscErrorCode (*Extend)(Extension *extension); /* or NULL */
  PetscReal radii, spacings;                      /* reach of Extend: sum of [radius] and [dx] */
  PetscErrorCode (*Check)(const Scene *scene);    /* refuses unsuitable scenes; NULL: none */
} WallRow;
extern const Table       WallTable;
extern const OptionTable OperatorOptions;
extern const WallRow     WallGiven; /* treatment of patch tests, not in the table */

void     DenseEliminate(PetscInt n, PetscReal A[], PetscInt rows, PetscReal B[]);
PetscInt DenseCholesky(PetscInt n, PetscReal a[]);
void     DenseCholeskyRidge(PetscInt n, const PetscReal a[], PetscReal ridge, PetscReal factor[]);
void     DenseCholeskySolve(PetscInt n, const PetscReal factor[], PetscReal x[]);

#define POINT_FIT_TERMS (1 + MLS_MAX_TERMS)
#define POINT_FITS      8 /* most fits at once, 2^dim */
void PointFits(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[], const PetscReal W[],
               PetscReal w[], PetscBool fits[]);
PetscBool VectorFit(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                    const PetscReal W[], const PetscBool wall[], PetscReal *const normal[],
                    PetscReal *const w[]);

void      MomentWeights(const Stencil *stencil, PetscBool walls, PetscReal weight[]);
PetscBool MomentInverse(const Stencil *stencil, const PetscReal weight[], PetscReal inverse[]);
void      ConcentrationRow(const Scene *scene, const KernelRow *kernel, const Stencil *stencil,
                           const PetscReal x[], PetscBool mirrored, PetscReal *concentration,
                           PetscReal gradient[]);

#endif
