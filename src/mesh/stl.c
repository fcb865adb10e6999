/* Files of triangles: STL, binary or text, and OBJ. A binary STL file is known by its length,
   because some of them begin with "solid", the first word of texts. */
#include "mesh.h"
#include <stdint.h>
#include <string.h>

#define HEADER 84 /* bytes before the triangles of a binary STL file */
#define RECORD 50 /* bytes of a triangle */

static void ReadBinary(MeshFile *file, PetscInt n)
{
  for (PetscInt t = 0; t < n && !*file->fault; t++) {
    const char *at = file->text + HEADER + (size_t)t * RECORD + 12; /* behind the normal */
    PetscReal   x[9];

    for (PetscInt k = 0; k < 9; k++) {
      uint32_t word = 0;
      float    value;

      for (PetscInt byte = 3; byte >= 0; byte--) word = word << 8 | (unsigned char)at[4 * k + byte];
      memcpy(&value, &word, sizeof(value));
      x[k] = value;
    }
    MeshAdd(file, 9, x);
  }
}

static void ReadText(MeshFile *file)
{
  PetscReal x[9];
  PetscInt  n = 0;

  if (strlen(file->text) < file->length) MeshFail(file, "it begins as a text, but has bytes of 0");
  MeshSkipLine(file);
  while (!*file->fault && *file->at) {
    if (MeshWord(file, "vertex")) {
      for (PetscInt a = 0; a < 3; a++)
        if (!MeshNumber(file, &x[3 * n + a]))
          MeshFail(file, "a number is required at '%.20s'", file->at);
      n = (n + 1) % 3;
      if (n == 0) MeshAdd(file, 9, x);
    } else if (MeshWord(file, "endfacet") || MeshWord(file, "facet")) {
      if (n) MeshFail(file, "a facet has no three corners");
    } else if (MeshWord(file, "endsolid")) {
      MeshSkipLine(file);
      if (MeshWord(file, "solid")) MeshSkipLine(file);
      else file->at = file->text + file->length;
      if (!*file->at) return;
      continue;
    }
    MeshSkipLine(file);
  }
  MeshFail(file, "it ends without 'endsolid': a part of it is missing");
}

/* MeshReadStl - Reads an STL file */
void MeshReadStl(MeshFile *file)
{
  const unsigned char *count = (const unsigned char *)file->text + 80;
  double               n     = 0.0;

  if (file->length >= HEADER)
    n = count[0] + 256.0 * count[1] + 65536.0 * count[2] + 16777216.0 * count[3];
  if (file->length >= HEADER && (double)file->length == HEADER + RECORD * n)
    ReadBinary(file, (PetscInt)n);
  else if (MeshWord(file, "solid")) ReadText(file);
  else if (strlen(file->text) == file->length)
    MeshFail(file, "it is no STL or OBJ file, as a shape in 3D is");
  else
    MeshFail(file,
             "as a binary STL file with %.0f triangles it should have %.0f bytes "
             "in place of %.0f",
             n, HEADER + RECORD * n, (double)file->length);
}

/* Reads the corners of a face of an OBJ file, as 3, 3/1, 3//2 or 3/1/2, and -1 for the last. */
static void ReadFace(MeshFile *file, PetscInt corners, const PetscReal x[])
{
  PetscInt  corner[64], n = 0;
  PetscReal number;

  while (strspn(file->at, " \t")) {
    file->at += strspn(file->at, " \t");
    if (strchr("\r\n", *file->at) || !MeshNumber(file, &number)) break;
    if (n == 64) MeshFail(file, "a face has over 64 corners");
    if (n == 64) return;
    corner[n++] =
        (PetscInt)(number < 0.0 ? PetscMax(number, -1e9) + corners : PetscMin(number, 1e9) - 1.0);
    file->at += strcspn(file->at, " \t\r\n");
  }
  MeshAddPolygon(file, n, corner, corners, x);
}

/* MeshReadObj - Reads the faces of an OBJ file */
void MeshReadObj(MeshFile *file)
{
  MeshFile points = {.n = 0};

  if (strlen(file->text) < file->length) MeshFail(file, "it has bytes of 0, and is no text");
  for (; *file->at && !*file->fault; MeshSkipLine(file)) {
    if (file->at[0] == 'v' && strchr(" \t", file->at[1])) {
      PetscReal x[3];

      file->at++;
      for (PetscInt a = 0; a < 3; a++)
        if (!MeshNumber(file, &x[a])) MeshFail(file, "a number is required at '%.20s'", file->at);
      if (!*file->fault) MeshAdd(&points, 3, x);
      if (*points.fault) MeshFail(file, "%s", points.fault);
    } else if (file->at[0] == 'f' && strchr(" \t", file->at[1])) {
      file->at++;
      ReadFace(file, points.n / 3, points.number);
    }
  }
  (void)PetscFree(points.number);
}
