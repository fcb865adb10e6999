/* The command line and the environment before PETSc reads them: requests that need no run, and
   words that PETSc would ignore or answer with a traceback. */
#include "optionsfile.h"
#include <stdlib.h>
#include <string.h>

static const char *const LogFormats[] = {":file", ":file:ascii_info_detail", ":file:ascii_xml",
                                         ":file:ascii_flamegraph", NULL};

static const OptionRow options[] = {
    OPTION(WORD, "-help",
           "list all options of isph and end; -help WORD searches them, -help petsc adds PETSc's "
           "for the chosen solvers; also -h and --help",
           NULL, NULL),
    OPTION(NOTHING, "-version",
           "print the versions of isph and of its libraries, and end; also --version", NULL, NULL),
    OPTION(NOTHING, "-catalogue",
           "list all rows that can be chosen by name, with their papers, and end: cases, "
           "operators, walls, schemes, integrators",
           NULL, NULL),
    OPTION(NOTHING, "-options_reference",
           "print the reference page of all options in Markdown, and end", NULL, NULL),
    OPTION(FILE, "-options_file",
           "file with more options, each in a line of its own; # begins a comment; may be given "
           "several times",
           NULL, NULL, .early = PETSC_TRUE),
    OPTION(SWITCH, "-skip_petscrc", "read no options from ~/.petscrc, .petscrc and petscrc", NULL,
           NULL, .where = "the command line", .early = PETSC_TRUE),
    OPTION(SWITCH, "-options_left", "print options that PETSc has not used", NULL, NULL,
           .early = PETSC_TRUE, .late = PETSC_TRUE),
    OPTION(SWITCH, "-options_view", "print all options in force", NULL, NULL, .early = PETSC_TRUE,
           .late = PETSC_TRUE),
    OPTION(VIEWER, "-log_view", "print time and memory of all parts of the run", NULL, NULL,
           .words = LogFormats, .early = PETSC_TRUE, .late = PETSC_TRUE),
};
const OptionTable ProgramOptions = OPTIONS("Program", options);

/* Returns true if a word is an option of this name, with a single or double dash. */
static PetscBool IsOption(const char word[], const char name[])
{
  if (word[0] != '-') return PETSC_FALSE;
  word += word[1] == '-' ? 2 : 1;
  return strcmp(word, name) ? PETSC_FALSE : PETSC_TRUE;
}

/* CommandLineRequest - Determines the request of a command line. Input/Output: argc, argv - a word
   after -help is removed, because PETSc would refuse it; -h and --help become -help. Output: word -
   to be searched for; NULL: none. */
Request CommandLineRequest(int *argc, char **argv, const char **word)
{
  static char help[]  = "-help";
  Request     request = *argc > 1 ? REQUEST_RUN : REQUEST_USAGE;
  int         kept    = 1;

  *word = NULL;

  for (int k = 1; k < *argc; k++) {
    if (IsOption(argv[k], "version")) request = REQUEST_VERSION;
    if (IsOption(argv[k], "options_reference")) request = REQUEST_REFERENCE;
    argv[kept++] = argv[k];
    if (!IsOption(argv[k], "h") && !IsOption(argv[k], "help")) continue;
    argv[kept - 1] = help;
    request        = REQUEST_HELP;
    if (k + 1 == *argc || OptionBegins(argv[k + 1])) continue;
    if (strcmp(argv[++k], "petsc") == 0) request = REQUEST_HELP_PETSC;
    else *word = argv[k];
  }
  argv[kept] = NULL;
  *argc      = kept;
  return request;
}

/* OptionsCheckWords - Checks words as PETSc reads them: an option, its value if there is one, and
   so on; not collective. Output: sentence - the first mistake; unchanged if there is none */
void OptionsCheckWords(const char source[], int n, char *const word[], char sentence[],
                       size_t length)
{
  OptionsPlace place = {.depth = 0};

  (void)snprintf(place.source, sizeof(place.source), "%s", source);
  for (int k = 0; k < n && !sentence[0]; k++) {
    const char *const option = word[k];
    const char *const value  = k + 1 < n && !OptionBegins(word[k + 1]) ? word[k + 1] : NULL;
    const PetscBool   absent = !value || value[0] == '-'; /* as a file */

    if (!OptionBegins(option))
      (void)snprintf(sentence, length,
                     "%s%s: a stray word; options begin with a dash, e.g. -case cavity", source,
                     option);
    else
      OptionsPairCheck(&place, option, absent && OptionNamesFile(option) ? NULL : value, sentence,
                       length);
    if (value) k++;
  }
}

/* Checks the words of the environment variable PETSC_OPTIONS. */
static void CheckEnvironment(char sentence[], size_t length)
{
  const char *const given = getenv("PETSC_OPTIONS");
  char             *text, *rest, **word;
  int               n = 0;

  if (!given) return;
  text = rest = strdup(given);
  word        = calloc(strlen(given) + 1, sizeof(*word));
  while (text && word && (word[n] = OptionsNextWord(&rest))) n++;
  OptionsCheckWords("PETSC_OPTIONS: ", n, word, sentence, length);
  free(word);
  free(text);
}

/* Returns true if the command line asks PETSc to pass over its own files, ~/.petscrc and so on. */
static PetscBool SkipsOwnFiles(int argc, char **argv)
{
  PetscBool skips = PETSC_FALSE;

  for (int k = 1; k < argc; k++) {
    if (!IsOption(argv[k], "skip_petscrc")) continue;
    skips = !(k + 1 < argc && strchr("0fFnN", argv[k + 1][0]));
  }
  return skips;
}

/* OptionsCheck - Checks all options that PETSc will read: of its own files, of the environment, of
   the command line and its options files. To be called before PetscInitialize(), where PETSc reads
   them. Output: sentence - the first mistake; empty if there is none. */
void OptionsCheck(int argc, char **argv, char sentence[], size_t length)
{
  const char *const home = getenv("HOME");
  char              path[PETSC_MAX_PATH_LEN];

  sentence[0] = '\0';
  if (!SkipsOwnFiles(argc, argv)) {
    (void)snprintf(path, sizeof(path), "%s/.petscrc", home ? home : "");
    if (home) OptionsFileCheck(NULL, path, sentence, length);
    OptionsFileCheck(NULL, ".petscrc", sentence, length);
    OptionsFileCheck(NULL, "petscrc", sentence, length);
  }
  if (!sentence[0]) CheckEnvironment(sentence, length);
  if (!sentence[0] && getenv("PETSC_OPTIONS_YAML"))
    (void)snprintf(sentence, length, "PETSC_OPTIONS_YAML: " OPTIONS_NO_YAML);
  if (!sentence[0]) OptionsCheckWords("", argc - 1, argv + 1, sentence, length);
}
