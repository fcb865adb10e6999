/*
  Start-up of plane channel flows, viscous only by default: walls at y = 0 and y = L, periodic along
  x over eight particles. Their series are exact for an impulsive start from rest.
*/
#include "cases.h"

/* The box both channels share. */
static PetscErrorCode ChannelBox(Scene *scene)
{
  PetscFunctionBegin;
  scene->hi[0]       = 8.0 * scene->dx;
  scene->hi[1]       = scene->length;
  scene->periodic[0] = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Relative norms against the series, and

    u_profile_l2   = sqrt(mean (u - U)^2)/max U,  U the exact velocity of the moment
    u_relative_rms = sqrt(mean ((u - U)/U)^2), where `relative`

  Reference of the second: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009),
  Eq. (38)
*/
static PetscErrorCode MeasureProfile(const Flow *flow, PetscBool relative, Report *report)
{
  const Scene     *scene  = flow->scene;
  const Particles *p      = flow->particles;
  PetscReal        sum[2] = {0.0, 0.0}, most = 0.0;

  PetscFunctionBegin;
  for (PetscInt i = 0; i < p->n_fluid; i++) {
    PetscReal x[ISPH_MAX_DIM], exact[ISPH_MAX_DIM], pressure;

    for (PetscInt a = 0; a < scene->dim; a++) x[a] = p->x[a][i];
    scene->problem->Exact(scene, ClockMoment(flow->clock), x, exact, &pressure);
    sum[0] += PetscSqr(p->u[0][i] - exact[0]);
    if (relative && exact[0] != 0.0) sum[1] += PetscSqr(p->u[0][i] / exact[0] - 1.0);
    most = PetscMax(most, PetscAbsReal(exact[0]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, p->comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, p->comm));
  if (SceneIsAsPosed(scene)) {
    if (most > 0.0)
      PetscCall(ReportAddError(report, "u_profile_l2", PetscSqrtReal(sum[0] / p->N_fluid) / most));
    if (most > 0.0 && relative)
      PetscCall(ReportAddError(report, "u_relative_rms", PetscSqrtReal(sum[1] / p->N_fluid)));
    PetscCall(NormsExact(flow, report));
  }
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* CouetteMeasure - The profile's errors; far from the wall that moves U is as good as zero at
   first */
PetscErrorCode CouetteMeasure(const Flow *flow, Report *report)
{
  PetscFunctionBegin;
  PetscCall(MeasureProfile(flow, PETSC_FALSE, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PoiseuilleMeasure - The profile's errors, relative to the velocity at each place too */
PetscErrorCode PoiseuilleMeasure(const Flow *flow, Report *report)
{
  PetscFunctionBegin;
  PetscCall(MeasureProfile(flow, PETSC_TRUE, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CouetteSetup(Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(ChannelBox(scene));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The wall at y = L moves with U. */
void CouetteWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                         PetscReal u[])
{
  if (side == 3) u[0] = scene->speed;
}

/*
  CouetteExact - Start-up of plane Couette flow

    u/U = y/L + sum_n 2 (-1)^n/(n pi) sin(n pi y/L) exp(-n^2 pi^2 nu t/L^2)

  With -rheology it is the steady flow, at any t > 0.

  Reference: J. P. Morris, P. J. Fox, Y. Zhu, J. Comput. Phys. 136 (1997), Eq. (22)
*/
void CouetteExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[], PetscReal *p)
{
  const PetscReal y = x[1] / scene->length, tau = scene->nu * t / PetscSqr(scene->length);
  PetscReal       sum = y;

  u[0] = u[1] = 0.0;
  if (t <= 0.0) return;
  if (!SceneIsNewtonian(scene)) { /* steady: one shear stress, one rate */
    u[0] = scene->speed * y;
    return;
  }
  for (PetscInt n = 1; n < 2000; n++) {
    const PetscReal decay = PetscExpReal(-PetscSqr(n * PETSC_PI) * tau);

    if (decay < 1e-16) break;
    sum += (n % 2 ? -2.0 : 2.0) / (n * PETSC_PI) * PetscSinReal(n * PETSC_PI * y) * decay;
  }
  u[0] = scene->speed * sum;
}

/* The force that gives a largest velocity U: f = 8 nu U/L^2. */
PetscErrorCode PoiseuilleSetup(Scene *scene)
{
  PetscFunctionBegin;
  PetscCall(ChannelBox(scene));
  scene->body_force[0] = 8.0 * scene->nu * scene->speed / PetscSqr(scene->length);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Steady velocity between plates of a fluid whose viscosity follows the strain rate: the shear
  stress is f (d - s) at a distance s from the nearer wall, so

    u = int_(tau(y))^(tau_w) g(tau) dtau/f,   g the strain rate of the true fluid at a stress,

  by the midpoint rule, exact to 1e-5 for the rows there are.
*/
static PetscReal SteadyVelocity(const Scene *scene, PetscReal y)
{
  const PetscReal f = scene->body_force[0], d = 0.5 * scene->length, wall = PetscAbsReal(f) * d,
                  here  = PetscAbsReal(f * (y - d));
  const PetscInt panels = 200;
  PetscReal      sum    = 0.0;

  for (PetscInt k = 0; k < panels; k++)
    sum += scene->rheology.row->Rate(&scene->rheology,
                                     here + (wall - here) * (k + 0.5) / (PetscReal)panels);
  return f != 0.0 ? sum * (wall - here) / panels / f : 0.0;
}

/*
  PoiseuilleExact - Start-up of plane Poiseuille flow, Y = distance from the middle, d = L/2

    u/U = 1 - (Y/d)^2 - 32/pi^3 sum_n (-1)^n/(2n+1)^3 cos((2n+1) pi Y/2d) exp(-(2n+1)^2 pi^2 nu
  t/4d^2),   U = f d^2/(2 nu)

  Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eq. (36),
  whose printed form multiplies the series by (Y/d)^2 and so has u = U at the wall; this one
  satisfies the equation, the wall and the start from rest.

  With -rheology it is the steady flow, at any t > 0.
*/
void PoiseuilleExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                     PetscReal *p)
{
  const PetscReal d = 0.5 * scene->length, y = (x[1] - d) / d,
                  tau = scene->nu * t / PetscSqr(2.0 * d);
  PetscReal sum       = 0.0;

  u[0] = u[1] = 0.0;
  if (t <= 0.0) return;
  if (!SceneIsNewtonian(scene)) {
    u[0] = SteadyVelocity(scene, x[1]);
    return;
  }
  for (PetscInt n = 0; n < 1000; n++) {
    const PetscReal m = 2.0 * n + 1.0, decay = PetscExpReal(-PetscSqr(m * PETSC_PI) * tau);

    if (decay < 1e-16) break;
    sum += (n % 2 ? -1.0 : 1.0) / (m * m * m) * PetscCosReal(0.5 * m * PETSC_PI * y) * decay;
  }
  u[0] = scene->body_force[0] * d * d / (2.0 * scene->nu) *
         (1.0 - y * y - 32.0 / (PETSC_PI * PETSC_PI * PETSC_PI) * sum);
}
