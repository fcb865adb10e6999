/*
  Options files: a check line by line, so that messages name file and line, before PETSc would
  answer a mistake with a traceback. Each option with its value has a line; # begins a comment;
  values with blanks need quotes; -options_file includes another file.
*/
#include "isph/options.h"
#include <ctype.h>
#include <errno.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#define MAX_DEPTH  8 /* files within files */
#define MAX_TOKENS 4 /* examined words of a line */

/* Returns true if a word begins an option: a dash or two and a letter, but no number such as -inf
   or -e5. */
static PetscBool IsOption(const char word[])
{
  const char *letter = word + (word[0] == '-' && word[1] == '-' ? 2 : 1);
  char       *end;

  if (word[0] != '-' || !isalpha((unsigned char)*letter)) return PETSC_FALSE;
  (void)strtod(word, &end);
  return end == word || *end == '_' || isalnum((unsigned char)*end) ? PETSC_TRUE : PETSC_FALSE;
}

/* Splits a line as PETSc does: at blanks, but not within quotes that begin a word. Returns the
   number of words, at most MAX_TOKENS. */
static int Split(char line[], char *token[MAX_TOKENS])
{
  int n = 0;

  line[strcspn(line, "#\n\r")] = '\0';
  while (n < MAX_TOKENS) {
    const char *ends = " \t";

    line += strspn(line, " \t");
    if (!*line) break;
    if (*line == '"' || *line == '\'') ends = *line++ == '"' ? "\"" : "'";
    token[n++] = line;
    line += strcspn(line, ends);
    if (*line) *line++ = '\0';
  }
  return n;
}

/* Returns true if PETSc would read a file as YAML, by its name or its first letters. */
static PetscBool IsYaml(const char path[], FILE *file)
{
  const char *const endings[] = {".yaml", ".yml", ".json"};
  char              first[7]  = "";
  const size_t      length    = strlen(path);

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(endings); k++) {
    const size_t n = strlen(endings[k]);

    if (length >= n && !strcmp(path + length - n, endings[k])) return PETSC_TRUE;
  }
  if (!fgets(first, (int)sizeof(first), file)) first[0] = '\0';
  rewind(file);
  return !strncmp(first, "%YAML ", 6) || !strncmp(first, "---", 3) ? PETSC_TRUE : PETSC_FALSE;
}

static void CheckFile(const char path[], int depth, char sentence[], size_t length);

/* Checks a line of a file. */
static void CheckLine(const char path[], int number, char line[], int depth, char sentence[],
                      size_t length)
{
  char     *token[MAX_TOKENS] = {NULL};
  const int n                 = Split(line, token);

  if (!n || !strcasecmp(token[0], "alias")) return;
  if (token[0][0] != '-') {
    (void)snprintf(
        sentence, length,
        "%s, line %d: %s: a stray word; options begin with a dash, and a value stands in "
        "the line of its option",
        path, number, token[0]);
  } else if (!IsOption(token[0])) {
    (void)snprintf(sentence, length, "%s, line %d: %s: a dash and a letter begin an option", path,
                   number, token[0]);
  } else if ((n > 1 && IsOption(token[1])) || (n > 2 && IsOption(token[2]))) {
    (void)snprintf(sentence, length,
                   "%s, line %d: %s and %s: each option has a line of its own, with its value",
                   path, number, token[0], IsOption(token[1]) ? token[1] : token[2]);
  } else if (n > 2) {
    (void)snprintf(
        sentence, length,
        "%s, line %d: %s %s %s: a single value is required; a value with blanks needs quotes", path,
        number, token[0], token[1], token[2]);
  } else if (!strcasecmp(token[0], "-options_file")) {
    if (n == 1)
      (void)snprintf(sentence, length, "%s, line %d: -options_file: a file name is required", path,
                     number);
    else CheckFile(token[1], depth + 1, sentence, length);
  }
}

/* Checks a file included at a depth of inclusion. */
static void CheckFile(const char path[], int depth, char sentence[], size_t length)
{
  struct stat status;
  FILE       *file;
  char       *line   = NULL;
  size_t      room   = 0;
  int         number = 0;

  if (strstr(path, "${")) return; /* PETSc substitutes it */
  if (depth > MAX_DEPTH) {
    (void)snprintf(
        sentence, length,
        "-options_file %s: files are included more than %d deep; does one include itself?", path,
        MAX_DEPTH);
    return;
  }
  file = fopen(path, "r");
  if (!file) {
    const char *colon = strrchr(path, ':');

    if (!colon || strcmp(colon, ":yaml"))
      (void)snprintf(sentence, length, "-options_file %s: %s", path, strerror(errno));
    return;
  }
  if (!fstat(fileno(file), &status) && S_ISDIR(status.st_mode))
    (void)snprintf(sentence, length, "-options_file %s: %s", path, strerror(EISDIR));
  else if (!IsYaml(path, file)) {
    while (!sentence[0] && getline(&line, &room, file) >= 0)
      CheckLine(path, ++number, line, depth, sentence, length);
  }
  free(line);
  (void)fclose(file);
}

/*
  OptionsFileCheck - Checks an options file and its included files

  Not collective. Files that PETSc would read as YAML are not checked. Output: sentence - the first
  mistake with file and line; unchanged if there is none
*/
void OptionsFileCheck(const char path[], char sentence[], size_t length)
{
  CheckFile(path, 0, sentence, length);
}
