"""The cases of studies/verify: runs, quantities, where their references come from, and what is drawn."""
import cmath
import csv
import dataclasses
import math
import os
import typing

PI = math.pi
REFERENCE = os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "cases", "reference")


def lattice_first(k):
    """Arguments of the k-th start: the lattice, then lattices disturbed at random."""
    return f" -jitter 0.1 -seed {k}" if k else ""


def seeds(k):
    """Arguments of the k-th start where the options disturb the lattice already."""
    return f" -seed {k + 1}" if k else ""


@dataclasses.dataclass
class Quantity:
    """A column of a run, or a function of its row. `exact` is its reference, a number or a function of the row; True
    where the column is an error itself; None where there is none, and the change with n is all that is known."""
    kind: str  # velocity, pressure, force, energy, operator
    label: str
    column: typing.Any
    exact: typing.Any = None
    source: str = ""


@dataclasses.dataclass
class Study:
    """Runs of one setting at some resolutions, each from so many starts. Watch: -probe_ options."""
    title: str
    arguments: str
    sides: tuple
    quantities: list
    starts: tuple = ()
    start: typing.Callable = lattice_first
    watch: str = ""


@dataclasses.dataclass
class Panel:
    """A picture of one run along a line: a column of -probe_line over another, beside curves and points."""
    title: str
    arguments: str
    line: str  # -probe_line
    over: str
    column: str
    labels: tuple
    every: float = 0  # -probe_every: the last row is drawn
    curve: typing.Any = None  # exact, a function of `over`
    files: tuple = ()  # (label, file of cases/reference)
    centred: bool = False  # the curve is known up to a constant


@dataclasses.dataclass
class Chart:
    """A picture of a quantity of several studies at their finest n over a number that tells them apart."""
    title: str
    column: str
    labels: tuple
    numbers: dict  # by title of the study


@dataclasses.dataclass
class Case:
    title: str
    studies: list
    panels: list  # Panel or Chart
    drawn: tuple = ()  # labels of the quantities in the panel of errors; without, there is none


def report(kind, label, column, source):
    """A quantity whose reference the program reports."""
    return Quantity(kind, label, column, lambda row: row.get(f"{column}_reference"), source)


def norm(kind, label, column, source="exact solution"):
    """A quantity that is an error itself."""
    return Quantity(kind, label, column, True, source)


def sums(*names):
    """The sum of columns, a minus before a name taking it off; None where one is absent."""
    def add(row):
        terms = [(-1 if name[0] == "-" else 1, name.lstrip("-")) for name in names]
        if any(name not in row for _, name in terms):
            return None
        return sum(sign * row[name] for sign, name in terms)
    return add


def per_length(name):
    """A force on a wall of a channel, which is 8 dx long, per L of its length; n is an eighth of its particles."""
    return lambda row: row[name] * row["particles"] / 64 if name in row else None


# ---- cavities ----

FV = "finite volumes, extrapolated"
BP = "Botella & Peyret"
BRUNEAU = "Bruneau & Saad"
CAVITY = "-options_file options/cavity.opts"
MIDDLE = "-probe_point 0.5,0,0.5,0.5,0.5,1 -probe_forces -probe_every "
ALONG_Y, ALONG_X = "0.5,0,0.5,1,101", "0,0.5,1,0.5,101"


def centrelines(source, energy=True):
    return [
        *[norm("velocity", f"profile of {c} on the centreline, rms over U", f"{c}_profile_l2", source) for c in "uv"],
        *[report("velocity", f"{name} on the centreline", name, source) for name in ("u_min", "v_max", "v_min")],
        *([report("energy", "kinetic energy", "kinetic_energy", FV)] if energy else []),
    ]


def cavity_quantities(energy=True):
    return [
        *centrelines(FV, energy),
        Quantity("pressure", "p(0.5, 0) - p(0.5, 0.5)", sums("point_0_p", "-point_1_p")),
        Quantity("pressure", "p(0.5, 1) - p(0.5, 0.5)", sums("point_2_p", "-point_1_p")),
        Quantity("force", "shear force on the bottom", "forces_bottom_fx"),
    ]


def tabulated_pressures():
    """Points of the centrelines with the pressures of the tables, less the pressure in the middle."""
    points = {(0.5, 0.5): 0.0}
    for along, name in (("y", "p"), ("x", "p_horizontal")):
        with open(os.path.join(REFERENCE, f"botella_peyret_re1000_{name}.csv"), newline="") as file:
            for row in csv.DictReader(line for line in file if not line.startswith("#")):
                s, p = float(row[along]), float(row["p"])
                points[(0.5, s) if along == "y" else (s, 0.5)] = p
    return points


TABULATED = tabulated_pressures()
VORTEX = "0.5308,0,0.5308,0.5652"  # from the bottom to the centre of the vortex: the flux is the streamfunction there
TABLES = (f"-probe_point {','.join(f'{x},{y}' for x, y in TABULATED)} -probe_flux {VORTEX} -probe_forces "
          "-probe_every ")


def pressure_error(along):
    """The largest error on a centreline over the range of the pressures of both tables."""
    span = max(TABULATED.values()) - min(TABULATED.values())
    of_line = [(k, p) for k, ((x, y), p) in enumerate(TABULATED.items()) if (x if along == "y" else y) == 0.5]

    def error(row):
        if any(f"point_{k}_p" not in row for k, _ in of_line):
            return None
        return max(abs(row[f"point_{k}_p"] - row["point_0_p"] - p) for k, p in of_line) / span
    return error


def steady_quantities():
    return [
        *centrelines(BP, False),
        Quantity("energy", "kinetic energy", "kinetic_energy", 0.044503, BRUNEAU),
        Quantity("velocity", "streamfunction in the centre of the vortex", "flux_0_flux", -0.11892, BRUNEAU),
        *[norm("pressure", f"pressure on {line}, largest error over the range", pressure_error(along), BP)
          for line, along in (("x = 0.5", "y"), ("y = 0.5", "x"))],
        Quantity("force", "shear force on the bottom", "forces_bottom_fx"),
    ]


def centreline_panels(title, arguments, every, u_file, v_file, label=FV):
    return [Panel(title, arguments, ALONG_Y, "y", "u", ("y/L", "u/U"), every, files=((label, u_file),)),
            Panel(title, arguments, ALONG_X, "x", "v", ("x/L", "v/U"), every, files=((label, v_file),))]


def creeping_extrema():
    """Extrema of the creeping flow, whose references are those of studies/stokes_cavity."""
    return [report("velocity", f"{name} on the centreline", name, "biharmonic equation")
            for name in ("u_min", "v_max", "v_min")]


def energy_at(*times, source=FV):
    """The kinetic energy at times of report."""
    return [Quantity("energy", f"kinetic energy at t = {t}", f"kinetic_energy@{t}",
                     lambda row, t=t: row.get(f"kinetic_energy_reference@{t}"), source) for t in times]


def cavity():
    re400 = f"{CAVITY} -reynolds 400 -t_end 40"
    re1000 = f"{CAVITY} -reynolds 1000 -t_end 40"
    steady = f"{CAVITY} -reynolds 1000 -t_end 80 -cfl 1 -motion eulerian"
    coarse = f"{steady} -pressure_points coarse"
    in_time = [*energy_at(1, 2, 3, 5, 8, 12), *centrelines(FV)]
    series, later = "-report_times 1,1.5,2,3,5,8,12,16", ",".join(map(str, range(1, 20)))
    creeping, graded = f"{CAVITY} -motion eulerian -reynolds 0.01", "finite volumes, 200 x 200 graded cells"
    limit = creeping_extrema()
    return Case("Lid-driven cavity", [
        Study("Re = 100, t = 20, fixed particles", f"{CAVITY} -motion eulerian", (25, 50, 100), cavity_quantities(),
              watch=MIDDLE + "20"),
        Study("Re = 100, t = 20, moving particles", CAVITY, (25, 50), cavity_quantities(), (3, 3),
              watch=MIDDLE + "20"),
        *[Study(f"Re = 100, in the course of time, {name} particles", f"{CAVITY} -motion {motion} {series}", (100,),
                in_time) for name, motion in (("moving", "lagrangian"), ("fixed", "eulerian"))],
        *[Study(f"Re = 0.01, 50 steps of nu dt/L^2 = {100 * dt:g}, fixed particles",
                f"{creeping} -dt {dt:g} -t_end {50 * dt:g}", (25, 50, 100), limit) for dt in (1, 0.01)],
        Study("Re = 400, t = 40, fixed particles", f"{re400} -motion eulerian", (25, 50, 100),
              cavity_quantities(energy=False), watch=MIDDLE + "40"),
        Study("Re = 400, t = 40, moving particles", f"{re400} -motion lagrangian", (25, 50, 100),
              cavity_quantities(energy=False), (3, 1, 1), watch=MIDDLE + "40"),
        Study("Re = 1000, t = 40, moving particles", re1000, (25, 50, 64, 100), cavity_quantities(), (3, 1, 1, 1),
              watch=MIDDLE + "40"),
        *[Study(f"Re = 1000, t = 80 (steady), {name}", arguments, sides, steady_quantities(), watch=TABLES + "80")
          for name, arguments, sides in (
              ("fixed particles, CFL number 1", steady, (25, 50, 100)),
              ("fixed particles, pressure on coarse points, CFL number 1", coarse, (70, 100)),
              ("moving particles", f"{CAVITY} -reynolds 1000 -t_end 80", (25, 50, 100)))],
        Study("Re = 10,000, t = 20, moving particles", f"{CAVITY} -reynolds 10000 -report_times {later}", (100,),
              [*energy_at(1, 2, 3, 5, 8, 12, 16, source=graded),
               report("energy", "kinetic energy", "kinetic_energy", graded)]),
    ], [
        *centreline_panels("Re = 100, n = 50, fixed", f"{CAVITY} -motion eulerian -n 50", 20,
                           "cavity_re100_u.csv", "cavity_re100_v.csv"),
        *centreline_panels("Re = 1000, t = 80, n = 50, fixed", f"{steady} -n 50", 80,
                           "botella_peyret_re1000_u.csv", "botella_peyret_re1000_v.csv", BP),
        *[Panel("Re = 1000, t = 80, n = 50, fixed", f"{steady} -n 50", line, over, "p",
                (f"{over}/L", "p/(rho U^2)"), 80, files=((BP, f"botella_peyret_re1000_{file}.csv"),),
                centred=True) for line, over, file in ((ALONG_Y, "y", "p"), (ALONG_X, "x", "p_horizontal"))],
    ], ("profile of u on the centreline, rms over U", "pressure on x = 0.5, largest error over the range",
        "pressure on y = 0.5, largest error over the range"))


def cavity_cube():
    cube = f"{CAVITY} -dim 3 -motion eulerian"
    re100 = f"{cube} -reynolds 100 -t_end 12"
    return Case("Lid-driven cubic cavity", [
        Study("Re = 100, t = 12, fixed particles", re100, (10, 20, 40), centrelines(FV, False)),
        Study("Re = 400, t = 30, fixed particles", f"{cube} -reynolds 400 -t_end 30", (20, 40), centrelines(FV, False)),
    ], [
        Panel("Re = 100, n = 20", f"{re100} -n 20", "0.5,0,0.5,0.5,1,0.5,101", "y", "u", ("y/L", "u/U"), 12,
              files=((FV, "cavity3d_re100_u.csv"),)),
        Panel("Re = 100, n = 20", f"{re100} -n 20", "0,0.5,0.5,1,0.5,0.5,101", "x", "v", ("x/L", "v/U"), 12,
              files=((FV, "cavity3d_re100_v.csv"),)),
    ], tuple(f"profile of {c} on the centreline, rms over U" for c in "uv"))


def cavity_cylinder():
    base = "-options_file options/cavity_cylinder.opts"
    watch = "-probe_point 0.5,0,0.5,0.75,0.25,0.5 -probe_forces -probe_every 40"
    quantities = [
        *centrelines(FV),
        Quantity("pressure", "p(0.5, 0.75) - p(0.5, 0)", sums("point_1_p", "-point_0_p")),
        Quantity("force", "torque on the cylinder", "forces_body_1_tz"),
        Quantity("force", "force on the cylinder along x", "forces_body_1_fx"),
        Quantity("force", "shear force on the bottom", "forces_bottom_fx"),
    ]
    return Case("Lid-driven cavity with a cylinder", [
        Study("Re = 1000, t = 40, moving particles", base, (25, 50, 100), quantities, (3, 2, 1), watch=watch),
        Study("Re = 1000, t = 40, fixed particles", f"{base} -motion eulerian", (25, 50, 100), quantities, watch=watch),
    ], centreline_panels("Re = 1000, t = 40, n = 50, moving", f"{base} -n 50 -jitter 0.1 -seed 1", 40,
                         "cavity_cylinder_re1000_u.csv", "cavity_cylinder_re1000_v.csv"),
        ("profile of u on the centreline, rms over U", "kinetic energy"))


# ---- flows with exact solutions ----

def taylor_couette():
    base = "-options_file options/taylor_couette.opts"
    fixed = f"{base} -motion eulerian"
    quantities = [norm("velocity", "velocity, relative L2", "velocity_l2"),
                  norm("velocity", "velocity, relative maximum", "velocity_linf"),
                  norm("pressure", "pressure, relative L2", "pressure_l2"),
                  report("force", "torque on the inner cylinder", "torque", "exact solution")]

    def pressure(r):
        a, b = -2 / 3, 2 / 3  # u = a r + b/r: R1 = 1/2, R2 = 1, U = 1
        return a * a * r * r / 2 + 2 * a * b * math.log(r) - b * b / (2 * r * r)

    return Case("Flow between cylinders (Taylor-Couette)", [
        Study("Re = 10, steady, fixed particles", fixed, (12, 25, 50, 100), quantities),
        Study("Re = 10, steady, moving particles", base, (12, 25, 50), quantities, (3, 3, 1)),
    ], [
        Panel("Re = 10, n = 25, fixed", f"{fixed} -n 25", "0.5,0,1,0,41", "x", "v", ("r/L", "u_theta/U"), 10,
              lambda r: 2 / 3 * (1 / r - r)),
        Panel("Re = 10, n = 25, fixed", f"{fixed} -n 25", "0.5,0,1,0,41", "x", "p", ("r/L", "p/(rho U^2)"), 10,
              pressure, centred=True),
    ], ("velocity, relative L2", "pressure, relative L2", "torque on the inner cylinder"))


def taylor_green():
    base = "-options_file options/taylor_green.opts"
    decay = math.exp(-8 * PI**2 * 0.01)
    quantities = [norm("velocity", "velocity, relative L2", "velocity_l2"),
                  norm("velocity", "velocity, relative maximum", "velocity_linf"),
                  norm("pressure", "pressure, relative L2", "pressure_l2"),
                  Quantity("energy", "kinetic energy", "kinetic_energy", 0.25 * decay**2, "exact solution")]
    run = f"{base} -n 50 -jitter 0 -motion eulerian"
    line = "0,0,1,0,81"
    return Case("Decaying vortices (Taylor-Green)", [
        Study("Re = 100, t = 1, moving particles, jitter 0.2 dx", base, (25, 50, 100, 200), quantities, (5, 3, 1, 1),
              seeds),
        Study("Re = 100, t = 1, moving particles from the lattice", f"{base} -jitter 0", (25, 50, 100, 200),
              quantities),
        Study("Re = 100, t = 1, fixed particles", f"{base} -jitter 0 -motion eulerian", (25, 50, 100), quantities),
    ], [
        Panel("Re = 100, t = 1, n = 50, fixed", run, line, "x", "u", ("x/L", "u/U at y = 0"), 1,
              lambda x: decay * math.sin(2 * PI * x)),
        Panel("Re = 100, t = 1, n = 50, fixed", run, line, "x", "p", ("x/L", "p/(rho U^2) at y = 0"), 1,
              lambda x: 0.25 * decay**2 * (1 + math.cos(4 * PI * x)), centred=True),
    ], ("velocity, relative L2", "pressure, relative L2", "kinetic energy"))


def poiseuille_u(y, t, nu=1.0):
    """Start-up with U = 1, L = 1."""
    Y = 2 * y - 1
    return 1 - Y * Y - 32 / PI**3 * sum((-1) ** k / (2 * k + 1) ** 3 * math.cos((k + 0.5) * PI * Y)
                                        * math.exp(-((2 * k + 1) * PI) ** 2 * nu * t) for k in range(200))


def poiseuille():
    base, steady = "-case poiseuille -reynolds 1 -t_end 0.1", "-options_file options/poiseuille.opts -dt 0.132 -t_end 3"
    nu, t = 0.5, 0.1
    late = 1 - 8 / PI**2 * sum(math.exp(-((2 * k + 1) * PI) ** 2 * nu * t) / (2 * k + 1) ** 2 for k in range(200))
    flow = [norm("velocity", "profile, rms over the largest velocity", "u_profile_l2", "exact series"),
            norm("velocity", "velocity, relative maximum", "velocity_linf", "exact series")]
    watch = "-probe_forces -probe_every "
    early = f"{steady.replace('-dt 0.132 -t_end 3', '')}-dt 2.64e-5 -report_times 0.005066,0.020264,0.101321"
    force = Quantity("force", "shear force on a wall", per_length("forces_bottom_fx"), 4 * nu * late, "exact series")
    force_steady = Quantity("force", "shear force on a wall", per_length("forces_bottom_fx"), 4.0, "momentum balance")
    return Case("Plane Poiseuille flow", [
        Study("from rest, nu t/L^2 = 0.05, default steps", base, (25, 50, 100, 200), [*flow, force],
              watch=watch + "0.1"),
        Study("from rest, steps of 0.2 dt_explicit", early, (40,),
              [*[norm("velocity", f"profile at pi^2 nu t/L^2 = {times}, rms over the largest velocity",
                      f"u_profile_l2@{t}", "exact series")
                 for times, t in ((0.05, 0.005066), (0.2, 0.02026), (1, 0.1013))], flow[0]]),
        Study("steady, steps of 1000 dt_explicit", steady, (10, 20, 40), [*flow, force_steady], watch=watch + "3"),
        Study("steady, with a pressure, `-scheme coupled`, disordered particles",
              f"{steady} -scheme coupled -with pressure -jitter 0.25", (10, 20, 40), [*flow, force_steady], (3, 3, 3),
              seeds, watch=watch + "3"),
    ], [Panel("nu t/L^2 = 0.05, n = 50", f"{base} -n 50", "0.08,0,0.08,1,81", "y", "u", ("y/L", "u/U"), 0.1,
              lambda y: poiseuille_u(y, t, nu))],
        ("profile, rms over the largest velocity", "shear force on a wall"))


def couette_u(y, t):
    return y + sum(2 * (-1) ** k / (k * PI) * math.sin(k * PI * y) * math.exp(-((k * PI) ** 2) * t)
                   for k in range(1, 200))


def couette():
    base, t = "-case couette -reynolds 1 -t_end 0.1", 0.1
    decay = [math.exp(-((k * PI) ** 2) * t) for k in range(1, 200)]
    below = 1 + 2 * sum((-1) ** k * e for k, e in enumerate(decay, 1))
    above = 1 + 2 * sum(decay)
    flow = [norm("velocity", "profile, rms over the largest velocity", "u_profile_l2", "exact series"),
            norm("velocity", "velocity, relative maximum", "velocity_linf", "exact series")]
    walls = [Quantity("force", "shear force on the moving wall", per_length("forces_top_fx"), -above, "exact series"),
             Quantity("force", "shear force on the wall at rest", per_length("forces_bottom_fx"), below,
                      "exact series")]
    steady = [Quantity("force", "shear force on the moving wall", per_length("forces_top_fx"), -1.0, "exact solution")]
    watch = "-probe_forces -probe_every "
    return Case("Plane Couette flow", [
        Study("from rest, nu t/L^2 = 0.1, default steps", base, (25, 50, 100, 200), [*flow, *walls],
              watch=watch + "0.1"),
        Study("from rest, nu t/L^2 = 0.1, steps of dt = 0.001", "-options_file options/couette.opts", (40,),
              [*flow, *walls], watch=watch + "0.1"),
        Study("steady, steps of 1e6 dt_explicit, with a pressure",
              "-options_file options/couette.opts -with pressure -dt 132 -t_end 1320", (10, 20, 40), [*flow, *steady],
              watch=watch + "1320"),
    ], [Panel("nu t/L^2 = 0.1, n = 50", f"{base} -n 50", "0.08,0,0.08,1,81", "y", "u", ("y/L", "u/U"), 0.1,
              lambda y: couette_u(y, t))],
        ("profile, rms over the largest velocity", "shear force on the moving wall"))


def hydrostatic():
    base = "-options_file options/hydrostatic.opts -t_end 1"
    quantities = [norm("velocity", "largest speed over g dt", "speed_over_gdt", "rest"),
                  norm("pressure", "pressure, relative L2", "pressure_l2", "exact solution"),
                  Quantity("force", "weight, from the forces on bottom and top",
                           sums("forces_bottom_fy", "forces_top_fy"), -1.0, "exact solution")]
    watch = "-probe_forces -probe_every 1"
    return Case("Fluid at rest under gravity", [
        Study("100 steps, moving particles", base, (8, 16, 32), quantities, (3, 3, 1), watch=watch),
        Study("100 steps, fixed particles", f"{base} -motion eulerian", (8, 16, 32), quantities, watch=watch),
    ], [Panel("n = 16, moving", f"{base} -n 16", "0.5,0,0.5,1,41", "y", "p", ("y/L", "p/(rho g L)"), 1,
              lambda y: 0.5 - y, centred=True)])


# ---- creeping flow ----

def stokes_cylinders():
    base = "-options_file options/stokes_cylinders.opts"
    sangani = "Sangani & Acrivos"
    quantities = [report("force", "drag over mu U, from the mean velocity", "drag", sangani),
                  report("force", "traction on the cylinder", "traction", "momentum balance"),
                  Quantity("pressure", "p(0.1, 0.5) - p(0.9, 0.5)", sums("point_0_p", "-point_1_p"))]
    watch = "-probe_point 0.1,0.5,0.9,0.5"
    coupled = "-case stokes_cylinders -scheme coupled -steady"
    titles = {c: f"solid fraction {c}, `-scheme coupled -steady`" for c in (0.1, 0.3, 0.05, 0.2, 0.4, 0.5)}
    return Case("Creeping flow through an array of cylinders", [
        *[Study(title, f"{coupled} -solid_fraction {c}", (25, 50, 100, 200) if c in (0.1, 0.3) else (25, 50, 100),
                quantities, watch=watch) for c, title in titles.items()],
        Study("solid fraction 0.1, `-scheme coupled -steady`, disordered particles",
              f"{coupled} -solid_fraction 0.1 -jitter 0.25", (25, 50, 100), quantities, (5, 3, 3), seeds, watch=watch),
        *[Study(f"solid fraction {c}, `-scheme projection`, t = 10", f"{base} -solid_fraction {c}", (25, 50, 100),
                quantities, watch=f"{watch} -probe_every 10") for c in (0.1, 0.3)],
        *[Study(f"solid fraction {c}, `-scheme projection`, pressure on coarse points, t = 10",
                f"{base} -solid_fraction {c} -pressure_points coarse", (25, 50, 100), quantities,
                watch=f"{watch} -probe_every 10") for c in (0.1, 0.3)],
    ], [Chart("coupled, finest n", "drag", ("solid fraction", "drag/(mu U)"), {t: c for c, t in titles.items()})],
        ("drag over mu U, from the mean velocity", "traction on the cylinder"))


def stokes_exact():
    base = "-options_file options/stokes_exact.opts"
    quantities = [norm("velocity", "velocity, relative L2", "velocity_l2"),
                  norm("velocity", "velocity, relative maximum", "velocity_linf"),
                  norm("pressure", "pressure, relative L2", "pressure_l2"),
                  Quantity("force", "shear force on the bottom", "forces_bottom_fx", PI**2, "exact solution"),
                  Quantity("force", "pressure force on left and right", sums("forces_left_fx", "forces_right_fx"), 20.0,
                           "exact solution")]
    creeping = "-options_file options/creeping.opts"
    line = "0,0.5,1,0.5,81"
    return Case("Creeping flow, velocity and pressure together", [
        Study("exact flow, `-scheme coupled -steady`, disordered particles", base, (16, 32, 64, 128), quantities,
              (5, 5, 3, 1), seeds, "-probe_forces"),
        Study("exact flow, `-scheme coupled -steady`, lattice", f"{base} -jitter 0", (16, 32, 64, 128), quantities,
              watch="-probe_forces"),
        Study("the same flow in two steps of dt = 1", f"{base} -steady 0 -dt 1 -t_end 2", (16, 32, 64), quantities,
              (3, 3, 1), seeds, "-probe_forces -probe_every 2"),
        Study("lid-driven cavity, creeping, lattice", creeping, (25, 50, 100, 200),
              [*creeping_extrema(),
               Quantity("pressure", "p(0, 0.5) - p(1, 0.5)", sums("point_0_p", "-point_1_p")),
               Quantity("force", "shear force on the bottom", "forces_bottom_fx")],
              watch="-probe_point 0,0.5,1,0.5 -probe_forces"),
    ], [
        Panel("exact flow, n = 32", f"{base} -n 32", "0.5,0,0.5,1,81", "y", "u", ("y/L", "u/U at x = 0.5"), 0,
              lambda y: PI * math.sin(2 * PI * y)),
        Panel("exact flow, n = 32", f"{base} -n 32", line, "x", "p", ("x/L", "p/(rho U^2) at y = 0.5"), 0,
              lambda x: 20 * (x**3 - 0.25) + 30 * (x - 0.5) * (0.25 - 1 / 3), centred=True),
    ], ("velocity, relative L2", "pressure, relative L2", "shear force on the bottom"))


# ---- viscosity that varies ----

def two_layers():
    layers, rings = "-options_file options/fluids.opts", "-options_file options/fluids_turning.opts"
    field = "-options_file options/viscosity_field.opts"
    flow = [norm("velocity", "velocity, relative L2", "velocity_l2"),
            norm("velocity", "velocity, relative maximum", "velocity_linf")]
    thousand = (f"{layers} -scene_fluid_1 box,-1,0.513,2,2 -scene_fluid_1_viscosity 1e3 "
                '-scene_exact "y < 0.513 ? 1.9474689719506*y : 1 - 0.0019474689719506*(1 - y), 0"')
    watch = "-probe_forces -probe_every 1e6"
    return Case("Fluids of different viscosity", [
        Study("two layers, contrast 1e6, interface between rows", layers, (25, 50, 100),
              [*flow, Quantity("force", "shear force on the wall of the thinner fluid", "forces_bottom_fx",
                               0.16 * 2 / (1 + 1e-6), "exact solution")], watch=watch),
        Study("two layers, contrast 1e3, interface cuts a row, disordered particles", f"{thousand} -jitter 0.25",
              (25, 50, 100),
              [*flow, Quantity("force", "shear force on the wall of the thinner fluid", "forces_bottom_fx",
                               0.16 * 1.9474689719506, "exact solution")], (5, 3, 3), seeds, watch),
        Study("two fluids between cylinders, contrast 1e6, the inner one turns as one piece", rings, (20, 40, 80),
              [*flow, Quantity("force", "torque on the outer cylinder", "forces_body_2_tz", 4 * PI * 18 / 7,
                               "exact solution, infinite contrast")], watch=watch),
        Study("viscosity 1 + 9 y, disordered particles", field, (25, 50, 100),
              [*flow, Quantity("force", "shear force on the lower wall", "forces_bottom_fx", 0.32 * 9 / math.log(10),
                               "exact solution")], (5, 3, 3), seeds, watch),
    ], [
        Panel("contrast 1e3, n = 50, jitter 0.25", f"{thousand} -jitter 0.25 -n 50", "0.08,0,0.08,1,81", "y", "u",
              ("y/L", "u/U"), 1e6, lambda y: 1.9474689719506 * y if y < 0.513 else 1 - 0.0019474689719506 * (1 - y)),
        Panel("two fluids between cylinders, n = 40", f"{rings} -n 40", "0.5,0,1,0,81", "x", "v", ("r/L", "u_theta/U"),
              1e6, lambda r: 2 * r if r < 0.75 else 18 / 7 * (1 / r - r)),
        Panel("nu = 1 + 9 y, n = 25", f"{field} -n 25", "0.16,0,0.16,1,81", "y", "u", ("y/L", "u/U"), 1e6,
              lambda y: math.log(1 + 9 * y) / math.log(10)),
    ], ("velocity, relative L2", "shear force on the wall of the thinner fluid", "torque on the outer cylinder",
        "shear force on the lower wall"))


def power_law_u(y, n):
    """Steady flow between plates with force 8 and K = 1, U = L = 1."""
    tau = 4.0
    return n / (n + 1) * tau ** (1 / n) / 2 * (1 - abs(2 * y - 1) ** (1 + 1 / n))


def bingham_u(y):
    """Yield stress 2, half that at the wall: nu = 1, force 8."""
    s = max(abs(y - 0.5), 0.25)
    return 4 * (0.25 - s * s) - 2 * (0.5 - s)


def rheology():
    power = "-options_file options/power_law.opts"
    plastic = "-options_file options/bingham.opts"
    quantities = [norm("velocity", "profile, rms over the largest velocity", "u_profile_l2"),
                  norm("velocity", "profile, relative rms", "u_relative_rms"),
                  Quantity("force", "shear force on a wall", per_length("forces_bottom_fx"), 4.0, "momentum balance")]
    watch = "-probe_forces -probe_every 500"
    return Case("Viscosity that follows the strain rate", [
        Study("power law, exponent 0.5", power, (25, 50, 100), quantities, watch=watch),
        Study("power law, exponent 1.5", f"{power} -rheology_exponent 1.5", (25, 50, 100), quantities, watch=watch),
        Study("power law, exponent 0.5, whole stress, disordered particles",
              f"{power} -visc_laplacian stress_mls -jitter 0.25", (25, 50, 100), quantities, (5, 3, 3), seeds, watch),
        Study("Carreau, exponent 0.5, lambda = 5 L/U", f"{power} -rheology carreau -rheology_time 5", (25, 50, 100),
              quantities, watch=watch),
        Study("Bingham, plug of half the width, Papanastasiou with m = 1e4 L/U", plastic, (25, 50, 100), quantities,
              watch=watch),
    ], [
        *[Panel(f"power law, exponent {n}, n = 50", f"{power} -rheology_exponent {n} -n 50", "0.08,0,0.08,1,81", "y",
                "u", ("y/L", "u/U"), 500, lambda y, n=n: power_law_u(y, n)) for n in (0.5, 1.5)],
        Panel("Bingham, n = 50", f"{plastic} -n 50", "0.08,0,0.08,1,81", "y", "u", ("y/L", "u/U"), 500, bingham_u),
    ], ("profile, rms over the largest velocity", "shear force on a wall"))


# ---- typed scenes, and operators alone ----

def womersley_u(y, alpha):
    """Velocity at a quarter of a period, in which the force is zero: Re(1 - cosh(K (y - 1/2))/cosh(K/2))."""
    k = 2 * alpha * cmath.sqrt(1j)
    return (1 - cmath.cosh(k * (y - 0.5)) / cmath.cosh(k / 2)).real


def womersley():
    base = "-options_file options/womersley.opts"
    alphas = {1: f"{base} -viscosity 7.85398163", 4: f"{base} -viscosity 0.490873852", 12.5: base}
    flow = [norm("velocity", "velocity, relative L2", "velocity_l2"),
            norm("velocity", "velocity, relative maximum", "velocity_linf")]
    return Case("Oscillating flow between plates (Womersley)", [
        *(Study(f"Womersley number {alpha}, moving particles", run, (16, 32, 64), flow)
          for alpha, run in alphas.items()),
        Study("Womersley number 12.5, fixed particles", f"{base} -motion eulerian", (16, 32, 64), flow),
        Study("Womersley number 12.5, coupled scheme", f"{base} -scheme coupled", (16, 32), flow),
        Study("Womersley number 12.5, steps by the CFL number", f"{base} -dt_adapt cfl", (16, 32, 64), flow),
        Study("Womersley number 12.5, tolerance 1e-4", f"{base} -dt_rtol 1e-4", (16, 32, 64), flow),
    ], [Panel(f"Womersley number {alpha}, n = 32", f"{run} -n 32", "0.25,0,0.25,1,81", "y", "u", ("y/L", "u/U"), 0.45,
              lambda y, alpha=alpha: womersley_u(y, alpha)) for alpha, run in alphas.items()],
        ("velocity, relative L2",))


def scene():
    forced, second = "-options_file options/scene_expressions.opts", "-options_file options/stokes_second.opts"
    channel = ("-case scene -scene_box 0,0,2,1 -scene_periodic x -scene_body_1 circle,0.6,0.5,0.2 -body_force 1,0 "
               "-viscosity 0.1 -t_end 4")
    flow = [norm("velocity", "velocity, relative L2", "velocity_l2"),
            norm("velocity", "velocity, relative maximum", "velocity_linf")]
    pressure = norm("pressure", "pressure, relative L2", "pressure_l2")
    k = math.sqrt(PI / 0.05)
    area = 2 - 0.04 * PI
    channel_quantities = [
        Quantity("force", "sum of the forces on walls and cylinder",
                 sums("forces_bottom_fx", "forces_top_fx", "forces_body_1_fx"), area, "momentum balance"),
        Quantity("force", "force on the cylinder along x", "forces_body_1_fx"),
        Quantity("energy", "kinetic energy", "kinetic_energy"),
        Quantity("pressure", "p(0.3, 0.5) - p(0.9, 0.5)", sums("point_0_p", "-point_1_p"))]
    watch = "-probe_forces -probe_point 0.3,0.5,0.9,0.5 -probe_every 4"
    return Case("Typed scenes", [
        Study("forced flow in a box with driven walls, Re = 10, fixed particles", f"{forced} -motion eulerian",
              (16, 32, 64), [*flow, pressure]),
        Study("the same, moving particles", forced, (16, 32), [*flow, pressure], (3, 3)),
        Study("Stokes' second problem, one period, dt = 0.00125", f"{second} -dt 0.00125", (20, 40, 80),
              [*flow, Quantity("force", "shear force on the wall", "forces_bottom_fx", -0.05 * k * 0.4,
                               "exact solution")], watch="-probe_forces -probe_every 1"),
        Study("channel with a cylinder, steady, fixed particles, coupled scheme",
              f"{channel.replace(' -t_end 4', '')} -motion eulerian -scheme coupled -steady", (16, 32, 64),
              channel_quantities, watch=watch.replace(" -probe_every 4", "")),
        Study("channel with a cylinder, t = 4, fixed particles", f"{channel} -motion eulerian", (16, 32, 64),
              channel_quantities, watch=watch),
        Study("channel with a cylinder, t = 4, moving particles", channel, (16, 32, 64), channel_quantities, (5, 3, 1),
              watch=watch),
    ], [
        Panel("forced flow, n = 32, fixed", f"{forced} -motion eulerian -n 32", "0.25,0,0.25,1,81", "y", "u",
              ("y/L", "u/U at x = 0.25"), 1, lambda y: math.sin(PI / 4) * math.cos(PI * y)),
        Panel("forced flow, n = 32, fixed", f"{forced} -motion eulerian -n 32", "0.25,0,0.25,1,81", "y", "p",
              ("y/L", "p/(rho U^2) at x = 0.25"), 1, lambda y: math.sin(0.25 + 2 * y), centred=True),
        Panel("Stokes' second problem, n = 40", f"{second} -dt 0.00125 -n 40", "0.2,0,0.2,1,81", "y", "u",
              ("y/L", "u/U"), 1, lambda y: math.exp(-k * y) * math.cos(k * y)),
    ], ("velocity, relative L2", "pressure, relative L2", "shear force on the wall",
        "sum of the forces on walls and cylinder"))


def regularised_cavity():
    base = "-options_file options/regularised_cavity.opts"
    fixed, coarse = "-motion eulerian", "-motion eulerian -pressure_points coarse"
    end = {1: "-t_end 0.5 -report_times 0.1,0.25", 100: "-t_end 10 -report_times 2.5,5",
           1000: "-t_end 20 -report_times 5,10"}
    half = {1: "0.25", 100: "5", 1000: "10"}
    sides = (16, 32, 64, 128)

    def study(title, re, how, sides):
        words = " ".join(("-reynolds", str(re), *how.split(), end[re]))
        return Study(f"Re = {re}, {title}", f"{base} {words}", sides,
                     [norm("velocity", "velocity, relative L2", "velocity_l2"),
                      norm("velocity", f"the same at t = {half[re]}", f"velocity_l2@{half[re]}"),
                      norm("velocity", "velocity, relative maximum", "velocity_linf"),
                      norm("pressure", "pressure, relative L2", "pressure_l2"),
                      norm("pressure", f"the same at t = {half[re]}", f"pressure_l2@{half[re]}")])

    waves, driven = "-options_file options/channel_waves.opts", "-options_file options/scene_expressions.opts"
    flow = [norm("velocity", "velocity, relative L2", "velocity_l2"),
            norm("pressure", "pressure, relative L2", "pressure_l2")]
    walls = ("wall_layer", "dummy_linear", "mirror", "linear", "quadratic", "global_quadratic", "adami")
    shown = "-options_file options/regularised_cavity.opts -reynolds 100 -t_end 10 -report_times 2.5,5 -n 32"
    return Case("Regularised cavity, and every wall treatment", [
        *(study("moving particles", re, "", sides if re < 1000 else sides[:3]) for re in end),
        *(study("fixed particles, pressure on coarse points", re, coarse, sides if re < 1000 else (96, 128))
          for re in end),
        *(study("fixed particles", re, fixed, sides) for re in end),
        *(study("fixed particles, coupled scheme", re, f"{fixed} -scheme coupled", sides[:3 if re < 1000 else 2])
          for re in end),
        *(Study(f"{name}, `-wall {wall}`", f"{case} -wall {wall} {coarse}", sides[:3], flow)
          for name, case in (("waves in a channel", waves), ("box with driven walls", driven))
          for wall in walls if case == waves or wall != "global_quadratic"),
    ], [
        Panel("Re = 100, n = 32, moving", shown, ALONG_Y, "y", "u", ("y/L", "u/U at x = 0.5"), 10,
              lambda y: 0.5 * (4 * y**3 - 2 * y)),
        Panel("Re = 100, n = 32, moving", shown, "0,0.9,1,0.9,81", "x", "p", ("x/L", "p/(rho U^2) at y = 0.9"), 10,
              lambda x: shih_pressure(x, 0.9, 0.01), centred=True),
    ], ("velocity, relative L2", "pressure, relative L2"))


def shih_pressure(x, y, nu):
    """Pressure of the regularised cavity over rho."""
    return (8 * nu * ((4 * x**3 - 6 * x * x + 2 * x) * (4 * y**3 - 2 * y) + 24 * y * (x**5 / 5 - x**4 / 2 + x**3 / 3))
            - 64 * (x * (1 - x)) ** 4 * (2 * y**6 - y**4 + y * y))


def patch():
    base = "-options_file options/patch.opts -patch_spectrum 0 -patch_field wave"
    quantities = [norm("operator", "Laplacian, relative L2", "laplacian_l2", "exact field"),
                  norm("operator", "Laplacian, relative maximum", "laplacian_linf", "exact field"),
                  norm("operator", "solution of a Poisson problem, relative L2", "solution_l2", "exact field")]
    return Case("Patch test", [
        Study(f"`{form}`, disordered particles", f"{base} -visc_laplacian {form}", (25, 50, 100, 200), quantities,
              (5, 3, 3, 1), seeds) for form in ("mls", "mls3", "schwaiger", "morris")
    ], [], ("Laplacian, relative L2", "solution of a Poisson problem, relative L2"))


CASES = {make.__name__: make for make in (
    cavity, cavity_cube, cavity_cylinder, taylor_couette, taylor_green, poiseuille, couette, hydrostatic,
    stokes_cylinders, stokes_exact, two_layers, rheology, womersley, scene,
    regularised_cavity, patch)}
