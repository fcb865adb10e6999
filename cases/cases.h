/* The functions that case files give to the table in cases.c. */
#ifndef ISPH_CASES_H
#define ISPH_CASES_H

#include "isph/io.h"

PetscErrorCode CavitySetup(Scene *scene);
void CavityWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                        PetscReal u[]);
PetscErrorCode CavityMeasure(const Flow *flow, Report *report);

PetscErrorCode CavityCylinderSetup(Scene *scene);
PetscErrorCode CavityCylinderMeasure(const Flow *flow, Report *report);

PetscErrorCode TaylorCouetteSetup(Scene *scene);
void TaylorCouetteExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                        PetscReal *p);
PetscErrorCode TaylorCouetteMeasure(const Flow *flow, Report *report);

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
PetscErrorCode HydrostaticMeasure(const Flow *flow, Report *report);

PetscErrorCode StokesCylindersSetup(Scene *scene);
PetscErrorCode StokesCylindersMeasure(const Flow *flow, Report *report);

PetscErrorCode SceneTypedSetup(Scene *scene);
void SceneTypedVelocity(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[]);
void SceneTypedExact(const Scene *scene, PetscReal t, const PetscReal x[], PetscReal u[],
                     PetscReal *p);
void SceneTypedWallVelocity(const Scene *scene, PetscInt side, PetscReal t, const PetscReal x[],
                            PetscReal u[]);
PetscErrorCode SceneTypedMeasure(const Flow *flow, Report *report);

PetscErrorCode PatchSetup(Scene *scene);

PetscErrorCode CentrelineExtrema(const Flow *flow, PetscReal u_min, PetscReal v_max,
                                 PetscReal v_min, Report *report);
PetscErrorCode CentrelineProfile(const Flow *flow, PetscInt a, PetscInt c, const char file[],
                                 const char name[], Report *report);
PetscErrorCode ReferenceEnergy(const Flow *flow, const char file[], PetscReal *energy);

PetscErrorCode CouetteMeasure(const Flow *flow, Report *report);
PetscErrorCode PoiseuilleMeasure(const Flow *flow, Report *report);
PetscErrorCode MeasureExact(const Flow *flow, Report *report);

#endif
