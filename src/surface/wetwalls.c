/* Walls and openings beside a free surface: wall particles that fluid touches, dry walls, walls
   that cover a particle, and openings, where a void is fluid that enters or has left. The contact
   line, where the surface meets a wall, follows from them: contactline.c. */
#include "surfacefits.h"

#define WET 1.3 /* distance of fluid from a wall particle that it touches [dx] */
#define DRY 2.4 /* distance of wall particles that are tried for contact with fluid [dx] */

/* Returns true if fluid enters at wall particle w. */
static PetscBool IsInflow(const Scene *scene, const Particles *p, PetscInt w)
{
  const PetscInt side = (PetscInt)p->side[w];
  PetscReal      x[ISPH_MAX_DIM];

  if (!BoundaryIs(scene, side, BOUNDARY_INFLOW)) return PETSC_FALSE;
  ParticlesWallPoint(p, w, x);
  return BoundaryIsOpen(scene, side, x);
}

/* Returns true if wall particle w is a part of an opening: beyond it is fluid that enters or has
   left. */
static PetscBool IsOpening(const Scene *scene, const Particles *p, PetscInt w)
{
  return BoundaryIs(scene, (PetscInt)p->side[w], BOUNDARY_OUTFLOW) || IsInflow(scene, p, w);
}

/* FreeSurfaceTouches - Returns true if fluid touches a wall particle that is a neighbour of own
   fluid particle i. Not collective. Fluid does not see a wall across a gap: there it has no
   friction, and the wall does not cover it. Only neighbours of i are searched, so that the answer
   needs no other rank. Fluid touches all wall particles of openings. Isolated particles do not
   count if `free` is given; NULL: they do. */
PetscBool FreeSurfaceTouches(const Scene *scene, const Particles *p, const Neighbors *nb,
                             const FreeSurface *free, PetscInt i, PetscInt wall)
{
  const PetscReal most = PetscSqr(WET * p->dx[i]);

  if (IsOpening(scene, p, wall)) return PETSC_TRUE;
  for (PetscInt q = nb->row[i] - 1; q < nb->row[i + 1]; q++) {
    const PetscInt j = q < nb->row[i] ? i : nb->col[q];

    if (ParticlesIsWall(p, j) || (free && free->kind[j] == SURFACE_ISOLATED)) continue;
    if (ParticlesSquareDistance(p, i, j) >= PetscSqr(nb->radius)) continue;
    if (ParticlesSquareDistance(p, wall, j) < most) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Counts the places nearer to wall particle w than the root of most. Inlined for each dimension. */
static ISPH_INLINE PetscInt64 CountNear(PetscInt dim, const Particles *p, PetscInt w,
                                        PetscReal most, PetscInt n, PetscReal *const x[])
{
  const PetscReal *px[ISPH_MAX_DIM] = {x[0], x[1], x[dim - 1]};
  PetscReal        at[ISPH_MAX_DIM] = {0.0};
  PetscInt64       near             = 0;

  for (PetscInt a = 0; a < dim; a++) at[a] = p->x[a][w];
  for (PetscInt k = 0; k < n; k++) {
    PetscReal r2 = 0.0;

    for (PetscInt a = 0; a < dim; a++) r2 += PetscSqr(px[a][k] - at[a]);
    near += r2 < most;
  }
  return near;
}

/* Returns true if a place is nearer to wall particle w than the root of most. */
static ISPH_WIDE PetscBool IsNear(const Particles *p, PetscInt w, PetscReal most, PetscInt n,
                                  PetscReal *const x[])
{
  return (p->dim == 2 ? CountNear(2, p, w, most, n, x) : CountNear(3, p, w, most, n, x)) > 0
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/* FreeSurfaceListTouched - Lists the neighbours of own fluid particle i without wall particles that
   no fluid touches, as FreeSurfaceTouches() finds it; returns their number. Not collective. Input:
   x - room for the places of the neighbours. Output: list - the neighbours. */
PetscInt FreeSurfaceListTouched(const Scene *scene, const Particles *p, const Neighbors *nb,
                                PetscInt i, PetscReal *const x[], PetscInt list[])
{
  const PetscReal most = PetscSqr(WET * p->dx[i]);
  PetscInt        n = 0, listed = 0;

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j = nb->col[q];

    if (ParticlesIsWall(p, j) || ParticlesSquareDistance(p, i, j) >= PetscSqr(nb->radius)) continue;
    for (PetscInt a = 0; a < p->dim; a++) x[a][n] = p->x[a][j];
    n++;
  }
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j = list[listed] = nb->col[q];

    if (!ParticlesIsWall(p, j) || ParticlesSquareDistance(p, i, j) < most ||
        IsNear(p, j, most, n, x) || IsOpening(scene, p, j))
      listed++;
  }
  return listed;
}

/* FreeSurfaceIsCoveredBy - Returns true if wall particle w covers own particle i: fluid enters
   there, or it faces the normal and fluid touches it; not collective */
PetscBool FreeSurfaceIsCoveredBy(const Scene *scene, const Particles *p, const Neighbors *nb,
                                 PetscInt i, PetscInt w, const PetscReal normal[])
{
  PetscReal faces = 0.0;

  if (IsInflow(scene, p, w)) return PETSC_TRUE;
  for (PetscInt a = 0; a < p->dim; a++) faces += p->normal[a][w] * normal[a];
  return faces < -0.5 && FreeSurfaceTouches(scene, p, nb, NULL, i, w);
}

/* Returns true if neighbour j of own particle i is a wall particle of an opening close to it. */
static PetscBool IsOpeningClose(const Scene *scene, const Particles *p, const Neighbors *nb,
                                PetscInt i, PetscInt j)
{
  return ParticlesIsWall(p, j) &&
         ParticlesSquareDistance(p, i, j) < PetscSqr(SurfaceReach(p, nb, i, SURFACE_CLOSE)) &&
         IsOpening(scene, p, j);
}

/* FreeSurfaceOpenings - Returns the number of wall particles of openings close to own particle i: a
   void there is fluid that enters or has left; not collective */
PetscInt FreeSurfaceOpenings(const Scene *scene, const Particles *p, const Neighbors *nb,
                             PetscInt i)
{
  PetscInt n = 0;

  if (!SceneHasOpenings(scene)) return 0;
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++)
    if (IsOpeningClose(scene, p, nb, i, nb->col[q])) n++;
  return n;
}

/* FreeSurfaceFillOpenings - Takes the void at openings close to own particle i out of S: its
   component away from them; not collective. With it n_0 of a particle at the rim of a jet would
   point to the wall around the opening, which covers it. */
void FreeSurfaceFillOpenings(const Scene *scene, const Particles *p, const Neighbors *nb,
                             PetscInt i, PetscReal S[])
{
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j    = nb->col[q];
    PetscReal      away = 0.0;

    if (!IsOpeningClose(scene, p, nb, i, j)) continue;
    for (PetscInt a = 0; a < p->dim; a++) away += S[a] * p->normal[a][j];
    for (PetscInt a = 0; a < p->dim && away > 0.0; a++) S[a] -= away * p->normal[a][j];
  }
}

/* Returns true if neighbour j is a wall particle of a boundary without slip. */
static PetscBool IsNoSlipWall(const Scene *scene, const Particles *p, PetscInt j)
{
  return ParticlesIsWall(p, j) ? BoundaryIs(scene, (PetscInt)p->side[j], BOUNDARY_NO_SLIP)
                               : PETSC_FALSE;
}

/* FreeSurfaceNearestWall - Returns the wall particle nearest to own particle i, -1 if none is
   nearer than a distance. Not collective. Input: scene - only walls without slip count; NULL: all
   do. most - the distance [m]; the radius of the support if that is less. */
PetscInt FreeSurfaceNearestWall(const Scene *scene, const Particles *p, const Neighbors *nb,
                                PetscInt i, PetscReal most)
{
  PetscInt  nearest = -1;
  PetscReal least   = PetscSqr(PetscMin(most, nb->radius));

  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt  j  = nb->col[q];
    const PetscReal r2 = ParticlesSquareDistance(p, i, j);

    if (r2 >= least || !(scene ? IsNoSlipWall(scene, p, j) : ParticlesIsWall(p, j))) continue;
    nearest = j;
    least   = r2;
  }
  return nearest;
}

/* FreeSurfaceIsBesideDryWall - Returns true if own particle i is beside a wall without slip that no
   fluid touches, except isolated particles; not collective. Wall particles nearer than 1.3 dx are
   touched by the particle itself, and the next ones are dx further: wherever a front is, one of
   them is within DRY dx. */
PetscBool FreeSurfaceIsBesideDryWall(const Scene *scene, const Particles *p, const Neighbors *nb,
                                     const FreeSurface *free, PetscInt i)
{
  for (PetscInt q = nb->row[i]; q < nb->row[i + 1]; q++) {
    const PetscInt j = nb->col[q];

    if (IsNoSlipWall(scene, p, j) &&
        ParticlesSquareDistance(p, i, j) < PetscSqr(SurfaceReach(p, nb, i, DRY)) &&
        !FreeSurfaceTouches(scene, p, nb, free, i, j))
      return PETSC_TRUE;
  }
  return PETSC_FALSE;
}
