/* Snapshots: the fields of a file, and the index that lists the files. */
#ifndef ISPH_IO_SNAPSHOT_H
#define ISPH_IO_SNAPSHOT_H

#include "hdf5file.h"

/* A snapshot that is complete on disk. */
typedef struct {
  PetscInt  number; /* in its file's name */
  PetscReal t;      /* [s] */
  PetscInt  N;      /* particles in it */
} Snapshot;

/* The shape and the type of a field. */
typedef enum {
  FIELD_SCALAR, /* a real number */
  FIELD_VECTOR, /* dim real numbers */
  FIELD_AXIAL,  /* a real number in 2D, three in 3D */
  FIELD_LABEL,  /* a whole number of 32 bits */
  FIELD_ID      /* a whole number of 64 bits */
} FieldShape;

/* A field of snapshots, of own particles, fluid first, then walls: numbers of the fluid, a label of
   each particle, or values that Gather computes. */
typedef struct {
  const char *name, *units;
  FieldShape  shape;
  PetscBool (*Has)(const Flow *flow);          /* NULL: every run has it */
  const PetscReal *(*Fluid)(const Flow *flow); /* NULL: the run has none */
  int (*Label)(const Flow *flow, PetscInt i);
  PetscErrorCode (*Gather)(const Flow *flow, void *rows); /* double or long long; collective */
  const PetscReal *values;                                /* of a scalar of the fluid */
} SnapshotField;

PetscErrorCode SnapshotFieldsCheck(const Scene *scene);
PetscBool      SnapshotNext(const Flow *flow, PetscInt *k, SnapshotField *field);
PetscInt       SnapshotColumns(const Flow *flow, const SnapshotField *field);
PetscErrorCode SnapshotGather(const Flow *flow, const SnapshotField *field, PetscBool first,
                              double rows[]);
PetscErrorCode SnapshotFieldsWrite(const Flow *flow, Hdf5File *file);
size_t         SnapshotBytes(const Flow *flow);

PetscErrorCode SurfaceFileWrite(const Scene *scene, PetscReal t, const char path[],
                                PetscBool *good);
PetscErrorCode VtkGroupWrite(const Flow *flow, Hdf5File *file);
PetscErrorCode XdmfWrite(const char base[], const Flow *flow, PetscInt n,
                         const Snapshot snapshots[], PetscBool *good);

#endif
