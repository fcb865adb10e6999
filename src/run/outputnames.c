/* Names of the files that a run writes or reads: two options must not lead to the same file, those
   of PETSc's viewers included, and a checkpoint does not replace a file of another kind. */
#include "impl.h"
#include "io/hdf5file.h"
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
    {"-checkpoint", ""},
    {"-checkpoint", ".part"},
    {"-report", ""},
    {"-output", "_[0-9][0-9][0-9][0-9]*.h5"},
    {"-output", ".xdmf"},
    {"-output", "_[0-9][0-9][0-9][0-9]*.vtp"},
    {"-probe_output", "_*.csv"},
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
static PetscErrorCode OutputPattern(const OutputName *row, char pattern[3 * PETSC_MAX_PATH_LEN])
{
  const char *typed;
  char        base[PETSC_MAX_PATH_LEN], path[2 * PETSC_MAX_PATH_LEN];
  PetscBool   given, snapshots, h5;

  PetscFunctionBegin;
  pattern[0] = '\0';
  PetscCall(PetscStrcmp(row->option, "-output", &snapshots));
  PetscCall(OptionTyped(row->option, &typed, &given));
  if (!typed[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrncpy(base, typed, sizeof(base)));
  PetscCall(PetscStrendswith(base, ".h5", &h5));
  if (snapshots && h5) base[strlen(base) - 3] = '\0';
  Canonical(base, path);
  (void)snprintf(pattern, 3 * PETSC_MAX_PATH_LEN, "%s%s", path, row->ending);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of the files that a run reads; it may continue the checkpoint that it restarts from. */
static const char *const inputs[] = {"-options_file", "-particles", "-library", "-restart"};

/* A file that an option leads to, in its shortest form, or a pattern of such files. */
typedef struct {
  char      option[OPTION_LENGTH], pattern[3 * PETSC_MAX_PATH_LEN];
  PetscBool read;
} NamedFile;

#define NAMED_MOST 64

typedef struct {
  NamedFile file[NAMED_MOST];
  PetscInt  n;
} NamedFiles;

/* Adds a file; further ones than fit are not looked at. */
static void AddFile(const char option[], const char pattern[], PetscBool read, NamedFiles *all)
{
  NamedFile *file = &all->file[all->n];

  if (all->n == NAMED_MOST || !pattern[0]) return;
  (void)snprintf(file->option, sizeof(file->option), "%s", option);
  (void)snprintf(file->pattern, sizeof(file->pattern), "%s", pattern);
  file->read = read;
  all->n++;
}

/* Adds the file of a viewer of PETSc, type:file:format. */
static void AddViewer(const char option[], const char value[], NamedFiles *all)
{
  const char *begin = strchr(value, ':');
  char        name[PETSC_MAX_PATH_LEN], path[2 * PETSC_MAX_PATH_LEN];

  if (!begin || !begin[1] || begin[1] == ':') return;
  (void)snprintf(name, sizeof(name), "%s", begin + 1);
  name[strcspn(name, ":")] = '\0';
  Canonical(name, path);
  AddFile(option, path, PETSC_FALSE, all);
}

/* Adds the files of all options that view or monitor, as `-log_view :file` and `-visc_ksp_view_mat
   binary:file`. */
static PetscErrorCode AddViewers(NamedFiles *all)
{
  char *text, *rest, *word, option[OPTION_LENGTH] = "";

  PetscFunctionBegin;
  PetscCall(PetscOptionsGetAll(NULL, &text));
  for (word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
    if (word[0] == '-') (void)snprintf(option, sizeof(option), "%s", word);
    else if (strstr(option, "view") || strstr(option, "monitor")) AddViewer(option, word, all);
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the files that the run writes and reads. */
static PetscErrorCode ListFiles(NamedFiles *all)
{
  char pattern[3 * PETSC_MAX_PATH_LEN];

  PetscFunctionBegin;
  all->n = 0;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(names); k++) {
    PetscCall(OutputPattern(&names[k], pattern));
    AddFile(names[k].option, pattern, PETSC_FALSE, all);
  }
  PetscCall(AddViewers(all));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(inputs); k++) {
    const char *typed;
    PetscBool   given;

    PetscCall(OptionTyped(inputs[k], &typed, &given));
    if (!typed[0]) continue;
    Canonical(typed, pattern);
    AddFile(inputs[k], pattern, PETSC_TRUE, all);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if two options must not lead to these files. */
static PetscBool Clash(const NamedFile *a, const NamedFile *b)
{
  if ((a->read && b->read) || !strcmp(a->option, b->option)) return PETSC_FALSE;
  if (!strcmp(a->option, "-checkpoint") && !strcmp(b->option, "-restart")) return PETSC_FALSE;
  return !fnmatch(a->pattern, b->pattern, 0) || !fnmatch(b->pattern, a->pattern, 0) ? PETSC_TRUE
                                                                                    : PETSC_FALSE;
}

/* Refuses a file in the place of the checkpoint that is no checkpoint. A damaged one may go. */
static PetscErrorCode KeepForeignFile(void)
{
  static const char mark[]              = "\x89HDF\r\n\x1a\n";
  char              begin[sizeof(mark)] = "";
  const char       *path;
  PetscBool         given, closed, there, good;
  FILE             *f;
  Hdf5File          file;

  PetscFunctionBegin;
  PetscCall(OptionTyped("-checkpoint", &path, &given));
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  f     = FileOpen(path, "r");
  there = f && fread(begin, 1, sizeof(mark) - 1, f) > 0 ? PETSC_TRUE : PETSC_FALSE;
  good  = memcmp(begin, mark, sizeof(mark) - 1) == 0 ? PETSC_TRUE : PETSC_FALSE;
  if (f) (void)fclose(f);
  PetscCall(FirstRankDecides(&there));
  PetscCall(FirstRankDecides(&good));
  if (good) {
    PetscCall(Hdf5FileOpen(PETSC_COMM_WORLD, path, HDF5_READ, &file));
    if (file.file >= 0) {
      if (H5Lexists(file.file, "memory", H5P_DEFAULT) == 0) good = PETSC_FALSE;
      PetscCall(Hdf5FileClose(&file, &closed));
    }
  }
  UserCheck(!there || good,
            "-checkpoint %s: this file is there and is no checkpoint; give another name", path);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* RunCheckOutputs - Refuses two options that lead to the same file, unless both only read it, and a
   checkpoint in the place of another file. Collective. To be called before any file is opened:
   solvers take their viewers early. */
PetscErrorCode RunCheckOutputs(void)
{
  NamedFiles *all;

  PetscFunctionBegin;
  PetscCall(PetscNew(&all));
  PetscCall(ListFiles(all));
  for (PetscInt k = 0; k < all->n; k++) {
    for (PetscInt m = 0; m < k; m++) {
      PetscBool same = Clash(&all->file[m], &all->file[k]);

      PetscCall(FirstRankDecides(&same)); /* its folders decide */
      UserCheck(!same, "%s and %s lead to the same file; two names are required",
                all->file[m].option, all->file[k].option);
    }
  }
  PetscCall(PetscFree(all));
  PetscCall(KeepForeignFile());
  PetscFunctionReturn(PETSC_SUCCESS);
}
