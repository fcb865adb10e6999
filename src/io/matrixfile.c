/*
  Files of matrices for analysis by other programs. Rows stand in the order of particle ids, which
  depends neither on ranks nor on epochs. Ids may have gaps, row numbers have none: a second file
  holds the id and the position of each row.
*/
#include "isph/io.h"

static const char *const Matrices[] = {"visc", "ppe", NULL};
static const OptionRow   options[]  = {
       {
           .name   = "-<matrix>_mat_view",
           .kind   = VALUE_VIEWER,
           .brief  = "matrix of the last solve, e.g. binary:file or ascii:file:ascii_matlab, with "
                        "rows in the order of ids; another file holds ids and positions",
           .places = Matrices,
           .where  = "runs that solve with that matrix; ppe only with -pressure_points same",
    },
};
const OptionTable MatrixOptions = OPTIONS("Matrices", options);

struct MatrixFile {
  const char       *prefix; /* of the option, without dash */
  PetscViewer       viewer;
  PetscViewerFormat format;
};

/*
  MatrixFileCreate - Opens the viewer of -<prefix>mat_view

  Collective on PETSC_COMM_WORLD.

  Options Database Keys:
. -visc_mat_view, -ppe_mat_view - binary:file, ascii:file[:ascii_matlab] or any PETSc viewer

  Output: file - NULL unless the option is given

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
  if (!(*file)->viewer) PetscCall(PetscFree(*file));
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

/* Creates a vector in the order of the rows of the file from values of own fluid particles. Its
   local size on each rank is the number of own fluid particles. */
static PetscErrorCode SortById(const Particles *p, const PetscInt index[], const PetscReal values[],
                               Vec *by_id)
{
  PetscFunctionBegin;
  PetscCall(FluidVec(p, NULL, by_id));
  PetscCall(VecSetValues(*by_id, p->n_fluid, index, values, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(*by_id));
  PetscCall(VecAssemblyEnd(*by_id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Creates the index set of global numbers in the order of ids, with `size` numbers per particle. */
static PetscErrorCode NumbersById(const Particles *p, const PetscInt index[], PetscInt size,
                                  IS *order)
{
  const PetscScalar *number;
  PetscReal         *row;
  PetscInt          *indices;
  Vec                by_id;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(p->n_fluid, &row));
  for (PetscInt i = 0; i < p->n_fluid; i++) row[i] = (PetscReal)p->row[i];
  PetscCall(SortById(p, index, row, &by_id));
  PetscCall(PetscFree(row));
  PetscCall(PetscMalloc1(p->n_fluid, &indices));
  PetscCall(VecGetArrayRead(by_id, &number));
  for (PetscInt k = 0; k < p->n_fluid; k++) indices[k] = (PetscInt)number[k];
  PetscCall(VecRestoreArrayRead(by_id, &number));
  PetscCall(VecDestroy(&by_id));
  PetscCall(ISCreateBlock(p->comm, size, p->n_fluid, indices, PETSC_OWN_POINTER, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the ids and positions of the rows to a second file. */
static PetscErrorCode WritePositions(const Particles *p, const PetscInt index[],
                                     const char matrix[])
{
  char             path[PETSC_MAX_PATH_LEN];
  Vec              by_id[1 + ISPH_MAX_DIM];
  const PetscReal *column[1 + ISPH_MAX_DIM];
  PetscReal       *id;
  FILE            *stream;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s.particles.csv", matrix));
  PetscCall(PetscFOpen(p->comm, path, "w", &stream));
  PetscCall(PetscFPrintf(p->comm, stream, "id,x,y%s\n", p->dim == 3 ? ",z" : ""));
  PetscCall(PetscMalloc1(p->n_fluid, &id));
  for (PetscInt i = 0; i < p->n_fluid; i++) id[i] = (PetscReal)p->id[i];
  for (PetscInt c = 0; c <= p->dim; c++) {
    PetscCall(SortById(p, index, c ? p->x[c - 1] : id, &by_id[c]));
    PetscCall(VecGetArrayRead(by_id[c], &column[c]));
  }
  PetscCall(PetscFree(id));
  for (PetscInt k = 0; k < p->n_fluid; k++) {
    PetscCall(PetscSynchronizedFPrintf(p->comm, stream, "%.0f", (double)column[0][k]));
    for (PetscInt c = 1; c <= p->dim; c++)
      PetscCall(PetscSynchronizedFPrintf(p->comm, stream, ",%.17g", (double)column[c][k]));
    PetscCall(PetscSynchronizedFPrintf(p->comm, stream, "\n"));
  }
  PetscCall(PetscSynchronizedFlush(p->comm, stream));
  for (PetscInt c = 0; c <= p->dim; c++) {
    PetscCall(VecRestoreArrayRead(by_id[c], &column[c]));
    PetscCall(VecDestroy(&by_id[c]));
  }
  PetscCall(PetscFClose(p->comm, stream));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MatrixFileWrite - Writes the present matrix over fluid particles

  Collective. Row and column k of the file belong to the fluid particle with the k-th smallest id;
  if A couples the velocity components, rows and columns dim k to dim k + dim - 1 belong to it. Row
  k of <file>.particles.csv has its id and position [m].

  Input Parameter:
. A - matrix in the present numbering of particles; NULL: there is none, and a message says so
*/
PetscErrorCode MatrixFileWrite(const Particles *p, Mat A, MatrixFile *file)
{
  const char *path = NULL;
  char        option[OPTION_LENGTH];
  PetscBool   binary, ascii;
  PetscInt    size, *index;
  IS          order;
  Mat         by_id;

  PetscFunctionBegin;
  if (!A) {
    PetscCall(SayLine("-%smat_view: nothing was solved, so there is no matrix", file->prefix));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatGetBlockSize(A, &size));
  PetscCall(PetscMalloc1(p->n_fluid, &index));
  PetscCall(ParticlesNumberById(p, index));
  PetscCall(NumbersById(p, index, size, &order));
  PetscCall(MatCreateSubMatrix(A, order, order, MAT_INITIAL_MATRIX, &by_id));
  PetscCall(PetscViewerPushFormat(file->viewer, file->format));
  PetscCall(MatView(by_id, file->viewer));
  PetscCall(PetscViewerPopFormat(file->viewer));
  PetscCall(PetscSNPrintf(option, sizeof(option), "-%smat_view", file->prefix));
  PetscCall(ViewerCheck(file->viewer, option));
  PetscCall(PetscViewerFlush(file->viewer));
  PetscCall(PetscObjectTypeCompare((PetscObject)file->viewer, PETSCVIEWERBINARY, &binary));
  PetscCall(PetscObjectTypeCompare((PetscObject)file->viewer, PETSCVIEWERASCII, &ascii));
  if (binary || ascii) PetscCall(PetscViewerFileGetName(file->viewer, &path));
  if (path && path[0]) PetscCall(WritePositions(p, index, path));
  PetscCall(PetscFree(index));
  PetscCall(MatDestroy(&by_id));
  PetscCall(ISDestroy(&order));
  PetscFunctionReturn(PETSC_SUCCESS);
}
