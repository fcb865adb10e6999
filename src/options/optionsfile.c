/*
  Options files, checked before PETSc reads them: a mistake ends the run with a line that names the
  file and, unless it is YAML, the line. Each option with its value has a line; # begins a comment;
  values with blanks need double quotes; -options_file includes another file.
*/
#include "optionsfile.h"
#include <ctype.h>
#include <errno.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#define MAX_DEPTH  8 /* files within files */
#define MAX_TOKENS 4 /* examined words of a line */

/* OptionBegins - Returns true if a word begins an option: a dash or two and a letter, but no number
   such as -inf or -e5; not collective */
PetscBool OptionBegins(const char word[])
{
  const char *letter = word + (word[0] == '-' && word[1] == '-' ? 2 : 1);
  char       *end;

  if (word[0] != '-' || !isalpha((unsigned char)*letter)) return PETSC_FALSE;
  (void)strtod(word, &end);
  return end == word || *end == '_' || isalnum((unsigned char)*end) ? PETSC_TRUE : PETSC_FALSE;
}

/* OptionNamesFile - Returns true for options by which PETSc reads another file; not collective */
PetscBool OptionNamesFile(const char option[])
{
  return !strcasecmp(option, "-options_file") || !strcasecmp(option, "-options_file_yaml")
             ? PETSC_TRUE
             : PETSC_FALSE;
}

/*
  OptionsValueCheck - Checks the value of an option that PetscInitialize() reads

  Not collective; to be called before PetscInitialize(), when PETSc prints no errors. Inputs: source
  - beginning of the sentence; value - NULL if there is none. Output: sentence - the mistake;
  unchanged if there is none or if it holds a sentence already
*/
void OptionsValueCheck(const char source[], const char option[], const char value[],
                       char sentence[], size_t length)
{
  PetscBool   flag;
  PetscEnum   known;
  const char *format = value;

  if (sentence[0] || !value) return;
  option += option[1] == '-' ? 2 : 1;
  if (!strcasecmp(option, "skip_petscrc") || !strcasecmp(option, "options_left") ||
      !strcasecmp(option, "options_view")) {
    if (PetscOptionsStringToBool(value, &flag))
      (void)snprintf(sentence, length,
                     "%s-%s %s: allowed are true and false; without a value it is true", source,
                     option, value);
  } else if (!strcasecmp(option, "log_view")) {
    char word[64];

    for (int k = 0; k < 2 && format; k++) { /* type:file:format:mode */
      format = strchr(format, ':');
      if (format) format++;
    }
    if (!format || !*format || *format == ':') return;
    (void)snprintf(word, sizeof(word), "%.*s", (int)strcspn(format, ":"), format);
    if (PetscEnumFind(PetscViewerFormats, word, &known, &flag) || !flag)
      (void)snprintf(sentence, length,
                     "%s-log_view %.200s: unknown format %s; allowed are :file, "
                     ":file:ascii_info_detail, :file:ascii_xml and :file:ascii_flamegraph",
                     source, value, word);
  }
}

/* OptionsNextWord - Cuts the next word off a text as PETSc does: at blanks, but not within double
   quotes that begin a word; returns NULL at the end; not collective */
char *OptionsNextWord(char **text)
{
  const char *ends = " \t";
  char       *word = *text + strspn(*text, ends);

  if (!*word) return NULL;
  if (*word == '"') {
    ends = "\"";
    word++;
  }
  *text = word + strcspn(word, ends);
  if (**text) *(*text)++ = '\0';
  return word;
}

/* Splits a line into words, without its comment. Returns their number, at most MAX_TOKENS. */
static int Split(char line[], char *token[MAX_TOKENS])
{
  int n = 0;

  line[strcspn(line, "#\n\r")] = '\0';
  while (n < MAX_TOKENS && (token[n] = OptionsNextWord(&line))) n++;
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

static void CheckFile(const char option[], const char name[], int depth, char sentence[],
                      size_t length);

/* Checks the files that a YAML text includes, and changes their tags: PETSc cannot include files
   before PetscInitialize(). */
static void CheckIncluded(char text[], int depth, char sentence[], size_t length)
{
  static const char include[] = "!include", ignored[] = "!ignored";

  for (char *tag = strstr(text, include); tag; tag = strstr(tag, include)) {
    char path[PETSC_MAX_PATH_LEN];

    (void)memcpy(tag, ignored, strlen(ignored));
    tag += strlen(ignored);
    tag += strspn(tag, " \t\"'");
    (void)snprintf(path, sizeof(path), "%.*s", (int)strcspn(tag, " \t\r\n\"',}"), tag);
    CheckFile(include, path, depth + 1, sentence, length);
  }
}

/* Checks a YAML text at a depth of inclusion. */
static void CheckYaml(const char name[], char text[], int depth, char sentence[], size_t length)
{
  PetscOptions scratch;

  CheckIncluded(text, depth, sentence, length);
  if (sentence[0] || PetscOptionsCreate(&scratch)) return;
  if (PetscOptionsInsertStringYAML(scratch, text))
    (void)snprintf(sentence, length,
                   "%s: PETSc cannot read it as YAML; each line is 'name: value', names without a "
                   "dash",
                   name);
  (void)PetscOptionsDestroy(&scratch);
}

/*
  OptionsYamlCheck - Checks that PETSc can read a text as YAML, into a database of its own

  Not collective; to be called before PetscInitialize(), when PETSc prints no errors.

  Input: name - source of the text. Output: sentence - the first mistake; unchanged if there is none
*/
void OptionsYamlCheck(const char name[], const char text[], char sentence[], size_t length)
{
  char *copy = strdup(text);

  if (copy) CheckYaml(name, copy, 0, sentence, length);
  free(copy);
}

/* OptionsPrefix - Returns 1 for -prefix_push, -1 for -prefix_pop, 0 for others; not collective */
int OptionsPrefix(const char word[])
{
  return !strncasecmp(word, "-prefix_push", 12) - !strncasecmp(word, "-prefix_pop", 11);
}

/* Checks that a line of a number of bytes has no bytes that no editor shows, and takes back no more
   prefixes of options than the file has set. */
static void CheckPrefix(const char path[], int number, const char line[], size_t bytes,
                        int *prefixes, char sentence[], size_t length)
{
  *prefixes += OptionsPrefix(line + strspn(line, " \t"));
  if (*prefixes < 0)
    (void)snprintf(sentence, length, "%s, line %d: -prefix_pop: there is no -prefix_push before it",
                   path, number);
  if (number == 1 && !strncmp(line, "\xef\xbb\xbf", 3))
    (void)snprintf(sentence, length,
                   "%s, line 1: it begins with a byte order mark; save the file without it", path);
  if (strlen(line) < bytes)
    (void)snprintf(sentence, length, "%s, line %d: it has a null byte; save the file as text", path,
                   number);
}

/* Checks a line of a file. */
static void CheckLine(const char path[], int number, char line[], int depth, char sentence[],
                      size_t length)
{
  char     *token[MAX_TOKENS] = {NULL};
  const int n                 = Split(line, token);

  if (!n) return;
  if (!strcasecmp(token[0], "alias")) {
    if (n != 3 || !OptionBegins(token[1]) || !OptionBegins(token[2]))
      (void)snprintf(sentence, length,
                     "%s, line %d: alias: two options are required, the new name first", path,
                     number);
  } else if (token[0][0] != '-') {
    (void)snprintf(
        sentence, length,
        "%s, line %d: %s: a stray word; options begin with a dash, and a value stands in "
        "the line of its option",
        path, number, token[0]);
  } else if (!OptionBegins(token[0])) {
    (void)snprintf(sentence, length, "%s, line %d: %s: a dash and a letter begin an option", path,
                   number, token[0]);
  } else if ((n > 1 && OptionBegins(token[1])) || (n > 2 && OptionBegins(token[2]))) {
    (void)snprintf(sentence, length,
                   "%s, line %d: %s and %s: each option has a line of its own, with its value",
                   path, number, token[0], OptionBegins(token[1]) ? token[1] : token[2]);
  } else if (n > 2) {
    (void)snprintf(sentence, length,
                   "%s, line %d: %s %s %s: a single value is required; a value with blanks needs "
                   "double quotes",
                   path, number, token[0], token[1], token[2]);
  } else if (OptionsPrefix(token[0]) > 0 && n == 1) {
    (void)snprintf(sentence, length, "%s, line %d: %s: a prefix is required", path, number,
                   token[0]);
  } else if (OptionNamesFile(token[0])) {
    if (n == 1)
      (void)snprintf(sentence, length, "%s, line %d: %s: a file name is required", path, number,
                     token[0]);
    else CheckFile(token[0], token[1], depth + 1, sentence, length);
  } else {
    char source[PETSC_MAX_PATH_LEN + 32];

    (void)snprintf(source, sizeof(source), "%s, line %d: ", path, number);
    OptionsValueCheck(source, token[0], token[1], sentence, length);
  }
}

/* Checks a file at a depth of inclusion; option NULL: PETSc reads the file only if it exists. */
static void CheckFile(const char option[], const char name[], int depth, char sentence[],
                      size_t length)
{
  const size_t n    = strlen(name);
  PetscBool    yaml = n > 5 && !strcmp(name + n - 5, ":yaml") ? PETSC_TRUE : PETSC_FALSE;
  struct stat  status;
  FILE        *file;
  char        *line = NULL, path[PETSC_MAX_PATH_LEN];
  size_t       room = 0;
  ssize_t      bytes;
  int          number = 0, prefixes = 0;

  if (sentence[0] || strstr(name, "${")) return; /* PETSc substitutes it */
  (void)snprintf(path, sizeof(path), "%.*s", (int)(yaml ? n - 5 : n), name);
  if (depth > MAX_DEPTH) {
    (void)snprintf(sentence, length,
                   "%s %s: files are included more than %d deep; does one include itself?", option,
                   path, MAX_DEPTH);
    return;
  }
  if (!stat(path, &status) && !S_ISREG(status.st_mode)) { /* PETSc could not read a pipe again */
    if (option)
      (void)snprintf(sentence, length, "%s %s: %s", option, path,
                     S_ISDIR(status.st_mode) ? strerror(EISDIR) : "it is no regular file");
    return;
  }
  file = fopen(path, "r");
  if (!file) {
    if (option) (void)snprintf(sentence, length, "%s %s: %s", option, path, strerror(errno));
    return;
  }
  if (option && strcasecmp(option, "-options_file")) yaml = PETSC_TRUE;
  if (yaml || IsYaml(path, file)) {
    if (getdelim(&line, &room, '\0', file) > 0) CheckYaml(path, line, depth, sentence, length);
  } else {
    while (!sentence[0] && (bytes = getline(&line, &room, file)) >= 0) {
      CheckPrefix(path, ++number, line, (size_t)bytes, &prefixes, sentence, length);
      if (!sentence[0]) CheckLine(path, number, line, depth, sentence, length);
    }
  }
  free(line);
  (void)fclose(file);
}

/*
  OptionsFileCheck - Checks an options file and its included files

  Not collective; to be called before PetscInitialize().

  Input Parameters:
+ option - option that gives the file; NULL: PETSc reads the file only if it exists
- path   - of the file

  Output: sentence - the first mistake with file and line; unchanged if there is none or if it holds
  a sentence already
*/
void OptionsFileCheck(const char option[], const char path[], char sentence[], size_t length)
{
  CheckFile(option, path, 0, sentence, length);
}
