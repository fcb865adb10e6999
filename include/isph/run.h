/* The run of a flow: from its scene to its report. */
#ifndef ISPH_RUN_H
#define ISPH_RUN_H

#include "isph/io.h"

PetscErrorCode FlowRun(Scene *scene);

#endif
