/*
  Plug-ins: shared objects of -library, with rows for the tables of the program. A plug-in defines

    static const PluginRows rows[] = {{&LaplacianTable, TABLE("Laplacians", laplacians)}};
    const Plugin IsphPlugin = PLUGIN(rows);

  Any table of isph -catalogue takes rows, FunctionTable besides, with functions for expressions.
*/
#ifndef ISPH_PLUGIN_H
#define ISPH_PLUGIN_H

#include "isph/cases.h"
#include "isph/io.h"

typedef struct {
  const Table *table; /* of the program */
  Table        rows;  /* of the same type */
} PluginRows;

typedef struct {
  const char       *version; /* of the headers that it was built with */
  size_t            sizes[3];
  const PluginRows *rows;
  PetscInt          n;
} Plugin;
#define PLUGIN_SYMBOL "IsphPlugin"
#define PLUGIN(rows)                                                                               \
  {                                                                                                \
    ISPH_VERSION, {sizeof(Stencil), sizeof(Scene), sizeof(Flow)}, rows,                            \
        (PetscInt)(sizeof(rows) / sizeof((rows)[0]))                                               \
  }

#endif
