/*
  isph - incompressible viscous flow by smoothed particles, on PETSc

  A flow is made from the options of the program isph, runs, and gives its fields, forces and
  measures. All functions return a PetscErrorCode; a refused option and a flow that diverges are
  errors too, with a text (IsphFlowGetError()). As any error of PETSc, it goes to the error handler
  that is installed, and a function never ends the process. Functions are collective on
  PETSC_COMM_WORLD unless they say so. Several flows may exist at the same time. Units are SI, in 2D
  per metre of depth.

  Arrays and vectors hold the particles of this rank, the fluid first, then walls. They belong to
  the flow, and are valid until it makes a step.
*/
#ifndef ISPH_LIBRARY_H
#define ISPH_LIBRARY_H

#include <petscvec.h>

typedef struct IsphFlow_s *IsphFlow;

/* A function in expressions of options; its value for n arguments. */
typedef PetscReal (*IsphFunction)(PetscInt n, const PetscReal argument[], void *ctx);
/* A function that is called after each step; an error ends IsphFlowRun() with this error. */
typedef PetscErrorCode (*IsphMonitor)(IsphFlow flow, void *ctx);

/* Initialises MPI and PETSc, unless they are initialised. PETSc reads no options of a command line,
   and leaves signals alone; its error handler returns errors without a print. */
PETSC_EXTERN PetscErrorCode IsphInitialize(void);
/* Ends what IsphInitialize() has begun; all flows are destroyed before. */
PETSC_EXTERN PetscErrorCode IsphFinalize(void);

/* Creates a flow. Unless it is given options of its own, it reads PETSc's database. */
PETSC_EXTERN PetscErrorCode IsphFlowCreate(IsphFlow *flow);
/* Gives options, as the words of a command line without the name of the program. With options of
   its own a flow prints no progress, unless -progress line is one of them. */
PETSC_EXTERN PetscErrorCode IsphFlowSetOptions(IsphFlow flow, int argc, char *argv[]);
/* Gives an option, as -n and 32; value NULL: the option has none. */
PETSC_EXTERN PetscErrorCode IsphFlowSetOption(IsphFlow flow, const char name[], const char value[]);
/* Gives a function, which expressions of options call by its name, as -scene_wall_top_velocity
   calls lid in "lid(x, t), 0". Its value follows from its arguments only; no function of a flow is
   called in it. */
PETSC_EXTERN PetscErrorCode IsphFlowSetFunction(IsphFlow flow, const char name[],
                                                IsphFunction function, void *ctx);
/* Gives a function that is called after each step, in which the flow may be read and changed. */
PETSC_EXTERN PetscErrorCode IsphFlowSetMonitor(IsphFlow flow, IsphMonitor monitor, void *ctx);
/* Reads the options, and makes the particles and the flow at the start, or reads -restart. */
PETSC_EXTERN PetscErrorCode IsphFlowSetUp(IsphFlow flow);
/* Destroys a flow; files that it has written stay. */
PETSC_EXTERN PetscErrorCode IsphFlowDestroy(IsphFlow *flow);
/* Gets the text of the error of the last call, empty without one; not collective. */
PETSC_EXTERN const char *IsphFlowGetError(IsphFlow flow);

/* Makes a step, and writes the files that are due after it. */
PETSC_EXTERN PetscErrorCode IsphFlowStep(IsphFlow flow);
/* Makes steps until a time, at which a step ends, or to the end of the run, -t_end, -max_steps or
   -steady_tol, if this is earlier; PETSC_INFINITY: to the end. */
PETSC_EXTERN PetscErrorCode IsphFlowRun(IsphFlow flow, PetscReal until);
/* Gets true if the run has reached its end; not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowIsOver(IsphFlow flow, PetscBool *over);
/* Gets the time, the length of the last step and the number of steps; not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowGetTime(IsphFlow flow, PetscReal *t, PetscReal *dt,
                                            PetscInt *step);
/* Gets the dimension and the numbers of fluid and wall particles of this rank; not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowGetSizes(IsphFlow flow, PetscInt *dim, PetscInt *fluid,
                                             PetscInt *walls);
/* Gets the ids of the particles of this rank, which they keep for ever; not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowGetIds(IsphFlow flow, const PetscInt64 **id);
/* Gets a field that particles carry, an array for each component: position, velocity, pressure,
   viscosity, spacing, volume, density with -scheme wcsph, or a scalar by its name. Walls have no
   pressure and no scalars. A change of it needs IsphFlowChanged(). Not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowGetField(IsphFlow flow, const char name[], PetscInt *components,
                                             PetscReal *component[3]);
/* Creates a vector of a component of such a field over the fluid, on the same numbers. */
PETSC_EXTERN PetscErrorCode IsphFlowGetVec(IsphFlow flow, const char name[], PetscInt component,
                                           Vec *v);
/* Computes a field of snapshots, as vorticity, strain_rate or boundary: rows of `columns` numbers
   for fluid and walls; there must be room for three of each particle. Vorticity, strain rate and
   density need -output, or a flow that computes them. */
PETSC_EXTERN PetscErrorCode IsphFlowComputeField(IsphFlow flow, const char name[],
                                                 PetscInt *columns, PetscReal rows[]);
/* Tells that velocities, pressures or scalars have been changed. The next step is of first order,
   as the first. */
PETSC_EXTERN PetscErrorCode IsphFlowChanged(IsphFlow flow);
/* Inserts n fluid particles at positions x, the same on all ranks; u: their velocities, NULL: the
   mean of the fluid around them. Other fields follow from this fluid. */
PETSC_EXTERN PetscErrorCode IsphFlowInsert(IsphFlow flow, PetscInt n, const PetscReal x[],
                                           const PetscReal u[]);
/* Removes n fluid particles by their ids, the same on all ranks. */
PETSC_EXTERN PetscErrorCode IsphFlowRemove(IsphFlow flow, PetscInt n, const PetscInt64 id[]);

/* Gets the name of boundary k, as left or body_1, and of its kind, as wall; k is at least 0. The
   sides of the box are before the bodies; both names are NULL after the last. Not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowGetBoundary(IsphFlow flow, PetscInt k, const char **name,
                                                const char **kind);
/* Computes force and torque of the fluid on boundary k, three numbers each, the torque about the
   centre of a body or the middle of the box. Sides through which fluid passes, and periodic ones,
   have none. Output: error - how far two measures of each differ, a lower bound of the error, NaN
   with a free surface; may be NULL. The report has error bars. */
PETSC_EXTERN PetscErrorCode IsphFlowGetForce(IsphFlow flow, PetscInt k, PetscReal force[3],
                                             PetscReal torque[3], PetscReal error[2]);
/* Gets place, attitude (a unit quaternion, real part first), velocity and spin of body k, which is
   a boundary; not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowGetPose(IsphFlow flow, PetscInt k, PetscReal x[3],
                                            PetscReal attitude[4], PetscReal velocity[3],
                                            PetscReal spin[3]);
/* Interpolates velocity, dim numbers each, and pressure, which may be NULL, at n points, the same
   on all ranks; NaN outside the fluid. */
PETSC_EXTERN PetscErrorCode IsphFlowProbe(IsphFlow flow, PetscInt n, const PetscReal x[],
                                          PetscReal u[], PetscReal p[]);
/* Measures the present flow: the quantities of the report, with their errors, and trust. */
PETSC_EXTERN PetscErrorCode IsphFlowMeasure(IsphFlow flow);
/* Gets measured quantity k, in their order: name, time, value, reference and relative error, NaN
   where there are none; name NULL after the last. Not collective. */
PETSC_EXTERN PetscErrorCode IsphFlowGetQuantity(IsphFlow flow, PetscInt k, const char **name,
                                                PetscReal *t, PetscReal value[3]);

/* Writes a snapshot of the present flow, for ParaView; the path ends in .h5. */
PETSC_EXTERN PetscErrorCode IsphFlowWriteSnapshot(IsphFlow flow, const char path[]);
/* Writes a checkpoint of the present flow, for -restart. */
PETSC_EXTERN PetscErrorCode IsphFlowWriteCheckpoint(IsphFlow flow, const char path[]);
/* Prints what is solved, and how. */
PETSC_EXTERN PetscErrorCode IsphFlowView(IsphFlow flow, PetscViewer viewer);
/* Measures the flow, writes the file of -report, prints both unless the viewer is NULL, and refuses
   measures beyond the bounds of -check_<quantity>. */
PETSC_EXTERN PetscErrorCode IsphFlowReport(IsphFlow flow, PetscViewer viewer);

#endif
