/* Gives PETSc 3.18 to 3.25 the names of the newest release. A name that changed between releases is
   defined here for the releases before the change; no other file depends on the version. */
#ifndef ISPH_PETSC_H
#define ISPH_PETSC_H

#include <petsc.h>

#if PETSC_VERSION_LT(3, 18, 0)
#error "isph needs PETSc 3.18 or newer"
#endif

#if PETSC_VERSION_LT(3, 19, 0)
#define PETSC_SUCCESS 0
#define PETSC_INT_MAX PETSC_MAX_INT
#endif

#if PETSC_VERSION_LT(3, 22, 0)
#define PETSC_CURRENT            PETSC_DEFAULT
#define PETSC_UNLIMITED          (-3)
#define PetscOptionsCreateViewer PetscOptionsGetViewer
#endif

#endif
