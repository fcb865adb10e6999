/*
  Declarations shared by the files of this folder. Each file calls only files to its right:

    particles.c | population.c | neighbors.c | epoch.c | migrate.c, decompose.c, halo.c,
    numbering.c, vectors.c | cells.c | exchange.c, storage.c
*/
#ifndef ISPH_PARTICLES_IMPL_H
#define ISPH_PARTICLES_IMPL_H

#include "isph/particles.h"

/* storage.c */
enum { RECORD_ID, RECORD_KIND, RECORD_FIELDS }; /* places in a record; field 0 is x */
typedef struct {
  PetscInt    n;
  PetscReal **values; /* of each component of each field */
} RecordColumns;
PetscErrorCode ParticlesReserve(Particles *p, PetscInt n);
PetscErrorCode RecordsBegin(const Particles *p, RecordColumns *columns);
PetscErrorCode RecordsEnd(RecordColumns *columns);
void RecordPack(const Particles *p, const RecordColumns *columns, PetscInt i, PetscReal record[]);
void RecordUnpack(const RecordColumns *columns, const PetscReal record[], PetscInt i);

/* cells.c */
PetscErrorCode SortIndices(PetscInt n, PetscInt list[]);

/* epoch.c */
PetscErrorCode ParticlesLargestMove(const Particles *p, PetscReal *const from[], PetscReal *move);

/* decompose.c */
PetscErrorCode ParticlesDecompose(const Scene *scene, Particles *p, PetscInt owner[]);

/* migrate.c */
PetscErrorCode ParticlesMigrate(const Scene *scene, Particles *p, const PetscInt owner[]);
PetscErrorCode ParticlesStore(const Scene *scene, Particles *p, PetscInt n,
                              const PetscReal record[]);

/* halo.c */
PetscErrorCode HaloBuild(const Scene *scene, Particles *p);

/* exchange.c */
PetscErrorCode ExchangeItems(MPI_Comm comm, MPI_Datatype unit, PetscInt width,
                             const PetscInt n_to[], const void *send, PetscMPIInt *n_sources,
                             PetscMPIInt **source, PetscInt **n_from, void *recv);

#endif
