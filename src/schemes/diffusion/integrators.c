/* The time integrators of viscosity: TS types, and for each type the callbacks that compute the
   terms of the equation. Several combinations of callbacks are necessary: explicit types refuse an
   IFunction, and implicit types combine an RHSFunction with the wrong Jacobian. */
#include "viscosity.h"

static const ViscousIntegratorRow integrators[] = {
    {
        .name     = TSBEULER,
        .brief    = "backward Euler, from (4u^n - u^{n-1})/3 over 2dt/3: BDF2 with the history on "
                    "particles",
        .citation = "Hairer & Wanner, Solving ODEs II (1996)",
        .terms    = TIME_IMPLICIT,
        .history  = PETSC_TRUE,
        .end_of_step = PETSC_TRUE,
    },
    {
        .name     = TSCN,
        .brief    = "Crank-Nicolson; oscillates after impulsive wall motion",
        .citation = "Crank & Nicolson (1947)",
        .terms    = TIME_IMPLICIT,
    },
    {.name     = TSTHETA,
     .brief    = "theta scheme (-visc_ts_theta_theta)",
     .citation = "Hairer & Wanner, Solving ODEs II (1996)",
     .terms    = TIME_IMPLICIT},
    {.name     = TSALPHA,
     .brief    = "generalised alpha",
     .citation = "Jansen, Whiting & Hulbert, Comput. Methods Appl. Mech. Eng. 190 (2000)",
     .terms    = TIME_IMPLICIT},
    {.name     = TSARKIMEX,
     .brief    = "additive Runge-Kutta, viscosity implicit, convection explicit",
     .citation = "Kennedy & Carpenter, Appl. Numer. Math. 44 (2003)",
     .terms    = TIME_IMEX,
     .substeps = PETSC_TRUE},
    {.name     = TSROSW,
     .brief    = "Rosenbrock-W, viscosity implicit, convection explicit",
     .citation = "Rang & Angermann, BIT 45 (2005)",
     .terms    = TIME_IMEX,
     .substeps = PETSC_TRUE},
    {.name = TSEULER, .brief = "forward Euler", .terms = TIME_EXPLICIT},
    {.name     = TSSSP,
     .brief    = "strong stability preserving Runge-Kutta",
     .citation = "Ketcheson, SIAM J. Sci. Comput. 30 (2008)",
     .terms    = TIME_EXPLICIT},
    {.name     = TSRK,
     .brief    = "explicit Runge-Kutta",
     .citation = "Bogacki & Shampine, Appl. Math. Lett. 2 (1989)",
     .terms    = TIME_EXPLICIT,
     .substeps = PETSC_TRUE},
};
const Table ViscousIntegratorTable = TABLE("Time integrators of viscosity", integrators);
