/* Refuses options that nothing has read: a misspelt option must not be a silent default. */
#include "isph/options.h"
#include <string.h>

/* Returns true if PETSc reads an option only later: in the set-up of a preconditioner, or at the
   end of the run. */
static PetscBool IsDeferred(const char name[])
{
  const char *const inner[] = {"sub_",     "mg_levels",         "mg_coarse", "redundant_",  "_view",
                               "_monitor", "_converged_reason", "esteig",    "fieldsplit_", "ml_"};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(inner); k++) {
    if (strstr(name, inner[k])) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Returns true if an option that nothing has read may still be read: later by this program or, if
   deferred_too is false, later by PETSc. */
static PetscBool IsReadLater(const char name[], PetscBool deferred_too)
{
  const OptionRow *row = OptionFind(name);

  if (row && row->late) return PETSC_TRUE;
  return !deferred_too && IsDeferred(name);
}

/* Ends the run with a message on an option that nothing has read. */
static PetscErrorCode Refuse(const char name[])
{
  const char *const families[] = {"-ksp_", "-pc_", "-ts_", "-snes_", "-sub_", "-mg_"};
  const OptionRow  *row        = OptionFind(name);
  char              nearest[OPTION_LENGTH];
  const char       *solver = "";

  PetscFunctionBegin;
  UserCheck(!row || !row->where, "%s: this run does not use it; it belongs to %s%s%s", name,
            row->where, row->instead ? "; " : "", row->instead ? row->instead : "");
  UserCheck(!row,
            "%s: this run does not use it; its physics is left out, or another type is chosen",
            name);
  for (size_t k = 0; SolverPrefixes[k]; k++) {
    if (!strncmp(name, SolverPrefixes[k], strlen(SolverPrefixes[k])))
      solver = ", or one that the chosen solvers do not read";
  }
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(families); k++) {
    UserCheck(strncmp(name, families[k], strlen(families[k])),
              "%s: unknown option; options of solvers begin with the name of the solve: -visc_%s, "
              "-ppe_%s or -coupled_%s",
              name, name + 1, name + 1, name + 1);
  }
  UserCheck(!OptionNearest(name, nearest),
            "%s: unknown option%s; the nearest known name is %s (see -help)", name, solver,
            nearest);
  UserCheck(PETSC_FALSE, "%s: unknown option%s; -help%s lists what there is", name, solver,
            *solver ? " petsc" : "");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* OptionsRefuseUnknown - Ends the run if an option was given that nothing has read. Collective on
   PETSC_COMM_WORLD. Input: deferred_too - true: refuses also unread options of IsDeferred(), which
   PETSc reads only later. */
PetscErrorCode OptionsRefuseUnknown(PetscBool deferred_too)
{
  PetscInt n;
  char   **names, **values, unknown[OPTION_LENGTH] = "";

  PetscFunctionBegin;
  PetscCall(PetscOptionsLeftGet(NULL, &n, &names, &values));
  for (PetscInt k = 0; k < n && !unknown[0]; k++) {
    char name[OPTION_LENGTH];

    PetscCall(PetscSNPrintf(name, sizeof(name), "-%s", names[k])); /* PETSc leaves out the dash */
    if (!IsReadLater(name, deferred_too)) PetscCall(PetscStrncpy(unknown, name, sizeof(unknown)));
  }
  PetscCall(PetscOptionsLeftRestore(NULL, &n, &names, &values));
  if (unknown[0]) PetscCall(Refuse(unknown));
  PetscFunctionReturn(PETSC_SUCCESS);
}
