/* Motions of particles, moving or fixed: transport velocities for the same arbitrary
   Lagrangian-Eulerian step. */
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
const Table MotionTable = TABLE("-motion", "Motions", motions);
