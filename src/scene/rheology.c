/*
  Rheologies: kinematic viscosity as a function of the strain rate g = sqrt(2 E:E),
  E = (grad u + grad u^T)/2. Like the kinematic viscosity, all stresses are divided by the density:
  a stress tau [m^2/s^2] is rho tau in Pa.
*/
#include "isph/scene.h"

/* ---- nu(g) [m^2/s] and its limits ---- */

/* Returns nu = K g^(n-1) at the strain rate g, with consistency K and exponent n. */
static PetscReal RheologyNu_PowerLaw(const Rheology *r, PetscReal rate)
{
  return r->parameter[RHEOLOGY_CONSISTENCY] *
         PetscPowReal(rate, r->parameter[RHEOLOGY_EXPONENT] - 1.0);
}

/* Returns nu = nu_inf + (nu_0 - nu_inf) (1 + (lambda g)^2)^((n-1)/2) at the strain rate g, with
   nu_0 = Scene.nu, time lambda and exponent n. */
static PetscReal RheologyNu_Carreau(const Rheology *r, PetscReal rate)
{
  const PetscReal infinite = r->parameter[RHEOLOGY_INFINITE],
                  square   = PetscSqr(r->parameter[RHEOLOGY_TIME] * rate);

  return infinite + (r->nu - infinite) *
                        PetscPowReal(1.0 + square, 0.5 * (r->parameter[RHEOLOGY_EXPONENT] - 1.0));
}

/* Returns nu = nu_p + tau_0 (1 - exp(-m g))/g at the strain rate g, with nu_p = Scene.nu and yield
   stress tau_0; for m -> infinity it is the Bingham model. */
static PetscReal RheologyNu_Papanastasiou(const Rheology *r, PetscReal rate)
{
  const PetscReal m = r->parameter[RHEOLOGY_REGULARISATION], x = m * rate;

  return r->nu + r->parameter[RHEOLOGY_YIELD] *
                     (x > 1e-8 ? -expm1(-(double)x) / rate : m * (1.0 - 0.5 * x));
}

/* ---- strain rate g at a shear stress tau > 0 [1/s]: of the ideal fluid, with neither bounds of
   the viscosity nor regularisation ---- */

static PetscReal RheologyRate_PowerLaw(const Rheology *r, PetscReal tau)
{
  return PetscPowReal(tau / r->parameter[RHEOLOGY_CONSISTENCY],
                      1.0 / r->parameter[RHEOLOGY_EXPONENT]);
}

/* Returns g with nu(g) g = tau, found by bisection; the stress increases with the rate. */
static PetscReal RheologyRate_Carreau(const Rheology *r, PetscReal tau)
{
  PetscReal low = 0.0, high = tau / r->nu;

  while (RheologyNu_Carreau(r, high) * high < tau) high *= 2.0;
  for (PetscInt k = 0; k < 60; k++) {
    const PetscReal middle = 0.5 * (low + high);

    if (RheologyNu_Carreau(r, middle) * middle < tau) low = middle;
    else high = middle;
  }
  return 0.5 * (low + high);
}

/* Returns the rate of the Bingham model, zero below the yield stress. */
static PetscReal RheologyRate_Papanastasiou(const Rheology *r, PetscReal tau)
{
  return PetscMax(0.0, tau - r->parameter[RHEOLOGY_YIELD]) / r->nu;
}

static const RheologyRow rheologies[] = {
    {
        .name     = "newtonian",
        .brief    = "viscosity does not follow the strain rate g = sqrt(2 E:E)",
        .citation = "",
    },
    {
        .name     = "power_law",
        .brief    = "nu = K g^(n-1)",
        .citation = "Ostwald, Kolloid-Z. 36 (1925)",
        .takes    = RHEOLOGY_BIT(RHEOLOGY_CONSISTENCY) | RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
        .wants    = RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
        .Nu       = RheologyNu_PowerLaw,
        .Rate     = RheologyRate_PowerLaw,
    },
    {
        .name     = "carreau",
        .brief    = "nu = nu_inf + (nu - nu_inf) (1 + (lambda g)^2)^((n-1)/2)",
        .citation = "Carreau, Trans. Soc. Rheol. 16 (1972)",
        .takes    = RHEOLOGY_BIT(RHEOLOGY_EXPONENT) | RHEOLOGY_BIT(RHEOLOGY_TIME) |
                 RHEOLOGY_BIT(RHEOLOGY_INFINITE),
        .wants = RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
        .Nu    = RheologyNu_Carreau,
        .Rate  = RheologyRate_Carreau,
    },
    {
        .name     = "papanastasiou",
        .brief    = "nu + tau_0 (1 - exp(-m g))/g: Bingham's plastic, regularised",
        .citation = "Papanastasiou, J. Rheol. 31 (1987)",
        .takes    = RHEOLOGY_BIT(RHEOLOGY_YIELD) | RHEOLOGY_BIT(RHEOLOGY_REGULARISATION),
        .wants    = RHEOLOGY_BIT(RHEOLOGY_YIELD),
        .Nu       = RheologyNu_Papanastasiou,
        .Rate     = RheologyRate_Papanastasiou,
    },
};
const Table RheologyTable = TABLE("Rheologies", rheologies);

/* RheologyViscosity - Returns the kinematic viscosity at a strain rate, within its bounds [m^2/s];
   not collective */
PetscReal RheologyViscosity(const Rheology *r, PetscReal rate)
{
  return PetscMin(PetscMax(r->row->Nu(r, rate), r->low), r->high);
}

/* SceneIsNewtonian - Returns true if the viscosity does not depend on the strain rate; not
   collective */
PetscBool SceneIsNewtonian(const Scene *scene)
{
  return !scene->rheology.row || !scene->rheology.row->Nu ? PETSC_TRUE : PETSC_FALSE;
}
