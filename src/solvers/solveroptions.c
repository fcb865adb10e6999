/* The options of PETSc's solvers that are needed most, for -help, the reference page and
   suggestions. PETSc reads them, and any other option of a KSP, PC, TS or SNES too. */
#include "isph/solvers.h"

static const char *const Linear[] = {"visc",
                                     "ppe",
                                     "coupled",
                                     "coupled_schur",
                                     "coupled_fieldsplit_velocity",
                                     "coupled_fieldsplit_pressure",
                                     NULL};
static const char *const Times[]  = {"visc", "wcsph", NULL};

/* Rows that PETSc reads: name, words of its place, brief, and other members. */
#define ROW(option, value, word, ...)                                                              \
  {                                                                                                \
    .name = option, .kind = value, .places = word, .brief = __VA_ARGS__                            \
  }
#define SOLVER(option, ...)  ROW(option, VALUE_SOLVER, __VA_ARGS__)
#define MONITOR(option, ...) ROW(option, VALUE_MONITOR, __VA_ARGS__)

static const OptionRow options[] = {
    SOLVER(
        "-<solve>_ksp_type", Linear, "Krylov method",
        .standard =
            "visc gmres, ppe fgmres, both cg for symmetric forms; coupled fgmres; blocks preonly"),
    SOLVER("-<solve>_ksp_rtol", Linear,
           "tolerance of the true residual, relative to the right-hand side", .unit = "-",
           .standard = "visc " REGIME "; ppe 1e-5, in patch tests 1e-10; coupled 1e-7, 1e-10 with "
                       "a free surface of strain cells, in 3D 1e-8"),
    SOLVER("-<solve>_ksp_max_it", Linear, "largest number of iterations",
           .standard = "visc 1000, ppe 500, coupled 300", .low = 1, .high = 1000000),
    SOLVER("-<solve>_ksp_gmres_restart", Linear, "iterations between restarts of GMRES",
           .standard = "30; coupled 100", .low = 1, .high = 1000),
    SOLVER("-<solve>_ksp_norm_type", Linear, "norm of the convergence test",
           .standard = "unpreconditioned"),
    SOLVER("-<solve>_ksp_pc_side", Linear, "side of the preconditioner"),
    MONITOR("-<solve>_ksp_monitor", Linear, "print the residual of each iteration"),
    MONITOR("-<solve>_ksp_monitor_true_residual", Linear,
            "print the true residual of each iteration"),
    SOLVER("-<solve>_ksp_converged_reason", Linear, "print the reason why each solve ended"),
    SOLVER("-<solve>_ksp_view", Linear, "print the solver after its first solve"),
    SOLVER("-<solve>_ksp_view_mat", Linear,
           "print the matrix of the first solve, or write it: binary:file"),
    SOLVER("-<solve>_ksp_view_pmat", Linear,
           "print or write the matrix of the preconditioner in the first solve"),
    SOLVER("-<solve>_ksp_view_rhs", Linear,
           "print or write the right-hand side of the first solve"),
    SOLVER("-<solve>_ksp_view_solution", Linear, "print or write the solution of the first solve"),
    SOLVER(
        "-<solve>_pc_type", Linear, "preconditioner",
        .standard =
            "visc and coupled_fieldsplit_velocity " REGIME
            "; ppe hypre, tensor, lu or gamg by its size (theory, section 13); coupled fieldsplit"),
    SOLVER("-<solve>_pc_factor_levels", Linear, "levels of fill of ilu and icc", .standard = "0"),
    SOLVER("-<solve>_pc_hypre_type", Linear, "method of hypre", .standard = "boomeramg"),
    SOLVER("-<solve>_pc_hypre_boomeramg_coarsen_type", Linear, "coarsening of BoomerAMG",
           .standard = "PMIS"),
    SOLVER("-<solve>_pc_hypre_boomeramg_interp_type", Linear, "interpolation of BoomerAMG",
           .standard = "ext+i"),
    SOLVER("-<solve>_pc_hypre_boomeramg_P_max", Linear,
           "largest number of entries in a row of the interpolation", .standard = "4"),
    SOLVER("-<solve>_pc_hypre_boomeramg_max_levels", Linear, "most levels of BoomerAMG",
           .standard = "25", .low = 2, .high = 100),
    SOLVER("-<solve>_pc_hypre_boomeramg_agg_nl", Linear, "levels of aggressive coarsening",
           .standard = "ppe and coupled_schur 1, velocities 0"),
    SOLVER("-<solve>_pc_hypre_boomeramg_strong_threshold", Linear,
           "threshold of strong connections"),
    SOLVER("-<solve>_pc_hypre_boomeramg_relax_type_all", Linear, "smoother on all levels"),
    SOLVER("-<solve>_pc_gamg_type", Linear, "method of PETSc's own AMG"),
    SOLVER("-<solve>_pc_gamg_threshold", Linear, "threshold of connections in PETSc's own AMG"),
    SOLVER("-<solve>_sub_pc_type", Linear, "preconditioner of the blocks of bjacobi and asm"),
    SOLVER("-<solve>_sub_ksp_type", Linear, "Krylov method of the blocks of bjacobi and asm"),
    SOLVER("-<solve>_mg_levels_ksp_type", Linear, "smoother on the levels of multigrid"),
    SOLVER("-<solve>_mg_levels_pc_type", Linear,
           "preconditioner of the smoother on the levels of multigrid"),
    SOLVER("-coupled_pc_fieldsplit_schur_fact_type", NULL,
           "factors of the block elimination that are applied", .expert = PETSC_TRUE,
           .where = "-scheme coupled with -coupled_pc_type fieldsplit"),
    SOLVER("-coupled_pc_fieldsplit_schur_precondition", NULL,
           "matrix that preconditions the Schur complement", .expert = PETSC_TRUE,
           .where = "-scheme coupled with -coupled_pc_type fieldsplit"),
    SOLVER("-<integrator>_ts_rtol", Times,
           "relative error allowed in a substep, for integrators that take substeps", .unit = "-"),
    SOLVER("-<integrator>_ts_adapt_type", Times, "control of substeps"),
    SOLVER("-visc_ts_theta_theta", NULL, "theta of the theta method, above 0 to 1", .unit = "-",
           .standard = "0.5"),
    SOLVER("-visc_ts_arkimex_type", NULL, "additive Runge-Kutta method"),
    SOLVER("-visc_ts_rosw_type", NULL, "Rosenbrock-W method"),
    SOLVER("-<integrator>_ts_rk_type", Times, "Runge-Kutta method"),
    SOLVER("-<integrator>_ts_ssp_type", Times, "strong-stability-preserving method"),
    SOLVER("-<integrator>_ts_monitor", Times, "print each substep"),
    SOLVER("-<integrator>_ts_view", Times, "print the integrator at the end of the run"),
    SOLVER("-visc_snes_type", NULL, "nonlinear solver",
           .standard = "newtonls where viscosity follows the strain rate"),
    SOLVER("-visc_snes_rtol", NULL, "tolerance of the nonlinear residual", .unit = "-",
           .standard = "visc 1e-6"),
    MONITOR("-visc_snes_monitor", NULL, "print the residual of each nonlinear iteration"),
    SOLVER("-visc_snes_mf_operator", NULL,
           "differences of residuals in place of the derivative of the viscosity",
           .expert = PETSC_TRUE, .where = "fluids that are not newtonian"),
};
const OptionTable SolverOptions = OPTIONS("Solvers of PETSc", options);
