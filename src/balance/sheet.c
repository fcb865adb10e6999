/* The balance sheet: what a flow conserves, and by how much a run violates it, relative to a scale
   of the flow. Some rows are measured in every step, others at the times of the report; see
   theory.md, (forces:flight), (forces:mass) and (forces:balance). A row that leaves its bound gives
   a line at the end of the run. */
#include "isph/balance.h"

const BalanceRow BalanceRows[BALANCES] = {
    [BALANCE_VOLUME] =
        {
            .name  = "fluid_volume",
            .brief = "volume inside the free surface, against that of the particles",
            .what  = "volume not kept: the free surface encloses another volume than the particles",
            .remedy = "single particles and small drops have too little of it; try a larger -n",
            .bound  = 0.02,
        },
    [BALANCE_MASS] =
        {
            .name   = "mass_balance",
            .brief  = "flux into the fluid through all boundaries, over the flux through openings; "
                      "moving particles: change of their volume, over that at the start",
            .what   = "mass not kept: more or less fluid enters than leaves",
            .remedy = "try a larger -n",
            .bound  = 0.01,
        },
    [BALANCE_MOMENTUM] =
        {.name   = "momentum_balance",
         .brief  = "momentum of fluid that touches nothing, less the impulse of the body force",
         .what   = "momentum not kept: fluid that touches nothing is accelerated",
         .remedy = "try a larger -n or a smaller -dt",
         .bound  = 0.05},
    [BALANCE_ANGULAR] =
        {.name   = "angular_balance",
         .brief  = "angular momentum of fluid that touches nothing, less that of the body force",
         .what   = "rotation not kept: fluid that touches nothing begins or ends to rotate",
         .remedy = "try a larger -n or a smaller -dt",
         .bound  = 0.05},
    [BALANCE_ENERGY] =
        {.name   = "energy_gain",
         .brief  = "energy beyond that of start, forces and surface, over the largest given",
         .what   = "energy not kept: the fluid had and dissipated more energy than start and "
                   "forces gave",
         .remedy = "try a larger -n or a smaller -dt",
         .bound  = 0.1},
    [BALANCE_FORCE] =
        {.name   = "force_balance",
         .brief  = "sum of forces on boundaries, body force and inertia, over their magnitudes",
         .what   = "momentum not kept: forces on boundaries do not balance",
         .remedy = "try a larger -n",
         .bound  = 0.1},
    [BALANCE_TORQUE] = {.name = "torque_balance",
                        .brief =
                            "sum of torques on boundaries, of body force and inertia, over their "
                            "magnitudes",
                        .what   = "rotation not kept: torques on boundaries do not balance",
                        .remedy = "try a larger -n",
                        .bound  = 0.05},
    [BALANCE_SOLID] =
        {.name   = "fluid_in_solids",
         .brief  = "particles of the fluid in solids beside bodies that move, the most in a "
                   "step, over all",
         .what   = "fluid not kept out of solids: surfaces that approach each other enclose "
                   "particles",
         .remedy = "leave a gap of 2 dx, or try a larger -n",
         .bound  = 1e-9},
    [BALANCE_SCALAR] =
        {.name   = "scalar_balance",
         .brief  = "what scalars have gained, less what entered and sources made, over their "
                   "range or amount",
         .what   = "a scalar not kept: the fluid gains more or less of it than enters",
         .remedy = "try a smaller -scalar_1_ksp_rtol",
         .bound  = 1e-3},
    [BALANCE_BOUNDS] =
        {.name   = "scalar_bounds",
         .brief  = "values of scalars beyond those of start and boundaries, the most in a step, "
                   "over the range of these",
         .what   = "a scalar not within bounds: it has values that neither start nor boundaries "
                   "have",
         .remedy = "try a larger -n",
         .bound  = 0.05},
};

/* BalanceSet - Sets a row of the sheet, which applies from now on. Input: residual - of any sign,
   relative to its scale; value - the part of it that its own error does not explain, positive or
   zero [-]; t - its time [s]. */
void BalanceSet(BalanceKind kind, PetscReal residual, PetscReal value, PetscReal t,
                BalanceSheet *sheet)
{
  sheet->applies[kind]  = 1;
  sheet->residual[kind] = PetscAbsReal(residual);
  sheet->value[kind]    = value;
  sheet->t[kind]        = t;
}

/* BalanceWorst - Finds the row of the balance sheet with the largest value over its bound. The same
   on all ranks. Rows of steps are known after each step, rows of boundaries after the measurement
   of a report. Output: name - of the row in the report; value - violation of the balance, relative
   to its scale [-]; bound - its largest value that is not reported as a fault [-]. Returns: false,
   and no output, if no row applies. */
PetscBool BalanceWorst(const Flow *flow, const char **name, PetscReal *value, PetscReal *bound)
{
  const BalanceSheet *sheet = &flow->scheme->sheet;
  PetscReal           worst = -1.0;

  for (PetscInt k = 0; k < BALANCES; k++) {
    const PetscReal ratio = sheet->value[k] / BalanceRows[k].bound;

    if (!sheet->applies[k] || !(ratio > worst)) continue;
    worst  = ratio;
    *name  = BalanceRows[k].name;
    *value = sheet->value[k];
    *bound = BalanceRows[k].bound;
  }
  return worst >= 0.0;
}
