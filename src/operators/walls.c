/*
  Wall treatments: where the wall particles lie, and what a fluid particle reads from one.
  Velocities: f_w - f_i = beta (f_wall - f_i), f_wall the wall's own, or the particle's from the
  fluid near it (wallfits.c), the divergence keeping beta. Pressures: n.grad p is given.
*/
#include "extension.h"

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

  if (depth <= 0.0) return 1.0; /* on the surface, above or below which the fluid may be */
  if (distance * (cap - 1.0) <= depth) return cap;
  return 1.0 + depth / distance;
}

static const WallRow walls[] = {
    /* name, brief, citation, on the surface, beta, extend, it looks as far as: radii, dx; check */
    {"wall_layer",
     "one layer of particles on the wall, its conditions equations of least-squares fits",
     "Kuhnert (1999); divergence sees the normal velocity only", PETSC_TRUE, WallBeta_Own, NULL,
     0.0, 0.0, NULL},
    {"dummy_linear", "dummy layers behind the wall, velocities extrapolated linearly",
     "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)", PETSC_FALSE, WallBeta_DummyLinear, NULL, 0.0,
     0.0, NULL},
    {"mirror", "dummies have the velocity at their mirror image, turned about the wall's",
     "Basa, Quinlan & Lastiwka (2009); Marrone et al. (2011)", PETSC_FALSE, WallBeta_DummyLinear,
     WallExtend_Mirror, 2.0, 3.0, NULL},
    {"linear", "dummies on the line through the wall and the fluid nearest to it",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", PETSC_FALSE,
     WallBeta_DummyLinear, WallExtend_Linear, 1.0, 3.0, NULL},
    {"quadratic", "dummies on the parabola through the wall and the fluid nearest to it",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", PETSC_FALSE,
     WallBeta_DummyLinear, WallExtend_Quadratic, 1.0, 4.0, NULL},
    {"global_quadratic", "dummies on the parabola through both walls of a channel",
     "Watkins et al., Astron. Astrophys. Suppl. 119 (1996)", PETSC_FALSE, WallBeta_DummyLinear,
     WallExtend_GlobalQuadratic, 1.0, 3.0, WallCheck_Channel},
    {"adami", "dummies have the mean velocity of the fluid they see, turned about the wall's",
     "Adami, Hu & Adams, J. Comput. Phys. 231 (2012)", PETSC_FALSE, WallBeta_DummyLinear,
     WallExtend_Adami, 1.0, 0.0, NULL},
};
/* Around the box of a patch test: no wall, particles whose values are given. */
const WallRow WallGiven = {.name     = "given",
                           .brief    = "values given at particles around the box",
                           .citation = "",
                           .Beta     = WallBeta_Own};

const Table WallTable = TABLE("-wall", "Wall treatments", walls);
