/*
  Surfaces of a scene for ParaView: a text file of VTK's poly data with the sides of the box and the
  bodies where they are at a time. Each piece of a surface is a segment, in 3D a square, with the
  number of its boundary, its normal and its velocity. Pieces need no mesh, so that any shape has
  them; parts buried in other boundaries are left out.

  Reference: VTK file formats, docs.vtk.org
*/
#include "isph/geometry.h"
#include "snapshot.h"

/* Writes a list of words as VTK does, a code for each letter and 0 after each word. */
static void WriteWords(FILE *f, const Scene *scene, const char name[],
                       void (*Word)(const Scene *scene, PetscInt side, char word[WALL_NAME]))
{
  fprintf(f, "<Array type=\"String\" Name=\"%s\" NumberOfTuples=\"%d\" format=\"ascii\">\n", name,
          (int)SceneBoundaries(scene));
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    char word[WALL_NAME];

    Word(scene, side, word);
    for (const char *c = word; *c; c++) fprintf(f, "%d ", *c);
    fprintf(f, "0\n");
  }
  fprintf(f, "</Array>\n");
}

static void WordName(const Scene *scene, PetscInt side, char word[WALL_NAME])
{
  SceneWallName(scene, side, word);
}

static void WordKind(const Scene *scene, PetscInt side, char word[WALL_NAME])
{
  (void)snprintf(word, WALL_NAME, "%s", scene->boundary[side].kind->name);
}

/* Begins an array of numbers. */
static void Begin(FILE *f, const char type[], const char name[], PetscInt columns)
{
  fprintf(f, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"ascii\">\n",
          type, name, (int)columns);
}

/* Writes a vector or a place, out of a turning frame, with z = 0 in 2D. */
static void WriteVector(FILE *f, const Scene *scene, PetscReal t, PetscBool place,
                        const PetscReal v[])
{
  PetscReal x[ISPH_MAX_DIM] = {0.0};

  for (PetscInt a = 0; a < scene->dim; a++) x[a] = v[a];
  if (scene->frame && place) ScenePlaceOutOfFrame(scene, t, x);
  else if (scene->frame) SceneOutOfFrame(scene, t, x);
  fprintf(f, "%.9g %.9g %.9g\n", (double)x[0], (double)x[1], (double)x[2]);
}

/* Writes the corners of facet k: the ends of a segment, or the corners of a square of its area. */
static void WriteCorners(FILE *f, const Scene *scene, PetscReal t, const Facets *facets, PetscInt k)
{
  static const PetscReal sign[4][2] = {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}};
  const PetscInt         dim        = scene->dim;
  const PetscReal        half = 0.5 * (dim == 2 ? facets->area[k] : PetscSqrtReal(facets->area[k]));
  PetscReal              tangent[2][ISPH_MAX_DIM];

  (void)SurfaceTangents(dim, &facets->normal[k * dim], tangent);
  for (PetscInt corner = 0; corner < 2 * (dim - 1); corner++) {
    PetscReal x[ISPH_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) {
      x[a] = facets->x[k * dim + a] + sign[corner][0] * half * tangent[0][a];
      if (dim == 3) x[a] += sign[corner][1] * half * tangent[1][a];
    }
    WriteVector(f, scene, t, PETSC_TRUE, x);
  }
}

/* Writes one number of each facet, or a vector, in the order of the boundaries. */
static void WriteCells(FILE *f, const Scene *scene, PetscReal t, const Facets facets[])
{
  const PetscInt dim = scene->dim;

  fprintf(f, "<CellData>\n");
  Begin(f, "Int32", "boundary", 1);
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++)
    for (PetscInt k = 0; k < facets[side].n; k++) fprintf(f, "%d\n", (int)side);
  fprintf(f, "</DataArray>\n");
  for (PetscInt field = 0; field < 2; field++) {
    Begin(f, "Float64", field ? "velocity" : "normal", 3);
    for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
      for (PetscInt k = 0; k < facets[side].n; k++) {
        PetscReal u[ISPH_MAX_DIM];

        SceneWallVelocity(scene, side, t, &facets[side].x[k * dim], u);
        WriteVector(f, scene, t, PETSC_FALSE, field ? u : &facets[side].normal[k * dim]);
      }
    }
    fprintf(f, "</DataArray>\n");
  }
  fprintf(f, "</CellData>\n");
}

/* Writes the file. Input: n - facets of all boundaries. */
static void WriteFile(FILE *f, const Scene *scene, PetscReal t, PetscInt n, const Facets facets[])
{
  const PetscInt    corners = 2 * (scene->dim - 1);
  const char *const cells   = scene->dim == 2 ? "Lines" : "Polys";

  fprintf(f, "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\">\n<PolyData>\n");
  fprintf(f,
          "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
          "format=\"ascii\">%.17g</DataArray>\n",
          (double)t);
  WriteWords(f, scene, "boundary_names", WordName);
  WriteWords(f, scene, "boundary_kinds", WordKind);
  fprintf(f,
          "</FieldData>\n<Piece NumberOfPoints=\"%" PetscInt_FMT "\" NumberOf%s=\"%" PetscInt_FMT
          "\">\n",
          n * corners, cells, n);
  WriteCells(f, scene, t, facets);
  fprintf(f, "<Points>\n");
  Begin(f, "Float64", "points", 3);
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++)
    for (PetscInt k = 0; k < facets[side].n; k++) WriteCorners(f, scene, t, &facets[side], k);
  fprintf(f, "</DataArray>\n</Points>\n<%s>\n", cells);
  Begin(f, "Int64", "connectivity", 1);
  for (PetscInt k = 0; k < n * corners; k++) fprintf(f, "%" PetscInt_FMT "\n", k);
  fprintf(f, "</DataArray>\n");
  Begin(f, "Int64", "offsets", 1);
  for (PetscInt k = 1; k <= n; k++) fprintf(f, "%" PetscInt_FMT "\n", k * corners);
  fprintf(f, "</DataArray>\n</%s>\n</Piece>\n</PolyData>\n</VTKFile>\n", cells);
}

/* SurfaceFileWrite - Writes the boundaries of a scene at time t under another name, and renames the
   complete file: called by the first rank. Sides at which the fluid continues, and those beyond a
   body around the fluid, are left out. Output: good - true if the file has been written. */
PetscErrorCode SurfaceFileWrite(const Scene *scene, PetscReal t, const char path[], PetscBool *good)
{
  char     part[PETSC_MAX_PATH_LEN];
  PetscInt n = 0;
  Facets  *facets;
  FILE    *f;

  PetscFunctionBegin;
  PetscCall(PetscSNPrintf(part, sizeof(part), "%s.part", path));
  PetscCall(PetscCalloc1(SceneBoundaries(scene), &facets));
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++) {
    if (BoundaryIs(scene, side, BOUNDARY_CONTINUES) || scene->boundary[side].kind == &BoundaryNone)
      continue;
    PetscCall(FacetsOfWall(scene, side, &facets[side]));
    n += facets[side].n;
  }
  f     = FileOpen(part, "w");
  *good = f ? PETSC_TRUE : PETSC_FALSE;
  if (f) {
    WriteFile(f, scene, t, n, facets);
    if (ferror(f)) *good = PETSC_FALSE;
    if (fclose(f) || !*good || !FileReplace(part, path)) *good = PETSC_FALSE;
  }
  for (PetscInt side = 0; side < SceneBoundaries(scene); side++)
    PetscCall(FacetsFree(&facets[side]));
  PetscCall(PetscFree(facets));
  PetscFunctionReturn(PETSC_SUCCESS);
}
