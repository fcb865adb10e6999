/* Words and files of options; see optionsfile.c. */
#ifndef ISPH_OPTIONS_OPTIONSFILE_H
#define ISPH_OPTIONS_OPTIONSFILE_H

#include "isph/options.h"

/* A place of options: a line of a file, or a list of words. */
typedef struct {
  char source[PETSC_MAX_PATH_LEN + 32]; /* beginning of sentences, "file, line 3: " */
  int  depth;                           /* files that include one another down to this place */
} OptionsPlace;
#define OPTIONS_NO_YAML "YAML is not read; write each option with its value in a line, as -n 16"

PetscBool OptionBegins(const char word[]);
void      OptionsPairCheck(const OptionsPlace *place, const char option[], const char value[],
                           char sentence[], size_t length);
char     *OptionsNextWord(char **text);
void      OptionsFileCheck(const char option[], const char path[], char sentence[], size_t length);

#endif
