/*
  The group VTKHDF of a snapshot, with which ParaView and VTK read the file directly. It describes
  an unstructured grid with a single polyvertex cell, and holds links to the data sets of the file.
  VTK requires vectors of three columns; in 2D positions and velocities are virtual data sets with a
  third column of zeros, which needs no storage.

  Reference: VTKHDF file format 1.0, docs.vtk.org
*/
#include "snapshot.h"

#define VTK_POLY_VERTEX 2

/* Writes a short list of whole numbers. Collective. */
static PetscErrorCode WriteList(Hdf5File *file, const char name[], PetscInt n,
                                const long long list[], hid_t stored)
{
  PetscFunctionBegin;
  PetscCall(Hdf5WriteTable(file, name, n, 0, stored, H5T_NATIVE_LLONG, list, "1"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the vertices of the cell: all rows of the file. */
static PetscErrorCode WriteVertices(Hdf5File *file)
{
  long long *vertex;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(file->own + 1, &vertex));
  for (PetscInt i = 0; i < file->own; i++) vertex[i] = (long long)(file->start + i);
  PetscCall(
      Hdf5WriteRows(file, "VTKHDF/Connectivity", 0, H5T_STD_I64LE, H5T_NATIVE_LLONG, vertex, "1"));
  PetscCall(PetscFree(vertex));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* VtkGroupWrite - Writes the group VTKHDF; called after SnapshotFieldsWrite(). Collective.
   Input/Output: file - its start, own and N are those that SnapshotFieldsWrite() set. */
PetscErrorCode VtkGroupWrite(const Flow *flow, Hdf5File *file)
{
  const long long version[] = {1, 0}, N = file->N, one = 1, offsets[] = {0, file->N},
                  type = VTK_POLY_VERTEX;
  SnapshotField field;

  PetscFunctionBegin;
  PetscCall(Hdf5GroupCreate(file, "VTKHDF"));
  PetscCall(Hdf5GroupCreate(file, "VTKHDF/PointData"));
  PetscCall(Hdf5WriteNumbers(file, "VTKHDF", "Version", H5T_NATIVE_LLONG, 2, version));
  PetscCall(Hdf5WriteWord(file, "VTKHDF", "Type", "UnstructuredGrid"));
  PetscCall(WriteList(file, "VTKHDF/NumberOfPoints", 1, &N, H5T_STD_I64LE));
  PetscCall(WriteList(file, "VTKHDF/NumberOfCells", 1, &one, H5T_STD_I64LE));
  PetscCall(WriteList(file, "VTKHDF/NumberOfConnectivityIds", 1, &N, H5T_STD_I64LE));
  PetscCall(WriteList(file, "VTKHDF/Offsets", 2, offsets, H5T_STD_I64LE));
  PetscCall(WriteList(file, "VTKHDF/Types", 1, &type, H5T_STD_U8LE));
  PetscCall(WriteVertices(file));
  for (PetscInt k = 0; SnapshotNext(flow, &k, &field);) {
    const PetscInt columns = SnapshotColumns(flow, &field);
    char           name[64];

    PetscCall(PetscSNPrintf(name, sizeof(name), "VTKHDF/%s%s", k > 1 ? "PointData/" : "Points",
                            k > 1 ? field.name : ""));
    if (columns == 2) PetscCall(Hdf5Widen(file, field.name, columns, name, 3));
    else PetscCall(Hdf5Link(file, field.name, name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
