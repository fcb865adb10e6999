/* Outlines in the plane from files: CSV and WKT. They become polygons, or compounds of polygons if
   there are several loops; a loop that is inside an odd number of others is a hole. */
#include "mesh.h"
#include <string.h>

#define CLOSED 1e-9 /* part of the areas by which loops that cross are found */

/* Reads lines "x,y"; other lines begin a new loop. */
static void ReadCsv(MeshFile *file)
{
  PetscInt line = 0;

  while (*file->at && !*file->fault) {
    PetscReal x, y;

    line++;
    file->at += strspn(file->at, " \t");
    if (*file->at == '#') {
      MeshSkipLine(file);
      continue;
    }
    if (strchr("\r\n", *file->at) || !MeshNumber(file, &x)) {
      MeshEndLoop(file);
      MeshSkipLine(file);
      continue;
    }
    file->at += strspn(file->at, " \t");
    if (*file->at == ',' || *file->at == ';') file->at++;
    file->at += strspn(file->at, " \t");
    if (strchr("\r\n", *file->at) || !MeshNumber(file, &y) ||
        !strchr("\r\n", file->at[strspn(file->at, " \t")]))
      MeshFail(file, "line %" PetscInt_FMT " has no two numbers; in 2D a file is CSV or WKT", line);
    MeshAddCorner(file, x, y);
    MeshSkipLine(file);
  }
  MeshEndLoop(file);
}

/* Reads POLYGON ((x y, ...), (...)) and MULTIPOLYGON (((x y, ...)), ...). */
static void ReadWkt(MeshFile *file)
{
  while (!*file->fault && (MeshWord(file, "polygon") || MeshWord(file, "multipolygon"))) {
    PetscInt depth = 0;

    do {
      PetscReal x, y;

      if (MeshWord(file, "(")) depth++;
      else if (MeshWord(file, ")")) {
        depth--;
        MeshEndLoop(file);
      } else if (MeshWord(file, ",")) continue;
      else if (depth && MeshNumber(file, &x) && MeshNumber(file, &y)) MeshAddCorner(file, x, y);
      else MeshFail(file, "two numbers are required at '%.20s'", file->at);
    } while (depth && !*file->fault);
    (void)MeshWord(file, ";");
  }
  file->at += strspn(file->at, " \t\r\n");
  if (*file->at) MeshFail(file, "POLYGON or MULTIPOLYGON is required at '%.20s'", file->at);
}

static void Parse(MeshFile *file)
{
  if (strlen(file->text) < file->length)
    MeshFail(file, "it has bytes of 0, and is no CSV or WKT file");
  else if (MeshWord(file, "polygon") || MeshWord(file, "multipolygon")) {
    file->at = file->text;
    ReadWkt(file);
  } else ReadCsv(file);
}

/* Makes a polygon of each loop. Output: fault - the first. */
static PetscErrorCode MakeParts(const MeshFile *file, PetscReal scale, BodyStore *store,
                                Body part[], const char **fault)
{
  PetscReal *x;

  PetscFunctionBegin;
  *fault = NULL;
  PetscCall(PetscMalloc1(file->n, &x));
  for (PetscInt loop = 0, k = 0; loop < file->loops && !*fault; loop++) {
    PetscInt n = 0;

    for (; k < file->n && file->number[k + 2] == (PetscReal)loop; k += 3)
      for (PetscInt a = 0; a < 2; a++) x[n++] = scale * file->number[k + a];
    part[loop] = (Body){.n = 0};
    *fault     = BodyNumbers(&ShapePolygon, n, x, store, &part[loop]);
  }
  PetscCall(PetscFree(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Orders loops by the number of loops around them, and sets their operations. Returns the area
   between them [m^2]. */
static PetscReal Nest(PetscInt loops, Body part[], PetscInt around[], char operation[])
{
  PetscReal area = 0.0, n[2];

  for (PetscInt k = 0; k < loops; k++) {
    BodyMoments m;

    around[k] = 0;
    for (PetscInt j = 0; j < loops; j++)
      if (j != k) around[k] += part[j].shape->Distance(&part[j], part[k].parameter, n) < 0.0;
    BodyFindMoments(&part[k], &m);
    area += around[k] % 2 ? -m.volume : m.volume;
  }
  for (PetscInt k = 1; k < loops; k++) {
    for (PetscInt j = k; j > 0 && around[j] < around[j - 1]; j--) {
      const Body     body = part[j];
      const PetscInt kept = around[j];

      part[j]       = part[j - 1];
      part[j - 1]   = body;
      around[j]     = around[j - 1];
      around[j - 1] = kept;
    }
  }
  for (PetscInt k = 0; k < loops; k++) operation[k] = around[k] % 2 ? '-' : '+';
  return area;
}

static PetscErrorCode Read(const char option[], const char text[], Body *body)
{
  char       *path, *operation;
  const char *fault;
  PetscReal   scale, area;
  PetscInt   *around;
  MeshFile    file;
  Body       *part;
  BodyMoments moments;

  PetscFunctionBegin;
  PetscCall(MeshPath(option, text, &path, &scale));
  PetscCall(MeshFileRead(option, path, Parse, &file));
  PetscCall(PetscMalloc3(file.loops, &part, file.loops, &operation, file.loops, &around));
  PetscCall(MakeParts(&file, scale, body->store, part, &fault));
  UserCheck(!fault, "%s: %s: %s", option, path, fault);
  area = Nest(file.loops, part, around, operation);
  if (file.loops == 1) {
    *body = part[0];
  } else {
    *body = (Body){.store = body->store};
    PetscCall(BodyCompound(file.loops, part, operation, body, &fault));
    UserCheck(!fault, "%s: %s: %s", option, path, fault);
    BodyFindMoments(body, &moments);
    UserCheck(PetscAbsReal(moments.volume - area) < CLOSED * area,
              "%s: %s: its outlines cross each other; unite them first", option, path);
  }
  PetscCall(PetscFree3(part, operation, around));
  PetscCall(FreeAll(&file.number, &path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const ShapeRow ShapeOutlines = {.name  = "file",
                                .brief = "path[,scale]: outlines of a CSV (lines x,y) or WKT file",
                                .plane = PETSC_TRUE,
                                .Read  = Read};
