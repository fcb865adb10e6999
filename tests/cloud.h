/*
  A cloud: particles with their operators, created as in a run, for tests of identities. The spacing
  is 0.1; axes of the box that are not periodic have walls. Fields are polynomials about the centre
  of the box.
*/
#ifndef CLOUD_H
#define CLOUD_H

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>
#include "isph/operators.h"

/* Describes a cloud; numbers of cells along axes beyond dim are ignored. */
typedef struct {
  const char        *name; /* for messages */
  PetscInt           dim, cells[ISPH_MAX_DIM];
  PetscInt           n_periodic;           /* the first axes are periodic, the others have walls */
  PetscReal          jitter;               /* [dx] */
  PetscReal          circle;               /* radius of a body in the middle [dx]; 0: none */
  PetscBool          grad_p_without_walls; /* pressure rows of the coupled scheme */
  PetscBool          without_matrices;     /* operators are products by rows only */
  PetscBool          moves;                /* particles move with the flow */
  unsigned           needs;                /* 0: those of the scene */
  const BoundaryRow *kind[2 * ISPH_MAX_DIM]; /* of sides; NULL: as n_periodic says */
} CloudBox;

/* A quadratic field f(x) = c + g.s + s.H s/2,  s = (x - centre)/dx,  H symmetric. */
typedef struct {
  PetscReal c, g[ISPH_MAX_DIM], H[ISPH_MAX_DIM][ISPH_MAX_DIM];
} Quadratic;

typedef struct {
  CaseRow    problem; /* first member: the wall velocity function casts its address to Cloud */
  Scene      scene;
  Particles *particles;
  Neighbors *neighbors;
  Operators *ops;
  WallValues walls;
  Quadratic  wall_u[ISPH_MAX_DIM];                  /* velocity of all walls, by components */
  PetscReal  slide[2 * ISPH_MAX_DIM][ISPH_MAX_DIM]; /* added to wall_u on each side */
  Vec        f[ISPH_MAX_DIM], y, e; /* over fluid, over fluid, over wall particles */
} Cloud;

/* Fails the test on all ranks if `wrong` is positive on any rank; if only this rank failed, the
   others would hang. */
void CloudAssertNone(const char *what, const char *where, PetscInt wrong);
#define ASSERT_OK(call) CloudAssertNone(#call, "PETSc", (call) ? 1 : 0)

/* Error handler that copies the message to `kept` (512 characters) and prints nothing. */
PetscErrorCode CloudKeepMessage(MPI_Comm comm, int line, const char *function, const char *file,
                                PetscErrorCode code, PetscErrorType type, const char *message,
                                void *kept);

/* Input: options - as on the command line; no other options are read. */
PetscErrorCode CloudCreate(const CloudBox *box, const char options[], Cloud *cloud);
PetscErrorCode CloudDestroy(Cloud *cloud);
PetscErrorCode CloudMove(PetscReal length, PetscBool renumber, PetscReal margin_step, Cloud *cloud);
PetscErrorCode CloudOperators(const CloudBox *box, const char options[], Cloud *cloud);

const LaplacianRow *CloudLaplacian(PetscInt k); /* row k of the table of Laplacians */
PetscInt CloudScalarForms(void); /* number of rows that do not couple components; they come first */
PetscBool CloudHas(const LaplacianRow *form, FormProperty property);
CloudBox  CloudPeriodic(PetscInt dim, PetscReal jitter);
void      CloudCreateForm(const CloudBox *box, const char kernel[], const LaplacianRow *form,
                          Cloud *cloud);
PetscReal CloudAsymmetry(Mat A);
Cloud     CloudOfForm(const LaplacianRow *form, const CloudBox *box, const char more[]);
Cloud     CloudFree(const LaplacianRow *form, PetscInt dim);

PetscInt  QuadraticCount(PetscInt dim);
Quadratic QuadraticMonomial(PetscInt dim, PetscInt k);
PetscReal QuadraticAt(const Cloud *cloud, const Quadratic *q, const PetscReal x[]);
Quadratic QuadraticDerivative(const Cloud *cloud, const Quadratic *q, PetscInt a);
Quadratic QuadraticLaplacian(const Cloud *cloud, const Quadratic *q);

PetscErrorCode CloudSet(const Cloud *cloud, const Quadratic *q, Vec v);
void           CloudSetVelocity(const Cloud *cloud, const Quadratic u[], Vec all);
PetscErrorCode CloudSetSlope(const Cloud *cloud, const Quadratic *q, Vec e);
PetscErrorCode CloudSetWalls(Cloud *cloud);
PetscErrorCode CloudDivergence(const Cloud *cloud, Vec y);
PetscErrorCode CloudError(const Cloud *cloud, Vec y, const Quadratic *expected, PetscBool interior,
                          PetscReal *error);

#endif
