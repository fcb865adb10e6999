/* The memory of a run, predicted before its particles exist: the memory of the program so far, and
   for each fluid particle the figure of results/memory.md, of which a share grows with the number
   of neighbours. Runs that their machines cannot hold are refused. */
#include "isph/io.h"
#include <stdio.h>
#include <unistd.h>

#define RADIUS 3.0 /* of the measured supports [dx] */
#define SHARE  0.4 /* of the memory, in proportion to the number of neighbours [-] */
#define ERROR  1.3 /* of the prediction, a factor; runs beyond it do not fit */

/* Returns the predicted memory of a fluid particle [bytes]. */
static PetscReal ParticleBytes(const Flow *flow)
{
  const Scene     *scene = flow->scene;
  const Operators *ops   = flow->ops;
  const PetscReal  more  = PetscPowRealInt(ops->forms.radius / (RADIUS * scene->dx), scene->dim);
  MemoryKind       kind  = MEMORY_FIXED;

  if (ops->cut_surface) kind = MEMORY_FREE;
  else if (SceneMoves(scene)) kind = MEMORY_MOVING;
  else if (ops->rows.repeats && scene->jitter == 0.0 && !SceneIsGraded(scene)) kind = MEMORY_EVEN;
  return 1e3 * flow->scheme->row->memory[scene->dim - 2][kind] * (1.0 - SHARE + SHARE * more);
}

/* Lowers the memory of the machine to the limit of a control group, if its file exists. */
static void LimitByGroup(const char path[], PetscReal *bytes)
{
  FILE  *file = fopen(path, "r");
  double most;

  if (!file) return;
  if (fscanf(file, "%lf", &most) == 1) *bytes = PetscMin(*bytes, (PetscReal)most);
  (void)fclose(file);
}

/* Returns the memory of this machine, or what a container may use of it [bytes]. */
static PetscReal MachineBytes(void)
{
  PetscReal bytes = (PetscReal)sysconf(_SC_PHYS_PAGES) * (PetscReal)sysconf(_SC_PAGE_SIZE);

  LimitByGroup("/sys/fs/cgroup/memory.max", &bytes);
  LimitByGroup("/sys/fs/cgroup/memory/memory.limit_in_bytes", &bytes);
  return bytes;
}

/* Predicts the memory of the ranks of a run on each machine. Collective. */
static PetscErrorCode Expect(const Flow *flow, PetscReal particles, MachineMemory *need)
{
  PetscLogDouble used;
  PetscMPIInt    ranks, here;
  MPI_Comm       machine;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCallMPI(
      MPI_Comm_split_type(PETSC_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  PetscCallMPI(MPI_Comm_size(machine, &here));
  PetscCallMPI(MPI_Comm_free(&machine));
  PetscCall(PetscMemoryGetCurrentUsage(&used));
  need->particle = ParticleBytes(flow);
  need->run      = here * ((PetscReal)used + particles * need->particle / ranks);
  need->machine  = MachineBytes();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &need->run, 1, MPIU_REAL, MPIU_MAX, PETSC_COMM_WORLD));
  PetscCallMPI(
      MPI_Allreduce(MPI_IN_PLACE, &need->machine, 1, MPIU_REAL, MPIU_MIN, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* MachineMemoryCheck - Predicts the memory of a run, and refuses one that needs more than a machine
   has. Collective on PETSC_COMM_WORLD. Called before particles exist. Input: particles - number of
   fluid particles at the start. */
PetscErrorCode MachineMemoryCheck(const Flow *flow, PetscReal particles, MachineMemory *need)
{
  const Scene *scene = flow->scene;

  PetscFunctionBegin;
  PetscCall(Expect(flow, particles, need));
  UserCheck(
      need->run < ERROR * need->machine,
      "-n %" PetscInt_FMT ": %.3g particles need %.3g GB of memory, %.3g kB each, and the "
      "machine has %.3g GB; use at most -n %.0f, or more machines",
      scene->n, (double)particles, (double)(1e-9 * need->run), (double)(1e-3 * need->particle),
      (double)(1e-9 * need->machine),
      (double)PetscFloorReal(scene->n * PetscPowReal(need->machine / need->run, 1.0 / scene->dim)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
