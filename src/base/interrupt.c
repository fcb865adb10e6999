/* SIGTERM, SIGINT and SIGXCPU (a limit on CPU time): recorded at once, handled between steps, and
   between the solves of a steady flow. */
#include "isph/base.h"
#include <signal.h>

static volatile sig_atomic_t caught; /* signal, 0: none; global: a handler has no context */

static void Interrupt_Handler(int signal)
{
  caught = signal;
}

/* InterruptInstall - Installs the handlers of the signals; not collective */
PetscErrorCode InterruptInstall(void)
{
  PetscFunctionBegin;
  caught = 0;
  (void)signal(SIGTERM, Interrupt_Handler);
  (void)signal(SIGINT, Interrupt_Handler);
  (void)signal(SIGXCPU, Interrupt_Handler);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* InterruptCheck - Checks if a signal has reached any rank. Collective on PETSC_COMM_WORLD. Output:
   signal - its number, 0 for none. */
PetscErrorCode InterruptCheck(PetscMPIInt *signal)
{
  PetscFunctionBegin;
  *signal = (PetscMPIInt)caught;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, signal, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* InterruptName - Returns the name of a signal that InterruptCheck() found; not collective */
const char *InterruptName(PetscMPIInt signal)
{
  return signal == SIGTERM ? "SIGTERM" : signal == SIGINT ? "SIGINT" : "SIGXCPU";
}
