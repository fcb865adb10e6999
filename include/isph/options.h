/*
  Options: checks of the command line and of options files before PETSc parses them, and requests
  that need no run.
*/
#ifndef ISPH_OPTIONS_H
#define ISPH_OPTIONS_H

#include "isph/base.h"
#include <stdio.h>

/* The request of a command line. */
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
