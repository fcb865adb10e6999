/* The rows of the table of schemes, each in its folder. */
#ifndef ISPH_SCHEMES_ROWS_H
#define ISPH_SCHEMES_ROWS_H

#include "isph/schemes.h"

extern const SchemeRow SchemeProjection, SchemeCoupled;

#endif
