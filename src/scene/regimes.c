/* The defaults that depend on the flow, and the bounds of what a flow allows. For each flow exactly
   one row of a table holds. Bounds were measured; the tables name the pages. Studies of the borders
   between rows: docs/developers/results/regimes.md. */
#include "isph/regime.h"

#define MEASURED "developers/results/regimes.md"

/* Ranges of the number of a table. */
/* clang-format off */
#define ANY         {0.0, 0.0, VALUE_CONSTANT}
#define UPTO(x)     {0.0, x, VALUE_CONSTANT}
#define ABOVE(x)    {x, 0.0, VALUE_CONSTANT}
#define RANGE(a, b) {a, b, VALUE_CONSTANT}
#define RAMP(a, b)  {a, b, VALUE_RAMP}
#define INVERSE(x)  {x, 0.0, VALUE_INVERSE}
/* clang-format on */

static const RegimeRow schemes[] = {
    {0, FACT_SURFACE, ANY, "projection", "a step is cheapest"},
    {FACT_SURFACE, 0, ANY, "coupled", "the surface is a part of its system"},
};

#define NO_SPLINES       (FACT_ASKED | FACT_SURFACE | FACT_NARROW)
#define OPEN_TO_BOTH     (NO_SPLINES | FACT_MOVES | FACT_WALLS)
#define CONVECTING_CLOUD (FACT_WALLS | FACT_CLOUD | FACT_CONVECTION)

static const RegimeRow points[] = {
    {FACT_SURFACE, 0, ANY, "coarse", "the pressure ends with the cells at the surface"},
    {FACT_ASKED, FACT_SURFACE, ANY, "same", "the option is for a pressure on particles"},
    {FACT_NARROW, FACT_ASKED | FACT_SURFACE, ANY, "same",
     "the splines need three cells along each axis"},
    {FACT_MOVES, NO_SPLINES, ANY, "coarse",
     "no noise from moving particles, and no condition at walls"},
    {FACT_WALLS, NO_SPLINES | FACT_MOVES | FACT_STEADY | FACT_CLOUD, ANY, "coarse",
     "there is no condition at walls"},
    {FACT_WALLS | FACT_CLOUD, NO_SPLINES | FACT_MOVES | FACT_STEADY | FACT_CONVECTION, ANY,
     "coarse", "there is no condition at walls"},
    {CONVECTING_CLOUD | FACT_QUARTIC, NO_SPLINES | FACT_MOVES | FACT_STEADY, ANY, "coarse",
     "quartic fits damp grid modes"},
    {CONVECTING_CLOUD, NO_SPLINES | FACT_MOVES | FACT_STEADY | FACT_QUARTIC, UPTO(5.0), "coarse",
     "there is no condition at walls"},
    {CONVECTING_CLOUD, NO_SPLINES | FACT_MOVES | FACT_STEADY | FACT_QUARTIC, ABOVE(5.0), "same",
     "coarse points are too coarse for the particles at walls"},
    {FACT_WALLS | FACT_STEADY, NO_SPLINES | FACT_MOVES | FACT_CONVECTION, ANY, "coarse",
     "there is no condition at walls"},
    {FACT_WALLS | FACT_STEADY | FACT_CONVECTION | FACT_QUARTIC, NO_SPLINES | FACT_MOVES, ANY,
     "coarse", "quartic fits damp grid modes"},
    {FACT_WALLS | FACT_STEADY | FACT_CONVECTION, NO_SPLINES | FACT_MOVES | FACT_QUARTIC, UPTO(5.0),
     "coarse", "viscosity damps what coarse points cannot see"},
    {FACT_WALLS | FACT_STEADY | FACT_CONVECTION, NO_SPLINES | FACT_MOVES | FACT_QUARTIC, ABOVE(5.0),
     "same", "no filter damps what coarse points cannot see"},
    {0, OPEN_TO_BOTH | FACT_QUARTIC | FACT_CONVECTION, ANY, "coarse", "nothing feeds grid modes"},
    {FACT_QUARTIC, OPEN_TO_BOTH, ANY, "same", "without walls there is no condition to avoid"},
    {FACT_CONVECTION, OPEN_TO_BOTH | FACT_QUARTIC, UPTO(5.0), "coarse",
     "pressures of vortices have a third of the error"},
    {FACT_CONVECTION, OPEN_TO_BOTH | FACT_QUARTIC, ABOVE(5.0), "same",
     "velocities of vortices have a third of the error"},
};

#define HIGHER (FACT_CUBIC | FACT_QUARTIC)

static const RegimeRow kernels[] = {
    {FACT_CUBIC, FACT_QUARTIC, ANY, "1.6", "fits need more neighbours"},
    {FACT_QUARTIC, 0, ANY, "2", "fits need more neighbours"},
    {FACT_SURFACE, HIGHER, ANY, "1.5",
     "on disordered particles grid modes grow beside the surface with less"},
    {0, HIGHER | FACT_SURFACE, ABOVE(5.0), "1.3", "viscosity does not smooth the grid scale"},
    {FACT_WALLS | FACT_MOVES, HIGHER | FACT_SURFACE, UPTO(5.0), "1.5",
     "changes of neighbours beside walls dominate the error, and 1.5 halves it"},
    {FACT_WALLS, HIGHER | FACT_SURFACE | FACT_MOVES, UPTO(5.0), "1.3", "neighbours stay the same"},
    {FACT_PRESSURE | FACT_EXACT, HIGHER | FACT_SURFACE | FACT_WALLS, UPTO(5.0), "1.1",
     "Taylor-Green vortices have a third of the error with 1.3"},
    {FACT_PRESSURE, HIGHER | FACT_SURFACE | FACT_WALLS | FACT_EXACT, UPTO(5.0), "1.3",
     "other forms have larger errors with fewer neighbours"},
    {0, HIGHER | FACT_SURFACE | FACT_WALLS | FACT_PRESSURE, UPTO(5.0), "1.3", "as for most flows"},
};

#define NO_FILTER (FACT_STEADY | FACT_WCSPH)

static const RegimeRow filters_u[] = {
    {FACT_WCSPH, 0, ANY, "0", "the scheme has no filter"},
    {FACT_STEADY, FACT_WCSPH, ANY, "0", "without du/dt there is no step to filter in"},
    {FACT_MOVES | FACT_COARSE, NO_FILTER, ANY, "4",
     "coarse points do not act on velocities between them"},
    {0, FACT_MOVES | NO_FILTER, UPTO(5.0), "0",
     "viscosity damps grid modes: fixed particles were stable at 6"},
    {FACT_COARSE, FACT_MOVES | NO_FILTER, ABOVE(5.0), "4",
     "coarse points do not act on velocities between them"},
    {0, FACT_MOVES | FACT_COARSE | NO_FILTER, ABOVE(5.0), "1", "grid modes grew at 7"},
    {FACT_MOVES, FACT_COARSE | NO_FILTER, UPTO(20.0), "0",
     "moving particles were stable at 20, and filters damp boundary layers"},
    {FACT_MOVES, FACT_COARSE | NO_FILTER, RAMP(20.0, 60.0), "1",
     "they were unstable at 25, and needed 0.2 at 40"},
    {FACT_MOVES, FACT_COARSE | NO_FILTER, ABOVE(60.0), "1", "they needed 1 at 200"},
};

static const RegimeRow filters_p[] = {
    {0, FACT_ORDERED, ANY, "1", "disordered particles have growing modes"},
    {FACT_ORDERED, FACT_IMPLICIT, ANY, "0.1",
     "the filter leaves a divergence: with 1 beside a cylinder 16 % energy too much"},
    {FACT_ORDERED | FACT_IMPLICIT, 0, UPTO(0.5), "0.1",
     "the same, in steps of explicit convection"},
    {FACT_ORDERED | FACT_IMPLICIT, 0, INVERSE(0.5), "0.1",
     "the divergence is in proportion to the step"},
};

static const RegimeRow shears[] = {
    {0, FACT_STRONG, ANY, "0", "a pressure on particles acts on short waves"},
    {FACT_STRONG | FACT_GRADED, 0, ANY, "0", "it takes energy from layers of graded particles"},
    {FACT_STRONG, FACT_GRADED, UPTO(5.0), "0", "viscosity damps disturbances across a shear"},
    {FACT_STRONG, FACT_GRADED, ABOVE(5.0), "1", "waves of 4 dx grow in channels without it"},
};

static const RegimeRow laplacians[] = {
    {FACT_WCSPH | FACT_SURFACE, 0, ANY, "cleary", "it keeps angular momentum"},
    {FACT_WCSPH, FACT_SURFACE, ANY, "morris", "it keeps momentum"},
    {FACT_SURFACE, FACT_WCSPH, ANY, "weak_stress", "its cells end at the surface"},
    {0, FACT_WCSPH | FACT_SURFACE | FACT_VARIES, ANY, "mls", "it is the most accurate"},
    {FACT_VARIES, FACT_WCSPH | FACT_SURFACE | FACT_CURVED, ANY, "mls",
     "parallel flows have no other part of the stress"},
    {FACT_VARIES | FACT_CURVED, FACT_WCSPH | FACT_SURFACE | FACT_GRADED | FACT_FLUIDS, ANY,
     "weak_stress", "its dissipation is right where streamlines curve and fluids yield"},
    {FACT_VARIES | FACT_CURVED | FACT_FLUIDS, FACT_WCSPH | FACT_SURFACE | FACT_GRADED | FACT_MOVES,
     ANY, "weak_stress", "its cells and the pressure are cut where viscosities jump"},
    {FACT_VARIES | FACT_CURVED | FACT_FLUIDS | FACT_MOVES,
     FACT_WCSPH | FACT_SURFACE | FACT_GRADED | FACT_MIXES, ANY, "stress_mls",
     "the place of an interface that moves is too uncertain for cuts"},
    {FACT_VARIES | FACT_CURVED | FACT_FLUIDS | FACT_MOVES | FACT_MIXES,
     FACT_WCSPH | FACT_SURFACE | FACT_GRADED, ANY, "weak_stress",
     "the pressure is not cut, and walls may be planes of symmetry"},
    {FACT_VARIES | FACT_CURVED | FACT_GRADED, FACT_WCSPH | FACT_SURFACE, ANY, "stress_mls",
     "without the whole stress fluids that rotate side by side err by tens of per cent"},
};

static const RegimeRow corrections[] = {
    {0, FACT_WCSPH, ANY, "none", "fits need none"},
    {FACT_WCSPH, FACT_SHIFTS, ANY, "none", "pair forces keep momentum"},
    {FACT_WCSPH | FACT_SHIFTS, 0, ANY, "first_order",
     "Taylor-Green vortices err by 0.2 %, without it by 6 %"},
};

static const RegimeRow walls[] = {
    {0, FACT_BLIND, ANY, "wall_layer", "fits have the walls as equations"},
    {FACT_BLIND, 0, ANY, "dummy_linear", "a chosen form needs a full support"},
};

static const RegimeRow shifts[] = {
    {0, FACT_WCSPH, ANY, "fickian", "it keeps particles evenly spread"},
    {FACT_WCSPH | FACT_SURFACE, 0, ANY, "none", "it would move the surface"},
    {FACT_WCSPH | FACT_SUMS, FACT_SURFACE, ANY, "none",
     "it would change the density: a cavity errs by 19 % with it, by 2 % without"},
    {FACT_WCSPH, FACT_SURFACE | FACT_SUMS, ANY, "fickian", "without it the flow is lost in noise"},
};

static const RegimeRow strengths[] = {
    {0, FACT_WCSPH, ANY, "1", "as measured with the projection"},
    {FACT_WCSPH, 0, ANY, "3", "Taylor-Green vortices err by 0.2 %, with 1 by 0.6 %"},
};

static const RegimeRow controls[] = {
    {FACT_STEP_GIVEN, 0, ANY, "none", "the step is given"},
    {FACT_DRIVEN, FACT_STEP_GIVEN, ANY, "error",
     "the present speed says nothing about the driving"},
    {0, FACT_STEP_GIVEN | FACT_DRIVEN, ANY, "cfl", "it is cheapest"},
};

static const RegimeRow courants[] = {
    {0, FACT_IMPLICIT, ANY, "0.5", "explicit convection and motion are stable"},
    {FACT_IMPLICIT, 0, ANY, "2", "the error of the step is still small"},
};

static const RegimeRow viscous_pcs[] = {
    {0, 0, UPTO(2.0), "jacobi", "few iterations, and no set-up"},
    {0, 0, RANGE(2.0, 200.0), "bjacobi", "block Jacobi with ILU(0) is enough"},
    {0, 0, ABOVE(200.0), "hypre", "iterations that do not grow with the step"},
};

static const RegimeRow viscous_rtols[] = {
    {FACT_NONLINEAR, 0, ANY, "1e-3", "the nonlinear solver has its own tolerance"},
    {FACT_IMPLICIT, FACT_NONLINEAR, UPTO(2.0), "1e-5",
     "it leaves six digits of extrema and energies"},
    {FACT_IMPLICIT, FACT_NONLINEAR, ABOVE(2.0), "1e-7", "residuals are relative to large steps"},
    {0, FACT_NONLINEAR | FACT_IMPLICIT, ANY, "1e-7",
     "explicit convection needs few iterations to it"},
};

static const RegimeRow block_pcs[] = {
    {FACT_SURFACE, 0, UPTO(0.2), "jacobi", "few iterations, and no set-up"},
    {FACT_SURFACE, 0, RANGE(0.2, 30.0), "factors",
     "iterations of Jacobi grow with the number of particles"},
    {FACT_SURFACE, 0, ABOVE(30.0), "two_level", "iterations that do not grow with the step"},
    {0, FACT_SURFACE, UPTO(2.0), "factors", "few iterations"},
    {0, FACT_SURFACE, ABOVE(2.0), "two_level", "iterations that do not grow with the step"},
};

static const RegimeRow chorin_holds[] = {
    {FACT_MOVES, 0, ANY, "allowed", "moving particles gain no energy"},
    {0, FACT_MOVES | FACT_WALLS, ANY, "allowed", "the gain is at walls"},
    {FACT_WALLS, FACT_MOVES | FACT_CONVECTION, ANY, "allowed", "the gain is by convection"},
    {FACT_WALLS | FACT_CONVECTION, FACT_MOVES, UPTO(10.0), "allowed",
     "a cavity gains 20 % energy at 10"},
    {FACT_WALLS | FACT_CONVECTION, FACT_MOVES, ABOVE(10.0), NULL,
     "a cavity gains 43 % energy at 12, and has eight times as much at 312"},
};

static const RegimeRow step_holds[] = {
    {0, FACT_MOVES, ANY, "inf", "the grid does not tangle"},
    {FACT_MOVES, 0, UPTO(20.0), "inf", "viscosity smooths the grid scale"},
    {FACT_MOVES, 0, ABOVE(20.0), "0.5", "cavities ended early at CFL numbers of 1 and more"},
};

#define ROWS(table) table, (PetscInt)(sizeof(table) / sizeof((table)[0]))
#define FILTERS     "developers/theory/filters.md#7-filters"
#define SOLVERS     "developers/theory/solvers.md#13-linear-solvers"
#define STABILITY   "developers/results/stability.md"

const RegimeTable RegimeTables[REGIMES] = {
    [REGIME_SCHEME]     = {"-scheme", NUMBER_NONE, MEASURED, PETSC_FALSE, ROWS(schemes)},
    [REGIME_POINTS]     = {"-pressure_points", NUMBER_CELL, MEASURED, PETSC_TRUE, ROWS(points)},
    [REGIME_KERNEL]     = {"-h_over_dx", NUMBER_CELL, MEASURED, PETSC_TRUE, ROWS(kernels)},
    [REGIME_FILTER_U]   = {"-velocity_filter", NUMBER_CELL, FILTERS, PETSC_TRUE, ROWS(filters_u)},
    [REGIME_FILTER_P]   = {"-ppe_filter", NUMBER_COURANT, MEASURED, PETSC_TRUE, ROWS(filters_p)},
    [REGIME_SHEAR]      = {"-velocity_filter across a shear", NUMBER_CELL, FILTERS, PETSC_FALSE,
                           ROWS(shears)},
    [REGIME_LAPLACIAN]  = {"-visc_laplacian", NUMBER_NONE, "developers/results/fluids.md",
                           PETSC_FALSE, ROWS(laplacians)},
    [REGIME_CORRECTION] = {"-correction", NUMBER_NONE, MEASURED, PETSC_FALSE, ROWS(corrections)},
    [REGIME_WALL] = {"-wall", NUMBER_NONE, "developers/results/walls.md", PETSC_FALSE, ROWS(walls)},
    [REGIME_SHIFT]          = {"-shift", NUMBER_NONE, MEASURED, PETSC_FALSE, ROWS(shifts)},
    [REGIME_SHIFT_STRENGTH] = {"-shift_strength", NUMBER_NONE, MEASURED, PETSC_FALSE,
                               ROWS(strengths)},
    [REGIME_DT_ADAPT]       = {"-dt_adapt", NUMBER_NONE, "howto/time-steps.md", PETSC_FALSE,
                               ROWS(controls)},
    [REGIME_COURANT] = {"-cfl", NUMBER_NONE, "developers/theory/motion.md#12-fixed-particles",
                        PETSC_FALSE, ROWS(courants)},
    [REGIME_VISC_PC] = {"-visc_pc_type", NUMBER_STIFFNESS, SOLVERS, PETSC_FALSE, ROWS(viscous_pcs)},
    [REGIME_VISC_RTOL]    = {"-visc_ksp_rtol", NUMBER_STIFFNESS, SOLVERS, PETSC_FALSE,
                             ROWS(viscous_rtols)},
    [REGIME_BLOCK_PC]     = {"-coupled_fieldsplit_velocity_pc_type", NUMBER_STIFFNESS, MEASURED,
                             PETSC_FALSE, ROWS(block_pcs)},
    [REGIME_CHORIN_HOLDS] = {"-projection chorin", NUMBER_CELL, MEASURED, PETSC_FALSE,
                             ROWS(chorin_holds)},
    [REGIME_STEP_HOLDS]   = {"largest CFL number without a warning", NUMBER_CELL, STABILITY,
                             PETSC_FALSE, ROWS(step_holds)},
};
