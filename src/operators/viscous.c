/*
  The viscous operator where the viscosity varies. Any Laplacian that is a row of weights on
  differences becomes

    (div(nu grad u))_i = sum_j w_ij nu_ij (u_j - u_i),   nu_ij = 2 nu_i nu_j/(nu_i + nu_j):

  a Laplacian of g(x) = nu(x_i, x) (u(x) - u_i), whose mean has the value nu_i and the slope grad
  nu/2 at x_i, so that lap g = nu lap u + grad nu.grad u to the order of the form. Across an
  interface half way between i and j the product is the flux times the distance, what the jump of nu
  is; forms that are exact for linear fields then need no more.

  Reference: P. W. Cleary, J. J. Monaghan, J. Comput. Phys. 148 (1999) 227-264
*/
#include "boundary_rows.h"

/* WeighByViscosity - w_k nu_ik/nu in place of the weights w_k of a Laplacian, a wall having the
   viscosity of whoever looks at it; not collective */
void WeighByViscosity(const Scene *scene, const Particles *p, const Stencil *st, PetscReal w[])
{
  const PetscReal own = p->nu[st->i];

  for (PetscInt k = 0; k < st->n; k++)
    w[k] *= (st->wall[k] ? own : PairViscosity(own, p->nu[st->j[k]])) / scene->nu;
}
