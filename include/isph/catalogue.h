/* The list of all tables of the program. */
#ifndef ISPH_CATALOGUE_H
#define ISPH_CATALOGUE_H

#include "isph/base.h"

const Table   *CatalogueTable(PetscInt k);
PetscErrorCode CatalogueView(PetscViewer viewer);

#endif
