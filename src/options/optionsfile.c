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
  return end == word || *end == '_' || isalnum((unsigned char)*end);
}

/* OptionNamesFile - Returns true for options by which PETSc reads another file; not collective */
PetscBool OptionNamesFile(const char option[])
{
  const OptionRow *row = OptionFind(option);

  return row && row->early && row->kind == VALUE_FILE;
}

/* Checks the format in a viewer, as "type:file:format:mode". */
static void CheckFormat(const char source[], const OptionRow *row, const char value[],
                        char sentence[], size_t length)
{
  const char *format = value;
  char        word[64], all[256] = "";
  PetscEnum   known;
  PetscBool   found;

  for (int k = 0; k < 2 && format; k++) {
    format = strchr(format, ':');
    if (format) format++;
  }
  if (!format || !*format || *format == ':') return;
  (void)snprintf(word, sizeof(word), "%.*s", (int)strcspn(format, ":"), format);
  for (PetscInt k = 0; row->words[k]; k++) AppendWord(all, sizeof(all), row->words[k]);
  if (PetscEnumFind(PetscViewerFormats, word, &known, &found) || !found)
    (void)snprintf(sentence, length, "%s%s %.200s: unknown format %s; allowed are %s", source,
                   row->name, value, word, all);
}

/* Checks the value of an option before PetscInitialize(), when PETSc prints no errors. Options with
   two dashes are the same options. */
static void CheckValue(const char source[], const char option[], const char value[],
                       char sentence[], size_t length)
{
  const char *const name = option[1] == '-' ? option + 1 : option;
  const OptionRow  *row  = OptionFind(name);
  PetscBool         flag;

  if (!value || !row || !row->early) return;
  if (row->kind == VALUE_SWITCH && PetscOptionsStringToBool(value, &flag))
    (void)snprintf(sentence, length,
                   "%s%s %s: allowed are true and false; without a value it is true", source, name,
                   value);
  if (row->kind == VALUE_VIEWER) CheckFormat(source, row, value, sentence, length);
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

/* Splits a line into words, without its comment. Returns their number, at most MAX_TOKENS. As in
   PETSc, a carriage return is a blank and ends no line. */
static int Split(char line[], char *token[MAX_TOKENS])
{
  int n = 0;

  line[strcspn(line, "#\n")] = '\0';
  for (char *c = strchr(line, '\r'); c; c = strchr(c, '\r')) *c = ' ';
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
  return !strncmp(first, "%YAML ", 6) || !strncmp(first, "---", 3);
}

/* Returns 1 for -prefix_push, -1 for -prefix_pop, 0 for others. */
static int Prefix(const char word[])
{
  return !strncasecmp(word, "-prefix_push", 12) - !strncasecmp(word, "-prefix_pop", 11);
}

static void CheckFile(const char option[], const char name[], int depth, char sentence[],
                      size_t length);

/*
  OptionsPairCheck - Checks an option and its value

  Not collective; to be called before PetscInitialize(). Input: value - NULL if there is none.
  Input/Output: place - counts the prefixes. Output: sentence - the mistake; unchanged if there is
  none
*/
void OptionsPairCheck(OptionsPlace *place, const char option[], const char value[], char sentence[],
                      size_t length)
{
  const char *const source = place->source;

  place->prefixes += Prefix(option);
  if (place->prefixes < 0)
    (void)snprintf(sentence, length, "%s%s: there is no -prefix_push before it", source, option);
  else if (Prefix(option) > 0 && !value)
    (void)snprintf(sentence, length, "%s%s: a prefix is required", source, option);
  else if (OptionNamesFile(option) && !value)
    (void)snprintf(sentence, length, "%s%s: a file name is required", source, option);
  else if (OptionNamesFile(option)) CheckFile(option, value, place->depth, sentence, length);
  else CheckValue(source, option, value, sentence, length);
}

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

/* Checks that a line of a number of bytes has no bytes that no editor shows. */
static void CheckBytes(const OptionsPlace *place, const char line[], size_t bytes, PetscBool first,
                       char sentence[], size_t length)
{
  if (first && !strncmp(line, "\xef\xbb\xbf", 3))
    (void)snprintf(sentence, length, "%sit begins with a byte order mark; save the file without it",
                   place->source);
  if (strlen(line) < bytes)
    (void)snprintf(sentence, length, "%sit has a null byte; save the file as text", place->source);
}

/* Checks a line of a file. */
static void CheckLine(OptionsPlace *place, char line[], char sentence[], size_t length)
{
  const char *const source            = place->source;
  char             *token[MAX_TOKENS] = {NULL};
  const int         n                 = Split(line, token);

  if (!n) return;
  if (!strcasecmp(token[0], "alias")) {
    if (n != 3 || !OptionBegins(token[1]) || !OptionBegins(token[2]))
      (void)snprintf(sentence, length, "%salias: two options are required, the new name first",
                     source);
  } else if (token[0][0] != '-') {
    (void)snprintf(
        sentence, length,
        "%s%s: a stray word; options begin with a dash, and a value stands in the line of its "
        "option",
        source, token[0]);
  } else if (!OptionBegins(token[0])) {
    (void)snprintf(sentence, length, "%s%s: a dash and a letter begin an option", source, token[0]);
  } else if ((n > 1 && OptionBegins(token[1])) || (n > 2 && OptionBegins(token[2]))) {
    (void)snprintf(sentence, length,
                   "%s%s and %s: each option has a line of its own, with its value", source,
                   token[0], OptionBegins(token[1]) ? token[1] : token[2]);
  } else if (n > 2) {
    (void)snprintf(sentence, length,
                   "%s%s %s %s: a single value is required; a value with blanks needs double "
                   "quotes",
                   source, token[0], token[1], token[2]);
  } else {
    OptionsPairCheck(place, token[0], token[1], sentence, length);
  }
}

/* Checks the lines of a file at a depth of inclusion. */
static void CheckLines(const char path[], FILE *file, int depth, char sentence[], size_t length)
{
  OptionsPlace place = {.depth = depth + 1};
  char        *line  = NULL;
  size_t       room  = 0;
  ssize_t      bytes;

  for (int k = 1; !sentence[0] && (bytes = getline(&line, &room, file)) >= 0; k++) {
    (void)snprintf(place.source, sizeof(place.source), "%s, line %d: ", path, k);
    CheckBytes(&place, line, (size_t)bytes, k == 1, sentence, length);
    if (!sentence[0]) CheckLine(&place, line, sentence, length);
  }
  free(line);
}

/* Copies the folder of PETSc. */
static PetscErrorCode GetFolder(char value[], size_t length)
{
  const char *folder;

  if (PetscGetPetscDir(&folder)) return PETSC_ERR_LIB;
  return PetscStrncpy(value, folder, length);
}

/* Copies the folder of PETSc's library, which the environment may change. */
static PetscErrorCode GetLibraryFolder(char value[], size_t length)
{
  const char *given = getenv("PETSC_LIB_DIR");

  return PetscStrncpy(value, given ? given : PETSC_LIB_DIR, length);
}

/* Names that PETSc itself replaces, as PetscStrreplace() does, which needs PetscInitialize(). */
static const struct {
  const char *name;
  PetscErrorCode (*Get)(char value[], size_t length);
} own_names[] = {
    {"PETSC_ARCH", PetscGetArchType},         {"PETSC_DIR", GetFolder},
    {"PETSC_LIB_DIR", GetLibraryFolder},      {"DISPLAY", PetscGetDisplay},
    {"HOMEDIRECTORY", PetscGetHomeDirectory}, {"WORKINGDIRECTORY", PetscGetWorkingDirectory},
    {"USERNAME", PetscGetUserName},           {"HOSTNAME", PetscGetHostName},
};

/* Copies the value of a name: PETSc's own, or an environment variable. Returns false if it has
   none. */
static PetscBool FindValue(const char name[], char value[], size_t length)
{
  const char *given = getenv(name);

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(own_names); k++) {
    if (!strcmp(name, own_names[k].name))
      return own_names[k].Get(value, length) ? PETSC_FALSE : PETSC_TRUE;
  }
  (void)snprintf(value, length, "%s", given ? given : "");
  return given ? PETSC_TRUE : PETSC_FALSE;
}

/* Replaces ${NAME} in the name of a file by its value, as PETSc does. Returns false if there is a
   mistake. */
static PetscBool Substitute(const char option[], const char name[], char path[PETSC_MAX_PATH_LEN],
                            char sentence[], size_t length)
{
  (void)snprintf(path, PETSC_MAX_PATH_LEN, "%s", name);
  for (char *open = strstr(path, "${"); open; open = strstr(path, "${")) {
    char     *close = strchr(open, '}'), value[PETSC_MAX_PATH_LEN], rest[PETSC_MAX_PATH_LEN];
    PetscBool found = PETSC_FALSE;

    if (close) *close = '\0';
    if (close) found = FindValue(open + 2, value, sizeof(value));
    if (!found || strstr(value, "${")) {
      (void)snprintf(sentence, length,
                     "%s %s: ${NAME} stands for an environment variable, which must be set", option,
                     name);
      return PETSC_FALSE;
    }
    (void)snprintf(rest, sizeof(rest), "%s", close + 1);
    (void)snprintf(open, PETSC_MAX_PATH_LEN - (size_t)(open - path), "%s%s", value, rest);
  }
  return PETSC_TRUE;
}

/* Checks a file at a depth of inclusion; option NULL: PETSc reads the file only if it exists. */
static void CheckFile(const char option[], const char name[], int depth, char sentence[],
                      size_t length)
{
  size_t      n;
  PetscBool   yaml;
  struct stat status;
  FILE       *file;
  char       *text = NULL, path[PETSC_MAX_PATH_LEN];
  size_t      room = 0;

  if (sentence[0] || (!option && strstr(name, "${"))) return;
  if (!Substitute(option, name, path, sentence, length)) return;
  n    = strlen(path);
  yaml = n > 5 && !strcmp(path + n - 5, ":yaml");
  if (yaml) path[n - 5] = '\0';
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
    if (getdelim(&text, &room, '\0', file) > 0) CheckYaml(path, text, depth, sentence, length);
    free(text);
  } else {
    CheckLines(path, file, depth, sentence, length);
  }
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
