/* Reference data: curves given by two columns of numbers in a CSV file. */
#include "isph/io.h"
#include <stdlib.h>

/* Opens a file of the reference data. The environment variable ISPH_DATA names the directory. If it
   is not set, the directory beside the program, the installation and the source tree are searched
   in this order. Output: stream - NULL if the file was not found. */
static PetscErrorCode ReferenceDataOpen(const char file[], FILE **stream)
{
  char              beside[PETSC_MAX_PATH_LEN];
  const char *const given       = getenv("ISPH_DATA");
  const char *const directory[] = {beside, ISPH_DATA_INSTALL, ISPH_DATA_SOURCE};

  PetscFunctionBegin;
  *stream = NULL;
  PetscCall(PathBesideProgram(ISPH_DATA_RELATIVE, beside));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(directory) && !*stream; k++) {
    char path[PETSC_MAX_PATH_LEN];

    PetscCall(PetscSNPrintf(path, sizeof(path), "%s/%s", given ? given : directory[k], file));
    *stream = fopen(path, "r");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Takes the first two columns of rows of numbers as points in ascending x. */
static PetscErrorCode ReferenceDataSort(PetscInt columns, const PetscReal value[],
                                        ReferenceData *curve)
{
  PetscReal *x;
  PetscInt  *order;

  PetscFunctionBegin;
  PetscCall(PetscMalloc2(curve->n, &order, curve->n, &x));
  PetscCall(PetscMalloc1(curve->n, &curve->x));
  PetscCall(PetscMalloc1(curve->n, &curve->y));
  for (PetscInt k = 0; k < curve->n; k++) {
    order[k] = k;
    x[k]     = value[columns * k];
  }
  PetscCall(PetscSortRealWithPermutation(curve->n, x, order));
  for (PetscInt k = 0; k < curve->n; k++) {
    curve->x[k] = x[order[k]];
    curve->y[k] = value[columns * order[k] + 1];
  }
  PetscCall(PetscFree2(order, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReferenceDataRead - Reads a reference curve. Collective on PETSC_COMM_WORLD. Input: file - name
   within the directory of reference data, as of CsvRead(), with two or more columns, of which the
   first two are used. Input/Output: report - records that a file is absent, so that a run prints a
   single warning. Output: curve - the points in ascending x, the same on all ranks; none if the
   file is absent; freed by ReferenceDataFree(). */
PetscErrorCode ReferenceDataRead(const char file[], Report *report, ReferenceData *curve)
{
  PetscMPIInt rank;
  PetscReal  *value;
  PetscInt    columns, bad;
  FILE       *stream = NULL;

  PetscFunctionBegin;
  *curve = (ReferenceData){.n = 0};
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) PetscCall(ReferenceDataOpen(file, &stream));
  PetscCall(CsvRead(stream, &curve->n, &columns, &value, &bad));
  if (stream) (void)fclose(stream);
  if (curve->n < 0) {
    if (!report->data_absent)
      PetscCall(SayLine("%s: reference data not found; set ISPH_DATA to their directory. The "
                        "columns that compare with them stay empty",
                        file));
    report->data_absent = PETSC_TRUE;
    curve->n            = 0;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(!bad && (columns > 1 || !curve->n), PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "%s: line %" PetscInt_FMT " of the reference data is not two numbers", file, bad);
  PetscCheck(curve->n, PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "%s: the reference data hold no numbers", file);
  PetscCall(ReferenceDataSort(columns, value, curve));
  PetscCall(PetscFree(value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReferenceDataFree - Frees reference data */
PetscErrorCode ReferenceDataFree(ReferenceData *curve)
{
  PetscFunctionBegin;
  PetscCall(FreeAll(&curve->x, &curve->y));
  curve->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
