/* Words and files of options as PETSc reads them; see optionsfile.c. */
#ifndef ISPH_OPTIONS_OPTIONSFILE_H
#define ISPH_OPTIONS_OPTIONSFILE_H

#include "isph/options.h"

PetscBool OptionBegins(const char word[]);
int       OptionsPrefix(const char word[]);
PetscBool OptionNamesFile(const char option[]);
void      OptionsValueCheck(const char source[], const char option[], const char value[],
                            char sentence[], size_t length);
char     *OptionsNextWord(char **text);
void      OptionsYamlCheck(const char name[], const char text[], char sentence[], size_t length);
void      OptionsFileCheck(const char option[], const char path[], char sentence[], size_t length);

#endif
