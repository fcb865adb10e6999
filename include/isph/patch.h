/*
  The patch test: what an operator is worth, without a flow. A field is given on a box of particles
  and on those around it; the Laplacian of it is assembled, applied, compared and timed, its matrix
  looked at, and a Poisson problem solved with it.
*/
#ifndef ISPH_PATCH_H
#define ISPH_PATCH_H

#include "isph/io.h"

/* Fields by name. x runs over the unit square or cube [-], so lap is dimensionless too. */
typedef struct FieldRow FieldRow;
struct FieldRow {
  const char *name, *brief, *citation;
  PetscInt    degree[2]; /* of polynomials: lowest and highest of a monomial */
  PetscBool   random;    /* coefficients by seed */
  PetscReal (*Value)(const FieldRow *row, PetscInt dim, PetscInt seed, const PetscReal x[]);
  PetscReal (*Laplacian)(const FieldRow *row, PetscInt dim, PetscInt seed, const PetscReal x[]);
};
extern const Table FieldTable;

/* A patch: one matrix L = A over the box and B over the given values around it. */
typedef struct {
  const Scene    *scene;
  const FieldRow *field;
  Particles      *particles;
  Neighbors      *neighbors;
  Operators      *ops;
  Vec             f, f_around; /* the field over the box and around it [-] */
  Vec             exact;       /* its Laplacian over the box [-] */
  PetscInt        repeats;     /* of what is timed; the least time counts */
  PetscBool       spectrum, solve;
} Patch;

PetscErrorCode PatchRun(Scene *scene);
PetscErrorCode PatchStructure(const Patch *patch, Report *report);
PetscErrorCode PatchSpectrum(const Patch *patch, Report *report);
PetscErrorCode PatchSolve(const Patch *patch, Report *report);

#endif
