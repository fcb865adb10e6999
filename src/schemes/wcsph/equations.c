/* Equations of state of the weakly compressible scheme, and the choices of its other families. Each
   equation has the speed of sound c0 at the density rho_0 of rest. */
#include "wcsph.h"

/* Pressure_Tait - Computes the pressure of a stiff liquid, p = rho_0 c0^2/gamma ((rho/rho_0)^gamma
   - 1) [Pa]. Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009),
   Eq. (13). */
static PetscReal Pressure_Tait(const Wcsph *w, PetscReal rho, PetscReal e)
{
  const PetscReal rho_0 = w->flow->scene->rho, gamma = w->equation->exponent;

  return rho_0 * PetscSqr(w->c0) / gamma * (PetscPowRealInt(rho / rho_0, (PetscInt)gamma) - 1.0);
}

static PetscReal Density_Tait(const Wcsph *w, PetscReal p)
{
  const PetscReal rho_0 = w->flow->scene->rho, gamma = w->equation->exponent;

  return rho_0 * PetscPowReal(1.0 + gamma * p / (rho_0 * PetscSqr(w->c0)), 1.0 / gamma);
}

/* Pressure_Linear - Computes p = c0^2 (rho - rho_0) [Pa]. Reference: J. Fang, A. Parriaux, M.
   Rentschler, C. Ancey, Appl. Numer. Math. 59 (2009), Eq. (8). */
static PetscReal Pressure_Linear(const Wcsph *w, PetscReal rho, PetscReal e)
{
  return PetscSqr(w->c0) * (rho - w->flow->scene->rho);
}

static PetscReal Density_Linear(const Wcsph *w, PetscReal p)
{
  return w->flow->scene->rho + p / PetscSqr(w->c0);
}

/* Pressure_IdealGas - Computes p = (gamma - 1) rho e, less the pressure at rest, rho_0 c0^2/gamma
   [Pa]. Reference: M. Basa, N. Quinlan, M. Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009), Eq.
   (12). */
static PetscReal Pressure_IdealGas(const Wcsph *w, PetscReal rho, PetscReal e)
{
  return (w->equation->exponent - 1.0) * rho * e - w->p_rest;
}

static PetscReal Density_IdealGas(const Wcsph *w, PetscReal p)
{
  return (w->p_rest + p) / ((w->equation->exponent - 1.0) * w->e_rest);
}

static const EquationOfStateRow equations[] = {
    {.name     = "tait",
     .brief    = "p = rho_0 c0^2/7 ((rho/rho_0)^7 - 1)",
     .citation = "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)",
     .exponent = 7.0,
     .Pressure = Pressure_Tait,
     .Density  = Density_Tait},
    {.name     = "linear",
     .brief    = "p = c0^2 (rho - rho_0)",
     .citation = "Fang et al., Appl. Numer. Math. 59 (2009)",
     .exponent = 1.0,
     .Pressure = Pressure_Linear,
     .Density  = Density_Linear},
    {
        .name       = "ideal_gas",
        .brief      = "p = 0.4 rho e with the energy equation; pressures less rho_0 c0^2/1.4",
        .citation   = "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)",
        .exponent   = 1.4,
        .has_energy = PETSC_TRUE,
        .Pressure   = Pressure_IdealGas,
        .Density    = Density_IdealGas,
    },
};
const Table EquationOfStateTable = TABLE("Equations of state", equations);

static const DensityFormRow densities[] = {
    {"continuity", "drho/dt = -rho div u, and the force -(p_i + p_j) V_j grad W/rho_i",
     "Fang et al., Appl. Numer. Math. 59 (2009)", PETSC_FALSE},
    {"summation", "rho = sum m_j W, and the force -m_j (p_i/rho_i^2 + p_j/rho_j^2) grad W",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", PETSC_TRUE},
};
const Table DensityFormTable = TABLE("Density of weakly compressible fluids", densities);

static const PressureReductionRow reductions[] = {
    {"none", "the pressure itself, which keeps the momentum", NULL, PETSC_FALSE},
    {"local_mean", "the mean pressure of the neighbours is subtracted",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", PETSC_TRUE},
};
const Table PressureReductionTable = TABLE("Reductions of the pressure", reductions);

/* WcsphListUnknowns - Lists the arrays of the unknowns of own particles, in the order of the
   vector, and counts them. Input: x, u, rho, e - the arrays. */
void WcsphListUnknowns(Wcsph *w, PetscReal *const x[], PetscReal *const u[], PetscReal *rho,
                       PetscReal *e, PetscReal *of[])
{
  const PetscInt d = w->flow->scene->dim;

  w->components = 2 * d;
  for (PetscInt a = 0; a < d; a++) {
    of[a]     = x[a];
    of[d + a] = u[a];
  }
  if (!w->density->sums) of[w->components++] = rho;
  if (w->equation->has_energy) of[w->components++] = e;
}

/* WcsphComponents - Lists the fields of the particles that are unknowns, in the order of the
   vector */
void WcsphComponents(Wcsph *w, PetscReal *of[])
{
  Particles *p = w->flow->particles;

  WcsphListUnknowns(w, p->x, p->u, w->rho, w->e, of);
}
