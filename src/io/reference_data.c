/*
  Reference data: two columns of numbers in a CSV file. The first rank reads them, and all ranks
  receive them.
*/
#include "isph/io.h"
#include <stdlib.h>

/*
  Opens a file of the reference data. The environment variable ISPH_DATA names the directory. If it
  is not set, the directory beside the program, the installation and the source tree are searched in
  this order. Output: stream - NULL if the file was not found.
*/
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

static PetscErrorCode ReferenceDataAppend(ReferenceData *curve, PetscInt *capacity, PetscReal x,
                                          PetscReal y)
{
  PetscFunctionBegin;
  if (curve->n == *capacity) {
    *capacity = 2 * *capacity + 64;
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)*capacity, &curve->x));
    PetscCall(PetscRealloc(sizeof(PetscReal) * (size_t)*capacity, &curve->y));
  }
  curve->x[curve->n] = x;
  curve->y[curve->n] = y;
  curve->n++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Reads '#' comments, a header and lines of numbers. Output: bad - number of the first line without
  two numbers, or 0. Comments may be longer than the buffer.
*/
static PetscErrorCode ReferenceDataParse(FILE *stream, ReferenceData *curve, PetscInt *bad)
{
  char      piece[512];
  PetscBool starts = PETSC_TRUE, header = PETSC_TRUE;
  PetscInt  line = 0, capacity = 0;

  PetscFunctionBegin;
  *bad = 0;
  while (!*bad && fgets(piece, (int)sizeof(piece), stream)) {
    const PetscBool first = starts;
    size_t          length;
    char           *comma, *end;
    PetscReal       x, y;

    PetscCall(PetscStrlen(piece, &length));
    starts = length && piece[length - 1] == '\n';
    if (first) line++;
    if (!first || piece[0] == '#' || piece[0] == '\n' || piece[0] == '\r') continue;
    if (header) {
      header = PETSC_FALSE;
      continue;
    }
    x = (PetscReal)strtod(piece, &comma);
    y = *comma == ',' ? (PetscReal)strtod(comma + 1, &end) : 0.0;
    if (comma == piece || *comma != ',' || end == comma + 1) *bad = line;
    else PetscCall(ReferenceDataAppend(curve, &capacity, x, y));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Sorts the points by x. */
static PetscErrorCode ReferenceDataSort(ReferenceData *curve)
{
  PetscInt  *order;
  PetscReal *x, *y;

  PetscFunctionBegin;
  PetscCall(PetscMalloc3(curve->n, &order, curve->n, &x, curve->n, &y));
  for (PetscInt k = 0; k < curve->n; k++) order[k] = k;
  PetscCall(PetscSortRealWithPermutation(curve->n, curve->x, order));
  PetscCall(PetscArraycpy(x, curve->x, curve->n));
  PetscCall(PetscArraycpy(y, curve->y, curve->n));
  for (PetscInt k = 0; k < curve->n; k++) {
    curve->x[k] = x[order[k]];
    curve->y[k] = y[order[k]];
  }
  PetscCall(PetscFree3(order, x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ReferenceDataRead - Reads a reference curve

  Collective on PETSC_COMM_WORLD

  Input Parameter:
. file - name within the directory of reference data: '#' comments, a header line, then lines of
         two or more columns, of which the first two are used

  Input/Output Parameter:
. report - records that a file is absent, so that a run prints a single warning

  Output Parameter:
. curve - the points in ascending x, the same on all ranks; none if the file is absent; freed by
          ReferenceDataFree()

  Errors: a file that is empty or holds a line without two numbers ends the run
*/
PetscErrorCode ReferenceDataRead(const char file[], Report *report, ReferenceData *curve)
{
  PetscMPIInt rank;
  PetscInt    found[3] = {0, 0, 0}; /* opened, points, first bad line */

  PetscFunctionBegin;
  PetscCall(PetscMemzero(curve, sizeof(*curve)));
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) {
    FILE *stream;

    PetscCall(ReferenceDataOpen(file, &stream));
    if (stream) {
      found[0] = 1;
      PetscCall(ReferenceDataParse(stream, curve, &found[2]));
      (void)fclose(stream);
    }
    found[1] = curve->n;
  }
  PetscCallMPI(MPI_Bcast(found, 3, MPIU_INT, 0, PETSC_COMM_WORLD));
  if (!found[0]) {
    if (!report->data_absent)
      PetscCall(SayLine("%s: reference data not found; set ISPH_DATA to their directory. The "
                        "columns that compare with them stay empty",
                        file));
    report->data_absent = PETSC_TRUE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCheck(!found[2], PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "%s: line %" PetscInt_FMT " of the reference data is not two numbers", file, found[2]);
  PetscCheck(found[1], PETSC_COMM_WORLD, PETSC_ERR_FILE_UNEXPECTED,
             "%s: the reference data hold no numbers", file);
  if (rank == 0) {
    PetscCall(ReferenceDataSort(curve));
  } else {
    curve->n = found[1];
    PetscCall(PetscMalloc(sizeof(PetscReal) * (size_t)curve->n, &curve->x));
    PetscCall(PetscMalloc(sizeof(PetscReal) * (size_t)curve->n, &curve->y));
  }
  PetscCallMPI(MPI_Bcast(curve->x, (PetscMPIInt)curve->n, MPIU_REAL, 0, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Bcast(curve->y, (PetscMPIInt)curve->n, MPIU_REAL, 0, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ReferenceDataFree - Frees reference data; not collective */
PetscErrorCode ReferenceDataFree(ReferenceData *curve)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(curve->x));
  PetscCall(PetscFree(curve->y));
  curve->n = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
