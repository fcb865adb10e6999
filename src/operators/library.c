/*
  Forms of a shared object (-forms_library): rows of Laplacians and gradients of a user, beside
  those of the tables. docs/howto/own-laplacian.md has an example.
*/
#include "choose.h"
#include <dlfcn.h>
#include <string.h>

/* Returns true if a shared object was built for the structs of this program. */
static PetscBool Fits(const FormsLibrary *library)
{
  return library->version == FORMS_VERSION && library->stencil == sizeof(Stencil) &&
         library->laplacian == sizeof(LaplacianRow) && library->gradient == sizeof(GradientRow);
}

static PetscBool LaplacianIsComplete(const TableRow *row)
{
  const LaplacianRow *form = (const LaplacianRow *)(const void *)row;

  return form->Row || form->composed || form->weak;
}

static PetscBool GradientIsComplete(const TableRow *row)
{
  return ((const GradientRow *)(const void *)row)->Row ? PETSC_TRUE : PETSC_FALSE;
}

/* Refuses a table of a shared object with rows that are not complete or have the name of a row of
   the program. Input: size - of a row; Complete - checks its functions. */
static PetscErrorCode CheckTable(const char option[], const Table *own, const Table *table,
                                 size_t size, PetscBool (*Complete)(const TableRow *row))
{
  PetscFunctionBegin;
  UserCheck(own->count >= 0 && (!own->count || own->rows) && (own->row_size == size || !own->count),
            "%s: its table of %s is not made by TABLE()", option, table->title);
  for (PetscInt k = 0; k < own->count; k++) {
    const TableRow *row = TableGet(own, k), *same;

    UserCheck(row && row->name && row->brief && row->citation && Complete(row),
              "%s: row %" PetscInt_FMT
              " of its %s lacks a name, a brief, a citation or its function",
              option, k + 1, table->title);
    PetscCall(TableFind(table, row->name, &same));
    UserCheck(!same, "%s: the program has a row %s of its own among the %s; take another name",
              option, row->name, table->title);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Returns true if the condition holds on all ranks; collective. */
static PetscErrorCode HoldsEverywhere(PetscBool *holds)
{
  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, holds, 1, MPIU_BOOL, MPI_LAND, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FormsLibraryOpen - Opens the shared object of an option; collective. Output: library - its rows,
   NULL if the option is not given; it stays open to the end of the program. */
PetscErrorCode FormsLibraryOpen(const OptionRow *option, const FormsLibrary **library)
{
  char        path[PETSC_MAX_PATH_LEN], place[PETSC_MAX_PATH_LEN + 2];
  void       *object;
  const char *why;
  PetscBool   good;

  PetscFunctionBegin;
  *library = NULL;
  PetscCall(OptionGetFile(option, path));
  if (!path[0]) PetscFunctionReturn(PETSC_SUCCESS);
  (void)snprintf(place, sizeof(place), "%s%s", strchr(path, '/') ? "" : "./", path);
  object = dlopen(place, RTLD_NOW | RTLD_LOCAL);
  why    = object ? "" : dlerror();
  good   = object ? PETSC_TRUE : PETSC_FALSE;
  PetscCall(HoldsEverywhere(&good));
  UserCheck(good,
            "%s %s: no shared object that opens (%s); build one as "
            "docs/howto/own-laplacian.md does",
            option->name, path, why);
  *library = (const FormsLibrary *)dlsym(object, FORMS_SYMBOL);
  UserCheck(*library, "%s %s: it has no symbol %s, a FormsLibrary of isph/rows.h", option->name,
            path, FORMS_SYMBOL);
  UserCheck(Fits(*library),
            "%s %s: it was built for another isph: version or sizes of the structs of its forms "
            "differ; build it again with the headers of this isph",
            option->name, path);
  PetscCall(CheckTable(option->name, &(*library)->laplacians, &LaplacianTable, sizeof(LaplacianRow),
                       LaplacianIsComplete));
  PetscCall(CheckTable(option->name, &(*library)->gradients, &GradientTable, sizeof(GradientRow),
                       GradientIsComplete));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* FormsLibraryRow - Reads the name of a row of the option's table or of a table of a shared object;
   collective. Input: own - count 0: no rows. */
PetscErrorCode FormsLibraryRow(const OptionRow *option, const Table *own, const char standard[],
                               void *chosen)
{
  const char     *name;
  const TableRow *row = NULL;
  PetscBool       given;

  PetscFunctionBegin;
  PetscCall(OptionTyped(option->name, &name, &given));
  if (own && given) PetscCall(TableFind(own, name, &row));
  if (row) {
    *(const TableRow **)chosen = row;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (own && own->count && given) {
    char names[1024] = "";

    for (PetscInt k = 0; k < own->count; k++)
      AppendWord(names, sizeof(names), TableGet(own, k)->name);
    PetscCall(TableFind(option->table, name, &row));
    UserCheck(row, "%s %s: no such name; -forms_library has %s, the program those of -catalogue",
              option->name, name, names);
  }
  PetscCall(OptionGetRow(option, standard, chosen));
  PetscFunctionReturn(PETSC_SUCCESS);
}
