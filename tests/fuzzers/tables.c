/* Fuzzer of the readers of CSV files: reference data, and the files of monitors in a restart. The
   first byte chooses the reader. */
#include "fuzzer.h"
#include "measures/monitors.h"
#include <stdlib.h>

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  FuzzerStart();
  (void)setenv("ISPH_DATA", ".", 1);
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  FuzzerInput input = {data, size};

  if (FuzzerByte(&input) % 2) {
    Monitor monitor = {.on = PETSC_TRUE, .n = 1, .path = "monitor.csv"};

    FuzzerWrite(monitor.path, input.next, input.left);
    if (MonitorGoOn(&MonitorPoints, 0.5, &monitor)) abort();
    if (monitor.stream) (void)fclose(monitor.stream);
  } else {
    Report        report = {.n = 0};
    ReferenceData curve  = {.n = 0};

    FuzzerWrite("reference.csv", input.next, input.left);
    (void)ReferenceDataRead("reference.csv", &report, &curve);
    if (ReferenceDataFree(&curve)) abort();
  }
  return 0;
}
