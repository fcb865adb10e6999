/*
  Symmetry: a side of the box in which the flow mirrors itself,

    u.n = 0,   n.grad u_t = 0,   n.grad p = rho n.f,

  so that only half of a symmetric flow is computed. The fluid slides along it without shear stress.
*/
#include "isph/scene.h"

const BoundaryRow BoundarySymmetry = {
    .name   = "symmetry",
    .brief  = "plane in which the flow mirrors itself: u.n = 0, no shear stress",
    .option = OPTION(NAMES, "-scene_symmetry", "sides of the box that are planes of symmetry", NULL,
                     NULL, .words = BoxSides, .table = &BoundaryTable, .where = "-case scene"),
    .properties = BOUNDARY_PARTICLES | BOUNDARY_CONFINES,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_VALUE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE]            = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE_FREE]       = EQUATION_NONE},
};
