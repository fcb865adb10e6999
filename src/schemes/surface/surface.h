/* Treatments of free surfaces: volumes, jumps and bursts of the velocity. */
#ifndef ISPH_SCHEMES_SURFACE_H
#define ISPH_SCHEMES_SURFACE_H

#include "isph/motion.h"

extern const OptionTable SurfaceVolumeOptions;

/* velocityjump.c, velocityburst.c */
extern const Judge JudgeJump, JudgeBurst;

/* cellvolume.c */
PetscErrorCode FlowCellVolumes(const Flow *flow, PetscInt points, PetscReal volume[]);

/* ownedvolumes.c */
PetscErrorCode VolumesCreate(Flow *flow);
PetscErrorCode VolumesRegister(Flow *flow);
PetscErrorCode VolumesControl(Flow *flow);

#endif
