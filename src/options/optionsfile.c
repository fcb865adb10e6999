/* Options files, checked before PETSc reads them: a mistake ends the run with a line that names the
   file and the line. Each option with its value has a line; # begins a comment; values with blanks
   need double quotes; -options_file includes another file. YAML, prefixes, aliases and names of
   variables, which PETSc would read too, are refused. */
#include "optionsfile.h"
#include <ctype.h>
#include <errno.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#define MAX_DEPTH  8 /* files within files */
#define DEEP       "files are included more than 8 deep; does one include itself?"
#define MAX_TOKENS 4 /* examined words of a line */

/* OptionBegins - Returns true if a word begins an option: a dash or two and a letter, but no number
   such as -inf or -e5 */
PetscBool OptionBegins(const char word[])
{
  const char *letter = word + (word[0] == '-' && word[1] == '-' ? 2 : 1);
  char       *end;

  if (word[0] != '-' || !isalpha((unsigned char)*letter)) return PETSC_FALSE;
  (void)strtod(word, &end);
  return end == word || *end == '_' || isalnum((unsigned char)*end);
}

/* OptionNamesFile - Returns true for options by which PETSc reads another file */
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
   quotes that begin a word; returns NULL at the end */
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
  const char *const endings[] = {".yaml", ".yml", ".json", ":yaml"};
  char              first[7]  = "";
  const size_t      length    = strlen(path);

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(endings); k++) {
    const size_t n = strlen(endings[k]);

    if (length >= n && !strcmp(path + length - n, endings[k])) return PETSC_TRUE;
  }
  if (!file) return PETSC_FALSE;
  if (!fgets(first, (int)sizeof(first), file)) first[0] = '\0';
  rewind(file);
  return !strncmp(first, "%YAML ", 6) || !strncmp(first, "---", 3);
}

static void CheckFile(const char option[], const char path[], int depth, char sentence[],
                      size_t length);

/* OptionsPairCheck - Checks an option and its value. To be called before PetscInitialize(). Input:
   value - NULL if there is none. Output: sentence - the mistake; unchanged if there is none. */
void OptionsPairCheck(const OptionsPlace *place, const char option[], const char value[],
                      char sentence[], size_t length)
{
  const char *const source = place->source;

  if (!strcasecmp(option, "-options_file_yaml"))
    (void)snprintf(sentence, length, "%s%s: " OPTIONS_NO_YAML, source, option);
  else if (!strncasecmp(option, "-prefix_p", 9))
    (void)snprintf(sentence, length, "%s%s: there are no prefixes; write whole names", source,
                   option);
  else if (OptionNamesFile(option) && !value)
    (void)snprintf(sentence, length, "%s%s: a file name is required", source, option);
  else if (OptionNamesFile(option)) CheckFile(option, value, place->depth, sentence, length);
  else CheckValue(source, option, value, sentence, length);
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
static void CheckLine(const OptionsPlace *place, char line[], char sentence[], size_t length)
{
  const char *const source            = place->source;
  char             *token[MAX_TOKENS] = {NULL};
  const int         n                 = Split(line, token);

  if (!n) return;
  if (token[0][0] != '-') {
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

/* Checks a file at a depth of inclusion; option NULL: PETSc reads the file only if it exists. */
static void CheckFile(const char option[], const char path[], int depth, char sentence[],
                      size_t length)
{
  struct stat status;
  FILE       *file;
  const char *fault = NULL;

  if (sentence[0] || (!option && strstr(path, "${"))) return;
  if (strstr(path, "${")) fault = "${NAME} is not replaced by a value; type the path";
  else if (IsYaml(path, NULL)) fault = OPTIONS_NO_YAML;
  else if (depth > MAX_DEPTH) fault = DEEP;
  else if (!stat(path, &status) && !S_ISREG(status.st_mode)) /* PETSc could not read a pipe again */
    fault = S_ISDIR(status.st_mode) ? strerror(EISDIR) : "it is no regular file";
  file = fault ? NULL : fopen(path, "r");
  if (!fault && !file) fault = strerror(errno);
  if (file && IsYaml(path, file)) fault = OPTIONS_NO_YAML;
  if (fault && (option || file))
    (void)snprintf(sentence, length, "%s%s%s: %s", option ? option : "", option ? " " : "", path,
                   fault);
  if (file && !fault) CheckLines(path, file, depth, sentence, length);
  if (file) (void)fclose(file);
}

/* OptionsFileCheck - Checks an options file and its included files. To be called before
   PetscInitialize(). Input: option - option that gives the file; NULL: PETSc reads the file only if
   it exists; path - of the file. Output: sentence - the first mistake with file and line; unchanged
   if there is none or if it holds a sentence already. */
void OptionsFileCheck(const char option[], const char path[], char sentence[], size_t length)
{
  CheckFile(option, path, 0, sentence, length);
}
