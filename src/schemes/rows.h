/* The rows of the schemes' table: one folder each. */
#ifndef ISPH_SCHEMES_ROWS_H
#define ISPH_SCHEMES_ROWS_H

#include "isph/schemes.h"

extern const SchemeRow SchemeProjection, SchemeCoupled;

#endif
