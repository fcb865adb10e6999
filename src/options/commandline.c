/*
  The command line before PETSc reads it: requests that need no run, and words that PETSc would
  ignore or answer with a traceback.
*/
#include "isph/options.h"
#include <errno.h>
#include <string.h>

static const OptionRow options[] = {
    {
        .name  = "-help",
        .kind  = VALUE_WORD,
        .brief = "all options of isph; with the word petsc, also PETSc's for the chosen solvers; "
                 "-h and --help too",
    },
    {
        .name  = "-version",
        .kind  = VALUE_NOTHING,
        .brief = "versions of isph and of the libraries it stands on; --version too",
    },
    {
        .name  = "-catalogue",
        .kind  = VALUE_NOTHING,
        .brief = "all rows that can be chosen by name: cases, operators, walls, schemes, "
                 "integrators, with their papers",
    },
    {
        .name  = "-options_reference",
        .kind  = VALUE_NOTHING,
        .brief = "the reference page of all options, in Markdown",
    },
    {
        .name = "-options_file",
        .kind = VALUE_FILE,
        .brief =
            "file with more options, one a line; # begins a comment; may be given several times",
    },
    {
        .name  = "-options_left",
        .kind  = VALUE_SOLVER,
        .brief = "print options that PETSc has not used",
        .late  = PETSC_TRUE,
    },
    {
        .name  = "-options_view",
        .kind  = VALUE_SOLVER,
        .brief = "print all options in force",
        .late  = PETSC_TRUE,
    },
    {
        .name  = "-log_view",
        .kind  = VALUE_SOLVER,
        .brief = "print time and memory of all parts of the run",
        .late  = PETSC_TRUE,
    },
};
const OptionTable ProgramOptions = OPTIONS("Program", options);

/* Returns true if a word is an option of this name, with a single or double dash. */
static PetscBool IsOption(const char word[], const char name[])
{
  if (word[0] != '-') return PETSC_FALSE;
  word += word[1] == '-' ? 2 : 1;
  return strcmp(word, name) ? PETSC_FALSE : PETSC_TRUE;
}

/*
  CommandLineRequest - Determines the request of a command line

  Not collective. Input/Output: argc, argv - "petsc" after -help is removed, because PETSc would
  refuse it; -h and --help become -help.
*/
Request CommandLineRequest(int *argc, char **argv)
{
  static char help[]  = "-help";
  Request     request = *argc > 1 ? REQUEST_RUN : REQUEST_USAGE;
  int         kept    = 1;

  for (int k = 1; k < *argc; k++) {
    if (IsOption(argv[k], "version")) request = REQUEST_VERSION;
    if (IsOption(argv[k], "options_reference")) request = REQUEST_REFERENCE;
    argv[kept++] = argv[k];
    if (!IsOption(argv[k], "h") && !IsOption(argv[k], "help")) continue;
    argv[kept - 1] = help;
    request        = REQUEST_HELP;
    if (k + 1 < *argc && strcmp(argv[k + 1], "petsc") == 0) {
      request = REQUEST_HELP_PETSC;
      k++;
    }
  }
  argv[kept] = NULL;
  *argc      = kept;
  return request;
}

/*
  CommandLineCheck - Checks the words of a command line and its options files

  Not collective. Output: sentence - the first mistake; empty if there is none
*/
void CommandLineCheck(int argc, char **argv, char sentence[], size_t length)
{
  sentence[0] = '\0';
  for (int k = 1; k < argc && !sentence[0]; k++) {
    const PetscBool word = argv[k][0] != '-' ? PETSC_TRUE : PETSC_FALSE;

    if (word && (k == 1 || argv[k - 1][0] != '-')) {
      (void)snprintf(sentence, length,
                     "%s: a stray word; options begin with a dash, e.g. -case cavity", argv[k]);
    } else if (IsOption(argv[k], "options_file")) {
      if (k + 1 == argc || argv[k + 1][0] == '-')
        (void)snprintf(sentence, length, "-options_file: a file name is required");
      else OptionsFileCheck(argv[k + 1], sentence, length);
    }
  }
}
