/* Reads files of shapes: the first rank reads and parses, and all ranks receive the numbers, or the
   fault. Parsers stop at the first fault, and every number that they add is finite. */
#include "mesh.h"
#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define MOST_CORNERS 10000 /* of outlines: sides of polygons are compared with all others */

#define MOST_BYTES   2000000000.0 /* of a file */
#define MOST_NUMBERS 200000000    /* about 20 million triangles */

/* MeshFail - Sets the fault of a file, unless it has an earlier one */
void MeshFail(MeshFile *file, const char format[], ...)
{
  va_list list;

  if (*file->fault) return;
  va_start(list, format);
  (void)vsnprintf(file->fault, FAULT, format, list);
  va_end(list);
}

/* MeshWord - Passes a word, in letters of either case, and the blanks before it; returns false if
   another text is next */
PetscBool MeshWord(MeshFile *file, const char word[])
{
  const size_t n  = strlen(word);
  const char  *at = file->at;

  while (isspace((unsigned char)*at)) at++;
  for (size_t k = 0; k < n; k++)
    if (tolower((unsigned char)at[k]) != word[k]) return PETSC_FALSE;
  if (isalnum((unsigned char)word[n - 1]) && isalnum((unsigned char)at[n])) return PETSC_FALSE;
  file->at = at + n;
  return PETSC_TRUE;
}

/* MeshNumber - Reads a number and passes it; returns false, and sets no fault, if there is none */
PetscBool MeshNumber(MeshFile *file, PetscReal *x)
{
  char *end;

  *x = strtod(file->at, &end);
  if (end == file->at) return PETSC_FALSE;
  file->at = end;
  return PETSC_TRUE;
}

/* MeshSkipLine - Passes the rest of a line */
void MeshSkipLine(MeshFile *file)
{
  file->at += strcspn(file->at, "\n");
  if (*file->at) file->at++;
}

/* MeshAdd - Adds n numbers to a file, or a fault if one is not finite */
void MeshAdd(MeshFile *file, PetscInt n, const PetscReal x[])
{
  if (*file->fault) return;
  if (file->n + n > MOST_NUMBERS) {
    MeshFail(file, "it has over %d numbers", MOST_NUMBERS);
    return;
  }
  if (file->n + n > file->capacity) {
    file->capacity = 2 * file->capacity + 4096;
    if (PetscRealloc(sizeof(*x) * (size_t)file->capacity, &file->number)) {
      MeshFail(file, "there is no memory for it");
      return;
    }
  }
  for (PetscInt k = 0; k < n; k++) {
    if (!isfinite(x[k]))
      MeshFail(file, "a coordinate is not finite, behind %" PetscInt_FMT " numbers", file->n);
    file->number[file->n++] = x[k];
  }
}

/* MeshAddPolygon - Adds the triangles of a plane polygon of n corners, numbers from 0 of points x,
   that share its first corner; one that this does not cover is a fault */
void MeshAddPolygon(MeshFile *file, PetscInt n, const PetscInt corner[], PetscInt corners,
                    const PetscReal x[])
{
  PetscReal sum[3] = {0.0};

  if (n < 3) MeshFail(file, "a face has %" PetscInt_FMT " corners; 3 or more are needed", n);
  for (PetscInt k = 0; k < n; k++)
    if (corner[k] < 0 || corner[k] >= corners)
      MeshFail(file, "a face has corner %" PetscInt_FMT ", of %" PetscInt_FMT, corner[k], corners);
  for (PetscInt pass = 0; pass < 2; pass++) {
    for (PetscInt k = 1; k + 1 < n && !*file->fault; k++) {
      const PetscReal *a = &x[3 * corner[0]], *b = &x[3 * corner[k]], *c = &x[3 * corner[k + 1]];
      PetscReal        along = 0.0, t[9];

      for (PetscInt i = 0; i < 3; i++) {
        const PetscInt  j = (i + 1) % 3, l = (i + 2) % 3;
        const PetscReal area = (b[j] - a[j]) * (c[l] - a[l]) - (b[l] - a[l]) * (c[j] - a[j]);

        t[i]     = a[i];
        t[3 + i] = b[i];
        t[6 + i] = c[i];
        along += area * sum[i];
        if (!pass) sum[i] += area;
      }
      if (pass && along < 0.0)
        MeshFail(file, "the face at (%g, %g, %g) is not convex; divide such faces into triangles",
                 (double)a[0], (double)a[1], (double)a[2]);
      if (pass) MeshAdd(file, 9, t);
    }
  }
}

/* MeshAddCorner - Adds a corner of the present loop, unless it repeats the last one */
void MeshAddCorner(MeshFile *file, PetscReal x, PetscReal y)
{
  const PetscReal  corner[3] = {x, y, (PetscReal)file->loops};
  const PetscReal *last      = file->n ? &file->number[file->n - 3] : NULL;

  if (last && last[2] == corner[2] && last[0] == x && last[1] == y) return;
  if (file->n >= 3 * MOST_CORNERS)
    MeshFail(file, "its outlines have over %d corners; simplify them", MOST_CORNERS);
  MeshAdd(file, 3, corner);
}

/* MeshEndLoop - Ends the present loop, and leaves out a last corner at the place of the first */
void MeshEndLoop(MeshFile *file)
{
  PetscInt   n = 0;
  PetscReal *x;

  while (n < file->n / 3 && file->number[file->n - 3 * n - 1] == (PetscReal)file->loops) n++;
  if (n == 0) return;
  x = &file->number[file->n - 3 * n];
  if (n > 1 && x[0] == x[3 * n - 3] && x[1] == x[3 * n - 2]) {
    file->n -= 3;
    n--;
  }
  if (n < 3)
    MeshFail(file, "an outline at (%g, %g) has %" PetscInt_FMT " corners", (double)x[0],
             (double)x[1], n);
  file->loops++;
}

/* Reads the bytes of a file on the first rank. */
static void ReadBytes(const char path[], MeshFile *file)
{
  FILE *stream = FileIsReadable(path) ? fopen(path, "rb") : NULL;
  long  length = -1;

  if (stream && !fseek(stream, 0, SEEK_END)) length = ftell(stream);
  if (length < 0) MeshFail(file, "it cannot be read, or is no regular file");
  else if (length == 0) MeshFail(file, "it is empty");
  else if ((double)length > MOST_BYTES) MeshFail(file, "it is larger than 2 GB");
  else if (PetscMalloc1((size_t)length + 1, &file->text)) MeshFail(file, "there is no memory");
  if (!*file->fault) {
    rewind(stream);
    file->length = fread(file->text, 1, (size_t)length, stream);
    if (file->length != (size_t)length) MeshFail(file, "it cannot be read to its end");
    file->text[file->length] = '\0';
    file->at                 = file->text;
  }
  if (stream) (void)fclose(stream);
}

/* MeshFileRead - Reads a file of a shape; collective. Input: Parse - adds the numbers of
   file->text, or a fault. Output: file - its numbers, equal on all ranks; the caller frees
   file->number. Errors: a fault ends the run. */
PetscErrorCode MeshFileRead(const char option[], const char path[], void (*Parse)(MeshFile *file),
                            MeshFile *file)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  *file = (MeshFile){.n = 0};
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) {
    ReadBytes(path, file);
    if (!*file->fault) Parse(file);
    if (!*file->fault && !file->n) MeshFail(file, "it has no face and no outline");
    PetscCall(PetscFree(file->text));
  }
  PetscCallMPI(MPI_Bcast(file->fault, FAULT, MPI_CHAR, 0, PETSC_COMM_WORLD));
  UserCheck(!*file->fault, "%s: %s: %s", option, path, file->fault);
  PetscCallMPI(MPI_Bcast(&file->n, 1, MPIU_INT, 0, PETSC_COMM_WORLD));
  PetscCallMPI(MPI_Bcast(&file->loops, 1, MPIU_INT, 0, PETSC_COMM_WORLD));
  if (rank) PetscCall(PetscMalloc1(file->n, &file->number));
  PetscCallMPI(MPI_Bcast(file->number, (PetscMPIInt)file->n, MPIU_REAL, 0, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}
