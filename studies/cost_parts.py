"""The runs of studies/cost, part by part."""
from typing import NamedTuple

from cost_runs import BODY, LONG, PERIODIC

GRADED = "-motion eulerian -convection implicit -spacing_wall 0.2 -pressure_points coarse"
CAVITY = "isph -case cavity -reynolds 1000"
FIXED = {  # the same settings in all flows of comparison
    "default": "-motion eulerian",
    "implicit": "-motion eulerian -convection implicit",
    "coarse points, CFL 8": "-motion eulerian -convection implicit -pressure_points coarse -cfl 8",
    "quartic, explicit": "-motion eulerian -mls_degree 4",
    "quartic, explicit, CFL 1": "-motion eulerian -mls_degree 4 -cfl 1",
    "quartic, explicit, CFL 1, order 3": "-motion eulerian -mls_degree 4 -cfl 1 -time_order 3",
    "quartic": "-motion eulerian -convection implicit -mls_degree 4",
    "quartic, CFL 4": "-motion eulerian -convection implicit -mls_degree 4 -cfl 4",
    "quartic, CFL 8": "-motion eulerian -convection implicit -mls_degree 4 -cfl 8",
    "quartic, coarse points": "-motion eulerian -convection implicit -mls_degree 4 -pressure_points coarse",
    "quartic, coarse points, explicit": "-motion eulerian -mls_degree 4 -pressure_points coarse",
    "quartic, coarse points, explicit, CFL 1": "-motion eulerian -mls_degree 4 -pressure_points coarse -cfl 1",
}
MOVING = {"default": "", "CFL 1": "-cfl 1", "CFL 2": "-cfl 2", "quartic": "-mls_degree 4",
          "quartic, CFL 1": "-mls_degree 4 -cfl 1", "CFL 1, order 3": "-cfl 1 -time_order 3",
          "quartic, order 3": "-mls_degree 4 -time_order 3"}
SHEAR = ('-case scene -scene_box 0,0,1,1 -scene_periodic x,y -viscosity 1e-4 -scene_velocity '
         '"tanh(30*((y<0.5)?(y-0.25):(0.75-y))),0.05*sin(2*pi*(x+0.25))"')


class Run(NamedTuple):
    """A run of a part: `kind` is fixed, disordered, moving, icoFoam or spectral."""
    kind: str
    setting: str
    n: int
    line: str
    flow: str = ""
    below: float = LONG  # user time of a run that is repeated [s]


class Comparison(NamedTuple):
    """A flow that several codes compute."""
    title: str
    error: str  # in words
    isph: str
    reynolds: float
    t_end: float
    sides: tuple  # n of OpenFOAM
    fixed: tuple  # n of fixed and of moving particles: more of them, for equal errors
    moving: tuple
    quick: tuple  # n of all codes with --quick


COMPARISONS = {
    "cylinder": Comparison(
        f"Two lids and a cylinder off the centre (`{BODY}`), Re = 400, t = 4",
        "root mean square difference of u and v at 50 points on three vertical lines, over their root mean square",
        f"-case scene -scene_wall_top_velocity 1,0 -scene_wall_bottom_velocity 1,0 -scene_body_1 {BODY} -reynolds 400",
        400, 4, (40, 80, 120, 160), (32, 40, 44, 50, 60, 80, 120, 160), (32, 40, 50, 60, 80, 120), (20, 40)),
    "taylor_green": Comparison(
        "Taylor-Green vortices, Re = 100, t = 1", "L2 error of the velocity over particles or cells, relative",
        "-case taylor_green -reynolds 100", 100, 1, (32, 64, 96, 128, 192, 256),
        (16, 20, 24, 32, 48, 64, 96, 128), (16, 24, 30, 32, 40, 48, 64), (16, 24)),
    "double_shear": Comparison(
        "Double shear layer of Brown & Minion, 1/ν = 10⁴, thickness parameter 30, t = 1",
        "L2 error of the velocity over particles or cells, relative", SHEAR, 1e4, 1, (64, 128, 256, 512),
        (48, 54, 64, 96, 128), (48, 64, 96, 128, 192), (16, 24)),
}


def cavity(quick):
    """Yields the runs of the cavity at Re = 1000, t = 40 from rest."""
    base = f"{CAVITY} -t_end 40"
    for n in (36,) if quick else (36, 44, 52, 64):
        for cfl in (8,) if quick else (8, 4):
            yield Run("fixed", f"spacing 0.2 at walls, CFL {cfl}", n, f"{base} {GRADED} -cfl {cfl} -n {n}")
    for n in (32,) if quick else (48, 64):
        yield Run("fixed", "quartic, CFL 4", n, f"{base} {FIXED['quartic']} -cfl 4 -n {n}")
        if not quick:
            yield Run("fixed", "default", n, f"{base} {FIXED['default']} -n {n}")
    if not quick:
        yield Run("fixed", "default", 100, f"{base} {FIXED['default']} -n 100")
    for n in (36,) if quick else (50, 64):
        for seed in (1,) if quick else (1, 2, 3):
            yield Run("disordered", "spacing 0.2 at walls, CFL 8", n,
                      f"{base} {GRADED} -cfl 8 -jitter 0.2 -n {n} -seed {seed}")
    for n in (16,) if quick else (32, 40, 50):
        for seed in range(1, 9) if n == 50 else (1,):
            yield Run("moving", "default", n, f"{base} -n {n} -seed {seed}", below=0)
    for n in (24,) if quick else (64, 100, 168):
        yield Run("icoFoam", "Courant 2", n, f"icoFoam -reynolds 1000 -t_end 40 -n {n} -courant 2")


def steady(quick):
    """Yields the runs of the cavity at Re = 1000 to t = 100, where the flow is steady."""
    base = f"{CAVITY} -t_end 100"
    for n in (36,) if quick else (44, 64, 80, 100, 128):
        yield Run("fixed", "spacing 0.2 at walls, CFL 8", n, f"{base} {GRADED} -cfl 8 -n {n}")
        if not quick:
            yield Run("fixed", "spacing 0.2 at walls, CFL 4", n, f"{base} {GRADED} -cfl 4 -n {n}")
    if not quick:
        for n in (64, 80, 100):
            yield Run("fixed", "quartic, CFL 4", n, f"{base} {FIXED['quartic']} -cfl 4 -n {n}")
        for seed in (1, 2, 3):
            yield Run("disordered", "spacing 0.2 at walls, CFL 8", 64, f"{base} {GRADED} -cfl 8 -jitter 0.2 -n 64 -seed {seed}")
            yield Run("moving", "default", 50, f"{base} -n 50 -seed {seed}", below=0)
        for n in (100, 168):
            yield Run("icoFoam", "Courant 2", n, f"icoFoam -reynolds 1000 -t_end 100 -n {n} -courant 2")


def comparison(flow, quick):
    """Yields the runs of a flow that several codes compute."""
    case = COMPARISONS[flow]
    t_end = min(case.t_end, 0.2) if quick and flow not in PERIODIC else case.t_end
    base = f"isph {case.isph} -t_end {t_end}"
    for n in case.quick if quick else case.fixed:
        for setting, words in FIXED.items():
            if "quartic, coarse points" not in setting or flow in PERIODIC:  # the default between walls
                yield Run("fixed", setting, n, f"{base} {words} -n {n}", flow)
    for n in case.quick if quick else case.moving:
        for setting, words in MOVING.items():
            yield Run("moving", setting, n, f"{base} {words} -n {n}" if words else f"{base} -n {n}", flow)
    for n in case.quick if quick else case.sides:
        for courant in (2, 1, 0.5):
            yield Run("icoFoam", f"Courant {courant}", n, foam(flow, case, t_end, n, courant), flow)
    if flow in PERIODIC:
        for n in (16,) if quick else (64, 128, 192, 256):
            if n < PERIODIC[flow].modes:
                yield Run("spectral", "RK4, CFL 0.4", n, f"spectral {flow} -n {n}", flow)
    else:
        for n in references(quick):
            yield Run("reference", "Courant 0.5", n, foam(flow, case, t_end, n, 0.5), flow, 0)
        n = case.quick[-1] if quick else case.fixed[-1]
        yield Run("check", "quartic", n, f"{base} {FIXED['quartic']} -n {n}", flow, 0)


def references(quick):
    """Returns n of the meshes from which the reference of the cylinder is extrapolated."""
    return (20, 40, 80) if quick else (80, 160, 320)


def foam(flow, case, t_end, n, courant):
    """Returns the line of a run of icoFoam."""
    return f"icoFoam {flow} -reynolds {case.reynolds:g} -t_end {t_end} -n {n} -courant {courant}"


# ---- cost of a step ----

class Step(NamedTuple):
    """A measurement of the cost of a step, from a long run and a short run; `before` are the values of the version before
    implicit convection and LU factors."""
    dim: int
    n: int
    motion: str
    short: int  # steps of the short run
    steps: int  # steps of the long run
    wanted: object = None  # microseconds a particle-step
    before: object = None
    memory: object = None  # wanted kB a particle


ALWAYS = float("inf")
TINY = 8  # n of the run whose memory is that of the program
MOTIONS = {"fixed": "-motion eulerian", "moving": ""}
STEPS = (
    Step(2, 100, "fixed", 40, 240, 0.8, 1.4, 1.5), Step(2, 100, "moving", 20, 100, 2.5, 5.1, 2),
    Step(2, 300, "fixed", 20, 60, None, None, 1.5), Step(2, 300, "moving", 5, 20, None, None, 2),
    Step(2, 400, "fixed", 10, 40, None, 2.6, 1.5), Step(2, 400, "moving", 4, 14, None, 9.2, 2),
    Step(2, 1000, "fixed", 4, 12, 1.2, 4.2, 1.5), Step(2, 1000, "moving", 2, 6, 3.5, 12, 2),
    Step(3, 32, "fixed", 10, 40, None, None, 5), Step(3, 32, "moving", 4, 14, None, None, 7),
    Step(3, 40, "fixed", 6, 20, None, 9.3, 5), Step(3, 40, "moving", 3, 9, None, 42, 7),
    Step(3, 64, "fixed", 4, 12, 5, 10.3, 5), Step(3, 64, "moving", 2, 6, 15, None, 7),
)
QUICK_STEPS = (Step(2, 16, "fixed", 5, 20), Step(2, 16, "moving", 5, 20), Step(3, 12, "fixed", 2, 4),
               Step(3, 12, "moving", 2, 4))
PARALLEL = ((2, 100), (2, 300), (2, 1000), (3, 32), (3, 64))
PARALLEL_BEFORE = {("fixed", 2, 100): 1.69, ("fixed", 2, 300): 1.51, ("fixed", 3, 32): 1.28, ("moving", 2, 100): 1.0,
                   ("moving", 2, 300): 1.09, ("moving", 3, 32): 1.24}


def step_line(dim, n, motion, steps, ranks=1):
    """Returns the line of a run of the cavity that ends after a number of steps."""
    launch = f"mpiexec -n {ranks} isph" if ranks > 1 else "isph"
    flow = "-reynolds 1000" if dim == 2 else "-dim 3 -reynolds 100"
    return " ".join(f"{launch} -case cavity {flow} {MOTIONS[motion]} -n {n} -max_steps {steps}".split())


def steps_of(quick):
    """Returns the measurements of a step."""
    return QUICK_STEPS if quick else STEPS


def parallel(quick):
    """Returns the measurements that are made on two ranks too."""
    return [step for step in steps_of(quick) if quick or (step.dim, step.n) in PARALLEL]


def step(quick):
    """Yields the runs that measure the cost of a step."""
    for dim in (2, 3):
        for motion in MOTIONS:
            yield Run(motion, "", TINY, step_line(dim, TINY, motion, 2), below=ALWAYS)
    for case in steps_of(quick):
        for steps in (case.short, case.steps):
            yield Run(case.motion, "", case.n, step_line(case.dim, case.n, case.motion, steps), below=ALWAYS)
    for case in parallel(quick):
        for steps in (case.short, case.steps):
            yield Run(case.motion, "two ranks", case.n, step_line(case.dim, case.n, case.motion, steps, 2),
                      below=ALWAYS)


# ---- single changes ----

CHANGES = {  # options that undo or add a change; the first of each motion are the defaults
    "fixed": (("defaults", ""), ("LU in place of AMG", "-ppe_pc_type lu"),
              ("no guess from earlier solutions", "-ppe_ksp_initial_guess_nonzero 0"),
              ("PETSc's AMG", "-ppe_pc_type gamg"), ("pressure to 1e-3", "-ppe_ksp_rtol 1e-3"),
              ("convection implicit, same steps", "-convection implicit -cfl 0.5"),
              ("the same, to 1e-7", "-convection implicit -cfl 0.5 -visc_ksp_rtol 1e-7"),
              ("the same, SOR", "-convection implicit -cfl 0.5 -visc_pc_type sor"),
              ("the same, ILU(0)", "-convection implicit -cfl 0.5 -visc_pc_type ilu"),
              ("pressure on coarse points", "-pressure_points coarse"), ("quartic fits", "-mls_degree 4")),
    "moving": (("defaults", ""), ("pressure to 1e-3, viscosity to 1e-4", "-ppe_ksp_rtol 1e-3 -visc_ksp_rtol 1e-4"),
               ("PETSc's AMG", "-ppe_pc_type gamg"), ("pressure on particles", "-pressure_points same"),
               ("no shifting", "-shift none"), ("no velocity filter", "-velocity_filter 0")),
}


def change_line(motion, options, quick):
    """Returns the line of a run with an option changed."""
    n, steps = (24, 20) if quick else (100, 400 if motion == "fixed" else 100)
    words = f"{MOTIONS[motion]} -n {n} -max_steps {steps} {options}".split()
    return " ".join(["isph -case cavity -reynolds 1000", *words])


def changes(quick):
    """Yields the runs of single changes."""
    for motion, cases in CHANGES.items():
        for name, options in cases:
            yield Run(motion, name, 24 if quick else 100, change_line(motion, options, quick))


# ---- orders ----

class Order(NamedTuple):
    """A flow of disordered fixed particles with an exact solution, and the wanted orders of velocity and pressure."""
    title: str
    line: str
    wanted: tuple


GROWTH, SWIRL = "(1+0.5*sin(4*t))", ("pi*sin(pi*x)^2*sin(2*pi*y)", "(-pi*sin(2*pi*x)*sin(pi*y)^2)")
STRESS = ("(-2*pi^3*sin(2*pi*y)*(2*cos(2*pi*x)-1)+60*x^2+30*(y^2-1/3))",
          "(2*pi^3*sin(2*pi*x)*(2*cos(2*pi*y)-1)+60*(x-0.5)*y)")  # -lap u + grad p of options/stokes_exact.opts
UNSTEADY = (f'-scene_exact "{GROWTH}*{SWIRL[0]},{GROWTH}*{SWIRL[1]},{GROWTH}*(20*(x^3-0.25)+30*(x-0.5)*(y^2-1/3))" '
            f'-body_force "{GROWTH}*{STRESS[0]}+2*cos(4*t)*{SWIRL[0]},{GROWTH}*{STRESS[1]}+2*cos(4*t)*{SWIRL[1]}"')
ORDERS = {
    "vortices": Order("Taylor-Green vortices, Re = 100, t = 0.2, dt = 5e-4, coarse points",
                      "isph -case taylor_green -reynolds 100 -motion eulerian -jitter 0.2 -t_end 0.2 -dt 5e-4 "
                      "-pressure_points coarse", (4, 3.5)),
    "vortices, same": Order("the same, pressure on the particles",
                            "isph -case taylor_green -reynolds 100 -motion eulerian -jitter 0.2 -t_end 0.2 -dt 5e-4 "
                            "-pressure_points same", (4, 3.5)),
    "cavity": Order("Regularised cavity of Shih, Re = 1, t = 0.5",
                    "isph -options_file options/regularised_cavity.opts -motion eulerian -jitter 0.2 "
                    "-pressure_points coarse", (2.5, 2)),
    "creeping": Order("Exact creeping flow in a box, coupled and steady",
                      "isph -options_file options/stokes_exact.opts -jitter 0.2", (2.5, 2)),
    "unsteady": Order("The same flow times 1 + sin(4 t)/2, projection, t = 0.2, dt = 5e-4",
                      f"isph -case scene -without convection -reynolds 1 -jitter 0.2 -t_end 0.2 -dt 5e-4 {UNSTEADY}", (2.5, 2)),
}


def order_sides(quick):
    """Returns n of the runs of orders."""
    return (12, 16) if quick else (16, 24, 32, 48)


def order_seeds(quick):
    """Returns the seeds of the runs of orders."""
    return (1,) if quick else (1, 2, 3)


def order_line(name, n, seed, degree=4):
    """Returns the line of a run of an order."""
    return f"{ORDERS[name].line} -mls_degree {degree} -n {n} -seed {seed}"


def order(quick):
    """Yields the runs of orders."""
    for name in ORDERS:
        for n in order_sides(quick):
            for seed in order_seeds(quick):
                yield Run("disordered", name, n, order_line(name, n, seed), below=0)
        for seed in order_seeds(quick):  # the quadratic fits at the finest resolution
            n = order_sides(quick)[-1]
            yield Run("disordered", name, n, order_line(name, n, seed, 2), below=0)


PARTS = {"cavity": cavity, "steady": steady, **{flow: lambda quick, flow=flow: comparison(flow, quick)
                                                for flow in COMPARISONS}, "step": step, "changes": changes, "order": order}
