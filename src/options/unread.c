/*
  Refusal of options that no function has read, so that misspelt options do not become silent
  defaults. The message suggests the nearest known name.
*/
#include "isph/base.h"

/* Names to suggest for a misspelt option: names of isph, then common PETSc names after a prefix. */
static const char *const OwnNames[] = {
    "case",
    "density",
    "body_force",
    "n",
    "dim",
    "reynolds",
    "viscosity",
    "t_end",
    "dt",
    "cfl",
    "max_steps",
    "seed",
    "jitter",
    "particles",
    "scheme",
    "projection",
    "motion",
    "with",
    "without",
    "steady",
    "steady_tol",
    "time_order",
    "kernel",
    "h_over_dx",
    "visc_laplacian",
    "ppe_laplacian",
    "ppe_alpha",
    "ppe_filter",
    "velocity_filter",
    "coupled_schur",
    "coupled_pc_fieldsplit_schur_fact_type",
    "coupled_pc_fieldsplit_schur_precondition",
    "coupled_ts_rtol",
    "gradient",
    "wall",
    "wall_surface",
    "correction",
    "shift",
    "shift_strength",
    "skin",
    "output",
    "output_every",
    "report",
    "report_times",
    "progress",
    "catalogue",
    "patch_field",
    "patch_margin",
    "patch_repeats",
    "patch_spectrum",
    "patch_solve",
    "visc_mat_view",
    "ppe_mat_view",
    "options_file",
    "help",
    "log_view",
    "options_left",
    "length",
    "speed",
    "dt_adapt",
    "dt_move_max",
    "fallback",
    "checkpoint",
    "checkpoint_every",
    "restart",
    "probe_point",
    "probe_line",
    "probe_flux",
    "probe_forces",
    "probe_every",
    "probe_output",
    "solid_fraction",
    "scene_box",
    "scene_periodic",
    "scene_symmetry",
    "scene_wall_top_velocity",
    "scene_body_1",
    "scene_body_1_velocity",
    "scene_body_1_rotation",
    "scene_body_1_around",
    "scene_fluid_1",
    "scene_fluid_1_viscosity",
    "viscosity_field",
    "rheology",
    "rheology_consistency",
    "rheology_exponent",
    "rheology_time",
    "rheology_viscosity_infinite",
    "rheology_yield",
    "rheology_regularisation",
    "rheology_viscosity_min",
    "rheology_viscosity_max",
    "scene_velocity",
    "scene_exact",
};
static const char *const SolverNames[] = {
    "ksp_type",
    "ksp_rtol",
    "ksp_max_it",
    "ksp_monitor",
    "ksp_converged_reason",
    "ksp_view",
    "ksp_gmres_restart",
    "ksp_norm_type",
    "ksp_pc_side",
    "ksp_monitor_true_residual",
    "pc_type",
    "pc_hypre_type",
    "pc_gamg_type",
    "pc_gamg_threshold",
    "pc_factor_levels",
    "pc_hypre_boomeramg_coarsen_type",
    "pc_hypre_boomeramg_interp_type",
    "pc_hypre_boomeramg_strong_threshold",
    "pc_hypre_boomeramg_P_max",
    "pc_hypre_boomeramg_agg_nl",
    "pc_hypre_boomeramg_relax_type_all",
    "sub_pc_type",
    "sub_ksp_type",
    "mg_levels_ksp_type",
    "mg_levels_pc_type",
    "ts_type",
    "ts_theta_theta",
    "ts_bdf_order",
    "ts_arkimex_type",
    "ts_rosw_type",
    "ts_rk_type",
    "ts_ssp_type",
    "ts_monitor",
    "ts_view",
    "ts_adapt_type",
    "snes_type",
    "snes_monitor",
    "snes_rtol",
};

/* Returns the Levenshtein distance of two words of fewer than 128 letters. */
static PetscInt WordDistance(const char a[], const char b[])
{
  PetscInt row[128], m = 0;

  for (; b[m] && m < 127; m++) row[m] = m;
  row[m] = m;
  for (PetscInt i = 0; a[i]; i++) {
    PetscInt diagonal = row[0];

    row[0] = i + 1;
    for (PetscInt j = 1; j <= m; j++) {
      const PetscInt change = diagonal + (a[i] == b[j - 1] ? 0 : 1);

      diagonal = row[j];
      row[j]   = PetscMin(change, PetscMin(row[j], row[j - 1]) + 1);
    }
  }
  return row[m];
}

/* Finds the known option nearest to name (without its dash). */
static PetscErrorCode NearestOption(const char name[], char nearest[], size_t length)
{
  const char *const prefix[] = {"visc_",
                                "ppe_",
                                "coupled_",
                                "coupled_schur_",
                                "coupled_fieldsplit_velocity_",
                                "coupled_fieldsplit_pressure_"};
  PetscInt          best     = 1000;

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(OwnNames); k++) {
    const PetscInt distance = WordDistance(name, OwnNames[k]);

    if (distance < best) PetscCall(PetscStrncpy(nearest, OwnNames[k], length));
    best = PetscMin(best, distance);
  }
  for (size_t q = 0; q < PETSC_STATIC_ARRAY_LENGTH(prefix); q++) {
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(SolverNames); k++) {
      char     word[128];
      PetscInt distance;

      PetscCall(PetscSNPrintf(word, sizeof(word), "%s%s", prefix[q], SolverNames[k]));
      distance = WordDistance(name, word);
      if (distance < best) PetscCall(PetscStrncpy(nearest, word, length));
      best = PetscMin(best, distance);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Determines if PETSc reads an option only later: in the set-up of a preconditioner, or at the
   end. */
static PetscErrorCode OptionIsDeferred(const char name[], PetscBool *deferred)
{
  const char *const inner[] = {"sub_",     "mg_levels",         "mg_coarse", "redundant_",  "_view",
                               "_monitor", "_converged_reason", "esteig",    "fieldsplit_", "ml_"};

  PetscFunctionBegin;
  *deferred = PETSC_FALSE;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(inner); k++) {
    char *found;

    PetscCall(PetscStrstr(name, inner[k], &found));
    if (found) *deferred = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionsRefuseUnknown - Ends the run if a given option has not been read

  Collective. Called when all objects are configured, with deferred_too = PETSC_FALSE, and again
  after the first step has set up the preconditioners, with PETSC_TRUE.

  Errors: the message names the option and the nearest known option
*/
PetscErrorCode OptionsRefuseUnknown(PetscBool deferred_too)
{
  PetscInt n;
  char   **names, **values;
  char     unknown[128] = "";

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n && !unknown[0]; k++) {
    PetscBool deferred, own, check;

    PetscCall(OptionIsDeferred(names[k], &deferred));
    PetscCall(PetscStrcmp(names[k], "options_left", &own));
    PetscCall(PetscStrncmp(names[k], "check_", 6, &check)); /* ReportCheck() checks these */
    if (!own && !check && (deferred_too || !deferred))
      PetscCall(PetscStrncpy(unknown, names[k], sizeof(unknown)));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  if (unknown[0]) {
    char      nearest[128] = "";
    PetscBool known;

    PetscCall(NearestOption(unknown, nearest, sizeof(nearest)));
    PetscCall(PetscStrcmp(unknown, nearest, &known));
    UserCheck(!known,
              "-%s: this run does not use it; its physics is left out, or another type is chosen",
              unknown);
    UserCheck(PETSC_FALSE,
              "-%s: unknown option, or one that the chosen solvers do not read; the nearest known "
              "name is -%s (see -help)",
              unknown, nearest);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
