/* Functions that several cases share. */
#ifndef ISPH_CASES_SHARED_H
#define ISPH_CASES_SHARED_H

#include "isph/cases.h"
#include "isph/io.h"

/* cavity.c */
PetscErrorCode CavitySetup(Scene *scene);
void CavityWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                        PetscReal u[]);

/* channel.c */
PetscErrorCode ChannelSetup(Scene *scene);
PetscErrorCode ChannelMeasure(const Flow *flow, PetscBool relative, Report *report);

/* centreline.c */
PetscErrorCode CentrelineExtrema(const Flow *flow, PetscReal u_min, PetscReal v_max,
                                 PetscReal v_min, Report *report);
PetscErrorCode CentrelineProfile(const Flow *flow, PetscInt a, PetscInt c, const char file[],
                                 const char name[], Report *report);
PetscErrorCode ReferenceEnergy(const Flow *flow, const char file[], Report *report,
                               PetscReal *energy);

/* exact.c */
void VelocityExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[]);

/* array.c */
PetscErrorCode MeasureArray(const Flow *flow, PetscReal scale, PetscReal known, Report *report);

#endif
