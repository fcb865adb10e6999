/* Rheologies: kinematic viscosity as a function of the strain rate g = sqrt(2 E:E), E = (grad u +
   grad u^T)/2. Like the kinematic viscosity, all stresses are divided by the density: a stress tau
   [m^2/s^2] is rho tau in Pa. Defaults of the options follow from the chosen row, the strain rate
   U/L and the viscosity of the scene. */
#include "isph/scene.h"

#define SLOPE_STEP 1e-4 /* change of the strain rate for the slope of the viscosity [-] */

/* ---- nu(g) [m^2/s] and its limits ---- */

/* Returns nu = K g^(n-1) at the strain rate g, with consistency K and exponent n. */
static PetscReal RheologyNu_PowerLaw(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  return r->parameter[RHEOLOGY_CONSISTENCY] *
         PetscPowReal(rate, r->parameter[RHEOLOGY_EXPONENT] - 1.0);
}

/* Returns nu = nu_inf + (nu_0 - nu_inf) (1 + (lambda g)^2)^((n-1)/2) at the strain rate g, with
   nu_0 = Scene.nu, time lambda and exponent n. */
static PetscReal RheologyNu_Carreau(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  const PetscReal infinite = r->parameter[RHEOLOGY_INFINITE],
                  square   = PetscSqr(r->parameter[RHEOLOGY_TIME] * rate);

  return infinite + (r->nu - infinite) *
                        PetscPowReal(1.0 + square, 0.5 * (r->parameter[RHEOLOGY_EXPONENT] - 1.0));
}

/* Returns nu = nu_p + tau_0 (1 - exp(-m g))/g at the strain rate g, with nu_p = Scene.nu and yield
   stress tau_0; for m -> infinity it is the Bingham model. */
static PetscReal RheologyNu_Papanastasiou(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  const PetscReal m = r->parameter[RHEOLOGY_REGULARISATION], x = m * rate;

  return r->nu + r->parameter[RHEOLOGY_YIELD] *
                     (x > 1e-8 ? -expm1(-(double)x) / rate : m * (1.0 - 0.5 * x));
}

/* Returns nu = K (g^2 + 1/m^2)^((n-1)/2) + tau_0 (1 - exp(-m g))/g; for m -> infinity it is the
   Herschel-Bulkley model. */
static PetscReal RheologyNu_HerschelBulkley(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  const PetscReal m = r->parameter[RHEOLOGY_REGULARISATION], x = m * rate;
  const PetscReal yields = x > 1e-8 ? -expm1(-(double)x) / rate : m * (1.0 - 0.5 * x);

  return r->parameter[RHEOLOGY_YIELD] * yields +
         r->parameter[RHEOLOGY_CONSISTENCY] *
             PetscPowReal(rate * rate + 1.0 / (m * m),
                          0.5 * (r->parameter[RHEOLOGY_EXPONENT] - 1.0));
}

/* Returns nu = (nu_p^1/2 + (tau_0/g)^1/2 (1 - exp(-(m g)^1/2)))^2, with nu_p = Scene.nu; for m ->
   infinity it is the Casson model. */
static PetscReal RheologyNu_Casson(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  const PetscReal root = PetscSqrtReal(r->parameter[RHEOLOGY_REGULARISATION] * rate);
  const PetscReal part = root > 1e-8 ? -expm1(-(double)root) / PetscSqrtReal(rate)
                                     : PetscSqrtReal(r->parameter[RHEOLOGY_REGULARISATION]);

  return PetscSqr(PetscSqrtReal(r->nu) + PetscSqrtReal(r->parameter[RHEOLOGY_YIELD]) * part);
}

/* Returns nu = nu_inf + (nu_0 - nu_inf)/(1 + (lambda g)^(1-n)), with nu_0 = Scene.nu. */
static PetscReal RheologyNu_Cross(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  const PetscReal infinite = r->parameter[RHEOLOGY_INFINITE];

  return infinite +
         (r->nu - infinite) / (1.0 + PetscPowReal(r->parameter[RHEOLOGY_TIME] * rate,
                                                  1.0 - r->parameter[RHEOLOGY_EXPONENT]));
}

/* Returns the viscosity that -viscosity_field gives at a place, time and strain rate, which is at
   least 1e-12 U/L: many laws have no value at rest. */
static PetscReal RheologyNu_Typed(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  const PetscReal least = 1e-12 / r->parameter[RHEOLOGY_TIME];
  const PetscReal nu    = ExpressionOf(r->typed, 0, r->t, at->x, at->field, PetscMax(rate, least));

  if (nu <= 0.0) ExpressionBlame(r->typed, 0, nu, "must be positive");
  return nu;
}

/* ---- strain rate g at a shear stress tau > 0 [1/s]: of the ideal fluid, with neither bounds of
   the viscosity nor regularisation ---- */

static PetscReal RheologyRate_PowerLaw(const Rheology *r, PetscReal tau)
{
  return PetscPowReal(tau / r->parameter[RHEOLOGY_CONSISTENCY],
                      1.0 / r->parameter[RHEOLOGY_EXPONENT]);
}

/* Returns g with nu(g) g = tau, found by bisection; the stress increases with the rate. */
static PetscReal RheologyRate_Bisect(const Rheology *r, PetscReal tau)
{
  PetscReal low = 0.0, high = tau / r->nu;

  while (r->row->Nu(r, NULL, high) * high < tau) high *= 2.0;
  for (PetscInt k = 0; k < 60; k++) {
    const PetscReal middle = 0.5 * (low + high);

    if (r->row->Nu(r, NULL, middle) * middle < tau) low = middle;
    else high = middle;
  }
  return 0.5 * (low + high);
}

/* Returns the rate of the Bingham model, zero below the yield stress. */
static PetscReal RheologyRate_Papanastasiou(const Rheology *r, PetscReal tau)
{
  return PetscMax(0.0, tau - r->parameter[RHEOLOGY_YIELD]) / r->nu;
}

/* Returns the rate of the Herschel-Bulkley model, zero below the yield stress. */
static PetscReal RheologyRate_HerschelBulkley(const Rheology *r, PetscReal tau)
{
  return PetscPowReal(PetscMax(0.0, tau - r->parameter[RHEOLOGY_YIELD]) /
                          r->parameter[RHEOLOGY_CONSISTENCY],
                      1.0 / r->parameter[RHEOLOGY_EXPONENT]);
}

/* Returns the rate of the Casson model, zero below the yield stress. */
static PetscReal RheologyRate_Casson(const Rheology *r, PetscReal tau)
{
  const PetscReal root = PetscSqrtReal(tau) - PetscSqrtReal(r->parameter[RHEOLOGY_YIELD]);

  return PetscSqr(PetscMax(0.0, root)) / r->nu;
}

static const RheologyRow rheologies[] = {
    {.name = "newtonian", .brief = "viscosity does not follow the strain rate g = sqrt(2 E:E)"},
    {.name     = "power_law",
     .brief    = "nu = K g^(n-1)",
     .citation = "Ostwald, Kolloid-Z. 36 (1925)",
     .takes    = RHEOLOGY_BIT(RHEOLOGY_CONSISTENCY) | RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
     .wants    = RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
     .Nu       = RheologyNu_PowerLaw,
     .Rate     = RheologyRate_PowerLaw},
    {.name     = "carreau",
     .brief    = "nu = nu_inf + (nu - nu_inf) (1 + (lambda g)^2)^((n-1)/2)",
     .citation = "Carreau, Trans. Soc. Rheol. 16 (1972)",
     .takes    = RHEOLOGY_BIT(RHEOLOGY_EXPONENT) | RHEOLOGY_BIT(RHEOLOGY_TIME) |
              RHEOLOGY_BIT(RHEOLOGY_INFINITE),
     .wants = RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
     .Nu    = RheologyNu_Carreau},
    {.name     = "papanastasiou",
     .brief    = "nu + tau_0 (1 - exp(-m g))/g: Bingham's plastic, regularised",
     .citation = "Papanastasiou, J. Rheol. 31 (1987)",
     .takes    = RHEOLOGY_BIT(RHEOLOGY_YIELD) | RHEOLOGY_BIT(RHEOLOGY_REGULARISATION),
     .wants    = RHEOLOGY_BIT(RHEOLOGY_YIELD),
     .Nu       = RheologyNu_Papanastasiou,
     .Rate     = RheologyRate_Papanastasiou},
    {.name     = "herschel_bulkley",
     .brief    = "K g^(n-1) + tau_0/g, regularised: yields, then thins or thickens",
     .citation = "Herschel & Bulkley, Kolloid-Z. 39 (1926)",
     .takes    = RHEOLOGY_BIT(RHEOLOGY_YIELD) | RHEOLOGY_BIT(RHEOLOGY_REGULARISATION) |
              RHEOLOGY_BIT(RHEOLOGY_CONSISTENCY) | RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
     .wants = RHEOLOGY_BIT(RHEOLOGY_YIELD) | RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
     .Nu    = RheologyNu_HerschelBulkley,
     .Rate  = RheologyRate_HerschelBulkley},
    {.name     = "casson",
     .brief    = "(nu^1/2 + (tau_0/g)^1/2)^2, regularised: chocolate, blood",
     .citation = "Casson, in Rheology of Disperse Systems (1959)",
     .takes    = RHEOLOGY_BIT(RHEOLOGY_YIELD) | RHEOLOGY_BIT(RHEOLOGY_REGULARISATION),
     .wants    = RHEOLOGY_BIT(RHEOLOGY_YIELD),
     .Nu       = RheologyNu_Casson,
     .Rate     = RheologyRate_Casson},
    {.name     = "cross",
     .brief    = "nu = nu_inf + (nu - nu_inf)/(1 + (lambda g)^(1-n))",
     .citation = "Cross, J. Colloid Sci. 20 (1965)",
     .takes    = RHEOLOGY_BIT(RHEOLOGY_EXPONENT) | RHEOLOGY_BIT(RHEOLOGY_TIME) |
              RHEOLOGY_BIT(RHEOLOGY_INFINITE),
     .wants = RHEOLOGY_BIT(RHEOLOGY_EXPONENT),
     .Nu    = RheologyNu_Cross},
    {.name  = "typed",
     .brief = "-viscosity_field at the present place, time, scalars and strain rate g",
     .Nu    = RheologyNu_Typed},
};
const Table RheologyTable = TABLE("Rheologies", rheologies);

/* RheologyRate - Returns the strain rate of the ideal fluid at a shear stress above 0 [1/s]; not
   collective */
PetscReal RheologyRate(const Rheology *r, PetscReal tau)
{
  return r->row->Rate ? r->row->Rate(r, tau) : RheologyRate_Bisect(r, tau);
}

/* RheologyAt - Returns point k of the given coordinates with the present fields of the fluid there,
   if a typed viscosity depends on the place. Input: x - by axis [m] */
FluidPlace RheologyAt(const Scene *scene, PetscReal *const x[], PetscInt k)
{
  const Rheology *r  = &scene->rheology;
  FluidPlace      at = {.x = {0.0}};

  for (PetscInt a = 0; a < scene->dim && r->typed; a++) at.x[a] = x[a][k];
  if (r->typed && ExpressionUses(r->typed, EXPRESSION_FIELDS))
    ExpressionFields(r->typed, r->t, at.x, at.field);
  if (r->typed) SceneIntoBox(scene, at.x);
  return at;
}

/* RheologyViscosity - Returns the kinematic viscosity at a place, see RheologyAt(), and a strain
   rate, within its bounds [m^2/s] */
PetscReal RheologyViscosity(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  return PetscMin(PetscMax(r->row->Nu(r, at, rate), r->low), r->high);
}

/* RheologySlope - Returns dnu/dg at a place and a strain rate g > 0, within the bounds of the
   viscosity, by central differences over SLOPE_STEP g, whose error is of order SLOPE_STEP^2
   [m^2] */
PetscReal RheologySlope(const Rheology *r, const FluidPlace *at, PetscReal rate)
{
  const PetscReal h = SLOPE_STEP * rate;

  return (RheologyViscosity(r, at, rate + h) - RheologyViscosity(r, at, rate - h)) / (2.0 * h);
}

/* SceneIsNewtonian - Returns true if the viscosity does not depend on the strain rate */
PetscBool SceneIsNewtonian(const Scene *scene)
{
  return !scene->rheology.row || !scene->rheology.row->Nu;
}

/* ---- options ---- */

/* Indices of options: name and bounds, then parameters in the order of RheologyParameter. */
enum { NAME, VISCOSITY_MIN, VISCOSITY_MAX, PARAMETERS };
static const OptionRow options[] = {
    [NAME] = OPTION(NAME, "-rheology", "law by which viscosity follows the strain rate", NULL,
                    "newtonian", .table = &RheologyTable, .where = "flows"),
    [VISCOSITY_MIN] = OPTION(REAL, "-rheology_viscosity_min", "least kinematic viscosity", "m^2/s",
                             "the limit of the law, or nu/1000; nu/20 for a power law with n > 1",
                             POSITIVE, .where = "fluids that are not newtonian"),
    [VISCOSITY_MAX] = OPTION(REAL, "-rheology_viscosity_max", "largest kinematic viscosity",
                             "m^2/s", "the limit of the law, or 1000 nu", POSITIVE,
                             .where = "fluids that are not newtonian"),
    [PARAMETERS + RHEOLOGY_CONSISTENCY] =
        OPTION(REAL, "-rheology_consistency", "consistency K", "m^2 s^(n-2)",
               "such that the viscosity at the rate U/L is -viscosity", POSITIVE,
               .where = "-rheology power_law and herschel_bulkley"),
    [PARAMETERS + RHEOLOGY_EXPONENT] =
        OPTION(REAL, "-rheology_exponent", "exponent n; must be given", "-", NULL, .low = 0.05,
               .high = 5.0, .where = "-rheology power_law, carreau, cross and herschel_bulkley"),
    [PARAMETERS + RHEOLOGY_TIME] = OPTION(REAL, "-rheology_time", "time constant lambda", "s",
                                          "L/U", POSITIVE, .where = "-rheology carreau and cross"),
    [PARAMETERS + RHEOLOGY_INFINITE] =
        OPTION(REAL, "-rheology_viscosity_infinite", "kinematic viscosity at infinite rate, nu_inf",
               "m^2/s", "0", NOT_NEGATIVE, .where = "-rheology carreau and cross"),
    [PARAMETERS + RHEOLOGY_YIELD] =
        OPTION(REAL, "-rheology_yield", "yield stress over the density, tau_0; must be given",
               "m^2/s^2", NULL, NOT_NEGATIVE, .where = "rheologies that yield"),
    [PARAMETERS + RHEOLOGY_REGULARISATION] =
        OPTION(REAL, "-rheology_regularisation", "time constant m of the regularisation", "s",
               "n^2 L/U, at least 1000 L/U", POSITIVE, .where = "rheologies that yield"),
};
const OptionTable RheologyOptions = OPTIONS("Rheology", options);

/* Sets the defaults of the parameters. Input: rate - the strain rate U/L [1/s]; n - L/dx. The creep
   of rigid parts, about 0.4 L/m, is then an error of order dx^2 as that of the operators. Flows may
   have a velocity far below U, so that m is not smaller for few particles. */
static void RheologyDefaults(PetscReal rate, PetscInt n, Rheology *r)
{
  r->parameter[RHEOLOGY_TIME]           = 1.0 / rate;
  r->parameter[RHEOLOGY_REGULARISATION] = PetscMax(PetscSqr((PetscReal)n), 1000.0) / rate;
  if (!(r->row->takes & RHEOLOGY_BIT(RHEOLOGY_EXPONENT))) return;
  r->parameter[RHEOLOGY_CONSISTENCY] =
      r->nu * PetscPowReal(rate, 1.0 - r->parameter[RHEOLOGY_EXPONENT]);
}

/* Returns the viscosity for zero rate (end = -1) or infinite rate (1); if it has no limit there,
   the viscosity at 1e-12 or 1e12 times the given rate. */
static PetscReal RheologyLimit(const Rheology *r, PetscReal rate, PetscInt end, PetscBool *limited)
{
  const PetscReal last = r->row->Nu(r, NULL, rate * PetscPowReal(1e100, end)),
                  near = r->row->Nu(r, NULL, rate * PetscPowReal(1e90, end));

  *limited = PetscAbsReal(last - near) <= 1e-3 * last;
  return *limited ? last : r->row->Nu(r, NULL, rate * PetscPowReal(1e12, end));
}

/* Sets default bounds of the viscosity: the limits of the model for zero and infinite rate. Without
   limits the bounds are 1000 nu and nu/1000. A fluid whose viscosity vanishes with the rate has the
   lower bound nu/20: particles of very low viscosity would decouple from their neighbours. In the
   Poiseuille flow of a power law with n = 2, with 51 rows of particles and thus a row at zero rate,
   the error is 1.8 % with nu/100 and 0.3 % with nu/20. */
static void RheologyBound(PetscReal rate, Rheology *r)
{
  PetscBool       slow_limited, fast_limited;
  const PetscReal slow = RheologyLimit(r, rate, -1, &slow_limited);
  const PetscReal fast = RheologyLimit(r, rate, 1, &fast_limited);

  r->low  = PetscMin(slow, fast);
  r->high = PetscMax(slow, fast);
  for (PetscInt k = -12; k <= 12; k++) /* a fluid that yields and thickens is thin between */
    r->low = PetscMin(r->low, r->row->Nu(r, NULL, rate * PetscPowReal(10.0, k)));
  if (r->low < 1e-5 * r->nu && !(slow < fast ? slow_limited : fast_limited))
    r->low = r->nu * (slow < fast ? 0.05 : 1e-3);
  if (r->high > 1e5 * r->nu && !(slow < fast ? fast_limited : slow_limited))
    r->high = PetscMax(PetscMin(slow, fast), 1e3 * r->nu);
}

/* Reads the bounds of the viscosity over their defaults. */
static PetscErrorCode ReadBounds(Rheology *r)
{
  PetscFunctionBegin;
  PetscCall(OptionGetReal(&options[VISCOSITY_MIN], &r->low, NULL));
  PetscCall(OptionGetReal(&options[VISCOSITY_MAX], &r->high, NULL));
  UserCheck(r->low <= r->high,
            "-rheology_viscosity_min %.6g: it is more than -rheology_viscosity_max %.6g",
            (double)r->low, (double)r->high);
  UserCheck(
      r->low > 0.0 && !PetscIsInfOrNanReal(r->high),
      "-rheology %s: the viscosity lies between %.6g and %.6g m^2/s, and must be positive and "
      "finite; change a parameter, or give -rheology_viscosity_min and _max",
      r->row->name, (double)r->low, (double)r->high);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneTypeRheology - Lets the viscosity follow scene->nu_field, an expression that may contain
   time, scalars and the strain rate; nu/1000 and 1000 nu bound it by default. Collective. Does
   nothing if -rheology is not typed, and the expression has neither t nor g. */
PetscErrorCode SceneTypeRheology(Scene *scene)
{
  static const PetscInt last = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(rheologies) - 1;
  Rheology             *r    = &scene->rheology;
  const PetscBool wanted     = ExpressionUses(&scene->nu_field, EXPRESSION_TIME | EXPRESSION_STRAIN)
                                   ? PETSC_TRUE
                                   : PETSC_FALSE;

  PetscFunctionBegin;
  if (wanted && SceneIsNewtonian(scene)) r->row = &rheologies[last];
  if (r->row != &rheologies[last]) PetscFunctionReturn(PETSC_SUCCESS);
  r->typed                    = &scene->nu_field;
  r->nu                       = scene->nu;
  r->low                      = 1e-3 * scene->nu;
  r->high                     = 1e3 * scene->nu;
  r->parameter[RHEOLOGY_TIME] = scene->length / scene->speed;
  PetscCall(ReadBounds(r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SceneReadRheology - Reads the rheology, a viscosity that depends on the strain rate. Collective.
   Called after scene->nu, length and speed are set. */
PetscErrorCode SceneReadRheology(Scene *scene)
{
  Rheology       *r    = &scene->rheology;
  const PetscReal rate = scene->speed / scene->length;
  PetscBool       typed;

  PetscFunctionBegin;
  PetscCall(OptionGetRow(&options[NAME], NULL, &r->row));
  if (!r->row->Nu) PetscFunctionReturn(PETSC_SUCCESS);
  UserCheck(SceneHas(scene, PHYSICS_VISCOSITY),
            "-without viscosity and -rheology %s cannot both be given", r->row->name);
  if (r->row->Nu == RheologyNu_Typed) {
    PetscCall(OptionGiven("-viscosity_field", &typed));
    UserCheck(typed && scene->problem->typed,
              "-rheology typed: -case scene and -viscosity_field are required");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  r->nu = scene->nu;
  for (PetscInt pass = 0; pass < 2; pass++) { /* defaults need the exponent */
    for (PetscInt k = 0; k < RHEOLOGY_PARAMETERS; k++) {
      PetscBool given;

      if (!(r->row->takes & RHEOLOGY_BIT(k))) continue;
      PetscCall(OptionGetReal(&options[PARAMETERS + k], &r->parameter[k], &given));
      UserCheck(given || !(r->row->wants & RHEOLOGY_BIT(k)), "-rheology %s: %s is required [%s]",
                r->row->name, options[PARAMETERS + k].name, options[PARAMETERS + k].unit);
    }
    if (pass == 0) RheologyDefaults(rate, scene->n, r);
  }
  UserCheck(!(r->row->takes & RHEOLOGY_BIT(RHEOLOGY_INFINITE)) ||
                r->parameter[RHEOLOGY_EXPONENT] <= 1.0 || r->parameter[RHEOLOGY_INFINITE] <= r->nu,
            "-rheology_viscosity_infinite %.6g: with -rheology_exponent above 1 it must be at most "
            "the viscosity at zero rate, %.6g, or viscosities become negative",
            (double)r->parameter[RHEOLOGY_INFINITE], (double)r->nu);
  RheologyBound(rate, r);
  PetscCall(ReadBounds(r));
  PetscFunctionReturn(PETSC_SUCCESS);
}
