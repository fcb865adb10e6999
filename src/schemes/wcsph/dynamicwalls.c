/* Dynamic walls, -wall dynamic: dummies that stay behind the wall have densities of their own, by
   the equation of the fluid, and so pressures that push back where the fluid comes near. Their
   velocities are extended from the fluid along the normal of the wall. */
#include "wcsph.h"

/* Sums over the fluid around a place. */
typedef struct {
  PetscReal density;             /* sum_j m_j W [kg/m^3] */
  PetscReal weight;              /* sum_j V_j W [-] */
  PetscReal height;              /* sum_j V_j W d_j, d_j: height above the wall [m] */
  PetscReal speed[ISPH_MAX_DIM]; /* sum_j V_j W u_j [m/s] */
} Nearby;

/* Adds up the fluid within the support around the place at a height above the wall of wall particle
   i; a height below zero is behind the wall. Input: u - velocities by local index, NULL: none. */
static PetscErrorCode LookAround(const Wcsph *w, PetscInt i, PetscReal height, PetscReal *const u[],
                                 Nearby *sum)
{
  const Flow          *flow  = w->flow;
  const Particles     *p     = flow->particles;
  const OperatorForms *forms = &flow->ops->forms;
  PetscInt            *found = w->local.found, n;
  PetscReal            wall[ISPH_MAX_DIM], centre[ISPH_MAX_DIM], value[3];

  PetscFunctionBegin;
  PetscCall(PetscMemzero(sum, sizeof(*sum)));
  ParticlesWallPoint(p, i, wall);
  for (PetscInt a = 0; a < p->dim; a++) centre[a] = wall[a] + height * p->normal[a][i];
  PetscCall(CellsFind(&flow->neighbors->cells, centre,
                      forms->radius + 0.5 * flow->neighbors->margin, flow->neighbors->cells.n,
                      found, &n));
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt j = found[k];
    PetscReal      r = 0.0, above = 0.0, weight;

    if (ParticlesIsWall(p, j)) continue;
    for (PetscInt a = 0; a < p->dim; a++) {
      r += PetscSqr(p->x[a][j] - centre[a]);
      above += (p->x[a][j] - wall[a]) * p->normal[a][i];
    }
    KernelEvaluate(forms->kernel, p->dim, forms->h, PetscSqrtReal(r), value);
    weight = p->volume[j] * value[0];
    sum->density += flow->scene->rho * weight / w->lattice;
    sum->weight += weight;
    sum->height += weight * above;
    for (PetscInt a = 0; u && a < p->dim; a++) sum->speed[a] += weight * u[a][j];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallDensities - Computes the density of own wall particles [kg/m^3]

    rho_w = rho_0 + S_w(t) - S_w(0),   S_w = sum_j m_j W_wj over the fluid

  This is the integral of drho/dt = sum_j m_j (u_w - u_j).grad W_wj, because the particles of the
  wall stay at rest to each other. Output: rho - by local index. References: A. Crespo, M.
  Gomez-Gesteira, R. Dalrymple, CMC 5 (2007) 173-184; M. Basa, N. Quinlan, M. Lastiwka, Int. J.
  Numer. Meth. Fluids 60 (2009), section 6.2 and Eqs (10), (11)
*/
PetscErrorCode WallDensities(const Wcsph *w, PetscReal rho[])
{
  const Particles *p = w->flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++) {
    Nearby sum;

    PetscCall(LookAround(w, i, -p->depth[i], NULL, &sum));
    rho[i] = w->flow->scene->rho + sum.density - w->wall_start[i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  WallVelocities - Extends the velocity of the fluid to own wall particles, tangentially to the wall

    u_w = u_wall + d_w (u_wall - <u>)/<d>,   <f> = sum_j V_j f_j W/sum_j V_j W over the fluid

  d is the distance from the wall. The sums are those around the dummy of the first layer before w,
  half a spacing behind the wall. Normally to the wall, and without fluid near it, u_w = u_wall.
  Collective. Input and output: w->local.u, with the halo. Reference: M. Basa, N. Quinlan, M.
  Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), section 6.2: "tangential velocities extrapolated
  normally to the wall, using information gathered by the wall particles closest to the fluid"
*/
PetscErrorCode WallVelocities(Wcsph *w)
{
  const Particles *p = w->flow->particles;

  PetscFunctionBegin;
  for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++) {
    Nearby    sum;
    PetscReal normal = 0.0, rise[ISPH_MAX_DIM];

    PetscCall(LookAround(w, i, -0.5 * p->dx[i], w->local.u, &sum));
    if (sum.height <= 0.0) continue;
    for (PetscInt a = 0; a < p->dim; a++) {
      rise[a] = (sum.weight * p->u[a][i] - sum.speed[a]) / sum.height;
      normal += rise[a] * p->normal[a][i];
    }
    for (PetscInt a = 0; a < p->dim; a++)
      w->local.u[a][i] += p->depth[i] * (rise[a] - normal * p->normal[a][i]);
  }
  PetscCall(ParticlesHaloComponents(p, w->local.u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* WallStart - Sets the sums S_w(0) of own wall particles at the start of a run, into room of
   WcsphReserve() */
PetscErrorCode WallStart(Wcsph *w)
{
  const Particles *p = w->flow->particles;

  PetscFunctionBegin;
  PetscCall(PetscArrayzero(w->wall_start + p->n_fluid, p->n_wall));
  PetscCall(WallDensities(w, w->wall_start));
  for (PetscInt i = p->n_fluid; i < ParticlesOwn(p); i++) w->wall_start[i] -= w->flow->scene->rho;
  PetscFunctionReturn(PETSC_SUCCESS);
}
