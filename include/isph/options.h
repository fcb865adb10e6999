/*
  Options: the command line and its files, checked before PETSc parses them, and the requests that
  are answered without a run.
*/
#ifndef ISPH_OPTIONS_H
#define ISPH_OPTIONS_H

#include "isph/base.h"
#include <stdio.h>

/* What a command line asks for. */
typedef enum {
  REQUEST_RUN,
  REQUEST_USAGE,      /* no option at all */
  REQUEST_HELP,       /* -h, -help, --help */
  REQUEST_HELP_PETSC, /* -help petsc */
  REQUEST_VERSION     /* -version, --version */
} Request;

Request     CommandLineRequest(int *argc, char **argv);
void        CommandLineCheck(int argc, char **argv, char sentence[], size_t length);
void        OptionsFileCheck(const char path[], char sentence[], size_t length);
void        UsagePrint(FILE *out);
void        VersionPrint(FILE *out);
const char *VersionCommit(void);

#endif
