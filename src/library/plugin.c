/* Plug-ins (-library): shared objects whose rows stand in the tables too, for all runs of the
   process. docs/howto/own-laplacian.md and own-case.md have examples. */
#include "isph/plugin.h"
#include "library.h"
#include <dlfcn.h>
#include <string.h>

static const OptionRow options[] = {
    OPTION(FILE, "-library",
           "shared objects, separated by commas, with own forms, rheologies, cases, shapes, "
           "kernels or functions of expressions",
           NULL, NULL, .also = " plugin ", .file = FILE_BEGINNING),
};
const OptionTable PluginOptions = OPTIONS("Plug-ins", options);

/* Refuses rows that the table of the program cannot take; adds the others, once. */
static PetscErrorCode PluginAdd(const char path[], const PluginRows *add)
{
  const Table *table = add->table, *rows = &add->rows;

  PetscFunctionBegin;
  UserCheck(table && rows->rows && rows->row_size == table->row_size,
            "-library %s: the rows of %s do not fit a table of this isph", path,
            rows->title ? rows->title : "a table");
  for (PetscInt k = 0; k < rows->count; k++) {
    const TableRow *row = TableGet(rows, k), *same;

    UserCheck(row && row->name && row->brief,
              "-library %s: row %" PetscInt_FMT " of %s lacks a name or a brief", path, k + 1,
              rows->title);
    PetscCall(TableFind(table, row->name, &same));
    if (same == row) PetscFunctionReturn(PETSC_SUCCESS); /* an earlier run has added them */
    UserCheck(!same, "-library %s: there is a row %s among the %s already; take another name", path,
              row->name, table->title);
  }
  PetscCall(TableExtend(table, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* As a plug-in of this program would be. */
static const PluginRows none[1];
static const Plugin     own = PLUGIN(none);

/* Opens a plug-in and adds its rows; it stays open to the end of the process. */
static PetscErrorCode PluginOpen(const char path[])
{
  char          place[PETSC_MAX_PATH_LEN + 2];
  const Plugin *plugin;
  void         *object;
  PetscBool     good;

  PetscFunctionBegin;
  (void)snprintf(place, sizeof(place), "%s%s", strchr(path, '/') ? "" : "./", path);
  object = dlopen(place, RTLD_NOW | RTLD_LOCAL);
  good   = object ? PETSC_TRUE : PETSC_FALSE;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &good, 1, MPIU_BOOL, MPI_LAND, PETSC_COMM_WORLD));
  UserCheck(good, "-library %s: no shared object that opens (%s)", path, object ? "" : dlerror());
  plugin = (const Plugin *)dlsym(object, PLUGIN_SYMBOL);
  UserCheck(plugin, "-library %s: it has no symbol %s, a Plugin of isph/plugin.h", path,
            PLUGIN_SYMBOL);
  UserCheck(!strcmp(plugin->version, own.version) &&
                !memcmp(plugin->sizes, own.sizes, sizeof(own.sizes)),
            "-library %s: it was built for another isph; build it again with the headers of this "
            "one",
            path);
  for (PetscInt k = 0; k < plugin->n; k++) PetscCall(PluginAdd(path, &plugin->rows[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PluginsOpen - Opens the shared objects of -library. Collective. To be called before any other
   option is read. Errors: refuses files that are no shared objects, have no symbol IsphPlugin, were
   built for other structs, or have rows that are not complete or have names of the program's
   rows. */
PetscErrorCode PluginsOpen(void)
{
  char path[PETSC_MAX_PATH_LEN], *next = path;

  PetscFunctionBegin;
  PetscCall(OptionGetFile(&options[0], path));
  while (*next) {
    char *const one = next;

    next += strcspn(next, ",");
    if (*next) *next++ = '\0';
    PetscCall(PluginOpen(one));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
