/*
  Options with ranges, and the refusal of what nobody reads: a misspelt option must not be a silent
  default. PETSc keeps the database; this file adds the sentences.
*/
#include "isph/base.h"
#include <errno.h>
#include <stdlib.h>

/*
  OptionReal - A real number from the command line, checked against [low, high]

  Collective. Between PetscOptionsBegin() and PetscOptionsEnd().

  Input/Output Parameter:
. value - in: the default shown by -help; out: the user's number

  Output Parameter:
. set - whether the user gave it; may be NULL

  Errors: no number, or one outside the range (infinities and NaN included), ends the run
*/
PetscErrorCode OptionReal_Private(PetscOptionItems *PetscOptionsObject, const char option[],
                                  const char text[], PetscReal low, PetscReal high,
                                  PetscReal *value, PetscBool *set)
{
  char      word[128], *end;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(
      PetscOptionsGetString(NULL, PetscOptionsObject->prefix, option, word, sizeof(word), &given));
  if (given) {
    const double number = strtod(word, &end);

    UserCheck(end != word && *end == '\0', "%s %s: a number is wanted", option, word);
    UserCheck(number >= low && number <= high, "%s %s: allowed is %.6g to %.6g", option, word,
              (double)low, (double)high);
  }
  PetscCall(PetscOptionsReal(option, text, "", *value, value, NULL));
  if (set) *set = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionInt - A whole number from the command line, checked as OptionReal() does */
PetscErrorCode OptionInt_Private(PetscOptionItems *PetscOptionsObject, const char option[],
                                 const char text[], PetscInt low, PetscInt high, PetscInt *value,
                                 PetscBool *set)
{
  char      word[128], *end;
  PetscBool given;

  PetscFunctionBegin;
  PetscCall(
      PetscOptionsGetString(NULL, PetscOptionsObject->prefix, option, word, sizeof(word), &given));
  if (given) {
    errno                  = 0;
    const long long number = strtoll(word, &end, 10);

    UserCheck(end != word && *end == '\0' && errno == 0, "%s %s: a whole number is wanted", option,
              word);
    UserCheck(number >= low && number <= high,
              "%s %s: allowed is %" PetscInt_FMT " to %" PetscInt_FMT, option, word, low, high);
  }
  PetscCall(PetscOptionsInt(option, text, "", *value, value, NULL));
  if (set) *set = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionSwitch - true or false, true where nothing is said of it

  Collective. Between PetscOptionsBegin() and PetscOptionsEnd(). Output: value - left alone where the option is not
  given.

  Errors: what is no such word
*/
PetscErrorCode OptionSwitch_Private(PetscOptionItems *PetscOptionsObject, const char option[],
                                    const char text[], PetscBool *value)
{
  const char *const words[]  = {"", "true", "yes", "on", "1", "0", "false", "no", "off", NULL};
  char              word[64] = "";
  PetscBool         given, known = PETSC_FALSE;

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(NULL, NULL, option, word, sizeof(word), &given));
  for (PetscInt k = 0; given && words[k] && !known; k++)
    PetscCall(PetscStrcasecmp(word, words[k], &known));
  UserCheck(!given || known, "%s %s: it is true or false, and by itself true", option, word);
  PetscCall(PetscOptionsBool(option, text, "", *value, value, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionReals - Real numbers separated by commas

  Collective. Between PetscOptionsBegin() and PetscOptionsEnd().

  Input Parameter:
. capacity - how many there may be

  Output Parameters:
+ value - the numbers, left alone where the option is not given
. n     - how many, 0 where it is not given
- set   - whether it is; may be NULL

  Errors: more than capacity, of which PETSc would drop the rest unsaid; numbers that are not finite
*/
PetscErrorCode OptionReals_Private(PetscOptionItems *PetscOptionsObject, const char option[],
                                   const char text[], PetscInt capacity, PetscReal value[],
                                   PetscInt *n, PetscBool *set)
{
  PetscReal *number;
  PetscBool  given;

  PetscFunctionBegin;
  *n = capacity + 1;
  PetscCall(PetscCalloc1(capacity + 1, &number));
  PetscCall(PetscOptionsRealArray(option, text, "", number, n, &given));
  if (!given) *n = 0;
  for (PetscInt k = 0; k < PetscMin(*n, capacity); k++) value[k] = number[k];
  PetscCall(PetscFree(number));
  UserCheck(*n <= capacity, "%s: at most %" PetscInt_FMT " numbers are allowed", option, capacity);
  for (PetscInt k = 0; k < *n; k++)
    UserCheck(!PetscIsInfOrNanReal(value[k]),
              "%s: number %" PetscInt_FMT " is %g, and must be finite", option, k + 1,
              (double)value[k]);
  if (set) *set = given;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionFlags - Names separated by commas, each standing for one bit

  Collective. Input: names[k] is the word for bit k. Output: flags, 0 if the option is not given.
*/
PetscErrorCode OptionFlags_Private(PetscOptionItems *PetscOptionsObject, const char option[],
                                   const char text[], const char *const names[], PetscInt count,
                                   unsigned *flags)
{
  char     *words[16], all[512] = "", help[640];
  PetscInt  n = 16;
  PetscBool given;

  PetscFunctionBegin;
  *flags = 0;
  for (PetscInt k = 0; k < count; k++) {
    if (k) PetscCall(PetscStrlcat(all, ", ", sizeof(all)));
    PetscCall(PetscStrlcat(all, names[k], sizeof(all)));
  }
  PetscCall(PetscSNPrintf(help, sizeof(help), "%s: %s", text, all));
  PetscCall(PetscOptionsStringArray(option, help, "", words, &n, &given));
  UserCheck(!given || n > 0, "%s: names are wanted; choose from %s", option, all);
  for (PetscInt w = 0; w < n; w++) {
    PetscBool same = PETSC_FALSE;

    for (PetscInt k = 0; k < count && !same; k++) {
      PetscCall(PetscStrcmp(words[w], names[k], &same));
      if (same) *flags |= 1u << k;
    }
    UserCheck(same, "%s %s: no such name; choose from %s", option, words[w], all);
    PetscCall(PetscFree(words[w]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionFile - A path from the command line; path stays empty where the option is not given */
PetscErrorCode OptionFile_Private(PetscOptionItems *PetscOptionsObject, const char option[],
                                  const char text[], char path[PETSC_MAX_PATH_LEN])
{
  PetscBool given;

  PetscFunctionBegin;
  path[0] = '\0';
  PetscCall(PetscOptionsString(option, text, "", "", path, PETSC_MAX_PATH_LEN, &given));
  UserCheck(!given || path[0], "%s: a file name is wanted", option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionGiven - Whether the user gave an option */
PetscErrorCode OptionGiven(const char option[], PetscBool *given)
{
  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, NULL, option, given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  OptionsRefuseTogether - Ends the run where two options that contradict each other are both given

  Collective. Input: why - the end of the sentence "-a and -b cannot both be given: why"
*/
PetscErrorCode OptionsRefuseTogether(const char a[], const char b[], const char why[])
{
  PetscBool has_a, has_b;

  PetscFunctionBegin;
  PetscCall(PetscOptionsHasName(NULL, NULL, a, &has_a));
  PetscCall(PetscOptionsHasName(NULL, NULL, b, &has_b));
  UserCheck(!has_a || !has_b, "%s and %s cannot both be given: %s", a, b, why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names to suggest for a misspelt option: ours, then PETSc's commonest behind their prefixes. */
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

/* Levenshtein distance of two words of fewer than 128 letters. */
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

/* The known option nearest to name (without its dash). */
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

/* Whether PETSc reads an option only later: inside a preconditioner's set-up, or at the end. */
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
  OptionsRefuseUnknown - Ends the run where an option was given that nothing has read

  Collective. Called once all objects are configured, with deferred_too = PETSC_FALSE, and again
  when the first step has set up the preconditioners, with PETSC_TRUE.

  Errors: names the option and the known one nearest to it
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
    PetscCall(PetscStrncmp(names[k], "check_", 6, &check)); /* ReportCheck() sees to those */
    if (!own && !check && (deferred_too || !deferred))
      PetscCall(PetscStrncpy(unknown, names[k], sizeof(unknown)));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  if (unknown[0]) {
    char      nearest[128] = "";
    PetscBool known;

    PetscCall(NearestOption(unknown, nearest, sizeof(nearest)));
    PetscCall(PetscStrcmp(unknown, nearest, &known));
    UserCheck(
        !known,
        "-%s: this run does not use it; what it belongs to is left out, or another type is chosen",
        unknown);
    UserCheck(PETSC_FALSE,
              "-%s: unknown option, or one that the chosen solvers do not read; the nearest known "
              "name is -%s (see -help)",
              unknown, nearest);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
