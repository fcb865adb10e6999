/*
  Sides of the box along which fluid slides: a plane in which the flow mirrors itself, so that only
  half of a symmetric flow is computed, and a wall with the slip length l,

    u.n = 0,   n.grad u_t = 0,   or   mu n.grad u_t = mu (u_t - U)/l,   n.grad p = rho n.f

  The traction of a wall is that of a layer of cells, see AddLayers() in src/strain/straincells.c.
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

const BoundaryRow BoundarySlip = {
    .name       = "slip",
    .brief      = "wall along which fluid slides: u.n = U.n, shear stress mu (u - U)/l",
    .citation   = "Navier, Mem. Acad. Sci. Inst. France 6 (1823) 389-440",
    .option     = OPTION(REAL, "-scene_wall_<side>_slip",
                         "slip length of a side of the box: the depth behind it at which the "
                             "velocity, continued in a line, is that of the wall",
                         "m", "0", POSITIVE, .places = BoxSides,
                         .where = "-case scene, sides that are walls, -visc_laplacian weak_stress"),
    .properties = BOUNDARY_PARTICLES | BOUNDARY_CONFINES,
    .equation   = {[FIT_VELOCITY_NORMAL]     = EQUATION_VALUE,
                   [FIT_VELOCITY_TANGENTIAL] = EQUATION_NONE,
                   [FIT_PRESSURE]            = EQUATION_NORMAL_DERIVATIVE,
                   [FIT_PRESSURE_FREE]       = EQUATION_NONE},
};
