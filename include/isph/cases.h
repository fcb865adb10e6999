/* The cases: flows and patch tests by name. Each has a file in cases/ with its row at the end, and
   a name in cases/cases.c. */
#ifndef ISPH_CASES_H
#define ISPH_CASES_H

#include "isph/scene.h"

#define NAVIER_STOKES (PHYSICS_VISCOSITY | PHYSICS_PRESSURE | PHYSICS_CONVECTION)

extern const Table       CaseTable;
extern const OptionRow   CaseOption; /* -case, for SceneCreate() */
extern const OptionTable CaseOptions;

PetscErrorCode MeasureExact(const Flow *flow, Report *report); /* for cases with Exact() */

#endif
