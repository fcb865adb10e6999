/*
  The memory of a run: numbers that steps keep for later steps, registered by name. Undo,
  checkpoints and restarts loop over them, so that a new number needs a single line of code.
*/
#include "isph/time.h"

static PetscErrorCode MemoryAdd(Memory *memory, const char name[], MemoryItem item)
{
  PetscFunctionBegin;
  PetscCheck(memory->n < MEMORY_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "%s is one more than MEMORY_MAX = %d", name, MEMORY_MAX);
  PetscCall(PetscStrncpy(item.name, name, sizeof(item.name)));
  memory->item[memory->n++] = item;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  MemoryAddReal - Adds a real number to the memory

  Not collective; all ranks add the same numbers in the same order. Input: name - unique, at most 31
  letters; value - address of the number, valid as long as the memory.
*/
PetscErrorCode MemoryAddReal(Memory *memory, const char name[], PetscReal *value)
{
  PetscFunctionBegin;
  PetscCall(MemoryAdd(memory, name, (MemoryItem){.real = value}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryAddInt - Adds a whole number below 2^53 to the memory; see MemoryAddReal() */
PetscErrorCode MemoryAddInt(Memory *memory, const char name[], PetscInt *value)
{
  PetscFunctionBegin;
  PetscCall(MemoryAdd(memory, name, (MemoryItem){.integer = value}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryAddCounter - Adds a whole number that undo does not restore; see MemoryAddInt() */
PetscErrorCode MemoryAddCounter(Memory *memory, const char name[], PetscInt *value)
{
  PetscFunctionBegin;
  PetscCall(MemoryAdd(memory, name, (MemoryItem){.integer = value, .counter = PETSC_TRUE}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MemoryGet - Copies all memory->n numbers to an array; not collective */
void MemoryGet(const Memory *memory, PetscReal values[])
{
  for (PetscInt k = 0; k < memory->n; k++) {
    const MemoryItem *item = &memory->item[k];

    values[k] = item->real ? *item->real : (PetscReal)*item->integer;
  }
}

/* MemoryFits - Determines if numbers of a file can be set: whole numbers must be whole and within
   their range, others above minus infinity; not collective. Infinity stands for an unknown. */
PetscBool MemoryFits(const Memory *memory, const PetscReal values[])
{
  for (PetscInt k = 0; k < memory->n; k++) {
    if (memory->item[k].real) {
      if (!(values[k] > PETSC_NINFINITY)) return PETSC_FALSE;
      continue;
    }
    if (!(PetscAbsReal(values[k]) < (PetscReal)PETSC_INT_MAX)) return PETSC_FALSE;
    if (values[k] != PetscFloorReal(values[k])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* MemorySet - Sets all numbers from a copy, but counters only if the flag `counters` is set; not
   collective */
void MemorySet(const Memory *memory, PetscBool counters, const PetscReal values[])
{
  for (PetscInt k = 0; k < memory->n; k++) {
    const MemoryItem *item = &memory->item[k];

    if (item->counter && !counters) continue;
    if (item->real) *item->real = values[k];
    else *item->integer = (PetscInt)values[k];
  }
}
