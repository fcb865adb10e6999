"""The cavities of studies/verify: their runs, quantities, references and pictures."""
from runs import reference_rows
from verification_parts import Case, Panel, Quantity, Study, norm, report, sums

FV = "finite volumes, extrapolated"
BP = "Botella & Peyret"
BRUNEAU = "Bruneau & Saad"
CAVITY = "-options_file options/cavity.opts"
MIDDLE = "-probe_point 0.5,0,0.5,0.5,0.5,1 -probe_forces -probe_every "
VORTEX = "0.5308,0,0.5308,0.5652"  # from the bottom to the centre of the vortex: the flux is the streamfunction there
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
    """Points of the centrelines with the pressures of the tables, less that in the middle, which comes first."""
    points = {(0.5, 0.5): 0.0}
    points.update({(0.5, float(row["y"])): float(row["p"]) for row in reference_rows("botella_peyret_re1000_p.csv")})
    points.update({(float(row["x"]), 0.5): float(row["p"])
                   for row in reference_rows("botella_peyret_re1000_p_horizontal.csv")})
    return points


def pressure_error(tables, axis):
    """The largest error on the centreline where coordinate `axis` is 0.5, over the range of all pressures."""
    span = max(tables.values()) - min(tables.values())
    of_line = [(f"point_{k}_p", p) for k, (point, p) in enumerate(tables.items()) if point[axis] == 0.5]

    def error(row):
        if any(name not in row for name, _ in of_line):
            return None
        return max(abs(row[name] - row["point_0_p"] - p) for name, p in of_line) / span
    return error


def steady_quantities(tables):
    return [
        *centrelines(BP, False),
        Quantity("energy", "kinetic energy", "kinetic_energy", 0.044503, BRUNEAU),
        Quantity("velocity", "streamfunction in the centre of the vortex", "flux_0_flux", -0.11892, BRUNEAU),
        *[norm("pressure", f"pressure on {line} = 0.5, largest error over the range", pressure_error(tables, axis), BP)
          for axis, line in enumerate("xy")],
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
    tables = tabulated_pressures()
    watch = f"-probe_point {','.join(f'{x},{y}' for x, y in tables)} -probe_flux {VORTEX} -probe_forces -probe_every 80"
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
        *[Study(f"Re = 1000, t = 80 (steady), {name}", arguments, sides, steady_quantities(tables), watch=watch)
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


def shih_pressure(x, y, nu):
    """Pressure of the regularised cavity over rho."""
    return (8 * nu * ((4 * x**3 - 6 * x * x + 2 * x) * (4 * y**3 - 2 * y) + 24 * y * (x**5 / 5 - x**4 / 2 + x**3 / 3))
            - 64 * (x * (1 - x)) ** 4 * (2 * y**6 - y**4 + y * y))


def regularised_cavity():
    base = "-options_file options/regularised_cavity.opts"
    fixed = "-motion eulerian"
    same, coarse = (f"{fixed} -pressure_points {points}" for points in ("same", "coarse"))
    times = {1: (0.1, 0.25, 0.5), 100: (2.5, 5, 10), 1000: (5, 10, 20)}
    sides = (16, 32, 64, 128)

    def study(title, re, how, sides):
        first, half, end = times[re]
        words = " ".join(("-reynolds", str(re), *how.split(), f"-t_end {end} -report_times {first},{half}"))
        return Study(f"Re = {re}, {title}", f"{base} {words}", sides,
                     [norm("velocity", "velocity, relative L2", "velocity_l2"),
                      norm("velocity", f"the same at t = {half}", f"velocity_l2@{half}"),
                      norm("velocity", "velocity, relative maximum", "velocity_linf"),
                      norm("pressure", "pressure, relative L2", "pressure_l2"),
                      norm("pressure", f"the same at t = {half}", f"pressure_l2@{half}")])

    waves, driven = "-options_file options/channel_waves.opts", "-options_file options/scene_expressions.opts"
    flow = [norm("velocity", "velocity, relative L2", "velocity_l2"),
            norm("pressure", "pressure, relative L2", "pressure_l2")]
    walls = ("wall_layer", "dummy_linear")
    shown = "-options_file options/regularised_cavity.opts -reynolds 100 -t_end 10 -report_times 2.5,5 -n 32"
    return Case("Regularised cavity, and both wall treatments", [
        *(study("moving particles", re, "", sides if re < 1000 else sides[:3]) for re in times),
        *(study("fixed particles, pressure on coarse points", re, coarse, sides if re < 1000 else (96, 128))
          for re in times),
        *(study("fixed particles, pressure on the particles", re, same, sides) for re in times),
        *(study("fixed particles, coupled scheme", re, f"{fixed} -scheme coupled", sides[:3 if re < 1000 else 2])
          for re in times),
        *(Study(f"{name}, `-wall {wall}`", f"{case} -wall {wall} {coarse}", sides[:3], flow)
          for name, case in (("waves in a channel", waves), ("box with driven walls", driven))
          for wall in walls),
    ], [
        Panel("Re = 100, n = 32, moving", shown, ALONG_Y, "y", "u", ("y/L", "u/U at x = 0.5"), 10,
              lambda y: 0.5 * (4 * y**3 - 2 * y)),
        Panel("Re = 100, n = 32, moving", shown, "0,0.9,1,0.9,81", "x", "p", ("x/L", "p/(rho U^2) at y = 0.9"), 10,
              lambda x: shih_pressure(x, 0.9, 0.01), centred=True),
    ], ("velocity, relative L2", "pressure, relative L2"))
