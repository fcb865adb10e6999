/* Lines of numbers in a CSV file. The first rank reads them, and all ranks receive them. */
#include "isph/base.h"
#include <stdlib.h>
#include <string.h>

/* Appends the numbers of a line to those before it; returns their count, -1 if the line has other
   text. */
static PetscInt AppendLine(char line[], size_t n, size_t *room, PetscReal **value)
{
  PetscInt columns = 0;
  char    *end;

  for (char *next = line; next; columns++) {
    const PetscReal number = strtod(next, &end);

    if (end == next || PetscIsInfOrNanReal(number)) return -1;
    end += strspn(end, " \t\r\n");
    if (*end != ',' && *end) return -1;
    if (n == *room) {
      *room = 2 * *room + 64;
      if (PetscRealloc(sizeof(**value) * *room, value)) return -1;
    }
    (*value)[n++] = number;
    next          = *end ? end + 1 : NULL;
  }
  return columns;
}

/* Reads the lines of a file on the first rank. Output: found - as of CsvRead(): rows, columns,
   number of the first bad line. */
static PetscErrorCode ReadLines(FILE *stream, PetscInt found[3], PetscReal **value)
{
  size_t   bytes = 0, room = 0;
  char    *line  = NULL;
  PetscInt total = 0;

  PetscFunctionBegin;
  for (PetscInt k = 1; !found[2] && getline(&line, &bytes, stream) >= 0; k++) {
    PetscInt columns;

    if (strchr("#\r\n", line[0])) continue;
    columns = AppendLine(line, (size_t)(found[0] * found[1]), &room, value);
    if (columns < 0 && total++ == 0) continue; /* the header */
    if (columns < 0 || (found[0] && columns != found[1])) found[2] = k;
    else found[1] = columns;
    found[0]++;
    total++;
  }
  free(line);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CsvRead - Reads the lines of numbers of a CSV file: '#' comments, a header or none, and lines
   that all have the same number of finite numbers. Collective on PETSC_COMM_WORLD. Input: stream -
   the file, on the first rank; NULL: there is none. Output: rows - number of lines with numbers;
   -1: there is no file; columns - numbers in each; value - the numbers, line after line, the same
   on all ranks; freed by PetscFree(); bad - number in the file of the first line that is wrong; 0:
   none. */
PetscErrorCode CsvRead(FILE *stream, PetscInt *rows, PetscInt *columns, PetscReal **value,
                       PetscInt *bad)
{
  PetscMPIInt rank;
  PetscInt    found[3] = {0, 0, 0};

  PetscFunctionBegin;
  *value = NULL;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0 && stream) PetscCall(ReadLines(stream, found, value));
  if (rank == 0 && !stream) found[0] = -1;
  PetscCallMPI(MPI_Bcast(found, 3, MPIU_INT, 0, PETSC_COMM_WORLD));
  *rows    = found[0];
  *columns = found[1];
  *bad     = found[2];
  if (*rows < 1 || *bad) PetscFunctionReturn(PETSC_SUCCESS);
  if (rank != 0) PetscCall(PetscMalloc1(*rows * *columns, value));
  PetscCallMPI(MPI_Bcast(*value, (PetscMPIInt)(*rows * *columns), MPIU_REAL, 0, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}
