/*
  The options of PETSc's solvers that are needed most, for -help, the reference page and
  suggestions. PETSc reads them, and any other option of a KSP, PC, TS or SNES too.
*/
#include "isph/solvers.h"

static const char *const Linear[]  = {"visc",
                                      "ppe",
                                      "coupled",
                                      "coupled_schur",
                                      "coupled_fieldsplit_velocity",
                                      "coupled_fieldsplit_pressure",
                                      NULL};
static const char *const Solvers[] = {"visc", "ppe", "coupled", NULL};
static const char *const Times[]   = {"visc", "wcsph", NULL};

/* clang-format off */
#define LINEAR(word)    .name = "-<solve>_" word, .kind = VALUE_SOLVER, .places = Linear
#define VISCOUS(word)   .name = "-visc_" word, .kind = VALUE_SOLVER
#define TIMES(word)     .name = "-<integrator>_" word, .kind = VALUE_SOLVER, .places = Times
#define MONITOR(option, words) .name = option, .kind = VALUE_MONITOR, .places = words
/* clang-format on */

static const OptionRow options[] = {
    {
        LINEAR("ksp_type"),
        .brief = "Krylov method",
        .standard =
            "visc gmres, ppe fgmres, both cg for symmetric forms; coupled fgmres; blocks preonly",
    },
    {
        LINEAR("ksp_rtol"),
        .brief    = "tolerance of the true residual, relative to the right-hand side",
        .unit     = "-",
        .standard = "visc " REGIME "; ppe 1e-5, in patch tests 1e-10; coupled 1e-7, "
                    "1e-10 with a free surface of strain cells, in 3D 1e-8",
    },
    {
        LINEAR("ksp_max_it"),
        .brief    = "largest number of iterations",
        .standard = "visc 1000, ppe 500, coupled 300",
        .low      = 1,
        .high     = 1000000,
    },
    {
        LINEAR("ksp_gmres_restart"),
        .brief    = "iterations between restarts of GMRES",
        .standard = "30; coupled 100",
        .low      = 1,
        .high     = 1000,
    },
    {
        LINEAR("ksp_norm_type"),
        .brief    = "norm of the convergence test",
        .standard = "unpreconditioned",
    },
    {
        LINEAR("ksp_pc_side"),
        .brief = "side of the preconditioner",
    },
    {
        MONITOR("-<solve>_ksp_monitor", Linear),
        .brief = "print the residual of each iteration",
    },
    {
        MONITOR("-<solve>_ksp_monitor_true_residual", Linear),
        .brief = "print the true residual of each iteration",
    },
    {
        LINEAR("ksp_converged_reason"),
        .brief = "print the reason why each solve ended",
    },
    {
        LINEAR("ksp_view"),
        .brief = "print the solver after its first solve",
    },
    {
        LINEAR("ksp_view_mat"),
        .brief = "print the matrix of the first solve, or write it: binary:file",
    },
    {
        LINEAR("ksp_view_pmat"),
        .brief = "print or write the matrix of the preconditioner in the first solve",
    },
    {
        LINEAR("ksp_view_rhs"),
        .brief = "print or write the right-hand side of the first solve",
    },
    {
        LINEAR("ksp_view_solution"),
        .brief = "print or write the solution of the first solve",
    },
    {
        LINEAR("pc_type"),
        .brief = "preconditioner",
        .standard =
            "visc and coupled_fieldsplit_velocity " REGIME "; ppe hypre, tensor, lu or gamg "
            "by its size (theory, section 13); coupled fieldsplit",
    },
    {
        LINEAR("pc_factor_levels"),
        .brief    = "levels of fill of ilu and icc",
        .standard = "0",
    },
    {
        LINEAR("pc_hypre_type"),
        .brief    = "method of hypre",
        .standard = "boomeramg",
    },
    {
        LINEAR("pc_hypre_boomeramg_coarsen_type"),
        .brief    = "coarsening of BoomerAMG",
        .standard = "PMIS",
    },
    {
        LINEAR("pc_hypre_boomeramg_interp_type"),
        .brief    = "interpolation of BoomerAMG",
        .standard = "ext+i",
    },
    {
        LINEAR("pc_hypre_boomeramg_P_max"),
        .brief    = "largest number of entries in a row of the interpolation",
        .standard = "4",
    },
    {
        LINEAR("pc_hypre_boomeramg_max_levels"),
        .brief    = "most levels of BoomerAMG",
        .standard = "25",
        .low      = 2,
        .high     = 100,
    },
    {
        LINEAR("pc_hypre_boomeramg_agg_nl"),
        .brief    = "levels of aggressive coarsening",
        .standard = "ppe and coupled_schur 1, velocities 0",
    },
    {
        LINEAR("pc_hypre_boomeramg_strong_threshold"),
        .brief = "threshold of strong connections",
    },
    {
        LINEAR("pc_hypre_boomeramg_relax_type_all"),
        .brief = "smoother on all levels",
    },
    {
        LINEAR("pc_gamg_type"),
        .brief = "method of PETSc's own AMG",
    },
    {
        LINEAR("pc_gamg_threshold"),
        .brief = "threshold of connections in PETSc's own AMG",
    },
    {
        LINEAR("sub_pc_type"),
        .brief = "preconditioner of the blocks of bjacobi and asm",
    },
    {
        LINEAR("sub_ksp_type"),
        .brief = "Krylov method of the blocks of bjacobi and asm",
    },
    {
        LINEAR("mg_levels_ksp_type"),
        .brief = "smoother on the levels of multigrid",
    },
    {
        LINEAR("mg_levels_pc_type"),
        .brief = "preconditioner of the smoother on the levels of multigrid",
    },
    {
        .name  = "-<solver>_mat_type",
        .kind  = VALUE_SOLVER,
        .brief = "type of the matrices of a solver: aij, or a type of PETSc that derives from it",
        .standard = "-mat_type",
        .places   = Solvers,
    },
    {
        .name     = "-mat_type",
        .kind     = VALUE_SOLVER,
        .brief    = "type of the matrices of all solvers",
        .standard = MATAIJ,
    },
    {
        .name     = "-vec_type",
        .kind     = VALUE_SOLVER,
        .brief    = "type of vectors; vectors that share memory with particle fields stay standard",
        .standard = VECSTANDARD,
    },
    {
        .name   = "-coupled_pc_fieldsplit_schur_fact_type",
        .expert = PETSC_TRUE,
        .kind   = VALUE_SOLVER,
        .brief  = "factors of the block elimination that are applied",
        .where  = "-scheme coupled with -coupled_pc_type fieldsplit",
    },
    {
        .name   = "-coupled_pc_fieldsplit_schur_precondition",
        .expert = PETSC_TRUE,
        .kind   = VALUE_SOLVER,
        .brief  = "matrix that preconditions the Schur complement",
        .where  = "-scheme coupled with -coupled_pc_type fieldsplit",
    },
    {
        TIMES("ts_rtol"),
        .brief = "relative error allowed in a substep, for integrators that take substeps",
        .unit  = "-",
    },
    {
        TIMES("ts_adapt_type"),
        .brief = "control of substeps",
    },
    {
        VISCOUS("ts_theta_theta"),
        .brief    = "theta of the theta method, above 0 to 1",
        .unit     = "-",
        .standard = "0.5",
    },
    {
        VISCOUS("ts_arkimex_type"),
        .brief = "additive Runge-Kutta method",
    },
    {
        VISCOUS("ts_rosw_type"),
        .brief = "Rosenbrock-W method",
    },
    {
        TIMES("ts_rk_type"),
        .brief = "Runge-Kutta method",
    },
    {
        TIMES("ts_ssp_type"),
        .brief = "strong-stability-preserving method",
    },
    {
        TIMES("ts_monitor"),
        .brief = "print each substep",
    },
    {
        TIMES("ts_view"),
        .brief = "print the integrator at the end of the run",
    },
    {
        VISCOUS("snes_type"),
        .brief    = "nonlinear solver",
        .standard = "newtonls where viscosity follows the strain rate",
    },
    {
        VISCOUS("snes_rtol"),
        .brief    = "tolerance of the nonlinear residual",
        .unit     = "-",
        .standard = "visc 1e-6",
    },
    {
        .name  = "-visc_snes_monitor",
        .kind  = VALUE_MONITOR,
        .brief = "print the residual of each nonlinear iteration",
    },
    {
        .name   = "-visc_snes_mf_operator",
        .expert = PETSC_TRUE,
        .kind   = VALUE_SOLVER,
        .brief  = "differences of residuals in place of the derivative of the viscosity",
        .where  = "fluids that are not newtonian",
    },
};
const OptionTable SolverOptions = OPTIONS("Solvers of PETSc", options);
