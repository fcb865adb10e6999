/* Solids from files of triangles, as bodies and regions in space. */
#include "mesh.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const Mesh *MeshOf(const Body *body)
{
  return (const Mesh *)((const Solid *)body->data)->mesh;
}

/* MeshPath - Splits "path[,scale]"; the caller frees the path; collective */
PetscErrorCode MeshPath(const char option[], const char text[], char **path, PetscReal *scale)
{
  char *comma, *end;

  PetscFunctionBegin;
  *scale = 1.0;
  PetscCall(PetscStrallocpy(text, path));
  comma = strrchr(*path, ',');
  if (comma) {
    *scale = strtod(comma + 1, &end);
    UserCheck(end > comma + 1 && !end[strspn(end, " ")] && *scale > 0.0 && *scale < 1e30,
              "%s: the scale of a file is a number above 0, not '%.40s'", option, comma + 1);
    *comma = '\0';
  }
  for (size_t n = strlen(*path); n && (*path)[n - 1] == ' '; n--) (*path)[n - 1] = '\0';
  UserCheck(**path, "%s: a file is path or path,scale", option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the format by the content. */
static void Parse(MeshFile *file)
{
  const char *line = file->text;

  while (*line && !(line[0] == 'v' && line[1] == ' ') && !MeshWord(file, "solid")) {
    file->at = line += strcspn(line, "\n");
    if (*line) line++;
    file->at = line;
  }
  file->at = file->text;
  if (line[0] == 'v' && line[1] == ' ') MeshReadObj(file);
  else MeshReadStl(file);
}

/* Integrates over the tetrahedra between the triangles and the corner of the box: for corners a, b,
   c with s = a + b + c, V = a.(b x c)/6,

     int x_i dV = V s_i/4,   int x_i x_j dV = V (s_i s_j + a_i a_j + b_i b_j + c_i c_j)/20 */
static void FindMoments(const Body *body, BodyMoments *m)
{
  const Mesh *mesh     = MeshOf(body);
  PetscReal   first[3] = {0.0};

  *m = (BodyMoments){.volume = 0.0};
  for (PetscInt t = 0; t < mesh->triangles; t++) {
    const PetscReal *x[3];
    PetscReal        normal[3], height = 0.0, volume, r[4][3];
    const PetscReal  area = MeshTriangle(mesh, t, x, normal);

    for (PetscInt a = 0; a < 3; a++) {
      for (PetscInt k = 0; k < 3; k++) r[k][a] = x[k][a] - mesh->lo[a];
      r[3][a] = r[0][a] + r[1][a] + r[2][a];
      height += r[0][a] * normal[a];
    }
    volume = area * height / 3.0;
    m->volume += volume;
    for (PetscInt i = 0; i < 3; i++) {
      first[i] += volume * r[3][i] / 4.0;
      for (PetscInt j = 0; j < 3; j++)
        for (PetscInt k = 0; k < 4; k++) m->second[i][j] += volume * r[k][i] * r[k][j] / 20.0;
    }
  }
  for (PetscInt i = 0; i < 3; i++) {
    m->centroid[i] = mesh->lo[i] + first[i] / m->volume;
    for (PetscInt j = 0; j < 3; j++) m->second[i][j] -= first[i] * first[j] / m->volume;
  }
}

/* Sets the numbers that identify the surface: a checksum (FNV-1a) and the number of triangles. */
static PetscErrorCode SetNumbers(const Mesh *mesh, Body *body)
{
  uint64_t hash = 14695981039346656037u;

  PetscFunctionBegin;
  for (PetscInt k = 0; k < 9 * mesh->triangles; k++) {
    uint64_t word;

    memcpy(&word, &mesh->x[3 * mesh->corner[k / 3] + k % 3], sizeof(word));
    hash = (hash ^ word) * 1099511628211u;
    hash ^= hash >> 29;
  }
  body->n = 2;
  PetscCall(PetscMalloc1(2, &body->parameter));
  PetscCall(BodyStoreAdd(body->parameter, body->store));
  body->parameter[0] = (PetscReal)(hash >> 16); /* a double holds 48 bits exactly */
  body->parameter[1] = (PetscReal)mesh->triangles;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Says which triangles were left out, turned or added. */
static PetscErrorCode Say(const char option[], const char path[], const Mesh *mesh)
{
  PetscFunctionBegin;
  if (mesh->equal + mesh->flat)
    PetscCall(SayLine("%s: %s: %" PetscInt_FMT " triangles without area or on the same corners as "
                      "others were left out, %" PetscInt_FMT " turned to their other diagonal",
                      option, path, mesh->equal, mesh->flat));
  if (mesh->closed)
    PetscCall(SayLine("%s: %s: holes were closed by %" PetscInt_FMT " triangles, %.2g of the area",
                      option, path, mesh->closed, (double)mesh->hole));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Fill(const Body *body, SurfacePoints *points)
{
  PetscCallAbort(PETSC_COMM_SELF, MeshPoints(MeshOf(body), points));
}

static PetscErrorCode Read(const char option[], const char text[], Body *body)
{
  char       *path;
  const char *fault;
  PetscReal   scale;
  MeshFile    file;
  Mesh       *mesh;
  BodyMoments moments;

  PetscFunctionBegin;
  PetscCall(MeshPath(option, text, &path, &scale));
  PetscCall(MeshFileRead(option, path, Parse, &file));
  for (PetscInt k = 0; k < file.n; k++) file.number[k] *= scale;
  PetscCall(PetscNew(&mesh));
  PetscCall(BodyStoreAdd(mesh, body->store));
  PetscCall(MeshCreate(&file, body->store, mesh));
  PetscCall(PetscFree(file.number));
  UserCheck(!*file.fault, "%s: %s: %s", option, path, file.fault);
  PetscCall(Say(option, path, mesh));
  PetscCall(PetscFree(path));
  fault = SolidCreate(Fill, body);
  UserCheck(!fault, "%s: %s", option, fault);
  ((Solid *)body->data)->mesh = mesh;
  PetscCall(SetNumbers(mesh, body));
  FindMoments(body, &moments);
  for (PetscInt a = 0; a < 3; a++) {
    body->centre[a] = moments.centroid[a];
    body->extent    = PetscMax(body->extent, PetscMax(mesh->hi[a] - moments.centroid[a],
                                                      moments.centroid[a] - mesh->lo[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Span(const Body *body, PetscInt axis, PetscReal span[2])
{
  span[0] = MeshOf(body)->lo[axis];
  span[1] = MeshOf(body)->hi[axis];
}

static PetscReal Distance(const Body *body, const PetscReal x[], PetscReal normal[])
{
  PetscReal foot[3];

  return MeshNearest(MeshOf(body), x, foot, normal);
}

const ShapeRow ShapeMesh = {
    .name     = "file",
    .brief    = "path[,scale]: triangles of an STL or OBJ file, a closed surface",
    .citation = "Baerentzen & Aanaes 2005",
    .Read     = Read,
    .Span     = Span,
    .Distance = Distance,
    .Count    = SolidCount,
    .Point    = SolidPoint,
    .Moments  = FindMoments,
};
