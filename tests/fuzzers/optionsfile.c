/*
  Fuzzer of the checks before PETSc reads options. The first byte chooses an options file, or the
  words of a command line, a line for each. PETSc must read a file that passes the checks.
*/
#include "fuzzer.h"
#include "options/optionsfile.h"
#include <stdlib.h>
#include <string.h>

#define MOST_WORDS 64

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  FuzzerStart();
  if (PetscPushErrorHandler(PetscIgnoreErrorHandler, NULL))
    abort(); /* as before PetscInitialize() */
  return 0;
}

/* Checks an options file; lets PETSc read it if there is no mistake. */
static void CheckFile(const char path[])
{
  char         sentence[2 * PETSC_MAX_PATH_LEN] = "";
  PetscOptions options;

  OptionsFileCheck("-options_file", path, sentence, sizeof(sentence));
  if (sentence[0]) return;
  if (PetscOptionsCreate(&options)) abort();
  FuzzerAssert(PetscOptionsInsertFile(PETSC_COMM_SELF, options, path, PETSC_TRUE) ? PETSC_FALSE
                                                                                  : PETSC_TRUE,
               "PETSc refuses a file that the checks accept");
  if (PetscOptionsDestroy(&options)) abort();
}

/* Checks the lines of a text as the words of a command line. */
static void CheckWords(char text[])
{
  char  name[] = "isph", sentence[2 * PETSC_MAX_PATH_LEN] = "", *word[MOST_WORDS + 2] = {name};
  char *next = text;
  const char *search;
  int         argc = 1;

  while (next && argc <= MOST_WORDS) {
    word[argc++] = next;
    next         = strchr(next, '\n');
    if (next) *next++ = '\0';
  }
  word[argc] = NULL;
  (void)CommandLineRequest(&argc, word, &search);
  OptionsCheck(argc, word, sentence, sizeof(sentence));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  FuzzerInput input = {data, size};

  if (FuzzerByte(&input) % 2) {
    char *text = FuzzerText(&input, 8192);

    CheckWords(text);
    free(text);
  } else {
    FuzzerWrite("fuzzed.opts", input.next, input.left);
    CheckFile("fuzzed.opts");
  }
  return 0;
}
