/* The functions that case files give to the table in cases.c. */
#ifndef ISPH_CASES_H
#define ISPH_CASES_H

#include "isph/io.h"

PetscErrorCode CavitySetup(Scene *scene);
void CavityWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                        PetscReal u[]);
PetscErrorCode CavityJudge(const Flow *flow, Report *report);

PetscErrorCode CavityCylinderSetup(Scene *scene);
PetscErrorCode CavityCylinderJudge(const Flow *flow, Report *report);

PetscErrorCode TaylorCouetteSetup(Scene *scene);
void TaylorCouetteExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                        PetscReal *p);
PetscErrorCode TaylorCouetteJudge(const Flow *flow, Report *report);

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

PetscErrorCode StokesCylindersSetup(Scene *scene);
PetscErrorCode StokesCylindersJudge(const Flow *flow, Report *report);

PetscErrorCode SceneTypedSetup(Scene *scene);
void SceneTypedVelocity(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[]);
void SceneTypedExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                     PetscReal *p);
void SceneTypedWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                            PetscReal u[]);
PetscErrorCode SceneTypedJudge(const Flow *flow, Report *report);

PetscErrorCode PatchSetup(Scene *scene);

PetscErrorCode CentrelineExtrema(const Flow *flow, PetscReal u_min, PetscReal v_max,
                                 PetscReal v_min, Report *report);
PetscErrorCode CentrelineProfile(const Flow *flow, PetscInt a, PetscInt c, const char file[],
                                 const char name[], Report *report);
PetscErrorCode ReferenceEnergy(const Flow *flow, const char file[], PetscReal *energy);

PetscErrorCode CouetteJudge(const Flow *flow, Report *report);
PetscErrorCode PoiseuilleJudge(const Flow *flow, Report *report);
PetscErrorCode ExactJudge(const Flow *flow, Report *report);

#endif
