/* Error messages: a single line for an error that the user can correct, PETSc's traceback for a
   defect of the program. */
#include "isph/base.h"
#include <ctype.h>
#include <signal.h>
#include <stdarg.h>
#include <string.h>
#include <unistd.h>

/* Returns true if an error code means wrong input, a file error, a diverged solve or a signal. */
static PetscBool ErrorIsUsers(PetscErrorCode code)
{
  switch (code) {
  case PETSC_ERR_USER_INPUT:
  case PETSC_ERR_NOT_CONVERGED:
  case PETSC_ERR_FP:
  case PETSC_ERR_FILE_OPEN:
  case PETSC_ERR_FILE_READ:
  case PETSC_ERR_FILE_WRITE:
  case PETSC_ERR_FILE_UNEXPECTED:
  case PETSC_ERR_ARG_UNKNOWN_TYPE:
  case PETSC_ERR_ARG_OUTOFRANGE:
  case PETSC_ERR_USER:
  case PETSC_ERR_SUP:
  case PETSC_ERR_MISSING_FACTOR:
  case PETSC_ERR_MEM:
    return PETSC_TRUE;
  default:
    return code > ERROR_INTERRUPTED(0);
  }
}

/* Returns true if the path of a source file is in the tree of this file: no source of PETSc. */
static PetscBool SourceIsOurs(const char path[])
{
  const char *const here = __FILE__;

  return !strncmp(path, here, strlen(here) - strlen("src/base/errors.c"));
}

const char *const SolverPrefixes[] = {"-visc_", "-ppe_", "-coupled_", "-wcsph_", "-scalar_", NULL};

/* Returns true if PETSc has found no memory. PETSc 3.18 passes the line of the caller for the error
   code and the name of the caller for the message. */
static PetscBool ErrorIsOfMemory(const char function[])
{
  return !strcmp(function, "PetscMallocAlign") || !strcmp(function, "PetscReallocAlign");
}

/* Returns true if PETSc fails with a solver that the user has chosen, such as a preconditioner that
   needs data of a mesh. */
static PetscBool ErrorIsOfChosenSolver(PetscErrorCode code, const char file[])
{
  char     *all    = NULL;
  PetscBool chosen = PETSC_FALSE;

  if (code == PETSC_ERR_SIG || SourceIsOurs(file) || PetscOptionsGetAll(NULL, &all))
    return PETSC_FALSE;
  for (size_t k = 0; SolverPrefixes[k] && !chosen; k++)
    chosen = strstr(all, SolverPrefixes[k]) ? PETSC_TRUE : PETSC_FALSE;
  (void)PetscFree(all);
  return chosen;
}

/* Returns a hint to add to messages of PETSc itself, which name no option; of_solver: PETSc fails
   with a solver that the user has chosen. */
static const char *ErrorHint(PetscErrorCode code, PetscBool of_solver)
{
  const char *const hint = " (from PETSc about a -visc_, -ppe_, -coupled_ or numeric option; -help "
                           "petsc lists allowed values)";

  switch (code) {
  case PETSC_ERR_ARG_UNKNOWN_TYPE:
    return " (a type named after a -visc_, -ppe_ or -coupled_ option; -help petsc lists the "
           "types)";
  case PETSC_ERR_MEM:
    return " (there is too little memory: use a smaller -n, or more nodes)";
  case PETSC_ERR_ARG_OUTOFRANGE:
  case PETSC_ERR_USER:
  case PETSC_ERR_SUP:
    return hint;
  default:
    return of_solver ? hint : "";
  }
}

/* ErrorPrint - Prints a message and a hint in a single line on standard error. A line break or
   another control character in a value that the message quotes is printed as \n or \x01. */
void ErrorPrint(const char message[], const char hint[])
{
  (void)fputs("isph: ", stderr);
  for (const char *c = message; *c; c++) {
    if (*c == '\n') (void)fputs("\\n", stderr);
    else if (iscntrl((unsigned char)*c)) (void)fprintf(stderr, "\\x%02x", (unsigned)*c);
    else (void)fputc(*c, stderr);
  }
  (void)fprintf(stderr, "%s\n", hint);
}

static PetscErrorCode ErrorHandler_OneLine(MPI_Comm comm, int line, const char *function,
                                           const char *file, PetscErrorCode code,
                                           PetscErrorType type, const char *message, void *ctx)
{
  ErrorState *state = (ErrorState *)ctx;
  int         rank  = 0;

  if (type == PETSC_ERROR_INITIAL && function && ErrorIsOfMemory(function)) {
    code    = PETSC_ERR_MEM;
    message = "memory cannot be allocated";
  }
  if (!ErrorIsUsers(code) && !state->of_solver && type == PETSC_ERROR_INITIAL)
    state->of_solver = ErrorIsOfChosenSolver(code, file);
  if (type == PETSC_ERROR_INITIAL && state->keeps) {
    state->kept = (KeptError){comm, line, function, file, ErrorHint(code, state->of_solver), ""};
    TextAppend(state->kept.message, sizeof(state->kept.message), message);
  }
  if (!ErrorIsUsers(code) && !state->of_solver) {
    return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, ctx);
  }
  if (state->keeps) return code;
  (void)MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (type == PETSC_ERROR_INITIAL && (rank == 0 || comm == PETSC_COMM_SELF)) {
    if (isatty(STDOUT_FILENO)) (void)fputc('\n', stdout); /* ends the progress line */
    (void)fflush(stdout);
    ErrorPrint(message, ErrorHint(code, state->of_solver));
  }
  if (type == PETSC_ERROR_INITIAL && comm == PETSC_COMM_SELF) state->of_one_rank = PETSC_TRUE;
  return code;
}

/* ErrorsInstall - Installs an error handler that prints errors of the user as single lines. Called
   once after PetscInitialize(). The run ends without a message if the program that reads its output
   ends first, as in `isph | head`. Output: state - must exist until ErrorsExit(). */
PetscErrorCode ErrorsInstall(ErrorState *state)
{
  PetscFunctionBegin;
  *state = (ErrorState){.of_one_rank = PETSC_FALSE, .of_solver = PETSC_FALSE};
  PetscCall(PetscPushErrorHandler(ErrorHandler_OneLine, state));
  (void)signal(SIGPIPE, SIG_DFL);
  (void)signal(SIGQUIT, SIG_DFL);
  (void)signal(SIGXFSZ, SIG_IGN); /* a write beyond a limit on the size of files fails instead */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ErrorsKeep - Installs an error handler that keeps the message of an error of the user, and prints
   defects of the program only. Not collective. Every call needs one of ErrorsRelease(). Output:
   state - must exist until then. */
PetscErrorCode ErrorsKeep(ErrorState *state)
{
  PetscFunctionBegin;
  *state = (ErrorState){.keeps = PETSC_TRUE};
  PetscCall(PetscPushErrorHandler(ErrorHandler_OneLine, state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ErrorsRelease - Removes the handler of ErrorsKeep(), and hands an error on to the handler that
   was there before, as if it were there in the beginning; returns its code; not collective */
PetscErrorCode ErrorsRelease(PetscErrorCode code, const ErrorState *state)
{
  const KeptError *kept = &state->kept;

  (void)PetscPopErrorHandler();
  if (!code || !kept->file) return code;
  return PetscError(kept->comm, kept->line, kept->function, kept->file, code,
                    ErrorIsUsers(code) || state->of_solver ? PETSC_ERROR_INITIAL
                                                           : PETSC_ERROR_REPEAT,
                    "%s", kept->message);
}

/* FirstRankDecides - Broadcasts a flag of the first rank, which alone opened or wrote a file.
   Collective on PETSC_COMM_WORLD. */
PetscErrorCode FirstRankDecides(PetscBool *verdict)
{
  PetscInt decided = *verdict ? 1 : 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Bcast(&decided, 1, MPIU_INT, 0, PETSC_COMM_WORLD));
  *verdict = decided ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SayLine - Prints a message during a run, on a line of its own below an unfinished progress line.
   The first rank prints. */
PetscErrorCode SayLine(const char format[], ...)
{
  PetscMPIInt rank;
  va_list     arguments;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank) PetscFunctionReturn(PETSC_SUCCESS);
  if (isatty(STDOUT_FILENO)) (void)fputc('\n', stdout);
  va_start(arguments, format);
  (void)vfprintf(stdout, format, arguments);
  va_end(arguments);
  (void)fputc('\n', stdout);
  (void)fflush(stdout);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ErrorsExit - Ends the program after an error. Collective for errors of the user that all ranks
   detect together. A single rank may have detected any other error, for example a file that the
   first rank cannot open; this rank aborts the others. Returns: the exit status, never zero. */
int ErrorsExit(PetscErrorCode code, const ErrorState *state)
{
  int size = 1;

  (void)MPI_Comm_size(PETSC_COMM_WORLD, &size);
  if ((ErrorIsUsers(code) || state->of_solver) && !(state->of_one_rank && size > 1)) {
    (void)PetscPushErrorHandler(PetscIgnoreErrorHandler, NULL); /* the first error is printed */
    (void)PetscFinalize();
    (void)MPI_Finalize();
  } else if (size > 1) {
    (void)MPI_Abort(PETSC_COMM_WORLD, (int)code);
  }
  return (int)code;
}
