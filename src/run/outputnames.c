/* Names of the files that a run writes: two options must not lead to the same file. */
#include "impl.h"
#include <fnmatch.h>
#include <libgen.h>
#include <stdlib.h>
#include <string.h>

/* Names of files of an option: its value, for -output without .h5, and an ending. */
typedef struct {
  const char *option;
  const char *ending; /* pattern of fnmatch() */
} OutputName;

static const OutputName names[] = {
    {"-checkpoint", ""},  {"-checkpoint", ".part"},
    {"-report", ""},      {"-output", "_[0-9][0-9][0-9][0-9]*.h5"},
    {"-output", ".xdmf"}, {"-probe_output", "_*.csv"},
};

/* Writes the path of an existing folder and a name in its shortest form, without links. */
static void Canonical(const char typed[], char path[2 * PETSC_MAX_PATH_LEN])
{
  char folder[PETSC_MAX_PATH_LEN], name[PETSC_MAX_PATH_LEN], found[PETSC_MAX_PATH_LEN + 1];

  (void)snprintf(folder, sizeof(folder), "%s", typed);
  (void)snprintf(name, sizeof(name), "%s", typed);
  (void)snprintf(path, 2 * PETSC_MAX_PATH_LEN, "%s/%s",
                 realpath(dirname(folder), found) ? found : ".", basename(name));
}

/* Writes the names of a row as a pattern; empty if the run writes no such file. */
static PetscErrorCode OutputPattern(const Run *run, const OutputName *row,
                                    char pattern[3 * PETSC_MAX_PATH_LEN])
{
  const char *typed;
  char        base[PETSC_MAX_PATH_LEN], path[2 * PETSC_MAX_PATH_LEN];
  PetscBool   given, probes, snapshots, h5;

  PetscFunctionBegin;
  pattern[0] = '\0';
  PetscCall(PetscStrcmp(row->option, "-probe_output", &probes));
  PetscCall(PetscStrcmp(row->option, "-output", &snapshots));
  if (probes) typed = MonitorsBase(run->monitors);
  else PetscCall(OptionTyped(row->option, &typed, &given));
  if (!typed[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(base, typed, sizeof(base)));
  PetscCall(PetscStrendswith(base, ".h5", &h5));
  if (snapshots && h5) base[strlen(base) - 3] = '\0';
  Canonical(base, path);
  (void)snprintf(pattern, 3 * PETSC_MAX_PATH_LEN, "%s%s", path, row->ending);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  RunCheckOutputs - Refuses two options that lead to the same file

  Collective.
*/
PetscErrorCode RunCheckOutputs(const Run *run)
{
  char pattern[PETSC_STATIC_ARRAY_LENGTH(names)][3 * PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(names); k++) {
    PetscCall(OutputPattern(run, &names[k], pattern[k]));
    for (size_t m = 0; m < k; m++) {
      PetscBool same;

      if (!pattern[k][0] || !pattern[m][0] || !strcmp(names[k].option, names[m].option)) continue;
      same = !fnmatch(pattern[k], pattern[m], 0) || !fnmatch(pattern[m], pattern[k], 0)
                 ? PETSC_TRUE
                 : PETSC_FALSE;
      PetscCall(FirstRankDecides(&same)); /* its folders decide */
      UserCheck(!same, "%s and %s lead to the same file; two names are required", names[m].option,
                names[k].option);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
