/* The list of all tables of the program. */
#ifndef ISPH_CATALOGUE_H
#define ISPH_CATALOGUE_H

#include "isph/options.h"

extern const OptionTable *const CatalogueOptions[]; /* of OptionsKnow(); NULL after the last */
const Table                    *CatalogueTable(PetscInt k);
PetscErrorCode                  CatalogueView(PetscViewer viewer);

#endif
