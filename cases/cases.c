/*
  The cases, one row each. A new case is one file with the functions, one row here and one .opts
  file.
*/
#include "cases.h"

/*
  MeasureExact - The quantities of a case that has Exact() and no other reference; it holds only
  for the flow as the case poses it, of a viscosity that does not follow the strain rate
*/
PetscErrorCode MeasureExact(const Flow *flow, Report *report)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  if (SceneIsAsPosed(scene) && SceneIsNewtonian(scene)) PetscCall(NormsExact(flow, report));
  PetscCall(MeasureCommon(flow, NAN, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define NAVIER_STOKES (PHYSICS_VISCOSITY | PHYSICS_PRESSURE | PHYSICS_CONVECTION)

static const CaseRow cases[] = {
    /* name, brief, citation,
       3D, physics, Reynolds number and its length, t_end, n, setup, velocity, wall velocity, exact,
       judge, solid fraction, typed, patch test */
    {"cavity", "lid-driven square or cubic cavity",
     "Botella & Peyret, Computers & Fluids 27 (1998)", PETSC_TRUE, NAVIER_STOKES | PHYSICS_WALLS,
     100.0, 1.0, 20.0, 50, CavitySetup, NULL, CavityWallVelocity, NULL, CavityMeasure, 0.0,
     PETSC_FALSE, PETSC_FALSE},
    {"cavity_cylinder", "lid-driven cavity with a fixed cylinder of half its width in the middle",
     "Zheng, Ma & Shao, Water 10 (2018)", PETSC_FALSE, NAVIER_STOKES | PHYSICS_WALLS, 1000.0, 1.0,
     40.0, 50, CavityCylinderSetup, NULL, CavityWallVelocity, NULL, CavityCylinderMeasure, 0.0,
     PETSC_FALSE, PETSC_FALSE},
    {"taylor_couette", "between cylinders of radius L/2, turning with U, and L, at rest",
     "Taylor, Phil. Trans. R. Soc. A 223 (1923)", PETSC_FALSE, NAVIER_STOKES | PHYSICS_WALLS, 10.0,
     0.5, 20.0, 25, TaylorCouetteSetup, NULL, NULL, TaylorCouetteExact, TaylorCouetteMeasure, 0.0,
     PETSC_FALSE, PETSC_FALSE},
    {"taylor_green", "decaying Taylor-Green vortices, in 3D uniform along z",
     "Taylor & Green, Proc. R. Soc. A 158 (1937)", PETSC_TRUE, NAVIER_STOKES, 100.0, 1.0, 1.0, 50,
     TaylorGreenSetup, TaylorGreenVelocity, NULL, TaylorGreenExact, MeasureExact, 0.0, PETSC_FALSE,
     PETSC_FALSE},
    {"couette", "start-up of plane Couette flow", "Morris, Fox & Zhu, J. Comput. Phys. 136 (1997)",
     PETSC_FALSE, PHYSICS_VISCOSITY | PHYSICS_WALLS, 1.0, 1.0, 1.0, 40, CouetteSetup, NULL,
     CouetteWallVelocity, CouetteExact, CouetteMeasure, 0.0, PETSC_FALSE, PETSC_FALSE},
    {"poiseuille", "start-up of plane Poiseuille flow; Re on the half width",
     "Basa, Quinlan & Lastiwka, Int. J. Numer. Meth. Fluids 60 (2009)", PETSC_FALSE,
     PHYSICS_VISCOSITY | PHYSICS_WALLS | PHYSICS_BODY_FORCE, 0.5, 0.5, 0.3, 40, PoiseuilleSetup,
     NULL, NULL, PoiseuilleExact, PoiseuilleMeasure, 0.0, PETSC_FALSE, PETSC_FALSE},
    {"hydrostatic", "closed box at rest under gravity", "", PETSC_TRUE,
     NAVIER_STOKES | PHYSICS_WALLS | PHYSICS_BODY_FORCE, 100.0, 1.0, 10.0, 16, HydrostaticSetup,
     NULL, NULL, HydrostaticExact, HydrostaticMeasure, 0.0, PETSC_FALSE, PETSC_FALSE},
    {"stokes_cylinders", "creeping flow through a square array of cylinders",
     "Sangani & Acrivos, Int. J. Multiphase Flow 8 (1982)", PETSC_FALSE,
     PHYSICS_VISCOSITY | PHYSICS_PRESSURE | PHYSICS_WALLS | PHYSICS_BODY_FORCE, 1.0, 1.0, 1.0, 50,
     StokesCylindersSetup, NULL, NULL, NULL, StokesCylindersMeasure, 0.1, PETSC_FALSE, PETSC_FALSE},
    {"scene", "typed by -scene_ options: a box, its sides, bodies", "", PETSC_FALSE,
     NAVIER_STOKES | PHYSICS_WALLS, 100.0, 1.0, 10.0, 50, SceneTypedSetup, SceneTypedVelocity,
     SceneTypedWallVelocity, SceneTypedExact, SceneTypedMeasure, 0.0, PETSC_TRUE, PETSC_FALSE},
    {"patch", "patch test: what an operator is worth on a given field, no flow",
     "Zheng, Ma & Shao, Water 10 (2018)", PETSC_TRUE, PHYSICS_VISCOSITY | PHYSICS_WALLS, 1.0, 1.0,
     0.0, 50, PatchSetup, NULL, NULL, NULL, NULL, 0.0, PETSC_FALSE, PETSC_TRUE},
};
const Table CaseTable = TABLE("-case", "Cases", cases);
