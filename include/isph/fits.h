/* Fits: kernels, the stencil of a particle with its neighbours, least-squares fits, and small dense
   systems. Formulas: theory.md, sections 3 and 4. */
#ifndef ISPH_FITS_H
#define ISPH_FITS_H

#include "isph/particles.h"

/* Sums over arrays in a fixed number of partial sums, so that processors with vectors of any length
   add in the same order. Arrays over neighbours end in zeros up to a multiple of this number, and
   loops over them need no remainder. */
#define ISPH_LANES 8

/* Rounds a length up to a multiple of ISPH_LANES. */
static ISPH_INLINE PetscInt LanesPadded(PetscInt n)
{
  return (n + ISPH_LANES - 1) / ISPH_LANES * ISPH_LANES;
}

/* Adds the partial sums; changes them. */
static ISPH_INLINE PetscReal LanesTotal(PetscReal lane[])
{
  for (PetscInt half = ISPH_LANES / 2; half > 0; half /= 2) {
    for (PetscInt l = 0; l < half; l++) lane[l] += lane[l + half];
  }
  return lane[0];
}

/* Computes sum_k a_k b_k; n is a multiple of ISPH_LANES. */
static ISPH_INLINE PetscReal LanesSum(PetscInt n, const PetscReal a[], const PetscReal b[])
{
  PetscReal lane[ISPH_LANES] = {0.0};

  for (PetscInt k = 0; k < n; k += ISPH_LANES) {
    for (PetscInt l = 0; l < ISPH_LANES; l++) lane[l] += a[k + l] * b[k + l];
  }
  return LanesTotal(lane);
}

/* Vector of four numbers, one of each of four points or neighbours. Unaligned, as PETSc allocates
   memory. */
typedef PetscReal Four
    __attribute__((vector_size(4 * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));

/* Returns the sum of the four numbers. */
static ISPH_INLINE PetscReal FourSum(const Four *v)
{
  return ((*v)[0] + (*v)[1]) + ((*v)[2] + (*v)[3]);
}

/* Returns four numbers of an array, from the first. */
static ISPH_INLINE const Four *FourAt(const PetscReal *first)
{
  return (const Four *)(const void *)first;
}

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

/* The chosen kernel and its size. */
typedef struct {
  const KernelRow *row;
  PetscReal        h_over_dx; /* smoothing length over a particle's spacing [-] */
  PetscReal        h, radius; /* of the coarsest particles; radius of the support [m] */
} KernelSize;

#define SLOPE_NONE ~0u /* Stencil.slope is not computed */

/* Neighbours of a particle with the quantities that row functions read. */
typedef struct {
  PetscInt   i, dim, n, n_wall; /* particle, neighbours, number of wall particles among them */
  PetscInt   capacity;
  PetscReal  dx, h, radius;         /* spacing of the particle, smoothing length, support [m] */
  PetscReal  scale;                 /* multiplies equations of derivatives in fits [m] */
  PetscReal  stretch[ISPH_MAX_DIM]; /* of the axes about the particle, SceneStretch() [-] */
  PetscInt  *j;                     /* local index of each neighbour */
  PetscInt  *walls;                 /* the n_wall numbers of wall neighbours */
  PetscReal *X[ISPH_MAX_DIM];       /* x_j - x_i, times stretch [m] */
  PetscReal *r, *V;                 /* distance [m], volume [m^dim] */
  PetscReal *W, *dW, *ddW;          /* kernel and its derivatives in r [m^-dim, ...] */
  PetscReal *corrected[2];          /* storage for corrected dW and ddW */
  PetscBool *wall;                  /* neighbour is a wall particle */
  PetscReal *normal[ISPH_MAX_DIM];  /* of wall neighbours, into the fluid */
  PetscInt  *side;                  /* side or body of wall neighbours */
  PetscReal *beta;         /* of dummies: factor of u_wall,i - u_i, theory.md, (walls:dummy) */
  PetscReal *share;        /* of dummies: weight in u_wall,i, theory.md, (walls:datum) */
  PetscReal *factor;       /* mean of the factors of the pair; of the particle alone with a wall */
  PetscBool  fits_walls;   /* wall neighbours have equations of their own, otherwise values */
  Equation  *equation;     /* of each neighbour in the present fit; fluid gives a value */
  PetscInt   degree;       /* of fits, 2 to MLS_MAX_DEGREE */
  PetscInt   least_degree; /* of fits whose points do not determine `degree` */
  PetscReal  weak;         /* pivot over its diagonal entry at which they do not */
  MlsFit     fit;          /* of these equations, shared by Laplacian, gradient and filter */
  PetscReal  volume;       /* of the particle itself [m^dim] */
  PetscReal  self[3];      /* W, dW/dr and d2W/dr2 at r = 0 [m^-dim, ...] */
  PetscInt   regularised;  /* number of fits so far whose points did not determine them */
  unsigned   correction;   /* CorrectionBit of the present row, for forms that couple components */
  PetscReal  own[ISPH_MAX_DIM * ISPH_MAX_DIM]; /* weight of u_i itself, see LaplacianRow */
  PetscReal *slope[ISPH_MAX_DIM]; /* of KernelGradients(), kept by StencilGradients() [1/m] */
  PetscReal *radial;              /* -V_k W'/r of the same volumes, without correction [1/m^2] */
  unsigned   sloped;              /* CorrectionBit of slope, or SLOPE_NONE */

  const Scene *scene; /* of the equations of walls */
  PetscBool    slips; /* a neighbour is on a wall along which the fluid slides */
} Stencil;

void     DenseEliminate(PetscInt n, PetscReal A[], PetscInt rows, PetscReal B[]);
PetscInt DenseCholesky(PetscInt n, PetscReal a[]);
void     DenseCholeskyRidge(PetscInt n, const PetscReal a[], PetscReal ridge, PetscReal factor[]);
PetscErrorCode DenseEigen(PetscInt n, PetscReal K[], PetscReal M[], PetscReal lambda[],
                          PetscReal V[]);
void           DenseCholeskySolve(PetscInt n, const PetscReal factor[], PetscReal x[]);

#define POINT_FIT_TERMS (1 + MLS_MAX_TERMS)
#define POINT_FITS      8 /* most fits at once, 2^dim */
void PointFits(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[], const PetscReal W[],
               PetscReal w[], PetscBool fits[]);
PetscBool PointFit(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                   const PetscReal W[], PetscInt wanted, PetscBool ridge, PetscReal *const w[]);
PetscBool VectorFit(PetscInt dim, PetscInt degree, PetscInt n, PetscReal *const s[],
                    const PetscReal W[], const PetscBool wall[], PetscReal *const normal[],
                    PetscReal *const w[]);

#define NEAREST_LEAST    84 /* most particles with which a fit of the nearest begins */
#define NEAREST_TIMES    3  /* times as many if their weights are large */
#define NEAREST_CAPACITY ((NEAREST_TIMES + 1) * NEAREST_LEAST)

/* Fits of the nearest particles at 2^dim points; the arrays are those of PointFits(). */
typedef struct {
  PetscInt  n[POINT_FITS]; /* particles in each */
  PetscBool fits[POINT_FITS];
  PetscReal R[POINT_FITS]; /* [m] */
  PetscInt  j[POINT_FITS * NEAREST_CAPACITY];
  PetscReal s[ISPH_MAX_DIM][POINT_FITS * NEAREST_CAPACITY];
  PetscReal W[POINT_FITS * NEAREST_CAPACITY], w[POINT_FITS * NEAREST_CAPACITY];
} NearestFits;
typedef PetscErrorCode (*NearestFill)(void *ctx, PetscInt i, PetscInt wanted, NearestFits *f,
                                      PetscBool *more);

/* Returns the weight in a fit of a particle at the distance r, over the radius. */
static inline PetscReal NearestWeight(PetscReal r)
{
  return PetscSqr(PetscSqr(1.0 - r)) * (1.0 + 4.0 * r);
}
PetscBool      NearestTakesMore(PetscInt least, PetscInt wanted, PetscBool more, PetscReal sum);
PetscErrorCode NearestFitsCompute(PetscInt dim, PetscInt degree, PetscInt least,
                                  const PetscBool todo[], NearestFill Fill, void *ctx,
                                  NearestFits *f);

/* Computes the image Y of a position X, relative to a particle, in those planes near the particle
   that are bits of `set`, one after another. */
static inline void MirrorImage(PetscInt dim, PetscInt n_planes, const WallPlane planes[],
                               PetscInt set, const PetscReal X[], PetscReal Y[])
{
  for (PetscInt a = 0; a < dim; a++) Y[a] = X[a];
  for (PetscInt p = 0; p < n_planes; p++) {
    PetscReal height = planes[p].distance;

    if (!(set & (1 << p))) continue;
    for (PetscInt a = 0; a < dim; a++) height += Y[a] * planes[p].normal[a];
    for (PetscInt a = 0; a < dim; a++) Y[a] -= 2.0 * height * planes[p].normal[a];
  }
}

/* The plane of an interface of two fluids near a place x, see InterfaceNear(). */
typedef struct {
  PetscInt  fluid[2];             /* on the positive and on the negative side */
  PetscReal offset;               /* signed distance of x from the plane [m] */
  PetscReal normal[ISPH_MAX_DIM]; /* unit, into fluid[0] */
} InterfacePlane;
PetscBool      InterfaceNear(const Particles *p, const PetscReal x[], PetscInt count,
                             const PetscInt list[], InterfacePlane *plane);
PetscErrorCode InterfacesUpdateHalo(Particles *p);
PetscErrorCode InterfacesFollow(Particles *p, const Neighbors *nb);
void           InterfaceSlip(Particles *p, PetscInt i, const PetscReal slip[]);

/* Rows of fits. */
PetscErrorCode LaplacianRow_Mls(Stencil *stencil, PetscReal w[]);
PetscErrorCode GradientRow_Mls(Stencil *stencil, PetscReal *g[]);
PetscErrorCode GradientRow_MlsDegree(Stencil *stencil, PetscInt degree, PetscReal *g[],
                                     PetscBool *determined);
PetscErrorCode FilterRow_Mls(Stencil *stencil, PetscReal w[]);
PetscErrorCode DivergenceFit_Mls(Stencil *stencil, PetscReal *d[], PetscReal m[]);

#endif
