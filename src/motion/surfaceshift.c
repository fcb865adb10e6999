/* Shifts at a free surface. A shift spreads particles and must not carry fluid: not through the
   surface, and not over a wall past the contact line, where the surface meets it. Only the velocity
   moves the surface and the contact line. See theory.md, section 15.11 and (surface:shift). */
#include "isph/motion.h"

#define SHARE 0.3 /* longest shift beside free surfaces [way of the fastest particle] */
#define WALL  1.5 /* largest distance of the wall beside a contact line [dx] */

/* Removes the part of a shift that carries particle i at a contact line along the wall out of the
   fluid. At the edge of a slit such shifts would wet the wall around it: they follow the
   fastest particle, and the fluid at the edge is slower the finer the particles are. */
static void KeepContactLine(const Flow *flow, PetscInt i, PetscReal shift[])
{
  const Particles *p      = flow->particles;
  const PetscInt   d      = p->dim;
  const PetscInt   w      = FreeSurfaceNearestWall(NULL, p, flow->neighbors, i, WALL * p->dx[i]);
  const PetscReal *normal = &flow->ops->free->normal[i * d];
  PetscReal        out[ISPH_MAX_DIM], facing = 0.0, length2 = 0.0, along = 0.0;

  if (w < 0) return;
  for (PetscInt a = 0; a < d; a++) facing += normal[a] * p->normal[a][w];
  for (PetscInt a = 0; a < d; a++) {
    out[a] = normal[a] - facing * p->normal[a][w];
    length2 += PetscSqr(out[a]);
    along += shift[a] * out[a];
  }
  if (along <= 0.0) return;
  for (PetscInt a = 0; a < d; a++) shift[a] -= along / length2 * out[a];
}

/* FlowLimitShift - Limits the shift of own particle i of a fluid with a free surface. Particles on
   the surface stay on it, and no shift carries them over a wall out of the fluid. Rough particles
   only move apart. No shift is longer than a share of the way of the fastest particle: longer
   shifts carry fluid through the surface, so that the level of a resting puddle would fall or rise.
   Input: apart - displacement of the particle by FlowSeparate() [m]; shift - wanted [m]. Output:
   shift. */
void FlowLimitShift(const Flow *flow, const PetscReal apart[], PetscInt i, PetscReal shift[])
{
  const FreeSurface *free  = flow->ops->free;
  const PetscInt     d     = flow->scene->dim;
  const SurfaceKind  kind  = (SurfaceKind)free->kind[i];
  const PetscReal    most  = SHARE * flow->scheme->stats.speed_max * flow->clock->dt;
  PetscReal          along = 0.0, length = 0.0;

  for (PetscInt a = 0; a < d; a++) along += shift[a] * free->normal[i * d + a];
  for (PetscInt a = 0; a < d; a++) {
    if (kind == SURFACE_SMOOTH) shift[a] -= along * free->normal[i * d + a];
    if (FreeSurfaceIsRough(free, i)) shift[a] = apart[a];
  }
  if (free->at_contact_line[i]) KeepContactLine(flow, i, shift);
  for (PetscInt a = 0; a < d; a++) length += PetscSqr(shift[a]);
  length = PetscSqrtReal(length);
  for (PetscInt a = 0; a < d && length > most; a++) shift[a] *= most / length;
}
