/* The functions that case files give to the table in cases.c. */
#ifndef ISPH_CASES_H
#define ISPH_CASES_H

#include "isph/io.h"

PetscErrorCode CavitySetup(Scene *scene);
void CavityWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                        PetscReal u[]);
PetscErrorCode CavityJudge(const Flow *flow, Report *report);

PetscErrorCode TaylorGreenSetup(Scene *scene);
void TaylorGreenVelocity(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[]);
void TaylorGreenExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                      PetscReal *p);

PetscErrorCode CouetteSetup(Scene *scene);
void CouetteWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                         PetscReal u[]);
void CouetteExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                  PetscReal *p);

PetscErrorCode PoiseuilleSetup(Scene *scene);
void           PoiseuilleExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                               PetscReal *p);

PetscErrorCode HydrostaticSetup(Scene *scene);
void           HydrostaticExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                                PetscReal *p);
PetscErrorCode HydrostaticJudge(const Flow *flow, Report *report);

PetscErrorCode PatchSetup(Scene *scene);

PetscErrorCode ChannelBox(Scene *scene);
PetscErrorCode ChannelJudge(const Flow *flow, Report *report);
PetscErrorCode ExactJudge(const Flow *flow, Report *report);

#endif
