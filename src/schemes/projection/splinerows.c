/* Rows of the splines that depend on the positions of particles: values and gradients of the
   pressure at particles. The fits of the velocity are in splinefits.c. */
#include "splines.h"

/* SplineRowsFree - Frees the matrices of this file; collective */
PetscErrorCode SplineRowsFree(Splines *s)
{
  PetscFunctionBegin;
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    PetscCall(MatDestroy(&s->G[a]));
    PetscCall(PetscFree(s->gradient[a]));
    for (PetscInt b = 0; b < ISPH_MAX_DIM; b++) {
      PetscCall(MatDestroy(&s->J[a][b]));
      PetscCall(MatDestroy(&s->W[a][b]));
      PetscCall(SplineEntriesFree(&s->from_fluid[a][b]));
      PetscCall(SplineEntriesFree(&s->from_walls[a][b]));
    }
  }
  PetscCall(MatDestroy(&s->V));
  PetscCall(PetscFree(s->value));
  PetscCall(PatternFree(&s->at_particles));
  s->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the number of entries of the rows of all fluid particles, or a larger one. */
static PetscInt EntriesAtParticles(const Particles *p, const Splines *s)
{
  const SplineLattice *l      = &s->lattice;
  const PetscInt       layers = l->dim == 2 ? 1 : 3;
  PetscInt             sum    = 0;

  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt cell[2];

    for (PetscInt a = 0; s->bodies && a < 2; a++) {
      cell[a] = (PetscInt)((p->x[a][i] - l->lo[a]) / l->side[a]);
      cell[a] = PetscMin(PetscMax(cell[a], 0), l->cells[a] - 1);
    }
    sum += layers * (s->bodies ? s->bodies->width[cell[1] * l->cells[0] + cell[0]] : 9);
  }
  return sum;
}

/* Assembles G and V. */
static PetscErrorCode AssembleAtParticles(const Particles *p, Splines *s)
{
  const SplineLattice *l = &s->lattice;

  PetscFunctionBegin;
  for (PetscInt a = 0; a < l->dim; a++) PetscCall(MatDestroy(&s->G[a]));
  PetscCall(MatDestroy(&s->V));
  PetscCall(PatternBegin(&s->at_particles, p->n_fluid, EntriesAtParticles(p, s)));
  if (s->at_particles.capacity > s->capacity) {
    s->capacity = s->at_particles.capacity;
    PetscCall(PetscFree(s->value));
    PetscCall(PetscMalloc1(s->capacity, &s->value));
    for (PetscInt a = 0; a < l->dim; a++) {
      PetscCall(PetscFree(s->gradient[a]));
      PetscCall(PetscMalloc1(s->capacity, &s->gradient[a]));
    }
  }
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscInt  slot[SPLINES_EXTENDED];
    PetscReal x[ISPH_MAX_DIM];
    SplineRow at;

    for (PetscInt a = 0; a < l->dim; a++) x[a] = p->x[a][i];
    SplineRowAt(s, p, x, &at);
    PatternRow(&s->at_particles, i, at.number, at.n, slot);
    for (PetscInt k = 0; k < at.n; k++) { /* each number once */
      s->value[slot[k]] = at.value[k];
      for (PetscInt a = 0; a < l->dim; a++) s->gradient[a][slot[k]] = at.gradient[a][k];
    }
  }
  PetscCall(PatternMat(p->comm, &s->at_particles, p->n_fluid, s->own.size, s->value, &s->V));
  for (PetscInt a = 0; a < l->dim; a++) {
    PetscCall(
        PatternMat(p->comm, &s->at_particles, p->n_fluid, s->own.size, s->gradient[a], &s->G[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  SplinesAssemble - Assembles the matrices that depend on positions, and numbers the splines anew if
  the box of a rank has changed

  Collective. Does nothing if positions and numbering have not changed since the last assembly.
*/
PetscErrorCode SplinesAssemble(Flow *flow, Splines *s)
{
  const Particles *p = flow->particles;

  PetscFunctionBegin;
  if (s->epoch == p->epoch && s->moved == p->moved) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SplinesNumber(flow, s));
  PetscCall(AssembleAtParticles(p, s));
  PetscCall(SplineFitsAssemble(flow, s));
  s->epoch = p->epoch;
  s->moved = p->moved;
  s->assemblies++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
