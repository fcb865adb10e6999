/* Parallel HDF5 for snapshots and checkpoints. Hdf5File.failed records failures of calls. */
#include "hdf5file.h"
#include <string.h>

#define COMPACT_MOST 1000 /* attributes and data sets that the header of a file holds itself */
#define ROWS_MAX                                                                                   \
  ((hsize_t)PETSC_INT_MAX / 16) /* of a data set; numbers of values do not overflow */

#define TEXT_MOST ((size_t)60000) /* of an attribute [bytes] */

/* Hdf5Noted - Records a failure of an HDF5 call; returns the result of the call */
hid_t Hdf5Noted(Hdf5File *file, hid_t result)
{
  if (result < 0) file->failed = PETSC_TRUE;
  return result;
}

/* Hdf5FileOpen - Opens a file of any format for reading, or creates or truncates one. Collective on
   comm. Hdf5FileClose() reports failures. */
PetscErrorCode Hdf5FileOpen(MPI_Comm comm, const char path[], Hdf5Use use, Hdf5File *file)
{
  hid_t access, creation;

  PetscFunctionBegin;
  *file = (Hdf5File){.comm = comm};
  (void)Hdf5Noted(file, H5Eset_auto2(H5E_DEFAULT, NULL, NULL)); /* isph prints its own messages */
  access   = Hdf5Noted(file, H5Pcreate(H5P_FILE_ACCESS));
  creation = Hdf5Noted(file, H5Pcreate(H5P_FILE_CREATE));
  (void)Hdf5Noted(file, H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL));
  if (use == HDF5_CHECKED) {
    (void)Hdf5Noted(file, H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18));
    (void)Hdf5Noted(file, H5Pset_attr_phase_change(creation, COMPACT_MOST, COMPACT_MOST));
    (void)Hdf5Noted(file, H5Pset_link_phase_change(creation, COMPACT_MOST, COMPACT_MOST));
  }
  file->file = use == HDF5_READ ? H5Fopen(path, H5F_ACC_RDONLY, access)
                                : H5Fcreate(path, H5F_ACC_TRUNC, creation, access);
  (void)Hdf5Noted(file, file->file);
  file->transfer = Hdf5Noted(file, H5Pcreate(H5P_DATASET_XFER));
  (void)Hdf5Noted(file, H5Pset_dxpl_mpio(file->transfer, H5FD_MPIO_COLLECTIVE));
  (void)Hdf5Noted(file, H5Pclose(creation));
  (void)Hdf5Noted(file, H5Pclose(access));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5FileClose - Closes the file. Collective on comm. Output: good - true if every call succeeded
   on every rank. */
PetscErrorCode Hdf5FileClose(Hdf5File *file, PetscBool *good)
{
  PetscInt failed;

  PetscFunctionBegin;
  (void)Hdf5Noted(file, H5Pclose(file->transfer));
  if (file->file >= 0) (void)Hdf5Noted(file, H5Fclose(file->file));
  failed = file->failed ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_MAX, file->comm));
  *good = failed ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5FileFinish - Closes a file written as `part` and renames it to `path` if it is complete.
   Collective on PETSC_COMM_WORLD. Output: good - true on all ranks if the file is complete. */
PetscErrorCode Hdf5FileFinish(Hdf5File *file, const char part[], const char path[], PetscBool *good)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  PetscCall(Hdf5FileClose(file, good));
  if (rank == 0 && !*good) (void)remove(part);
  if (rank == 0 && *good) *good = FileReplace(part, path);
  PetscCall(FirstRankDecides(good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes an attribute of an object, "/" for the file itself, and closes its type and its space. */
static void WriteAttribute(Hdf5File *file, const char object[], const char name[], hid_t type,
                           hid_t space, const void *values)
{
  const hid_t attribute = Hdf5Noted(file, H5Acreate_by_name(file->file, object, name, type, space,
                                                            H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));

  if (attribute >= 0) {
    (void)Hdf5Noted(file, H5Awrite(attribute, type, values));
    (void)Hdf5Noted(file, H5Aclose(attribute));
  }
  (void)Hdf5Noted(file, H5Tclose(type));
  (void)Hdf5Noted(file, H5Sclose(space));
}

/* Hdf5WriteNumbers - Writes n numbers as an attribute of an object in the file; the object "/" is
   the file itself; collective on comm */
PetscErrorCode Hdf5WriteNumbers(Hdf5File *file, const char object[], const char name[], hid_t type,
                                PetscInt n, const void *values)
{
  const hsize_t size = (hsize_t)n;

  PetscFunctionBegin;
  WriteAttribute(file, object, name, Hdf5Noted(file, H5Tcopy(type)),
                 Hdf5Noted(file, H5Screate_simple(1, &size, NULL)), values);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5WriteNumber - Writes a number as an attribute of the file; collective on comm */
PetscErrorCode Hdf5WriteNumber(Hdf5File *file, const char name[], hid_t type, const void *value)
{
  PetscFunctionBegin;
  WriteAttribute(file, "/", name, Hdf5Noted(file, H5Tcopy(type)),
                 Hdf5Noted(file, H5Screate(H5S_SCALAR)), value);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes a string of a length as an attribute of an object. */
static void WriteString(Hdf5File *file, const char object[], const char name[], const char text[],
                        size_t length, H5T_cset_t letters)
{
  const hid_t type = Hdf5Noted(file, H5Tcopy(H5T_C_S1));

  (void)Hdf5Noted(file, H5Tset_size(type, length));
  (void)Hdf5Noted(file, H5Tset_strpad(type, H5T_STR_NULLPAD));
  (void)Hdf5Noted(file, H5Tset_cset(type, letters));
  WriteAttribute(file, object, name, type, Hdf5Noted(file, H5Screate(H5S_SCALAR)), text);
}

/* Hdf5WriteText - Writes a string as an attribute of an object. Collective on comm. Note: an HDF5
   attribute is limited to 64 kB; a longer text is truncated. */
PetscErrorCode Hdf5WriteText(Hdf5File *file, const char object[], const char name[],
                             const char text[])
{
  PetscFunctionBegin;
  WriteString(file, object, name, text, PetscMin(strlen(text) + 1, TEXT_MOST), H5T_CSET_UTF8);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5WriteWord - Writes an ASCII word as an attribute of an object, without a terminating null;
   collective on comm */
PetscErrorCode Hdf5WriteWord(Hdf5File *file, const char object[], const char name[],
                             const char word[])
{
  PetscFunctionBegin;
  WriteString(file, object, name, word, strlen(word), H5T_CSET_ASCII);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Selects the rows of this rank in the space of a data set; returns their space in memory. */
static hid_t OwnRows(Hdf5File *file, PetscInt columns, hid_t space)
{
  const hsize_t first[2] = {(hsize_t)file->start, 0};
  const hsize_t count[2] = {(hsize_t)file->own, (hsize_t)columns};
  const hid_t   memory   = Hdf5Noted(file, H5Screate_simple(columns ? 2 : 1, count, NULL));

  if (file->own) {
    (void)Hdf5Noted(file, H5Sselect_hyperslab(space, H5S_SELECT_SET, first, NULL, count, NULL));
  } else {
    (void)Hdf5Noted(file, H5Sselect_none(space));
    (void)Hdf5Noted(file, H5Sselect_none(memory));
  }
  return memory;
}

/* Hdf5WriteRows - Writes a data set of N rows, of which each rank writes its own. Collective on
   comm; a rank may have no rows. Input: file - the file, with start, own and N set; columns -
   number of columns; 0 for a one-dimensional data set; stored - type in the file; given - type in
   memory; rows - rows of this rank, with `columns` values each; units - SI unit, "1" for a plain
   number. */
PetscErrorCode Hdf5WriteRows(Hdf5File *file, const char name[], PetscInt columns, hid_t stored,
                             hid_t given, const void *rows, const char units[])
{
  const hsize_t size[2] = {(hsize_t)file->N, (hsize_t)columns};
  const int     rank    = columns ? 2 : 1;
  hid_t         space, memory, data;

  PetscFunctionBegin;
  space  = Hdf5Noted(file, H5Screate_simple(rank, size, NULL));
  memory = OwnRows(file, columns, space);
  data   = Hdf5Noted(
        file, H5Dcreate2(file->file, name, stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  if (data >= 0) {
    (void)Hdf5Noted(file, H5Dwrite(data, given, memory, space, file->transfer, rows));
    (void)Hdf5Noted(file, H5Dclose(data));
    PetscCall(Hdf5WriteText(file, name, "units", units));
  }
  (void)Hdf5Noted(file, H5Sclose(memory));
  (void)Hdf5Noted(file, H5Sclose(space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5WriteTable - Writes a data set that all ranks have, of rows as in Hdf5WriteRows(). Collective
   on comm; the first rank writes. The rows of this rank in `file` do not change. */
PetscErrorCode Hdf5WriteTable(Hdf5File *file, const char name[], PetscInt rows, PetscInt columns,
                              hid_t stored, hid_t given, const void *values, const char units[])
{
  const PetscInt start = file->start, own = file->own, N = file->N;
  PetscMPIInt    rank;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(file->comm, &rank));
  file->start = 0;
  file->own   = rank == 0 ? rows : 0;
  file->N     = rows;
  PetscCall(Hdf5WriteRows(file, name, columns, stored, given, values, units));
  file->start = start;
  file->own   = own;
  file->N     = N;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5Has - Determines if the file has a data set of the given name; collective on comm */
PetscErrorCode Hdf5Has(Hdf5File *file, const char name[], PetscBool *there)
{
  const htri_t found = H5Lexists(file->file, name, H5P_DEFAULT);

  PetscFunctionBegin;
  if (found < 0) file->failed = PETSC_TRUE;
  *there = found > 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5CountRows - Gets the number of rows and of columns of a data set, 0 columns if it is
   one-dimensional; collective on comm */
PetscErrorCode Hdf5CountRows(Hdf5File *file, const char name[], PetscInt *N, PetscInt *columns)
{
  hsize_t size[2] = {0, 0};
  hid_t   data, space;

  PetscFunctionBegin;
  data = Hdf5Noted(file, H5Dopen2(file->file, name, H5P_DEFAULT));
  if (data >= 0) {
    space = Hdf5Noted(file, H5Dget_space(data));
    if (Hdf5Noted(file, H5Sget_simple_extent_ndims(space)) > 2) file->failed = PETSC_TRUE;
    else (void)Hdf5Noted(file, H5Sget_simple_extent_dims(space, size, NULL));
    (void)Hdf5Noted(file, H5Sclose(space));
    (void)Hdf5Noted(file, H5Dclose(data));
  }
  if (size[0] > ROWS_MAX || size[1] > ROWS_MAX) {
    file->failed = PETSC_TRUE;
    size[0] = size[1] = 0;
  }
  *N       = (PetscInt)size[0];
  *columns = (PetscInt)size[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5IsFull - Determines if a data set has all its values in the file itself, without compression.
   Collective on comm. The memory for such a data set is at most the size of the file; others may
   consist of a few bytes and ask for any memory. False if the data set is absent. */
PetscErrorCode Hdf5IsFull(Hdf5File *file, const char name[], PetscBool *full)
{
  const hid_t data = H5Dopen2(file->file, name, H5P_DEFAULT);
  hid_t       space, type, creation;

  PetscFunctionBegin;
  *full = PETSC_FALSE;
  if (data < 0) PetscFunctionReturn(PETSC_SUCCESS);
  space    = Hdf5Noted(file, H5Dget_space(data));
  type     = Hdf5Noted(file, H5Dget_type(data));
  creation = Hdf5Noted(file, H5Dget_create_plist(data));
  if (H5Pget_layout(creation) == H5D_CONTIGUOUS && H5Pget_external_count(creation) == 0) {
    const hssize_t values = H5Sget_simple_extent_npoints(space);
    const size_t   size   = H5Tget_size(type); /* 0: a type of no size, in a damaged file */

    *full = size && values >= 0 && H5Dget_storage_size(data) / size >= (hsize_t)values;
  }
  (void)Hdf5Noted(file, H5Pclose(creation));
  (void)Hdf5Noted(file, H5Tclose(type));
  (void)Hdf5Noted(file, H5Sclose(space));
  (void)Hdf5Noted(file, H5Dclose(data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5ReadRows - Reads rows [start, start + own) of a data set. Collective on comm; a rank may read
   no rows. Input: as Hdf5WriteRows(). */
PetscErrorCode Hdf5ReadRows(Hdf5File *file, const char name[], PetscInt columns, hid_t given,
                            void *rows)
{
  hid_t space, memory, data;

  PetscFunctionBegin;
  data = Hdf5Noted(file, H5Dopen2(file->file, name, H5P_DEFAULT));
  if (data < 0) PetscFunctionReturn(PETSC_SUCCESS);
  space  = Hdf5Noted(file, H5Dget_space(data));
  memory = OwnRows(file, columns, space);
  (void)Hdf5Noted(file, H5Dread(data, given, memory, space, file->transfer, rows));
  (void)Hdf5Noted(file, H5Sclose(memory));
  (void)Hdf5Noted(file, H5Sclose(space));
  (void)Hdf5Noted(file, H5Dclose(data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Opens an attribute that holds a single value of a class; other attributes are failures. */
static hid_t AttributeOpen(Hdf5File *file, const char name[], H5T_class_t wanted)
{
  const hid_t attribute = Hdf5Noted(file, H5Aopen(file->file, name, H5P_DEFAULT));
  hid_t       space, type;
  PetscBool   fits;

  if (attribute < 0) return attribute;
  space = Hdf5Noted(file, H5Aget_space(attribute));
  type  = Hdf5Noted(file, H5Aget_type(attribute));
  fits  = H5Sget_simple_extent_npoints(space) == 1 && H5Tget_class(type) == wanted &&
         H5Tis_variable_str(type) <= 0;
  (void)Hdf5Noted(file, H5Tclose(type));
  (void)Hdf5Noted(file, H5Sclose(space));
  if (fits) return attribute;
  (void)Hdf5Noted(file, H5Aclose(attribute));
  return Hdf5Noted(file, -1);
}

/* Hdf5ReadNumber - Reads a number from an attribute of the file; collective on comm */
PetscErrorCode Hdf5ReadNumber(Hdf5File *file, const char name[], hid_t type, void *value)
{
  hid_t attribute;

  PetscFunctionBegin;
  attribute = AttributeOpen(file, name, H5Tget_class(type));
  if (attribute >= 0) {
    (void)Hdf5Noted(file, H5Aread(attribute, type, value));
    (void)Hdf5Noted(file, H5Aclose(attribute));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Hdf5ReadText - Reads a string from an attribute of the file, truncated to length; collective on
   comm */
PetscErrorCode Hdf5ReadText(Hdf5File *file, const char name[], char text[], size_t length)
{
  hid_t attribute, type;

  PetscFunctionBegin;
  text[0]   = '\0';
  attribute = AttributeOpen(file, name, H5T_STRING);
  if (attribute >= 0) {
    type = Hdf5Noted(file, H5Tcopy(H5T_C_S1));
    (void)Hdf5Noted(file, H5Tset_size(type, length));
    (void)Hdf5Noted(file, H5Tset_strpad(type, H5T_STR_NULLTERM));
    (void)Hdf5Noted(file, H5Tset_cset(type, H5T_CSET_UTF8));
    (void)Hdf5Noted(file, H5Aread(attribute, type, text));
    (void)Hdf5Noted(file, H5Tclose(type));
    (void)Hdf5Noted(file, H5Aclose(attribute));
  }
  text[length - 1] = '\0';
  PetscFunctionReturn(PETSC_SUCCESS);
}
