/* SIGTERM, SIGINT and SIGXCPU (a limit on CPU time): recorded at once, handled between steps. */
#include "impl.h"
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

/*
  InterruptCheck - Checks if a signal has reached any rank

  Collective on PETSC_COMM_WORLD. Output: signal - its name, NULL for none.
*/
PetscErrorCode InterruptCheck(const char **signal)
{
  PetscInt most = (PetscInt)caught;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_INT, MPI_MAX, PETSC_COMM_WORLD));
  *signal = most == 0 ? NULL : most == SIGTERM ? "SIGTERM" : most == SIGINT ? "SIGINT" : "SIGXCPU";
  PetscFunctionReturn(PETSC_SUCCESS);
}
