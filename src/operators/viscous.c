/*
  The viscous operator for a varying viscosity. The weights w_ij of a Laplacian, multiplied by the
  harmonic mean viscosity of each pair, give

    (div(nu grad u))_i = sum_j w_ij nu_ij (u_j - u_i),   nu_ij = 2 nu_i nu_j/(nu_i + nu_j).

  Reason: the row is the Laplacian of g(x) = m(x) (u(x) - u_i), m(x) the mean of nu_i and nu(x). At
  x_i the mean has the value nu_i and the gradient grad nu/2, so lap g = nu lap u + grad nu.grad u
  to the order of the form. If an interface lies half way between i and j, nu_ij (u_j - u_i) is the
  exact flux times the distance, for any jump of nu. See docs/theory.md, (64) and (65).

  Reference: P. W. Cleary, J. J. Monaghan, J. Comput. Phys. 148 (1999) 227-264
*/
#include "boundary_rows.h"

/* WeighByViscosity - Multiplies the weights of a Laplacian by the mean viscosities of pairs over
   scene->nu; a wall neighbour has the viscosity of particle i; not collective */
void WeighByViscosity(const Scene *scene, const Particles *p, const Stencil *st, PetscReal w[])
{
  const PetscReal own = p->nu[st->i];

  for (PetscInt k = 0; k < st->n; k++)
    w[k] *= (st->wall[k] ? own : PairViscosity(own, p->nu[st->j[k]])) / scene->nu;
}
