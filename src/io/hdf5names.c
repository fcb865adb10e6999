/* Parallel HDF5: groups, second names of data sets, and the scene as attributes. */
#include "hdf5file.h"

/* Hdf5GroupCreate - Creates a group; collective on comm */
PetscErrorCode Hdf5GroupCreate(Hdf5File *file, const char name[])
{
  hid_t group;

  PetscFunctionBegin;
  group = Hdf5Noted(file, H5Gcreate2(file->file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (group >= 0) (void)Hdf5Noted(file, H5Gclose(group));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5WriteBoundaries - Writes the boundaries of a scene as attributes of the file: boundary_ids,
   boundary_names and boundary_kinds; names and kinds are lists with commas. Collective on comm. */
PetscErrorCode Hdf5WriteBoundaries(const Scene *scene, Hdf5File *file)
{
  const PetscInt n         = SceneBoundaries(scene);
  const size_t   name_size = (size_t)n * (WALL_NAME + 1), kind_size = (size_t)n * KIND_NAME;
  char          *names, *kinds;
  int           *ids;

  PetscFunctionBegin;
  PetscCall(PetscCalloc3(name_size, &names, kind_size, &kinds, n, &ids));
  for (PetscInt side = 0; side < n; side++) {
    char name[WALL_NAME];

    ids[side] = (int)side;
    SceneWallName(scene, side, name);
    if (side) {
      TextAppend(names, name_size, ",");
      TextAppend(kinds, kind_size, ",");
    }
    TextAppend(names, name_size, name);
    TextAppend(kinds, kind_size, scene->boundary[side].kind->name);
  }
  PetscCall(Hdf5WriteNumbers(file, "/", "boundary_ids", H5T_NATIVE_INT, n, ids));
  PetscCall(Hdf5WriteText(file, "/", "boundary_names", names));
  PetscCall(Hdf5WriteText(file, "/", "boundary_kinds", kinds));
  PetscCall(PetscFree3(names, kinds, ids));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes real numbers as an attribute. */
static PetscErrorCode WriteReals(Hdf5File *file, const char name[], PetscInt n, const PetscReal x[])
{
  double *numbers;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(n, &numbers));
  for (PetscInt k = 0; k < n; k++) numbers[k] = (double)x[k];
  PetscCall(Hdf5WriteNumbers(file, "/", name, H5T_NATIVE_DOUBLE, n, numbers));
  PetscCall(PetscFree(numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5WriteGeometry - Writes the box of a scene, its bodies and if it has a free surface as
   attributes of the file. Collective on comm. box has the low corner and the high one [m]; body_<k>
   the numbers of shape k of the list body_shapes, as BodySet() prepares them: corners for boxes,
   and of the outline of shapes with curves; body_<k>_ends in 3D both ends along z; body_<k>_around
   is 1 for bodies with the fluid inside. */
PetscErrorCode Hdf5WriteGeometry(const Scene *scene, Hdf5File *file)
{
  const int    free_surface = SceneHasFreeSurface(scene) ? 1 : 0;
  const size_t size         = (size_t)scene->n_bodies * KIND_NAME + 1;
  double       box[2 * ISPH_MAX_DIM];
  char         name[WALL_NAME + 8], *shapes;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(size, &shapes));
  for (PetscInt a = 0; a < scene->dim; a++) {
    box[a]              = (double)scene->lo[a];
    box[scene->dim + a] = (double)scene->hi[a];
  }
  PetscCall(Hdf5WriteNumbers(file, "/", "box", H5T_NATIVE_DOUBLE, 2 * scene->dim, box));
  PetscCall(Hdf5WriteNumber(file, "free_surface", H5T_NATIVE_INT, &free_surface));
  for (PetscInt k = 0; k < scene->n_bodies; k++) {
    const Body  *body    = SceneBody(scene, k);
    const int    around  = body->around ? 1 : 0;
    const double ends[2] = {(double)body->ends[0], (double)body->ends[1]};
    PetscReal   *corner;
    PetscInt     n;

    PetscCall(BodyCorners(body, 0.5 * scene->dx, &n, &corner));
    if (k) TextAppend(shapes, size, ",");
    TextAppend(shapes, size, n ? "outline" : body->shape->name);
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%d", (int)k + 1));
    PetscCall(WriteReals(file, name, n ? 2 * n : body->n, n ? corner : body->parameter));
    PetscCall(PetscFree(corner));
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%d_around", (int)k + 1));
    PetscCall(Hdf5WriteNumber(file, name, H5T_NATIVE_INT, &around));
    if (scene->dim < 3) continue;
    PetscCall(PetscSNPrintf(name, sizeof(name), "body_%d_ends", (int)k + 1));
    PetscCall(Hdf5WriteNumbers(file, "/", name, H5T_NATIVE_DOUBLE, 2, ends));
  }
  PetscCall(Hdf5WriteText(file, "/", "body_shapes", shapes));
  PetscCall(PetscFree(shapes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5Link - Gives a data set a second name by a hard link; collective on comm */
PetscErrorCode Hdf5Link(Hdf5File *file, const char name[], const char link[])
{
  PetscFunctionBegin;
  (void)Hdf5Noted(file,
                  H5Lcreate_hard(file->file, name, file->file, link, H5P_DEFAULT, H5P_DEFAULT));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5Widen - Creates a virtual data set that consists of another data set of real numbers and
   additional columns of zeros; collective on comm */
PetscErrorCode Hdf5Widen(Hdf5File *file, const char name[], PetscInt columns, const char wide[],
                         PetscInt wide_columns)
{
  const hsize_t narrow_size[2] = {(hsize_t)file->N, (hsize_t)columns}, first[2] = {0, 0};
  const hsize_t wide_size[2] = {(hsize_t)file->N, (hsize_t)wide_columns};
  const double  zero         = 0.0;
  const hid_t   from         = Hdf5Noted(file, H5Screate_simple(2, narrow_size, NULL));
  const hid_t   to           = Hdf5Noted(file, H5Screate_simple(2, wide_size, NULL));
  const hid_t   create       = Hdf5Noted(file, H5Pcreate(H5P_DATASET_CREATE));
  hid_t         data;

  PetscFunctionBegin;
  (void)Hdf5Noted(file, H5Sselect_hyperslab(to, H5S_SELECT_SET, first, NULL, narrow_size, NULL));
  (void)Hdf5Noted(file, H5Pset_virtual(create, to, ".", name, from));
  (void)Hdf5Noted(file, H5Pset_fill_value(create, H5T_NATIVE_DOUBLE, &zero));
  (void)Hdf5Noted(file, H5Sselect_all(to));
  data = Hdf5Noted(
      file, H5Dcreate2(file->file, wide, H5T_IEEE_F64LE, to, H5P_DEFAULT, create, H5P_DEFAULT));
  if (data >= 0) (void)Hdf5Noted(file, H5Dclose(data));
  (void)Hdf5Noted(file, H5Pclose(create));
  (void)Hdf5Noted(file, H5Sclose(to));
  (void)Hdf5Noted(file, H5Sclose(from));
  PetscFunctionReturn(PETSC_SUCCESS);
}
