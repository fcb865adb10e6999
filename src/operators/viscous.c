/*
  The viscous operator for a varying viscosity. A Laplacian with weights on differences becomes

    (div(nu grad u))_i = sum_j w_ij nu_ij (u_j - u_i),   nu_ij = 2 nu_i nu_j/(nu_i + nu_j).

  The row is the Laplacian of g(x) = nu(x_i, x) (u(x) - u_i). The mean nu(x_i, x) has the value nu_i
  and the gradient grad nu/2 at x_i, so lap g = nu lap u + grad nu.grad u to the order of the form.
  Across an interface half way between i and j the product is the exact flux times the distance,
  however large the jump of nu is. See docs/theory.md, (64) and (65).

  Reference: P. W. Cleary, J. J. Monaghan, J. Comput. Phys. 148 (1999) 227-264
*/
#include "boundary_rows.h"

/* WeighByViscosity - Multiplies the weights of a Laplacian by nu_ik/nu; a wall neighbour has the
   viscosity of particle i; not collective */
void WeighByViscosity(const Scene *scene, const Particles *p, const Stencil *st, PetscReal w[])
{
  const PetscReal own = p->nu[st->i];

  for (PetscInt k = 0; k < st->n; k++)
    w[k] *= (st->wall[k] ? own : PairViscosity(own, p->nu[st->j[k]])) / scene->nu;
}
