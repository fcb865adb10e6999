/* Operators: the chosen forms, the assembly of their rows, products, and sparse matrices of
   them. */
#ifndef ISPH_OPERATORS_H
#define ISPH_OPERATORS_H

#include "isph/walls.h"

extern const OptionTable OperatorOptions;

unsigned       SceneNeeds(const Scene *scene);
PetscErrorCode OperatorsCreate(const Scene *scene, unsigned needs, Operators **ops);
PetscErrorCode OperatorsDestroy(Operators **ops);
const char    *OperatorsCorrection(const Operators *ops);
PetscErrorCode OperatorsDegree(const Scene *scene, PetscInt *degree);
PetscErrorCode OperatorsPlacement(const Scene *scene, const Operators *ops, WallPlacement *walls);
PetscErrorCode OperatorsAssemble(const Scene *scene, const Particles *particles,
                                 const Neighbors *neighbors, Operators *ops, PetscBool *changed);

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

PetscErrorCode OperatorsStrainRate(const Operators *ops, const Particles *particles, const Vec u[],
                                   const Vec walls[], PetscReal g[]);
PetscErrorCode OperatorsFollowStrain(const Scene *scene, Particles *particles,
                                     const WallValues *walls, const Vec u[], Operators *ops);

#define STRAIN_MOST (ISPH_MAX_DIM * (ISPH_MAX_DIM + 1) / 2) /* components of a symmetric tensor */

/* The linear stress of a rheology at a point, in Newton's iteration: see src/operators/tangent.c.
   Tensors by their components a <= c. */
typedef struct {
  PetscReal  nu;                  /* nu_k [m^2/s] */
  PetscReal  strain[STRAIN_MOST]; /* S_k [1/s] */
  PetscReal  slope;               /* theta_k nu'(g_k)/g_k [m^2 s] */
  FluidPlace place;
} StressPoint;

/* The stresses at all points of this rank. */
typedef struct {
  const Scene *scene;
  Particles   *p;
  Operators   *ops;
  PetscInt     n; /* points: the cells of a weak form, or own fluid particles */
  StressPoint *point;
  PetscReal   *u;      /* u_k by local index, components of a particle together [m/s] */
  PetscReal   *change; /* dnu by local index [m^2/s] */
  PetscReal    error;  /* of the last TangentFollow(): |s - tau(u)| over |tau(u)| [-] */
  PetscReal    stress; /* |tau(u)|, root mean square of (tau:tau/2)^1/2 [m^2/s^2] */
} StressTangent;
#define STRESS_ERROR 1e-3 /* largest error of the stresses of a solution [-] */

PetscErrorCode TangentCreate(const Scene *scene, Particles *particles, Operators *ops,
                             StressTangent **tangent);
PetscErrorCode TangentDestroy(StressTangent **tangent);
PetscErrorCode TangentFollow(StressTangent *tangent, const Vec u[], const WallValues *walls);
PetscErrorCode TangentShare(const StressTangent *tangent, const Vec u[], const WallValues *walls,
                            PetscReal *share);
PetscErrorCode TangentApplyAdd(StressTangent *tangent, PetscReal scale, const Vec v[],
                               const Vec y[]);

PetscErrorCode PatternBegin(Pattern *pattern, PetscBool has_columns, PetscInt rows,
                            PetscInt entries);
PetscBool PatternRow(Pattern *pattern, PetscInt i, const PetscInt cols[], const PetscInt local[],
                     PetscInt n, PetscInt slot[]);
PetscErrorCode PatternMat(MPI_Comm comm, const Pattern *pattern, PetscInt rows, PetscInt cols,
                          PetscReal values[], Mat like, Mat *A);
PetscErrorCode PatternFree(Pattern *pattern);

/* Sparse matrices from rows with ascending columns. PETSc inserts the entries of such rows one by
   one, which takes longer than the computation of most of them. Own rows of a matrix, compressed;
   columns are global and ascend. */
typedef struct {
  PetscInt     n, *row, *col;
  PetscScalar *value;
} SparseRows;

PetscErrorCode SparseRowsMalloc(PetscInt n, PetscInt entries, SparseRows *rows);
PetscErrorCode SparseRowsMat(MPI_Comm comm, SparseRows *rows, PetscInt cols, Mat *A);
PetscErrorCode SparseRowsKeep(const SparseRows *rows, const char name[], Mat A);
PetscErrorCode SparseRowsGet(Mat A, const char name[], SparseRows **rows);
PetscErrorCode SparseAdd(Mat X, Mat *Y);

#define MAT_VALUES "values" /* rows of a matrix whose values can be computed again */
PetscErrorCode PatternBlocks(const Particles *particles, PetscInt entries, const Pattern *pattern,
                             PetscInt columns, Mat *A);
PetscErrorCode PatternMatSet(const SparseRows *rows, Mat A);

#endif
