/*
  Rheologies: kinematic viscosity as a function of the strain rate g = sqrt(2 E:E),
  E = (grad u + grad u^T)/2. All quantities are divided by the density, as is the kinematic
  viscosity: a stress of 1 m^2/s^2 means rho Pa.
*/
#include "isph/scene.h"

/* ---- nu(g) [m^2/s] and its limits ---- */

/* nu = K g^(n-1) */
static PetscReal RheologyNu_PowerLaw(const Rheology *r, PetscReal rate)
{
  return r->parameter[RHEOLOGY_CONSISTENCY] *
         PetscPowReal(rate, r->parameter[RHEOLOGY_EXPONENT] - 1.0);
}

/* nu = nu_inf + (nu_0 - nu_inf) (1 + (lambda g)^2)^((n-1)/2) */
static PetscReal RheologyNu_Carreau(const Rheology *r, PetscReal rate)
{
  const PetscReal infinite = r->parameter[RHEOLOGY_INFINITE],
                  square   = PetscSqr(r->parameter[RHEOLOGY_TIME] * rate);

  return infinite + (r->nu - infinite) *
                        PetscPowReal(1.0 + square, 0.5 * (r->parameter[RHEOLOGY_EXPONENT] - 1.0));
}

/* nu = nu_p + tau_0 (1 - exp(-m g))/g; for m -> infinity the Bingham model */
static PetscReal RheologyNu_Papanastasiou(const Rheology *r, PetscReal rate)
{
  const PetscReal m = r->parameter[RHEOLOGY_REGULARISATION], x = m * rate;

  return r->nu + r->parameter[RHEOLOGY_YIELD] *
                     (x > 1e-8 ? -expm1(-(double)x) / rate : m * (1.0 - 0.5 * x));
}

/* ---- g at a shear stress tau > 0 [1/s], for the ideal fluid without bounds and
   regularisation ---- */

static PetscReal RheologyRate_PowerLaw(const Rheology *r, PetscReal tau)
{
  return PetscPowReal(tau / r->parameter[RHEOLOGY_CONSISTENCY],
                      1.0 / r->parameter[RHEOLOGY_EXPONENT]);
}

/* Solves nu(g) g = tau by bisection; the stress increases with the rate. */
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

/* Bingham model: the rate is zero below the yield stress. */
static PetscReal RheologyRate_Papanastasiou(const Rheology *r, PetscReal tau)
{
  return PetscMax(0.0, tau - r->parameter[RHEOLOGY_YIELD]) / r->nu;
}

#define BIT(parameter) (1u << (parameter))

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
        .takes    = BIT(RHEOLOGY_CONSISTENCY) | BIT(RHEOLOGY_EXPONENT),
        .wants    = BIT(RHEOLOGY_EXPONENT),
        .Nu       = RheologyNu_PowerLaw,
        .Rate     = RheologyRate_PowerLaw,
    },
    {
        .name     = "carreau",
        .brief    = "nu = nu_inf + (nu - nu_inf) (1 + (lambda g)^2)^((n-1)/2)",
        .citation = "Carreau, Trans. Soc. Rheol. 16 (1972)",
        .takes    = BIT(RHEOLOGY_EXPONENT) | BIT(RHEOLOGY_TIME) | BIT(RHEOLOGY_INFINITE),
        .wants    = BIT(RHEOLOGY_EXPONENT),
        .Nu       = RheologyNu_Carreau,
        .Rate     = RheologyRate_Carreau,
    },
    {
        .name     = "papanastasiou",
        .brief    = "nu + tau_0 (1 - exp(-m g))/g: Bingham's plastic, regularised",
        .citation = "Papanastasiou, J. Rheol. 31 (1987)",
        .takes    = BIT(RHEOLOGY_YIELD) | BIT(RHEOLOGY_REGULARISATION),
        .wants    = BIT(RHEOLOGY_YIELD),
        .Nu       = RheologyNu_Papanastasiou,
        .Rate     = RheologyRate_Papanastasiou,
    },
};
const Table RheologyTable = TABLE("-rheology", "Rheologies", rheologies);

/* The choice and the bounds, then the parameters in the order of RheologyParameter. */
enum { NAME, VISCOSITY_MIN, VISCOSITY_MAX, PARAMETERS };
static const OptionRow options[] = {
    [NAME] =
        {
            .name     = "-rheology",
            .kind     = VALUE_NAME,
            .brief    = "law by which viscosity follows the strain rate",
            .standard = "newtonian",
            .table    = &RheologyTable,
            .where    = "flows",
        },
    [VISCOSITY_MIN] =
        {
            .name     = "-rheology_viscosity_min",
            .kind     = VALUE_REAL,
            .brief    = "least kinematic viscosity",
            .unit     = "m^2/s",
            .standard = "the limit of the law, or nu/1000; nu/20 of a power law with n > 1",
            POSITIVE,
            .where = "fluids that are not newtonian",
        },
    [VISCOSITY_MAX] =
        {
            .name     = "-rheology_viscosity_max",
            .kind     = VALUE_REAL,
            .brief    = "largest kinematic viscosity",
            .unit     = "m^2/s",
            .standard = "the limit of the law, or 1000 nu",
            POSITIVE,
            .where = "fluids that are not newtonian",
        },
    [PARAMETERS + RHEOLOGY_CONSISTENCY] =
        {
            .name     = "-rheology_consistency",
            .kind     = VALUE_REAL,
            .brief    = "consistency K",
            .unit     = "m^2 s^(n-2)",
            .standard = "the viscosity at the rate U/L is -viscosity",
            POSITIVE,
            .where = "-rheology power_law",
        },
    [PARAMETERS + RHEOLOGY_EXPONENT] =
        {
            .name  = "-rheology_exponent",
            .kind  = VALUE_REAL,
            .brief = "exponent n; must be given",
            .unit  = "-",
            .low   = 0.05,
            .high  = 5.0,
            .where = "-rheology power_law and carreau",
        },
    [PARAMETERS + RHEOLOGY_TIME] =
        {
            .name     = "-rheology_time",
            .kind     = VALUE_REAL,
            .brief    = "time constant lambda",
            .unit     = "s",
            .standard = "L/U",
            POSITIVE,
            .where = "-rheology carreau",
        },
    [PARAMETERS + RHEOLOGY_INFINITE] =
        {
            .name     = "-rheology_viscosity_infinite",
            .kind     = VALUE_REAL,
            .brief    = "kinematic viscosity at infinite rate, nu_inf",
            .unit     = "m^2/s",
            .standard = "0",
            NOT_NEGATIVE,
            .where = "-rheology carreau",
        },
    [PARAMETERS + RHEOLOGY_YIELD] =
        {
            .name  = "-rheology_yield",
            .kind  = VALUE_REAL,
            .brief = "yield stress over the density, tau_0; must be given",
            .unit  = "m^2/s^2",
            NOT_NEGATIVE,
            .where = "-rheology papanastasiou",
        },
    [PARAMETERS + RHEOLOGY_REGULARISATION] =
        {
            .name     = "-rheology_regularisation",
            .kind     = VALUE_REAL,
            .brief    = "time constant m of the regularisation",
            .unit     = "s",
            .standard = "1000 L/U",
            POSITIVE,
            .where = "-rheology papanastasiou",
        },
};
const OptionTable RheologyOptions = OPTIONS("Rheology", options);

/* Sets the defaults of parameters; rate U/L [1/s]. */
static void RheologyDefaults(PetscReal rate, Rheology *r)
{
  r->parameter[RHEOLOGY_TIME]           = 1.0 / rate;
  r->parameter[RHEOLOGY_REGULARISATION] = 1000.0 / rate;
  if (!(r->row->takes & BIT(RHEOLOGY_EXPONENT))) return;
  r->parameter[RHEOLOGY_CONSISTENCY] =
      r->nu * PetscPowReal(rate, 1.0 - r->parameter[RHEOLOGY_EXPONENT]);
}

/* Returns the viscosity for zero rate (end = -1) or infinite rate (1); without a limit, the
   viscosity 12 powers of ten away. */
static PetscReal RheologyLimit(const Rheology *r, PetscReal rate, PetscInt end, PetscBool *limited)
{
  const PetscReal last = r->row->Nu(r, rate * PetscPowReal(1e100, end)),
                  near = r->row->Nu(r, rate * PetscPowReal(1e90, end));

  *limited = PetscAbsReal(last - near) <= 1e-3 * last ? PETSC_TRUE : PETSC_FALSE;
  return *limited ? last : r->row->Nu(r, rate * PetscPowReal(1e12, end));
}

/*
  Sets default bounds of the viscosity: the limits of the model for zero and infinite rate. Without
  limits the bounds are 1000 nu and nu/1000. A fluid whose viscosity vanishes with the rate has the
  lower bound nu/20: particles of very low viscosity would decouple from their neighbours.
  (Poiseuille flow, n = 2, a row in the middle of 51: error 1.8 % with nu/100, 0.3 % with nu/20.)
*/
static void RheologyBound(PetscReal rate, Rheology *r)
{
  PetscBool       slow_limited, fast_limited;
  const PetscReal slow = RheologyLimit(r, rate, -1, &slow_limited);
  const PetscReal fast = RheologyLimit(r, rate, 1, &fast_limited);

  r->low  = PetscMin(slow, fast);
  r->high = PetscMax(slow, fast);
  if (r->low < 1e-5 * r->nu && !(slow < fast ? slow_limited : fast_limited))
    r->low = r->nu * (slow < fast ? 0.05 : 1e-3);
  if (r->high > 1e5 * r->nu && !(slow < fast ? fast_limited : slow_limited)) r->high = 1e3 * r->nu;
}

/*
  SceneReadRheology - Reads the rheology, a viscosity that depends on the strain rate

  Collective, when scene->nu, length and speed
  are known.
  Options Database Keys:
+ -rheology name             - row of the rheology table
. -rheology_consistency K    - of power_law [m^2 s^(n-2)]
. -rheology_exponent n       - of power_law and carreau [-]
. -rheology_time lambda      - of carreau; default L/U [s]
. -rheology_viscosity_infinite nu - of carreau [m^2/s]
. -rheology_yield tau_0      - of papanastasiou [m^2/s^2]
. -rheology_regularisation m - of papanastasiou; default 1000 L/U [s]
- -rheology_viscosity_min, -rheology_viscosity_max nu - bounds; see RheologyBound() [m^2/s]
*/
PetscErrorCode SceneReadRheology(Scene *scene)
{
  Rheology       *r    = &scene->rheology;
  const PetscReal rate = scene->speed / scene->length;

  PetscFunctionBegin;
  PetscCall(OptionGetRow(&options[NAME], NULL, &r->row));
  if (!r->row->Nu) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(SceneHas(scene, PHYSICS_VISCOSITY),
            "-without viscosity and -rheology %s cannot both be given", r->row->name);
  r->nu = scene->nu;
  for (PetscInt pass = 0; pass < 2; pass++) { /* defaults follow from the exponent */
    for (PetscInt k = 0; k < RHEOLOGY_PARAMETERS; k++) {
      PetscBool given;

      if (!(r->row->takes & BIT(k))) continue;
      PetscCall(OptionGetReal(&options[PARAMETERS + k], &r->parameter[k], &given));
      UserCheck(given || !(r->row->wants & BIT(k)), "-rheology %s: %s is required [%s]",
                r->row->name, options[PARAMETERS + k].name, options[PARAMETERS + k].unit);
    }
    if (pass == 0) RheologyDefaults(rate, r);
  }
  RheologyBound(rate, r);
  PetscCall(OptionGetReal(&options[VISCOSITY_MIN], &r->low, NULL));
  PetscCall(OptionGetReal(&options[VISCOSITY_MAX], &r->high, NULL));
  UserCheck(r->low <= r->high,
            "-rheology_viscosity_min %.6g: it is more than -rheology_viscosity_max %.6g",
            (double)r->low, (double)r->high);
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
