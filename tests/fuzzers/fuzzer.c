/* Starts PETSc for a fuzzer, accepts refusals of input without a message, and aborts on all other
   errors of PETSc, which would print a traceback. */
#include "fuzzer.h"
#include "isph/catalogue.h"
#include <stdlib.h>
#include <string.h>

/* MPI keeps memory until the end of the process, and parsers leave the data of a refused input to
   the end of the run. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
  return "detect_leaks=0:allocator_may_return_null=1";
}

/* Returns the code of an error of the user; aborts on other errors. */
static PetscErrorCode ErrorHandler_Refusals(MPI_Comm comm, int line, const char *function,
                                            const char *file, PetscErrorCode code,
                                            PetscErrorType type, const char *message, void *context)
{
  switch (code) {
  case PETSC_ERR_USER_INPUT:
  case PETSC_ERR_FILE_OPEN:
  case PETSC_ERR_FILE_READ:
  case PETSC_ERR_FILE_UNEXPECTED:
  case PETSC_ERR_NOT_CONVERGED:
  case PETSC_ERR_FP:
    return code;
  default:
    (void)fprintf(stderr, "error %d in %s() of %s, line %d: %s\n", (int)code, function, file, line,
                  message ? message : "");
    abort();
  }
}

/* FuzzerStart - Starts PETSc without options, signal handlers and daemons of MPI; called once */
void FuzzerStart(void)
{
  static char  name[] = "fuzzer", quiet[] = "-no_signal_handler", own[] = "-skip_petscrc";
  static char *words[] = {name, quiet, own, NULL}, **argv = words;
  int          argc = 3;

  OptionsKnow(CatalogueOptions);

  (void)setenv("OMPI_MCA_ess_singleton_isolated", "1", 1);
  (void)setenv("OMPI_MCA_opal_signal", "", 1); /* signals are libFuzzer's */
  (void)setenv("OMPI_MCA_orte_tmpdir_base", ".", 1);
  (void)setenv("OMP_NUM_THREADS", "1", 1);
  (void)setenv("HOME", ".", 1);
  (void)unsetenv("PETSC_OPTIONS");
  (void)unsetenv("PETSC_OPTIONS_YAML");
  if (PetscInitialize(&argc, &argv, NULL, NULL)) abort();
  if (PetscOptionsClear(NULL)) abort();
  if (PetscPushErrorHandler(ErrorHandler_Refusals, NULL)) abort();
}

/* FuzzerAssert - Aborts with a sentence if a property does not hold */
void FuzzerAssert(PetscBool holds, const char sentence[])
{
  if (holds) return;
  (void)fprintf(stderr, "%s\n", sentence);
  abort();
}

/* FuzzerByte - Returns the next byte of an input, 0 after its end */
unsigned FuzzerByte(FuzzerInput *input)
{
  if (!input->left) return 0;
  input->left--;
  return *input->next++;
}

/* FuzzerBytes - Copies the next n bytes of an input, fewer at its end; returns their number */
size_t FuzzerBytes(FuzzerInput *input, size_t n, void *bytes)
{
  n = PetscMin(n, input->left);
  if (n) (void)memcpy(bytes, input->next, n);
  input->next += n;
  input->left -= n;
  return n;
}

/* FuzzerText - Returns the rest of an input up to `most` bytes as a string, freed by the caller; it
   ends at the first null byte */
char *FuzzerText(FuzzerInput *input, size_t most)
{
  char *text = calloc(PetscMin(most, input->left) + 1, 1);

  if (!text) abort();
  (void)FuzzerBytes(input, most, text);
  return text;
}

/* FuzzerWrite - Writes a file in the present directory */
void FuzzerWrite(const char path[], const void *bytes, size_t n)
{
  FILE *file = fopen(path, "wb");

  if (!file || fwrite(bytes, 1, n, file) != n || fclose(file)) abort();
}
