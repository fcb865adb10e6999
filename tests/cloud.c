/* Creates the clouds of cloud.h: particles, neighbours and assembled operators. */
#include "isph/start.h"
#include "cloud.h"

/* CloudKeepMessage - Copies the message of an error to `kept`, an array of 512 characters; for
   PetscPushErrorHandler() */
PetscErrorCode CloudKeepMessage(MPI_Comm comm, int line, const char *function, const char *file,
                                PetscErrorCode code, PetscErrorType type, const char *message,
                                void *kept)
{
  if (type == PETSC_ERROR_INITIAL) (void)PetscStrncpy((char *)kept, message, 512);
  return code;
}

void CloudAssertNone(const char *what, const char *where, PetscInt wrong)
{
  MPI_Allreduce(MPI_IN_PLACE, &wrong, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  if (wrong) print_error("%s: %s: %d wrong\n", where, what, (int)wrong);
  assert_int_equal(wrong, 0);
}

static void CloudWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                              PetscReal u[])
{
  const Cloud *cloud = (const Cloud *)(const void *)scene->problem;

  for (PetscInt c = 0; c < scene->dim; c++)
    u[c] = QuadraticAt(cloud, &cloud->wall_u[c], x) + cloud->slide[side][c];
}

/* Adds a circle at rest in the middle of the box. */
static void CloudAddCircle(PetscReal radius, Scene *scene)
{
  BodyCircle(scene, 0.5 * (scene->lo[0] + scene->hi[0]), 0.5 * (scene->lo[1] + scene->hi[1]),
             radius, &SceneAddBody(scene)->body);
  scene->physics |= PHYSICS_WALLS;
}

/*
  CloudOperators - Creates the scene and the operators that the options choose, without particles

  Collective. The options are read from a separate database.

  Errors: as OperatorsCreate(); PETSc's own database is restored before the function returns
*/
PetscErrorCode CloudOperators(const CloudBox *box, const char options[], Cloud *cloud)
{
  Scene         *scene = &cloud->scene;
  PetscOptions   database;
  unsigned       needs;
  PetscErrorCode code;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(cloud, sizeof(*cloud)));
  cloud->problem              = (CaseRow){.name = "cloud", .brief = "", .citation = ""};
  cloud->problem.WallVelocity = CloudWallVelocity;
  scene->problem              = &cloud->problem;
  scene->physics              = PHYSICS_VISCOSITY | PHYSICS_PRESSURE | PHYSICS_CONVECTION;
  if (box->n_periodic < box->dim) scene->physics |= PHYSICS_WALLS;
  scene->dim    = box->dim;
  scene->n      = box->cells[0];
  scene->dx     = 0.1;
  scene->length = scene->speed = scene->rho = 1.0;
  scene->jitter                             = box->jitter;
  scene->seed                               = 3;
  for (PetscInt a = 0; a < box->dim; a++) {
    scene->lo[a]    = -0.3 + 0.7 * a;
    scene->hi[a]    = scene->lo[a] + box->cells[a] * scene->dx;
    scene->cells[a] = box->cells[a];
    SceneSetAxis(scene, a, a < box->n_periodic ? &BoundaryPeriodic : &BoundaryWall);
  }
  for (PetscInt side = 0; side < 2 * box->dim; side++)
    if (box->kind[side]) SceneSetSide(scene, side, box->kind[side]);
  if (box->circle > 0.0) CloudAddCircle(box->circle * scene->dx, scene);
  PetscCall(PetscOptionsCreate(&database));
  PetscCall(PetscOptionsInsertString(database, options));
  PetscCall(PetscOptionsPush(database));
  PetscCall(SceneReadSpacing(scene));
  if (box->moves) scene->motion = (const MotionRow *)TableGet(&MotionTable, 0); /* lagrangian */
  needs = box->needs ? box->needs : SceneNeeds(scene) | NEED_CONCENTRATION | NEED_GRADIENT_U;
  if (!box->without_matrices) needs |= NEED_MATRICES;
  if (box->grad_p_without_walls) needs |= NEED_FREE_GRAD_P | NEED_FILTER_P;
  PetscCall(RegimeCreate(scene, &scene->regime));
  code = OperatorsCreate(scene, needs, &cloud->ops);
  PetscCall(PetscOptionsPop());
  PetscCall(PetscOptionsDestroy(&database));
  PetscFunctionReturn(code);
}

static PetscErrorCode CloudAssemble(PetscReal margin_step, Cloud *cloud)
{
  PetscBool changed;

  PetscFunctionBegin;
  PetscCall(NeighborsUpdate(cloud->particles, margin_step * cloud->scene.dx, cloud->neighbors));
  PetscCall(
      OperatorsAssemble(&cloud->scene, cloud->particles, cloud->neighbors, cloud->ops, &changed));
  PetscCall(WallValuesRenumber(&cloud->scene, cloud->particles, &cloud->walls));
  PetscCheck(changed, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "Operators of new positions are not new");
  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    PetscCall(VecDestroy(&cloud->f[a]));
    PetscCall(FluidVec(cloud->particles, NULL, &cloud->f[a]));
  }
  PetscCall(VecDestroy(&cloud->y));
  PetscCall(VecDestroy(&cloud->e));
  PetscCall(FluidVec(cloud->particles, NULL, &cloud->y));
  PetscCall(WallVec(cloud->particles, &cloud->e));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CloudCreate - Creates a cloud with assembled operators and walls at rest; collective */
PetscErrorCode CloudCreate(const CloudBox *box, const char options[], Cloud *cloud)
{
  WallPlacement walls;

  PetscFunctionBegin;
  PetscCall(CloudOperators(box, options, cloud));
  PetscCall(OperatorsPlacement(&cloud->scene, cloud->ops, &walls));
  PetscCall(ParticlesCreate(&cloud->scene, cloud->ops->forms.reach, &cloud->particles));
  PetscCall(ParticlesFill(&cloud->scene, walls, NULL, cloud->particles));
  PetscCall(
      NeighborsCreate(cloud->ops->forms.radius, SceneCoarsest(&cloud->scene), &cloud->neighbors));
  PetscCall(CloudAssemble(0.0, cloud));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CloudDestroy(Cloud *cloud)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < cloud->scene.dim; a++) PetscCall(VecDestroy(&cloud->f[a]));
  PetscCall(VecDestroy(&cloud->y));
  PetscCall(VecDestroy(&cloud->e));
  PetscCall(WallValuesFree(&cloud->walls));
  PetscCall(OperatorsDestroy(&cloud->ops));
  PetscCall(NeighborsDestroy(&cloud->neighbors));
  PetscCall(ParticlesDestroy(&cloud->particles));
  PetscCall(ExpressionScopeDestroy(&cloud->scene.scope));
  PetscCall(PetscFree(cloud->scene.regime));
  PetscCall(SceneFreeShapes(&cloud->scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CloudMove - Moves each fluid particle by at most `length` [dx] along each axis and assembles anew

  Collective

  Input Parameters:
+ renumber    - true: starts an epoch, in which particles get new numbers
- margin_step - step length passed to NeighborsUpdate() [dx]
*/
PetscErrorCode CloudMove(PetscReal length, PetscBool renumber, PetscReal margin_step, Cloud *cloud)
{
  const Scene *scene = &cloud->scene;
  Particles   *p     = cloud->particles;
  PetscBool    started;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    for (PetscInt a = 0; a < p->dim; a++) {
      const PetscReal s = PetscSinReal(12.9898 * (p->id[i] + 1) + 78.233 * (a + 1)) * 43758.5453;

      p->x[a][i] += length * scene->dx * (2.0 * (s - PetscFloorReal(s)) - 1.0);
      if (SceneIsPeriodic(scene, a)) continue;
      p->x[a][i] = PetscMin(PetscMax(p->x[a][i], scene->lo[a] + 0.3 * scene->dx),
                            scene->hi[a] - 0.3 * scene->dx);
    }
  }
  PetscCall(ParticlesUpdateEpoch(scene, p, renumber, &started));
  if (!started) PetscCall(ParticlesUpdateHalo(p));
  PetscCall(CloudAssemble(margin_step, cloud));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const LaplacianRow *CloudLaplacian(PetscInt k)
{
  return (const LaplacianRow *)(const void *)TableGet(&LaplacianTable, k);
}

PetscInt CloudScalarForms(void)
{
  PetscInt n = 0;

  while (n < LaplacianTable.count && !CloudHas(CloudLaplacian(n), FORM_COUPLES)) n++;
  return n;
}

PetscBool CloudHas(const LaplacianRow *form, FormProperty property)
{
  return (form->properties & (unsigned)property) ? PETSC_TRUE : PETSC_FALSE;
}

/* CloudPeriodic - Returns a periodic box that is wide enough for rows whose support of up to 3 dx
   crosses no side */
CloudBox CloudPeriodic(PetscInt dim, PetscReal jitter)
{
  const PetscInt n = dim == 2 ? 16 : 9;

  return (CloudBox){.name       = jitter > 0.0 ? (dim == 2 ? "2D disorder" : "3D disorder")
                                               : (dim == 2 ? "2D lattice" : "3D lattice"),
                    .dim        = dim,
                    .cells      = {n, n, n},
                    .n_periodic = dim,
                    .jitter     = jitter};
}

/* CloudCreateForm - Creates a cloud whose velocity and pressure use a form; the pressure uses mls
   if the form is not safe in implicit steps */
void CloudCreateForm(const CloudBox *box, const char kernel[], const LaplacianRow *form,
                     Cloud *cloud)
{
  char options[256];

  ASSERT_OK(PetscSNPrintf(options, sizeof(options), "%s -visc_laplacian %s -ppe_laplacian %s",
                          kernel, form->name,
                          CloudHas(form, FORM_SAFE_IMPLICIT) ? form->name : "mls"));
  ASSERT_OK(CloudCreate(box, options, cloud));
}

/* CloudAsymmetry - Returns |A - A^T|/|A| in the Frobenius norm; collective */
PetscReal CloudAsymmetry(Mat A)
{
  Mat       T;
  PetscReal difference, norm;

  ASSERT_OK(MatTranspose(A, MAT_INITIAL_MATRIX, &T));
  ASSERT_OK(MatAXPY(T, -1.0, A, DIFFERENT_NONZERO_PATTERN));
  ASSERT_OK(MatNorm(T, NORM_FROBENIUS, &difference));
  ASSERT_OK(MatNorm(A, NORM_FROBENIUS, &norm));
  ASSERT_OK(MatDestroy(&T));
  return difference / norm;
}

/* QuadraticCount - Returns the number of monomials s_a and s_a s_b, b <= a */
PetscInt QuadraticCount(PetscInt dim)
{
  return dim + dim * (dim + 1) / 2;
}

/* QuadraticMonomial - Returns monomial k: s_a for k < dim, then s_a s_b with b <= a, row by row */
Quadratic QuadraticMonomial(PetscInt dim, PetscInt k)
{
  Quadratic q = {0};

  if (k < dim) {
    q.g[k] = 1.0;
    return q;
  }
  k -= dim;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b <= a; b++) {
      if (k-- != 0) continue;
      q.H[a][b] += 1.0;
      q.H[b][a] += 1.0;
    }
  }
  return q;
}

static PetscReal Scaled(const Cloud *cloud, const PetscReal x[], PetscInt a)
{
  const Scene *scene = &cloud->scene;

  return (x[a] - 0.5 * (scene->lo[a] + scene->hi[a])) / scene->dx;
}

PetscReal QuadraticAt(const Cloud *cloud, const Quadratic *q, const PetscReal x[])
{
  PetscReal value = q->c;

  for (PetscInt a = 0; a < cloud->scene.dim; a++) {
    value += q->g[a] * Scaled(cloud, x, a);
    for (PetscInt b = 0; b < cloud->scene.dim; b++)
      value += 0.5 * q->H[a][b] * Scaled(cloud, x, a) * Scaled(cloud, x, b);
  }
  return value;
}

/* QuadraticDerivative - Returns the derivative of a field along axis a, a linear field */
Quadratic QuadraticDerivative(const Cloud *cloud, const Quadratic *q, PetscInt a)
{
  Quadratic d = {.c = q->g[a] / cloud->scene.dx};

  for (PetscInt b = 0; b < cloud->scene.dim; b++) d.g[b] = q->H[a][b] / cloud->scene.dx;
  return d;
}

/* QuadraticLaplacian - Returns the Laplacian of a field, a constant field */
Quadratic QuadraticLaplacian(const Cloud *cloud, const Quadratic *q)
{
  Quadratic lap = {0};

  for (PetscInt a = 0; a < cloud->scene.dim; a++) lap.c += q->H[a][a] / PetscSqr(cloud->scene.dx);
  return lap;
}

static void Position(const Particles *p, PetscInt i, PetscReal x[])
{
  for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
}

/* CloudSet - Sets v to the values of a field at the fluid particles; collective on v */
PetscErrorCode CloudSet(const Cloud *cloud, const Quadratic *q, Vec v)
{
  PetscReal *value, x[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(VecGetArray(v, &value));
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) {
    Position(cloud->particles, i, x);
    value[i] = QuadraticAt(cloud, q, x);
  }
  PetscCall(VecRestoreArray(v, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CloudSetSlope - Sets e to n.grad of the field at the wall point of each wall particle; collective
   on e */
PetscErrorCode CloudSetSlope(const Cloud *cloud, const Quadratic *q, Vec e)
{
  const Particles *p = cloud->particles;
  PetscReal       *value, x[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(VecGetArray(e, &value));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt i = p->n_fluid + k;

    Position(p, i, x);
    for (PetscInt a = 0; a < p->dim; a++) x[a] += p->depth[i] * p->normal[a][i];
    value[k] = 0.0;
    for (PetscInt a = 0; a < p->dim; a++) {
      const Quadratic d = QuadraticDerivative(cloud, q, a);

      value[k] += p->normal[a][i] * QuadraticAt(cloud, &d, x);
    }
  }
  PetscCall(VecRestoreArray(e, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CloudSetWalls - Sets the wall values to the wall velocity; not collective */
PetscErrorCode CloudSetWalls(Cloud *cloud)
{
  PetscFunctionBegin;
  PetscCall(WallValuesSetVelocity(&cloud->scene, cloud->particles, 0.0, 0.0, &cloud->walls));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CloudDivergence - Computes y = div of the velocity f with the wall velocity; collective */
PetscErrorCode CloudDivergence(const Cloud *cloud, Vec y)
{
  const Operators *ops = cloud->ops;

  PetscFunctionBegin;
  PetscCall(AffineApply(&ops->div[0], cloud->f[0], cloud->walls.u[0], y));
  for (PetscInt c = 1; c < cloud->scene.dim; c++)
    PetscCall(AffineApplyAdd(&ops->div[c], cloud->f[c], cloud->walls.u[c], y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  CloudError - Computes the largest |y - expected| over fluid particles

  Collective. Input: interior - true: omits particles whose support crosses a periodic side, because
  a polynomial jumps there.
*/
PetscErrorCode CloudError(const Cloud *cloud, Vec y, const Quadratic *expected, PetscBool interior,
                          PetscReal *error)
{
  const Scene     *scene = &cloud->scene;
  const PetscReal *value;
  PetscReal        largest = 0.0, x[ISPH_MAX_DIM];
  PetscInt         rows    = 0;

  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(y, &value));
  for (PetscInt i = 0; i < cloud->particles->n_fluid; i++) {
    PetscReal miss, room = PETSC_MAX_REAL;

    Position(cloud->particles, i, x);
    for (PetscInt a = 0; a < scene->dim; a++) {
      if (!SceneIsPeriodic(scene, a)) continue;
      room = PetscMin(room, PetscMin(x[a] - scene->lo[a], scene->hi[a] - x[a]));
    }
    if (interior && room < cloud->ops->forms.reach) continue;
    miss = PetscAbsReal(value[i] - QuadraticAt(cloud, expected, x));
    if (!(miss <= largest)) largest = PetscIsInfOrNanReal(miss) ? PETSC_MAX_REAL : miss;
    rows++;
  }
  PetscCall(VecRestoreArrayRead(y, &value));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rows, 1, MPIU_INT, MPI_SUM, cloud->particles->comm));
  PetscCallMPI(MPI_Allreduce(&largest, error, 1, MPIU_REAL, MPIU_MAX, cloud->particles->comm));
  PetscCheck(rows > 0, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "The box has no interior row");
  PetscFunctionReturn(PETSC_SUCCESS);
}
