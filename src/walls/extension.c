/*
  Extension of the fluid's velocity to wall particles. Fluid particles j near the wall give wall
  particle w the velocity u_w = u_wall + sum_j E_wj (u_j - u_wall). Matrices A and B that were
  assembled for u_w then become matrices for the velocities of fluid and wall,

    A u + B u_w = (A + B E) u + B diag(S) u_wall,   S_w = 1 - sum_j E_wj,

  so that schemes apply all wall treatments in the same way. See docs/theory.md, (57) and (58).
*/
#include "rows/assembly.h"
#include "extension.h"

/* Entries of the sparse matrix E, and the vector S. */
typedef struct {
  PetscInt   n, capacity;
  PetscInt  *row, *col; /* global indices */
  PetscReal *value;
  Vec        S;
} Entries;

static PetscErrorCode EntriesAppend(Entries *list, PetscInt row, const Extension *ext)
{
  PetscFunctionBegin;
  if (list->n + ext->n > list->capacity) {
    list->capacity = 2 * list->capacity + ext->n + 1024;
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)list->capacity, &list->row));
    PetscCall(PetscRealloc(sizeof(PetscInt) * (size_t)list->capacity, &list->col));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)list->capacity, &list->value));
  }
  for (PetscInt k = 0; k < ext->n; k++, list->n++) {
    list->row[list->n]   = row;
    list->col[list->n]   = ext->particles->row[ext->j[k]];
    list->value[list->n] = ext->e[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the workspace of a row of E, with arrays for all local particles. */
static PetscErrorCode ExtensionCreate(const Scene *scene, const Particles *p, const Neighbors *nb,
                                      const Operators *ops, Extension *ext)
{
  const PetscInt n = nb->cells.n;

  PetscFunctionBegin;
  *ext = (Extension){.scene     = scene,
                     .particles = p,
                     .cells     = &nb->cells,
                     .margin    = nb->margin,
                     .kernel    = ops->forms.kernel,
                     .dim       = scene->dim,
                     .h_over_dx = ops->forms.h_over_dx};
  PetscCall(PetscMalloc4(n, &ext->j, n, &ext->q, n, &ext->weight, n, &ext->e));
  for (PetscInt a = 0; a < scene->dim; a++) PetscCall(PetscMalloc1(n, &ext->s[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ExtensionDestroy(Extension *ext)
{
  PetscFunctionBegin;
  PetscCall(PetscFree4(ext->j, ext->q, ext->weight, ext->e));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) PetscCall(PetscFree(ext->s[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Sets the geometry of own wall particle i for its row of E.

  Returns: PETSC_FALSE if the row is empty: the particle lies on the surface, or its support does
  not reach the fluid
*/
static PetscBool ExtensionPlace(const Particles *p, PetscInt i, Extension *ext)
{
  const Scene *scene = ext->scene;
  PetscReal    d2    = 0.0;

  ext->n      = 0;
  ext->dx     = p->dx[i];
  ext->radius = ext->kernel->support * (ext->h_over_dx * ext->dx);
  ext->depth  = p->depth[i];
  ext->side   = (PetscInt)p->side[i];
  ParticlesWallPoint(p, i, ext->wall_point);
  for (PetscInt a = 0; a < ext->dim; a++) {
    ext->x[a]      = p->x[a][i];
    ext->normal[a] = p->normal[a][i];
    ext->edge[a]   = ext->wall_point[a];
    if (!SceneIsPeriodic(scene, a))
      ext->edge[a] = PetscMin(PetscMax(ext->wall_point[a], scene->lo[a]), scene->hi[a]);
    d2 += PetscSqr(ext->x[a] - ext->edge[a]);
  }
  return ext->depth > 0.0 && d2 < PetscSqr(ext->radius);
}

/* Computes the rows of E for own wall particles, and S. */
static PetscErrorCode FillEntries(const WallRow *wall, const Particles *p, Extension *ext,
                                  Entries *list)
{
  PetscReal *S;

  PetscFunctionBegin;
  PetscCall(VecGetArray(list->S, &S));
  for (PetscInt k = 0; k < p->n_wall; k++) {
    const PetscInt i = p->n_fluid + k;

    S[k] = 1.0;
    if (!ExtensionPlace(p, i, ext)) continue;
    PetscCall(wall->Extend(ext));
    for (PetscInt q = 0; q < ext->n; q++) S[k] -= ext->e[q];
    PetscCall(EntriesAppend(list, p->row[i], ext));
  }
  PetscCall(VecRestoreArray(list->S, &S));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the matrix E; a particle and its periodic images share a column. */
static PetscErrorCode EntriesMat(const Particles *p, Entries *list, Mat *E)
{
  PetscFunctionBegin;
  PetscCall(MatCreate(p->comm, E));
  PetscCall(MatSetSizes(*E, p->n_wall, p->n_fluid, p->N_wall, p->N_fluid));
  PetscCall(MatSetType(*E, MATAIJ));
  PetscCall(MatSetPreallocationCOO(*E, list->n, list->row, list->col));
  PetscCall(MatSetValuesCOO(*E, list->value, ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Replaces A by A + B E and B by B diag(S). */
static PetscErrorCode ExtendOperator(Mat E, Vec S, AffineOperator *op)
{
  Mat BE;

  PetscFunctionBegin;
  if (!op->needed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatMatMult(op->B, E, MAT_INITIAL_MATRIX, PETSC_DETERMINE, &BE));
  PetscCall(MatAXPY(op->A, 1.0, BE, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatDestroy(&BE));
  PetscCall(MatDiagonalScale(op->B, NULL, S));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ExtendWalls - Changes the matrices of lap u, du/dx_a and the velocity filter by the extension of
  the velocity to wall particles, see the top of this file

  Collective on the particles' communicator. To be called once for each assembly.

  Notes: adds to ops->work->stencil->regularised the number of fits whose points did not determine
  them. Wall particles on the surface keep the wall velocity.
*/
PetscErrorCode ExtendWalls(const Scene *scene, const Particles *p, const Neighbors *nb,
                           Operators *ops)
{
  Extension ext;
  Entries   list = {0};
  Mat       E;

  PetscFunctionBegin;
  PetscCall(WallVec(p, &list.S));
  PetscCall(ExtensionCreate(scene, p, nb, ops, &ext));
  PetscCall(FillEntries(ops->forms.wall, p, &ext, &list));
  PetscCall(EntriesMat(p, &list, &E));
  for (PetscInt c = 0; c < ops->n_velocity; c++) {
    VelocityOperators *of = &ops->velocity[c];

    PetscCall(ExtendOperator(E, list.S, &of->visc));
    for (PetscInt a = 0; a < scene->dim; a++) PetscCall(ExtendOperator(E, list.S, &of->grad_u[a]));
    PetscCall(ExtendOperator(E, list.S, &of->filter_u));
  }
  ops->work->stencil->regularised += ext.regularised;
  PetscCall(MatDestroy(&E));
  PetscCall(VecDestroy(&list.S));
  PetscCall(PetscFree(list.row));
  PetscCall(PetscFree(list.col));
  PetscCall(PetscFree(list.value));
  PetscCall(ExtensionDestroy(&ext));
  PetscFunctionReturn(PETSC_SUCCESS);
}
