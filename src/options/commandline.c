/*
  The command line before PETSc reads it: requests that need no run, and words that PETSc would
  ignore or answer with a traceback.
*/
#include "isph/options.h"
#include <errno.h>
#include <string.h>

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
    if (IsOption(argv[k], "version") && request == REQUEST_RUN) request = REQUEST_VERSION;
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

/* UsagePrint - Prints first steps, for a command line without options; not collective */
void UsagePrint(FILE *out)
{
  (void)fputs(
      "isph: incompressible viscous flow by Smoothed Particle Hydrodynamics on PETSc\n"
      "\n"
      "usage: isph -option value ...         or: mpiexec -n 4 isph -option value ...\n"
      "\n"
      "  isph -case cavity -n 32 -t_end 5 -output flow.h5      a flow, and files for ParaView\n"
      "  isph -options_file options/cavity.opts -reynolds 400  options of a file, then others\n"
      "  isph -case cavity -reynolds 0.01 -motion eulerian -scheme coupled -steady\n"
      "  isph -case scene -scene_body_1 circle,0.5,0.5,0.2 -scene_wall_top_velocity 1,0 -n 40\n"
      "\n"
      "  -help             all options of isph; -help petsc adds PETSc's for the chosen solvers\n"
      "  -catalogue        cases, operators, walls, schemes and integrators with their papers\n"
      "  -version          versions of isph and of the libraries it stands on\n",
      out);
}
