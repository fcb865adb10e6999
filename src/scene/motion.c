/* Motions of particles: they move with the flow, or stay fixed. Both use the same arbitrary
   Lagrangian-Eulerian step; only the velocity of the particles differs. */
#include "isph/scene.h"

static const MotionRow motions[] = {
    {
        .name           = "lagrangian",
        .brief          = "particles move with the flow and are shifted",
        .citation       = "",
        .particles_move = PETSC_TRUE,
    },
    {
        .name     = "eulerian",
        .brief    = "particles stay; du/dt gains -u.grad u; operators are built once",
        .citation = "",
    },
};
const Table MotionTable = TABLE("Motions", motions);
