/*
  Wall treatments: where the wall particles lie, and what a fluid particle reads from one.
  Velocities: f_w - f_i = beta (f_wall - f_i), f_wall the wall's own. Pressures: n.grad p is given.
*/
#include "isph/operators.h"

/* Particles on the surface, or any with given values, speak for themselves. */
static PetscReal WallBeta_Own(const Scene *scene, PetscReal distance, PetscReal depth)
{
  return 1.0;
}

/*
  WallBeta_DummyLinear - Linear extrapolation through the wall, from each fluid particle anew

    u_w = u_i + beta (u_wall - u_i),   beta = 1 + d_w/d_i, at most 10

  Input: d_i the fluid particle's distance from the surface and d_w the dummy's depth behind it [m]

  Reference: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136 (1997), whose cap is 1.5
*/
static PetscReal WallBeta_DummyLinear(const Scene *scene, PetscReal distance, PetscReal depth)
{
  const PetscReal cap = 10.0;

  if (distance * (cap - 1.0) <= depth) return cap;
  return 1.0 + depth / distance;
}

static const WallRow walls[] = {
    {"wall_layer",
     "one layer of particles on the wall, its conditions equations of least-squares fits",
     "Kuhnert (1999); divergence sees the normal velocity only", PETSC_TRUE, WallBeta_Own},
    {"dummy_linear", "dummy layers behind the wall, velocities extrapolated linearly",
     "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)", PETSC_FALSE, WallBeta_DummyLinear},
};
/* Around the box of a patch test: no wall, particles whose values are given. */
const WallRow WallGiven = {"given", "values given at particles around the box", "", PETSC_FALSE,
                           WallBeta_Own};

const Table WallTable = TABLE("-wall", "Wall treatments", walls);
