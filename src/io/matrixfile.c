/*
  Matrices for study outside: in the order of particle ids, which neither ranks nor epochs change,
  with ids and positions in a file beside them.
*/
#include "isph/io.h"

struct MatrixFile {
  const char       *prefix; /* of the option, without its dash */
  PetscViewer       viewer; /* NULL: not asked for */
  PetscViewerFormat format;
};

/*
  MatrixFileCreate - Opens what -<prefix>mat_view asks for

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
. -visc_mat_view, -ppe_mat_view - binary:file, ascii:file[:ascii_matlab] or any viewer of PETSc's

  Errors: a file that cannot be opened ends the run
*/
PetscErrorCode MatrixFileCreate(const char prefix[], MatrixFile **file)
{
  PetscBool set;

  PetscFunctionBegin;
  PetscCall(PetscNew(file));
  (*file)->prefix = prefix;
  PetscCall(PetscOptionsCreateViewer(PETSC_COMM_WORLD, NULL, prefix, "-mat_view", &(*file)->viewer,
                                     &(*file)->format, &set));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MatrixFileDestroy(MatrixFile **file)
{
  PetscFunctionBegin;
  if (!*file) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscViewerDestroy(&(*file)->viewer));
  PetscCall(PetscFree(*file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A vector over fluid particles in the order of their ids, rank after rank as many as it owns. */
static PetscErrorCode VecById(const Particles *p, const PetscReal values[], Vec *by_id)
{
  PetscFunctionBegin;
  PetscCall(FluidVec(p, NULL, by_id));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    PetscCall(VecSetValue(*by_id, p->id[i], values ? values[i] : p->row[i], INSERT_VALUES));
  PetscCall(VecAssemblyBegin(*by_id));
  PetscCall(VecAssemblyEnd(*by_id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Global numbers of the particles in the order of their ids, each standing for `size` rows. */
static PetscErrorCode NumbersById(const Particles *p, PetscInt size, IS *order)
{
  const PetscScalar *number;
  PetscInt          *indices;
  Vec                by_id;

  PetscFunctionBegin;
  PetscCall(VecById(p, NULL, &by_id));
  PetscCall(PetscMalloc1(p->n_fluid, &indices));
  PetscCall(VecGetArrayRead(by_id, &number));
  for (PetscInt k = 0; k < p->n_fluid; k++) indices[k] = (PetscInt)number[k];
  PetscCall(VecRestoreArrayRead(by_id, &number));
  PetscCall(VecDestroy(&by_id));
  PetscCall(ISCreateBlock(p->comm, size, p->n_fluid, indices, PETSC_OWN_POINTER, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The ids and positions of the matrix's rows, in a file beside its own. */
static PetscErrorCode WritePositions(const Particles *p, const char matrix[])
{
  char             path[PETSC_MAX_PATH_LEN];
  Vec              by_id[ISPH_MAX_DIM];
  const PetscReal *x[ISPH_MAX_DIM];
  FILE            *stream;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s.particles.csv", matrix));
  PetscCall(PetscFOpen(p->comm, path, "w", &stream));
  PetscCall(PetscFPrintf(p->comm, stream, "id,x,y%s\n", p->dim == 3 ? ",z" : ""));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecById(p, p->x[a], &by_id[a]));
    PetscCall(VecGetArrayRead(by_id[a], &x[a]));
  }
  for (PetscInt k = 0; k < p->n_fluid; k++) {
    PetscCall(PetscSynchronizedFPrintf(p->comm, stream, "%" PetscInt_FMT, p->fluid_start + k));
    for (PetscInt a = 0; a < p->dim; a++)
      PetscCall(PetscSynchronizedFPrintf(p->comm, stream, ",%.17g", (double)x[a][k]));
    PetscCall(PetscSynchronizedFPrintf(p->comm, stream, "\n"));
  }
  PetscCall(PetscSynchronizedFlush(p->comm, stream));
  for (PetscInt a = 0; a < p->dim; a++) {
    PetscCall(VecRestoreArrayRead(by_id[a], &x[a]));
    PetscCall(VecDestroy(&by_id[a]));
  }
  PetscCall(PetscFClose(p->comm, stream));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MatrixFileWrite - Writes a matrix over the fluid as it is now, if it was asked for

  Collective. Row and column k of what is written, or the dim from dim k on where components
  go together, belong to the particle of id k, wherever and
  whatever its number; <file>.particles.csv has the ids and positions [m].

  Input Parameter:
. A - in the particles' present numbering; NULL: there is none, which is told
*/
PetscErrorCode MatrixFileWrite(const Particles *p, Mat A, MatrixFile *file)
{
  const char *path = NULL;
  PetscBool   binary, ascii;
  PetscInt    size;
  IS          order;
  Mat         by_id;

  PetscFunctionBegin;
  if (!file->viewer) PetscFunctionReturn(PETSC_SUCCESS);
  if (!A) {
    PetscCall(SayLine("-%smat_view: nothing was solved, so there is no matrix", file->prefix));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatGetBlockSize(A, &size));
  PetscCall(NumbersById(p, size, &order));
  PetscCall(MatCreateSubMatrix(A, order, order, MAT_INITIAL_MATRIX, &by_id));
  PetscCall(PetscViewerPushFormat(file->viewer, file->format));
  PetscCall(MatView(by_id, file->viewer));
  PetscCall(PetscViewerPopFormat(file->viewer));
  PetscCall(PetscViewerFlush(file->viewer));
  PetscCall(PetscObjectTypeCompare((PetscObject)file->viewer, PETSCVIEWERBINARY, &binary));
  PetscCall(PetscObjectTypeCompare((PetscObject)file->viewer, PETSCVIEWERASCII, &ascii));
  if (binary || ascii) PetscCall(PetscViewerFileGetName(file->viewer, &path));
  if (path && path[0]) PetscCall(WritePositions(p, path));
  PetscCall(MatDestroy(&by_id));
  PetscCall(ISDestroy(&order));
  PetscFunctionReturn(PETSC_SUCCESS);
}
