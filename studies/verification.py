"""The cases of studies/verify, by name; those of cavities have a file of their own."""
import cmath
import math

from verification_cavities import cavity, cavity_cube, cavity_cylinder, creeping_extrema, regularised_cavity
from verification_parts import Case, Chart, Panel, Quantity, Study, norm, report, seeds, sums

PI = math.pi


def per_length(name):
    """A force on a wall of a channel, which is 8 dx long, per L of its length; n is an eighth of its particles."""
    return lambda row: row[name] * row["particles"] / 64 if name in row else None


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
        *[Study(f"solid fraction {c}, `-scheme projection`{points}, t = 10", f"{base} -solid_fraction {c}{option}",
                (25, 50, 100), quantities, watch=f"{watch} -probe_every 10")
          for points, option in (("", ""), (", pressure on the particles", " -pressure_points same"))
          for c in (0.1, 0.3)],
    ], [Chart("coupled, finest n", "drag", ("solid fraction", "drag/(mu U)"), {t: c for c, t in titles.items()})],
        ("drag over mu U, from the mean velocity", "traction on the cylinder"))


def stokes_spheres():
    base = "-options_file options/stokes_spheres.opts"
    quantities = [report("force", "drag over 6 pi mu a U, from the mean velocity", "drag", "series"),
                  report("force", "traction on the sphere", "traction", "momentum balance")]
    titles = {c: f"solid fraction {c}, projection" for c in (0.064, 0.027, 0.125)}
    return Case("Creeping flow through an array of spheres", [
        *[Study(title, f"{base} -solid_fraction {c}", (12, 16, 24, 32) if c == 0.064 else (16, 24), quantities)
          for c, title in titles.items()],
        Study("solid fraction 0.064, projection, disordered particles", f"{base} -jitter 0.2", (12, 16, 24), quantities,
              (3, 3, 1), seeds),
        Study("solid fraction 0.064, `-scheme coupled`", f"{base} -scheme coupled", (12, 16, 24), quantities),
    ], [Chart("projection, finest n", "drag", ("solid fraction", "drag/(6 pi mu a U)"), {t: c for c, t in titles.items()})],
        ("drag over 6 pi mu a U, from the mean velocity", "traction on the sphere"))


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


# ---- free surfaces ----

def film_u(y, t):
    """Velocity of a film that starts from rest: g sin 30 = nu = H = 1."""
    odd = [(m + 0.5) * PI for m in range(20)]
    return 0.5 * (y - y * y / 2 - 2 * sum(math.sin(k * y) * math.exp(-k * k * t) / k**3 for k in odd))


def film():
    base = "-options_file options/film.opts -dt 1.25e-3"
    fixed = f"{base} -without convection"
    quantities = [norm("velocity", "velocity, relative L2", "velocity_l2"),
                  norm("velocity", "velocity, relative maximum", "velocity_linf"),
                  norm("pressure", "pressure, relative L2", "pressure_l2")]
    return Case("Film down a slope", [
        Study("nu t/H^2 = 0.2, fixed disordered particles", f"{fixed} -jitter 0.2", (10, 20, 40), quantities, (3, 3, 3),
              seeds),
        Study("nu t/H^2 = 0.2, moving disordered particles", f"{base} -jitter 0.2", (10, 20, 40), quantities, (3, 3, 3),
              seeds),
        Study("nu t/H^2 = 0.2, fixed particles on the lattice", fixed, (10, 20, 40), quantities),
    ], [Panel("n = 20, moving", f"{base} -jitter 0.2 -n 20", "0.25,0,0.25,1,41", "y", "u", ("y/H", "u nu/(g H^2)"), 0.2,
              lambda y: film_u(y, 0.2)),
        Panel("n = 20, moving", f"{base} -jitter 0.2 -n 20", "0.25,0,0.25,1,41", "y", "p", ("y/H", "p/(rho g H)"), 0.2,
              lambda y: math.sqrt(0.75) * (1 - y))],
        ("velocity, relative L2", "pressure, relative L2"))


def drop_mode():
    base = "-options_file options/drop_mode.opts"
    quantities = [norm("velocity", "velocity, relative L2", "velocity_l2"),
                  norm("velocity", "velocity, relative maximum", "velocity_linf"),
                  norm("pressure", "pressure, relative L2", "pressure_l2")]
    moving = "-with convection -speed 1e-3 -viscosity 1 -t_end 0.05"
    return Case("Decay of a mode of a viscous drop", [
        Study("nu t/R^2 = 0.1, fixed particles, dt = 5e-4 R^2/nu", f"{base} -dt 5e-4", (8, 16, 32, 64), quantities),
        Study("nu t/R^2 = 0.1, fixed particles, dt = 5e-3 R^2/nu", f"{base} -dt 5e-3", (8, 16, 32), quantities),
        Study("nu t/R^2 = 0.05, particles that move by 1e-3 R, dt = 5e-4 R^2/nu", f"{base} {moving} -dt 5e-4",
              (8, 16, 32), quantities),
        Study("Ball, nu t/R^2 = 0.1, dt = 2e-3 R^2/nu", f"{base} -dim 3", (6, 8, 12), quantities),
    ], [], ("velocity, relative L2", "pressure, relative L2"))


def standing_wave():
    base = "-options_file options/standing_wave.opts"

    def amplitude(row):
        return (row["amplitude"] - row["amplitude_reference"]) / 0.01 if "amplitude" in row else None

    quantities = [Quantity("velocity", "amplitude of the surface, over the first crest", amplitude, True,
                           "exact linear solution"),
                  norm("velocity", "velocity, relative L2", "velocity_l2", "exact linear solution")]
    return Case("Standing wave on a viscous fluid", [
        Study("t = 1.2, from the lattice", base, (16, 24, 32, 48), quantities),
        Study("t = 1.2, disordered particles", f"{base} -jitter 0.2", (16, 24, 32, 48), quantities, (3, 3, 3, 3), seeds),
        Study("t = 1.2, dt = 0.005", f"{base} -scheme coupled -dt 0.005", (16, 24, 32, 48), quantities),
    ], [], ("amplitude of the surface, over the first crest", "velocity, relative L2"))


def gravity_current():
    base = "-options_file options/gravity_current.opts"

    def beside(label, column, source):
        def error(row):
            return row[column] / row[f"{column}_reference"] - 1 if column in row else None
        return Quantity("velocity", label, error, True, source)

    quantities = [beside("front", "front", "similarity solution"), beside("height", "height", "similarity solution"),
                  beside("volume inside the surface", "fluid_volume", "volume of the particles")]
    return Case("Viscous gravity currents, plane and round", [
        Study("plane, from the age 1 to 2", f"{base} -t_end 5.77", (4, 6), quantities),
        Study("round, from the age 1 to 1.25", f"{base} -dim 3 -t_end 0.9", (4, 5), quantities),
    ], [], ("front", "height"))


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
              [*flow, Quantity("force", "torque on the outer cylinder", "forces_domain_tz", 4 * PI * 18 / 7,
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
    beltrami = "-options_file options/beltrami.opts"
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
        Study("Beltrami flow in a cube, fixed particles", f"{beltrami} -motion eulerian", (12, 16, 24), [*flow, pressure]),
        Study("the same, moving particles, jitter 0.2 dx", f"{beltrami} -jitter 0.2", (12, 16, 24), [*flow, pressure],
              (3, 3, 1), seeds),
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
    stokes_cylinders, stokes_spheres, stokes_exact, film, drop_mode, standing_wave, gravity_current, two_layers, rheology, womersley, scene,
    regularised_cavity, patch)}
