/* Noses of thin fluid on walls without slip: the last particles of a film before the contact line,
   where the surface meets the wall. Two or three particles on the surface hold the whole
   cross-section there, and the fit of one of them uses particles from both sides of the tip. Its
   pressure 2 mu n.E n then amplifies the velocity from which it is computed, and a nose is lost in
   one or two steps of any length. Particles of noses are therefore rough: they have pair forces,
   which dissipate in any arrangement, and a pressure without 2 mu n.E n. A film behind its nose
   keeps the fits, which are exact for a parabola of one or two particles across. See theory.md,
   (surface:nose) and (surface:height). */
#include "surfacefits.h"

#define LENGTH 2.5 /* of a nose, from particles beside a dry wall [dx] */
#define THIN   2.2 /* height above the wall below which fluid is thin [dx] */

/* Returns true if the fluid about own particle i lies lower than THIN dx above the wall. */
static PetscBool IsThin(const Scene *scene, const Particles *p, const Neighbors *nb, PetscInt i)
{
  const PetscInt wall = FreeSurfaceNearestWall(scene, p, nb, i, nb->radius);

  if (wall < 0) return PETSC_FALSE;
  for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
    const PetscInt j      = q < nb->row[i] ? i : nb->col[q];
    PetscReal      height = -p->depth[wall];

    if (ParticlesIsWall(p, j) || ParticlesSquareDistance(p, i, j) >= PetscSqr(nb->radius)) continue;
    for (PetscInt a = 0; a < p->dim; a++)
      height += p->normal[a][wall] * (p->x[a][j] - p->x[a][wall]);
    if (height > THIN * p->dx[i]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Returns true if own particle i is within the length of a nose from a contact line. */
static PetscBool IsNearContact(const Particles *p, const Neighbors *nb, const PetscReal contact[],
                               PetscInt i)
{
  if (contact[i] > 0.0) return PETSC_TRUE;
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j = nb->col[q];

    if (contact[j] > 0.0 &&
        ParticlesSquareDistance(p, i, j) < PetscSqr(SurfaceReach(p, nb, i, LENGTH)))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* FreeSurfaceFindNoses - Finds the contact lines, and sets smooth surface particles in noses of
   thin fluid to SURFACE_ROUGH. Collective. Input: free - kinds of all particles, halo included.
   Output: kinds of own particles, and which of them are at a contact line but in no nose. */
PetscErrorCode FreeSurfaceFindNoses(const Scene *scene, const Particles *p, const Neighbors *nb,
                                    FreeSurface *free)
{
  PetscReal *contact; /* 1 at particles on the surface beside a dry wall */

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(ParticlesAll(p), &contact));
  for (PetscInt i = 0; i < p->n_fluid; i++)
    contact[i] =
        FreeSurfaceHolds(free, i) && FreeSurfaceIsBesideDryWall(scene, p, nb, free, i) ? 1.0 : 0.0;
  PetscCall(ParticlesHaloField(p, contact));
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    const PetscBool nose =
        FreeSurfaceHolds(free, i) && IsNearContact(p, nb, contact, i) && IsThin(scene, p, nb, i);

    free->at_contact_line[i] = contact[i] > 0.0 && !nose;
    if (nose && free->kind[i] == SURFACE_SMOOTH) free->kind[i] = SURFACE_ROUGH;
  }
  PetscCall(PetscFree(contact));
  PetscFunctionReturn(PETSC_SUCCESS);
}
