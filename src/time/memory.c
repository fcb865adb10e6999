/* The memory of a run: numbers that steps keep for later steps, registered by name. Undo,
   checkpoints and restarts loop over them, so that a new number needs a single line of code. */
#include "isph/time.h"

static PetscErrorCode MemoryAdd(Memory *memory, const char name[], MemoryItem item)
{
  PetscFunctionBegin;
  PetscCheck(memory->n < MEMORY_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%s is one more than MEMORY_MAX = %d", name, MEMORY_MAX);
  PetscCall(PetscStrncpy(item.name, name, sizeof(item.name)));
  memory->item[memory->n++] = item;
  memory->size += item.count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryAddReal - Adds a real number to the memory. All ranks add the same numbers in the same
   order. Input: name - unique, at most 31 letters; value - address of the number, valid as long as
   the memory. */
PetscErrorCode MemoryAddReal(Memory *memory, const char name[], PetscReal *value)
{
  PetscFunctionBegin;
  PetscCall(MemoryAddReals(memory, name, 1, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryAddReals - Adds an array of real numbers under one name to the memory; see
   MemoryAddReal() */
PetscErrorCode MemoryAddReals(Memory *memory, const char name[], PetscInt count, PetscReal values[])
{
  PetscFunctionBegin;
  PetscCall(MemoryAdd(memory, name, (MemoryItem){.real = values, .count = count}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryAddInt - Adds a whole number below 2^53 to the memory; see MemoryAddReal() */
PetscErrorCode MemoryAddInt(Memory *memory, const char name[], PetscInt *value)
{
  PetscFunctionBegin;
  PetscCall(MemoryAdd(memory, name, (MemoryItem){.integer = value, .count = 1}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryAddCounter - Adds a whole number that undo does not restore; see MemoryAddInt() */
PetscErrorCode MemoryAddCounter(Memory *memory, const char name[], PetscInt *value)
{
  PetscFunctionBegin;
  PetscCall(
      MemoryAdd(memory, name, (MemoryItem){.integer = value, .count = 1, .counter = PETSC_TRUE}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryGet - Copies all memory->size numbers to an array */
void MemoryGet(const Memory *memory, PetscReal values[])
{
  for (PetscInt k = 0; k < memory->n; k++) {
    const MemoryItem *item = &memory->item[k];

    for (PetscInt i = 0; i < item->count; i++)
      *values++ = item->real ? item->real[i] : (PetscReal)*item->integer;
  }
}

/* MemoryFits - Determines if numbers of a file can be set: whole numbers must be whole and within
   their range, others above minus infinity. Infinity stands for an unknown. */
PetscBool MemoryFits(const Memory *memory, const PetscReal values[])
{
  for (PetscInt k = 0; k < memory->n; values += memory->item[k++].count) {
    for (PetscInt i = 0; memory->item[k].real && i < memory->item[k].count; i++)
      if (!(values[i] > PETSC_NINFINITY)) return PETSC_FALSE;
    if (memory->item[k].real) continue;
    if (!(PetscAbsReal(values[0]) < (PetscReal)PETSC_INT_MAX)) return PETSC_FALSE;
    if (values[0] != PetscFloorReal(values[0])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* MemorySet - Sets all numbers from a copy, but counters only if the flag `counters` is set */
void MemorySet(const Memory *memory, PetscBool counters, const PetscReal values[])
{
  for (PetscInt k = 0; k < memory->n; values += memory->item[k++].count) {
    const MemoryItem *item = &memory->item[k];

    if (item->counter && !counters) continue;
    for (PetscInt i = 0; item->real && i < item->count; i++) item->real[i] = values[i];
    if (item->integer) *item->integer = (PetscInt)values[0];
  }
}
