/* Versions of the program and of libraries that may influence its numbers. */
#include "commit.h"
#include "isph/options.h"
#include <hdf5.h>
#include <petscpkg_version.h>
#include <string.h>

/* VersionCommit - Returns the git commit of the program, empty if unknown; not collective */
const char *VersionCommit(void)
{
  return ISPH_COMMIT;
}

/*
  VersionPrint - Prints the versions of isph, PETSc, hypre, HDF5 and MPI

  Not collective; needs neither PETSc nor MPI to be initialized. Versions are read from the
  libraries at run time, except for hypre, whose version is from the build of PETSc.
*/
void VersionPrint(FILE *out)
{
  PetscInt     major, minor, subminor;
  unsigned int h5[3]                               = {0, 0, 0};
  char         mpi[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int          length;

  (void)fprintf(out, "isph %s%s%s\n", ISPH_VERSION, ISPH_COMMIT[0] ? ", commit " : "", ISPH_COMMIT);
  (void)PetscGetVersionNumber(&major, &minor, &subminor, NULL);
  (void)fprintf(out, "PETSc %d.%d.%d, %d-bit indices\n", (int)major, (int)minor, (int)subminor,
                (int)(8 * sizeof(PetscInt)));
#if defined(PETSC_PKG_HYPRE_VERSION_MAJOR)
  (void)fprintf(out, "hypre %d.%d.%d\n", PETSC_PKG_HYPRE_VERSION_MAJOR,
                PETSC_PKG_HYPRE_VERSION_MINOR, PETSC_PKG_HYPRE_VERSION_SUBMINOR);
#else
  (void)fprintf(out, "hypre absent from this PETSc\n");
#endif
  (void)H5get_libversion(&h5[0], &h5[1], &h5[2]);
  (void)fprintf(out, "HDF5 %u.%u.%u\n", h5[0], h5[1], h5[2]);
  (void)MPI_Get_library_version(mpi, &length);
  (void)fprintf(out, "%.*s\n", (int)strcspn(mpi, ",\n"), mpi);
}
