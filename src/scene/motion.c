/* Whether particles go with the flow: one arbitrary Lagrangian-Eulerian step, two transport
   velocities. */
#include "isph/scene.h"

static const MotionRow motions[] = {
    {"lagrangian", "particles move with the flow and are shifted", "", PETSC_TRUE},
    {"eulerian", "particles stay; du/dt gains -u.grad u; operators are built once", "",
     PETSC_FALSE},
};
const Table MotionTable = TABLE("-motion", "Motions", motions);
