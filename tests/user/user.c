/* Drives the lid of a cavity by a function of its own, and prints the force on the lid. */
#include <isph.h>
#include <stdio.h>

/* The speed of the lid at x and t: it starts smoothly, and is zero in the corners. */
static PetscReal Lid(PetscInt n, const PetscReal argument[], void *ctx)
{
  const PetscReal x = argument[0], t = argument[1], ramp = *(PetscReal *)ctx;

  return 16.0 * PetscSqr(x * (1.0 - x)) * PetscMin(t / ramp, 1.0);
}

static PetscErrorCode Run(IsphFlow flow, int argc, char *argv[], PetscReal *ramp)
{
  PetscReal force[3], torque[3], error[2];

  PetscCall(IsphFlowSetFunction(flow, "lid", Lid, ramp));
  PetscCall(IsphFlowSetOption(flow, "-case", "scene"));
  PetscCall(IsphFlowSetOption(flow, "-scene_wall_top_velocity", "lid(x, t), 0"));
  PetscCall(IsphFlowSetOptions(flow, argc - 1, argv + 1));
  PetscCall(IsphFlowSetUp(flow));
  PetscCall(IsphFlowRun(flow, 0.2));
  PetscCall(IsphFlowGetForce(flow, 3, force, torque, error));
  return PetscPrintf(PETSC_COMM_WORLD, "force on the lid %g N, two measures differ by %g N\n",
                     (double)force[0], (double)error[0]);
}

int main(int argc, char **argv)
{
  PetscReal      ramp = 0.1;
  PetscErrorCode failed;
  IsphFlow       flow;

  if (IsphInitialize() || IsphFlowCreate(&flow)) return 1;
  failed = Run(flow, argc, argv, &ramp);
  if (failed) (void)fprintf(stderr, "%s\n", IsphFlowGetError(flow));
  return IsphFlowDestroy(&flow) || IsphFinalize() || failed ? 1 : 0;
}
