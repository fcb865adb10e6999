/* The patch test: properties of an operator, measured without a flow. A field is given on particles
   in a box and around it. The test assembles, applies and times the Laplacian, compares it with the
   exact Laplacian, examines its matrix, and solves a Poisson problem with it. */
#ifndef ISPH_PATCH_H
#define ISPH_PATCH_H

#include "isph/io.h"

/* Fields by name. x lies in the unit square or cube [-], so the Laplacian has no unit either. */
typedef struct FieldRow FieldRow;
struct FieldRow {
  const char *name, *brief, *citation;
  PetscInt    degree[2]; /* of polynomials: lowest and highest degree of a monomial */
  PetscBool   random;    /* coefficients by seed */
  PetscReal (*Value)(const FieldRow *row, PetscInt dim, PetscInt seed, const PetscReal x[]);
  PetscReal (*Laplacian)(const FieldRow *row, PetscInt dim, PetscInt seed, const PetscReal x[]);
};
extern const Table       FieldTable;
extern const OptionTable PatchOptions;

/* A patch test of a Laplacian L: its matrix A over the box, and B over the given values around
   it. */
typedef struct {
  const Scene    *scene;
  const FieldRow *field;
  Particles      *particles;
  Neighbors      *neighbors;
  Operators      *ops;
  Vec             f, f_around; /* the field over the box and around it [-] */
  Vec             exact;       /* its Laplacian over the box [-] */
  PetscInt        repeats;     /* repetitions of the timed part; the least time counts */
  PetscBool       spectrum, solve;
} Patch;

PetscErrorCode PatchRun(Scene *scene);
PetscErrorCode PatchStructure(const Patch *patch, Report *report);
PetscErrorCode PatchSpectrum(const Patch *patch, Report *report);
PetscErrorCode PatchSolve(const Patch *patch, Report *report);

#endif
