/* An HDF5 file that all ranks write or read together. Failures are collected while the file is
   open, and all ranks report them when it is closed, so that no rank waits for the others after an
   error such as a full disk. */
#ifndef ISPH_HDF5FILE_H
#define ISPH_HDF5FILE_H

#include "isph/io.h"
#include <hdf5.h>

/* Uses of a file, with the format of its metadata: headers, names, shapes, types, attributes. */
typedef enum {
  HDF5_READ,
  HDF5_COMMON, /* written in the earliest format, which every reader accepts */
  HDF5_CHECKED /* of HDF5 1.8, with checksums: HDF5 itself notices damage before it uses them */
} Hdf5Use;

typedef struct {
  MPI_Comm  comm;
  hid_t     file, transfer; /* the file; collective transfers */
  PetscBool failed;         /* a call has failed on this rank */
  PetscInt  start, own, N;  /* rows of this rank: the first, their number; rows of all ranks */
} Hdf5File;

hid_t          Hdf5Noted(Hdf5File *file, hid_t result);
PetscErrorCode Hdf5FileOpen(MPI_Comm comm, const char path[], Hdf5Use use, Hdf5File *file);
PetscErrorCode Hdf5FileClose(Hdf5File *file, PetscBool *good);
PetscErrorCode Hdf5FileFinish(Hdf5File *file, const char part[], const char path[],
                              PetscBool *good);
PetscErrorCode Hdf5WriteRows(Hdf5File *file, const char name[], PetscInt columns, hid_t stored,
                             hid_t given, const void *rows, const char units[]);
PetscErrorCode Hdf5WriteTable(Hdf5File *file, const char name[], PetscInt rows, PetscInt columns,
                              hid_t stored, hid_t given, const void *values, const char units[]);
PetscErrorCode Hdf5WriteNumber(Hdf5File *file, const char name[], hid_t type, const void *value);
PetscErrorCode Hdf5WriteText(Hdf5File *file, const char object[], const char name[],
                             const char text[]);
PetscErrorCode Hdf5GroupCreate(Hdf5File *file, const char name[]);
PetscErrorCode Hdf5WriteNumbers(Hdf5File *file, const char object[], const char name[], hid_t type,
                                PetscInt n, const void *values);
PetscErrorCode Hdf5WriteWord(Hdf5File *file, const char object[], const char name[],
                             const char word[]);
PetscErrorCode Hdf5WriteBoundaries(const Scene *scene, Hdf5File *file);
PetscErrorCode Hdf5WriteGeometry(const Scene *scene, Hdf5File *file);
PetscErrorCode Hdf5Link(Hdf5File *file, const char name[], const char link[]);
PetscErrorCode Hdf5Widen(Hdf5File *file, const char name[], PetscInt columns, const char wide[],
                         PetscInt wide_columns);
PetscErrorCode Hdf5Has(Hdf5File *file, const char name[], PetscBool *there);
PetscErrorCode Hdf5CountRows(Hdf5File *file, const char name[], PetscInt *N, PetscInt *columns);
PetscErrorCode Hdf5IsFull(Hdf5File *file, const char name[], PetscBool *full);
PetscErrorCode Hdf5ReadRows(Hdf5File *file, const char name[], PetscInt columns, hid_t given,
                            void *rows);
PetscErrorCode Hdf5ReadNumber(Hdf5File *file, const char name[], hid_t type, void *value);
PetscErrorCode Hdf5ReadText(Hdf5File *file, const char name[], char text[], size_t length);

#endif
