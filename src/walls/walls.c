/* Wall treatments: the placement of wall particles, and their values in the row of a fluid particle
   i. The velocity of wall particle w is extrapolated from particle i through the wall with a factor
   beta (wall_points.c). For the pressure, the wall pressure gradient is given. */
#include "isph/walls.h"

/* Returns beta = 1, with which the velocity of a wall particle is not extrapolated but is its own
   value, for particles on the surface and particles with given values. */
static PetscReal WallBeta_Own(const Scene *scene, PetscReal distance, PetscReal depth)
{
  return 1.0;
}

/*
  WallBeta_DummyLinear - Returns beta of linear extrapolation from a fluid particle through the wall

    u_w = u_i + beta (u_wall - u_i),   beta = 1 + d_w/d_i, at most 10   (uniform wall velocity)

  Input: d_i distance of the fluid particle from the surface, d_w depth of the dummy behind it [m].
  Reference: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136 (1997), where beta is at most 1.5
*/
static PetscReal WallBeta_DummyLinear(const Scene *scene, PetscReal distance, PetscReal depth)
{
  const PetscReal cap = 10.0;

  if (depth <= 0.0) return 1.0; /* on the surface; a fluid particle may be on either side of it */
  if (distance * (cap - 1.0) <= depth) return cap;
  return 1.0 + depth / distance;
}

static const WallRow walls[] = {
    /* name, brief, citation, on the surface, beta, dynamic */
    {"wall_layer", "a layer of particles on the wall; wall conditions are equations of the fits",
     "Kuhnert (1999); divergence uses the normal velocity only", PETSC_TRUE, WallBeta_Own,
     PETSC_FALSE},
    {"dummy_linear", "dummy layers behind the wall, velocities extrapolated linearly",
     "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)", PETSC_FALSE, WallBeta_DummyLinear,
     PETSC_FALSE},
    {"dynamic", "fixed dummies with densities of their own, by the equation of the fluid; wcsph",
     "Crespo et al., CMC 5 (2007); Basa, Quinlan & Lastiwka (2009)", PETSC_FALSE,
     WallBeta_DummyLinear, PETSC_TRUE},
};
/* Treatment of patch tests: particles around the box have given values. */
const WallRow WallGiven = {
    .name = "given", .brief = "values given at particles around the box", .Beta = WallBeta_Own};

const Table WallTable = TABLE("Wall treatments", walls);
