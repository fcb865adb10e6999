/* The common part of the fuzzers: the start of PETSc, its error handler, and input that is read in
   bytes. */
#ifndef FUZZER_H
#define FUZZER_H

#include "isph/base.h"
#include <stdint.h>
#include <stdio.h>

/* Bytes of an input that are not used yet. */
typedef struct {
  const uint8_t *next;
  size_t         left;
} FuzzerInput;

void     FuzzerStart(void);
void     FuzzerAssert(PetscBool holds, const char sentence[]);
unsigned FuzzerByte(FuzzerInput *input);
size_t   FuzzerBytes(FuzzerInput *input, size_t n, void *bytes);
char    *FuzzerText(FuzzerInput *input, size_t most);
void     FuzzerWrite(const char path[], const void *bytes, size_t n);

/* Functions that libFuzzer calls. */
int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif
