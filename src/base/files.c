/* Files that a run writes, and the place of the program. Only regular files are written or
   replaced: a device, a folder or a symbolic link in the place of a file would be lost. */
#include "isph/base.h"
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/* FileIsOrdinary - Returns true if a path is free or names a regular file */
PetscBool FileIsOrdinary(const char path[])
{
  struct stat status;

  return lstat(path, &status) || S_ISREG(status.st_mode);
}

/* FileIsReadable - Returns true if a path is free or leads, through links, to a regular file */
PetscBool FileIsReadable(const char path[])
{
  struct stat status;

  return stat(path, &status) || S_ISREG(status.st_mode);
}

/* Ends the last line of a stream for reading and appending, unless it has an end: a row that is
   added begins a line, whatever program wrote the file. */
static void EndLastLine(FILE *stream)
{
  const int last = fseek(stream, -1, SEEK_END) ? '\n' : fgetc(stream);

  (void)fseek(stream, 0, SEEK_END);
  if (last != '\n') (void)fputc('\n', stream);
}

/* FileOpen - Opens a regular file as fopen() does, and to append begins a new line; returns NULL
   for others */
FILE *FileOpen(const char path[], const char mode[])
{
  const PetscBool adds   = mode[0] == 'a';
  FILE           *stream = FileIsOrdinary(path) ? fopen(path, adds ? "a+" : mode) : NULL;

  if (stream && adds) EndLastLine(stream);
  return stream;
}

/* FileReplace - Renames a file over a regular file or a free path; returns false on failure */
PetscBool FileReplace(const char part[], const char path[])
{
  return FileIsOrdinary(path) && !rename(part, path);
}

/* FileReserve - Finds out if a file of so many bytes can be written. Collective on
   PETSC_COMM_WORLD; the first rank tries. To be called before a run and before each file, because
   HDF5 aborts on a full disk. Removes an existing regular file of that name. */
PetscErrorCode FileReserve(const char path[], size_t bytes, PetscBool *good)
{
  PetscMPIInt rank;

  PetscFunctionBegin;
  *good = PETSC_TRUE;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) {
    const int file =
        FileIsOrdinary(path) ? open(path, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0666) : -1;

    *good = file >= 0 && posix_fallocate(file, 0, (off_t)bytes) == 0;
    if (file >= 0) (void)close(file);
    if (file >= 0) (void)remove(path);
  }
  PetscCall(FirstRankDecides(good));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ViewerCheck - Ends the run if text could not be written to an ASCII viewer. Collective on
   PETSC_COMM_WORLD. PETSc itself ignores a full disk. Input: option - of the viewer, for the
   message. */
PetscErrorCode ViewerCheck(PetscViewer viewer, const char option[])
{
  PetscBool   ascii, good = PETSC_TRUE;
  PetscMPIInt rank;
  FILE       *stream;

  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (!ascii) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank == 0) {
    PetscCall(PetscViewerASCIIGetPointer(viewer, &stream));
    good = !stream || (!fflush(stream) && !ferror(stream));
  }
  PetscCall(FirstRankDecides(&good));
  PetscCheck(good, PETSC_COMM_WORLD, PETSC_ERR_FILE_WRITE,
             "%s: the file cannot be written, or the disk is full", option);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* PathBesideProgram - Makes the path of a file from its place relative to the directory of the
   running program; "" if this directory is unknown */
PetscErrorCode PathBesideProgram(const char relative[], char path[PETSC_MAX_PATH_LEN])
{
  char          program[PETSC_MAX_PATH_LEN], *slash;
  const ssize_t length = readlink("/proc/self/exe", program, sizeof(program) - 1);

  PetscFunctionBegin;
  path[0]                          = '\0';
  program[length > 0 ? length : 0] = '\0';
  PetscCall(PetscStrrchr(program, '/', &slash));
  if (slash == program) PetscFunctionReturn(PETSC_SUCCESS);
  *slash = '\0'; /* PetscStrrchr() points behind the last '/' */
  PetscCall(PetscSNPrintf(path, PETSC_MAX_PATH_LEN, "%s%s", program, relative));
  PetscFunctionReturn(PETSC_SUCCESS);
}
