/* Fluid that returns through an outflow, as in an eddy that leaves the box, or where a pressure
   drives it in. Moving particles leave a void behind them there. A particle enters before a wall
   particle of the outflow if no fluid is within SPACE of its place and the fluid nearby moves into
   the box; it has the mean values of that fluid, as n.grad u = 0 demands. The volume that enters is
   thus that of the voids. With a free surface nothing returns: a void may be air. */
#include "entrants.h"

#define PLACE 0.35 /* distance of the place from the side [dx] */
#define SPACE 0.70 /* distance of the nearest fluid, with which the right volume enters [dx] */
#define NEAR  2.0  /* distance within which fluid decides on the direction [dx] */

/* Returns the velocity of particle i into the box through a side [m/s]. */
static PetscReal Inward(const Particles *p, PetscInt side, PetscInt i)
{
  return side % 2 ? -p->u[side / 2][i] : p->u[side / 2][i];
}

/* Returns true if own fluid near an outflow moves into the box. */
static PetscBool MovesIn(const Scene *scene, const Particles *p)
{
  for (PetscInt side = 0; side < 2 * scene->dim; side++) {
    for (PetscInt i = 0; BoundaryIs(scene, side, BOUNDARY_OUTFLOW) && i < p->n_fluid; i++) {
      PetscReal x[ISPH_MAX_DIM];

      for (PetscInt a = 0; a < p->dim; a++) x[a] = p->x[a][i];
      if (SceneSideDistance(scene, side, x) < NEAR * p->dx[i] && Inward(p, side, i) > 0.0)
        return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

/* Lets a particle enter before own wall particle w of an outflow, if there is a void. */
static PetscErrorCode FillBefore(const Particles *p, const Cells *cells, PetscInt w,
                                 PetscInt list[], Entrants *entrants)
{
  const PetscInt  side = (PetscInt)p->side[w];
  const PetscReal dx   = p->dx[w];
  PetscReal       x[ISPH_MAX_DIM], sum = 0.0, nearest = PETSC_INFINITY;
  PetscInt        n;

  PetscFunctionBegin;
  ParticlesWallPoint(p, w, x);
  for (PetscInt a = 0; a < p->dim; a++) x[a] += PLACE * dx * p->normal[a][w];
  PetscCall(CellsFind(cells, x, NEAR * dx, cells->n, list, &n));
  for (PetscInt k = 0; k < n; k++) {
    PetscReal r2 = 0.0;

    if (ParticlesIsWall(p, list[k])) continue;
    for (PetscInt a = 0; a < p->dim; a++) r2 += PetscSqr(p->x[a][list[k]] - x[a]);
    nearest = PetscMin(nearest, r2);
    sum += Inward(p, side, list[k]);
  }
  if (nearest < PetscSqr(SPACE * dx) || sum <= 0.0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(EntrantsAdd(p, w, PLACE * dx, entrants));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* EntrantsFindReturning - Adds the particles that return through outflows to the share of this
   rank; collective. Updates the halo, also of the velocities. */
PetscErrorCode EntrantsFindReturning(Flow *flow, Entrants *entrants)
{
  const Scene *scene = flow->scene;
  Particles   *p     = flow->particles;
  Cells        cells = {0};
  PetscBool    moves_in;
  PetscInt    *list;

  PetscFunctionBegin;
  if (flow->ops->cut_surface || !SceneHasBoundary(scene, BOUNDARY_OUTFLOW))
    PetscFunctionReturn(PETSC_SUCCESS);
  moves_in = MovesIn(scene, p);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moves_in, 1, MPIU_BOOL, MPI_LOR, p->comm));
  if (!moves_in) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ParticlesUpdateHalo(p));
  PetscCall(ParticlesHaloComponents(p, p->u));
  PetscCall(CellsBuild(p, NEAR * scene->dx, &cells));
  PetscCall(PetscMalloc1(cells.n, &list));
  for (PetscInt w = p->n_fluid; w < ParticlesOwn(p); w++) {
    if (BoundaryIs(scene, (PetscInt)p->side[w], BOUNDARY_OUTFLOW))
      PetscCall(FillBefore(p, &cells, w, list, entrants));
  }
  PetscCall(PetscFree(list));
  PetscCall(CellsFree(&cells));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if a returning particle is within SPACE of a kept one that returns too. */
static PetscBool IsCrowded(const Scene *scene, const Entrants *kept, const Entrant *entrant)
{
  for (PetscInt k = 0; k < kept->n; k++) {
    const Entrant *other = &kept->entrant[k];
    PetscReal      r2    = 0.0;

    if (!BoundaryIs(scene, (PetscInt)other->side, BOUNDARY_OUTFLOW)) continue;
    for (PetscInt a = 0; a < scene->dim; a++) r2 += PetscSqr(other->x[a] - entrant->x[a]);
    if (r2 < PetscSqr(SPACE * scene->dx)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* EntrantsDropCrowded - Drops returning particles that are close to others, as where two outflows
   meet. Input: entrants - of all ranks. */
void EntrantsDropCrowded(const Scene *scene, Entrants *entrants)
{
  const PetscInt n = entrants->n;

  entrants->n = 0;
  for (PetscInt k = 0; k < n; k++) {
    const Entrant entrant = entrants->entrant[k];

    if (BoundaryIs(scene, (PetscInt)entrant.side, BOUNDARY_OUTFLOW) &&
        IsCrowded(scene, entrants, &entrant))
      continue;
    entrants->entrant[entrants->n++] = entrant;
  }
}
