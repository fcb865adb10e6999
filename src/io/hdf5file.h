/*
  An HDF5 file written by all ranks together. Failures are gathered while it is open and told once,
  by all ranks alike, when it is closed: a full disk must not leave some ranks waiting for others.
*/
#ifndef ISPH_IO_HDF5FILE_H
#define ISPH_IO_HDF5FILE_H

#include "isph/io.h"
#include <hdf5.h>

typedef struct {
  MPI_Comm  comm;
  hid_t     file, transfer; /* the file; collective transfers */
  PetscBool failed;         /* some call, on this rank */
  PetscInt  start, own, N;  /* rows of this rank: the first, their number; rows of all ranks */
} Hdf5File;

PetscErrorCode Hdf5FileCreate(MPI_Comm comm, const char path[], Hdf5File *file);
PetscErrorCode Hdf5FileClose(Hdf5File *file, PetscBool *good);
PetscErrorCode Hdf5WriteRows(Hdf5File *file, const char name[], PetscInt columns, hid_t stored,
                             hid_t given, const void *rows, const char units[]);
PetscErrorCode Hdf5WriteNumber(Hdf5File *file, const char name[], hid_t type, const void *value);
PetscErrorCode Hdf5WriteText(Hdf5File *file, hid_t object, const char name[], const char text[]);

#endif
