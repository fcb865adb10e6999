/* Particle shifting: displacements in addition to the flow that keep particles evenly spread. A new
   kind needs a function and a row. This file has the options of the motion. */
#include "isph/motion.h"

/* ShiftStepFactor - Returns U dt/dx, but at least 1 and at most 2: so much longer are the longest
   shift and the disturbance of a lattice in a long step. A step strains the particles by dt |grad
   u|, and shifts have to keep pace with it. With the shifts of short steps a lattice in
   taylor_green (Re = 100, -cfl 2, n = 24 to 64) went to pieces: rows drifted apart before the
   disturbance had grown. */
PetscReal ShiftStepFactor(PetscReal dx, PetscReal speed, PetscReal dt)
{
  return PetscMin(PetscMax(speed * dt / dx, 1.0), 2.0);
}

/*
  ShiftDisplace_Fickian - Displaces a particle down the gradient of concentration, after Fick's law

    delta r = -D grad C,  D = min(S (U + 4 h |grad u|) h dt, h^2/2),  h = 1.3 dx

  |delta r| is at most 0.1 dx in steps up to dx/U, and up to 0.2 dx in longer ones, see
  ShiftStepFactor(). The first term of D spreads particles in any flow, the second keeps pace with
  strain. A lattice strained along its axes stays symmetric, so that grad C vanishes while its rows
  drift apart. The random displacement ShiftRow.disturbance in the first step breaks this symmetry.
  Input: dx - spacing of the particle [m]; strength - S; speed - U, the largest of the flow [m/s];
  rate - |grad u| at the particle [1/s]; gradient_c - grad C [1/m]. Output: displacement [m].
  Reference: S. J. Lind et al., J. Comput. Phys. 231 (2012) 1499-1523; D follows from measurements
  with this program.
*/
static void ShiftDisplace_Fickian(PetscInt dim, PetscReal dx, PetscReal strength, PetscReal speed,
                                  PetscReal rate, PetscReal dt, const PetscReal gradient_c[],
                                  PetscReal displacement[])
{
  const PetscReal h      = 1.3 * dx;
  const PetscReal most   = 0.1 * dx * ShiftStepFactor(dx, speed, dt);
  const PetscReal D      = PetscMin(strength * (speed + 4.0 * h * rate) * h * dt, 0.5 * h * h);
  PetscReal       length = 0.0;

  for (PetscInt a = 0; a < dim; a++) {
    displacement[a] = -D * gradient_c[a];
    length += PetscSqr(displacement[a]);
  }
  length = PetscSqrtReal(length);
  if (length <= most) return;
  for (PetscInt a = 0; a < dim; a++) displacement[a] *= most / length;
}

static const ShiftRow shifts[] = {
    {"fickian", "down the gradient of particle concentration, at most 0.1 dx a step",
     "Lind et al., J. Comput. Phys. 231 (2012)", ShiftDisplace_Fickian, 0.1},
    {"none", "no shifting", NULL, NULL, 0.0},
};
const Table ShiftTable = TABLE("Particle shifting", shifts);

enum { SHIFT, SHIFT_STRENGTH, VELOCITY_FILTER };
static const OptionRow options[] = {
    [SHIFT] = OPTION(NAME, "-shift", "particle shifting", NULL, REGIME, .table = &ShiftTable,
                     .where = "flows whose particles move"),
    [SHIFT_STRENGTH]  = OPTION(REAL, "-shift_strength", "factor of the diffusivity of -shift", "-",
                               REGIME, .expert = PETSC_TRUE, .low = 1e-3, .high = 100.0,
                               .where = "flows whose particles are shifted"),
    [VELOCITY_FILTER] = OPTION(
        REAL, "-velocity_filter", "strength of the grid-scale filter of velocities; 0: off", "-",
        REGIME, .expert = PETSC_TRUE, .low = 0.0, .high = 8.0, .where = "flows with convection"),
};
const OptionTable MotionOptions = OPTIONS("Motion of particles", options);

/* MotionCreate - Reads the options of filter and shifting; collective on PETSC_COMM_WORLD. Output:
   needs - bits of Need for them. The regime gives the default of the filter; a scheme takes it
   again when it knows the points of the pressure or its substeps. */
PetscErrorCode MotionCreate(Flow *flow, unsigned *needs)
{
  const Scene *scene = flow->scene;
  FlowState   *s     = flow->state;

  PetscFunctionBegin;
  if (SceneMoves(scene)) {
    PetscCall(OptionGetRow(&options[SHIFT], RegimeWord(scene->regime, REGIME_SHIFT), &s->shift));
    if (s->shift->Displace) {
      s->shift_strength = RegimeValue(scene->regime, REGIME_SHIFT_STRENGTH);
      PetscCall(OptionGetReal(&options[SHIFT_STRENGTH], &s->shift_strength, NULL));
      *needs |= NEED_CONCENTRATION;
    }
  }
  if (scene->motion) {
    s->velocity_filter = RegimeValue(scene->regime, REGIME_FILTER_U);
    PetscCall(OptionGetReal(&options[VELOCITY_FILTER], &s->velocity_filter, NULL));
    if (s->velocity_filter > 0.0) *needs |= NEED_FILTER_U;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
