/* The velocity at the points of quadrature of the splines: products of the fits of splinefits.c
   with the velocities of particles, which are read by their local index. */
#include "splines.h"

/* SplineFitsFree - Frees the fits; not collective */
PetscErrorCode SplineFitsFree(SplineFits *f)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(f->j));
  PetscCall(PetscFree(f->w));
  PetscCall(PetscFree(f->value));
  for (PetscInt a = 0; a < ISPH_MAX_DIM; a++) {
    for (PetscInt b = 0; b < ISPH_MAX_DIM; b++)
      PetscCall(PetscFree2(f->first[a][b], f->last[a][b]));
  }
  f->n = f->capacity = f->points = f->value_capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SplineFitsReserve - Makes room for the velocities of all local particles; not collective */
PetscErrorCode SplineFitsReserve(const Particles *p, SplineFits *f)
{
  const PetscInt all = ParticlesAll(p);

  PetscFunctionBegin;
  if (all <= f->value_capacity) PetscFunctionReturn(PETSC_SUCCESS);
  f->value_capacity = all + all / 8;
  PetscCall(PetscFree(f->value));
  PetscCall(PetscMalloc1(p->dim * f->value_capacity, &f->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns the sum of entries [first, last) times the values of component b. */
static inline PetscReal Sum(PetscInt dim, const SplineFits *f, PetscInt first, PetscInt last,
                            PetscInt b)
{
  PetscReal sum = 0.0;

  for (PetscInt k = first; k < last; k++) sum += f->w[k] * f->value[dim * f->j[k] + b];
  return sum;
}

/* Computes the components of the velocity at point g that share a fit. */
static inline void SumShared(PetscInt dim, const SplineFits *f, PetscInt g, PetscScalar *const y[])
{
  PetscReal sum[ISPH_MAX_DIM] = {0.0};

  for (PetscInt k = f->first[0][0][g]; k < f->last[0][0][g]; k++)
    for (PetscInt a = 0; a < dim; a++) sum[a] += f->w[k] * f->value[dim * f->j[k] + a];
  for (PetscInt a = 0; a < dim; a++) y[a][g] = sum[a];
}

/* Returns true if all components at point g have the fit of the first. */
static inline PetscBool IsShared(PetscInt dim, const SplineFits *f, PetscInt g)
{
  for (PetscInt a = 1; a < f->sets; a++)
    if (f->first[a][a][g] != f->first[0][0][g]) return PETSC_FALSE;
  return f->coupled && f->last[0][1][g] > f->first[0][1][g] ? PETSC_FALSE : PETSC_TRUE;
}

/* Computes the velocity at all points from f->value. Inlined, so that the compiler knows the
   dimension. */
static inline void ApplyInline(PetscInt dim, const SplineFits *f, PetscScalar *const y[])
{
  for (PetscInt g = 0; g < f->points; g++) {
    if (IsShared(dim, f, g)) {
      SumShared(dim, f, g, y);
      continue;
    }
    for (PetscInt a = 0; a < dim; a++) {
      y[a][g] = Sum(dim, f, f->first[a][a][g], f->last[a][a][g], a);
      for (PetscInt b = 0; f->coupled && b < dim; b++)
        if (b != a) y[a][g] += Sum(dim, f, f->first[a][b][g], f->last[a][b][g], b);
    }
  }
}

/* SplineFitsApply - Computes the velocity at the points, s->points, from the velocities of own
   particles in s->fits.value; collective */
PetscErrorCode SplineFitsApply(const Particles *p, Splines *s)
{
  PetscScalar *y[ISPH_MAX_DIM];

  PetscFunctionBegin;
  PetscCall(ParticlesHaloVectors(p, s->fits.value));
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(VecGetArrayWrite(s->points[a], &y[a]));
  if (p->dim == 2) ApplyInline(2, &s->fits, y);
  else ApplyInline(3, &s->fits, y);
  for (PetscInt a = 0; a < p->dim; a++) PetscCall(VecRestoreArrayWrite(s->points[a], &y[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
