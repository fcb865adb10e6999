"""Page and figure of studies/basa_cavity."""
import basa_cavity_runs as runs
import basa_parts as parts
import matplotlib
from runs import reference_rows, table

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

LOOKS = {name: (parts.COLOURS[name[0]], {"none": ":", "mixed": "--"}.get(name.split(", ")[1], "-"))
         for name in runs.SERIES if ", " in name} | {"wcsph": ("#666666", "-"), "projection": ("#666666", "--")}


SHARES = (0.25, 0.5, 0.75, 1)


def head(end):
    """Returns the head of the tables of results to a time."""
    return ["series", "end", *(f"energy, t = {end * share:g}" for share in SHARES), "min u", "u profile", "v profile", "CPU, s"]


def energies(q, reynolds):
    """Returns pairs of time and kinetic energy [U^2 L^2]."""
    return parts.series(q, "kinetic_energy", runs.TIMES[reynolds])


def off(q, times, share):
    """Returns the relative error of the energy at a share of the last of 20 times as text; the energy without a reference."""
    end = times[round(20 * share) - 1]
    name = "" if abs(q.get("t", 0.0) - end) < 1e-9 * end else f"@{end:.4g}"
    if "kinetic_energy" + name not in q:
        return ""
    if "kinetic_energy_reference" + name not in q:
        return f"{q['kinetic_energy' + name]:.4f}"
    return f"{100 * (q['kinetic_energy' + name] / q['kinetic_energy_reference' + name] - 1):+.1f} %"


def state(q):
    """Returns the end of a run as text."""
    if not q:
        return "no run"
    if "failed" not in q:
        return "reaches its end"
    if "CPU time" in q["failed"]:
        return f"stopped at t = {q.get('t', 0.0):.3g} by its CPU time"
    return f"lost at t = {q.get('failed_t', q.get('t', 0.0)):.3g}"


def results(runs_by_name, times):
    """Yields rows: series, end, errors of energy and profiles, CPU time."""
    for name, q in runs_by_name.items():
        yield [name, state(q), *(off(q, times, share) for share in SHARES),
               *(f"{q[key]:.3f}" if key in q else "" for key in ("u_min", "u_profile_l2", "v_profile_l2")), f"{q.get('cpu_s', 0):.3g}"]


def readings(run):
    """Yields rows: reading, end, energy and its error."""
    for name, options in runs.READINGS.items():
        q = runs.reading(run, options)
        yield [name, state(q), *(off(q, runs.TIMES[100], share) for share in (0.05, 0.1, 0.25))]


def walls(run):
    """Yields rows: series, then Re = 100 and 1000 with each kind of wall: end and error of the energy at t = 2.5."""
    for name in runs.DUMMIES:
        found = [runs.cavity(run, options[name], reynolds) for reynolds in runs.ENDS for options in (runs.SERIES, runs.DUMMIES)]
        yield [name, *(cell for reynolds, q in zip((100, 100, 1000, 1000), found) for cell in (state(q), off(q, runs.TIMES[reynolds], 0.25)))]


def energy_and_profiles(run, reynolds, n):
    """Yields the lines of a table of runs to the time of the paper."""
    made = {name: runs.long(run, name, reynolds, n) for name in (runs.LONG if n == runs.LONG_N else runs.LASTING)}
    yield from table(head(runs.LONG_ENDS[reynolds]), results({name: q for name, q in made.items() if q}, runs.LONG_TIMES[reynolds]))


def page(run):
    """Yields the lines of the page."""
    yield "# Viscous models of Basa, Quinlan & Lastiwka (2009) in the lid-driven cavity\n"
    yield ("Written by `studies/basa_cavity`; every run is in [basa_cavity.csv](basa_cavity.csv). The flow is that of section 6.2 "
           f"of Int. J. Numer. Meth. Fluids 60 (2009) 1127-1148, from rest, at Re = 100 and 1000: all models with {runs.N} by "
           f"{runs.N} particles to t = 10, some with {runs.LONG_N} by {runs.LONG_N} to t = 20 and 80 as in the paper. Models without "
           "a row were not run. Units are L and U.\n")
    yield "![Kinetic energy against time, and velocity on the vertical centreline](basa_cavity.png)\n"
    yield "## Statements of the paper\n"
    yield from table(["statement", "found", "in numbers"], STATEMENTS)
    yield "\n" + READING
    yield "## Settings\n"
    yield (f"`isph -case cavity -n {runs.N} -reynolds RE {runs.PAPER} {runs.REDUCED} -correction C -visc_laplacian FORM`; `wcsph` and "
           "`projection` have the defaults of the project. The forms are "
           + ", ".join(f"{model}: `{form}`" for model, form in parts.MODELS.items())
           + f". A run to t = 10 has at most {runs.SECONDS:g} s of CPU time.\n")
    yield ("Section 6.2 says of its walls: \"Walls are modelled using stationary particles, with tangential velocities extrapolated normally "
           "to the wall, using information gathered by the wall particles closest to the fluid. Density and pressure of wall particles are "
           "allowed to evolve according to the continuity and state equations.\" Here these are the equations (walls:density) and (walls:extended) of the "
           "[theory](../theory/walls.md#53-dummy-particles). The reading of \"information\" as the mean over the kernel of a wall particle of the first layer is ours.\n")
    for reynolds, end in runs.ENDS.items():
        yield f"## Re = {reynolds}\n"
        yield ("Energy against finite volumes (`cases/reference`), smallest u on the centreline, and root mean squares of the "
               f"errors of both profiles at t = {end:g}, for which Re = 100 has a reference.\n")
        found = {name: runs.cavity(run, options, reynolds) for name, options in runs.SERIES.items()}
        yield from table(head(end), results(found, runs.TIMES[reynolds]))
        yield ""
    for reynolds, n in ((1000, runs.N), (1000, runs.LONG_N), (100, runs.LONG_N)):
        yield f"## Re = {reynolds} to t = {runs.LONG_ENDS[reynolds]:g}, n = {n}\n"
        yield ("Errors of the energy to t = 40, then the energy itself, which is 0.0445 in the steady flow (Bruneau & Saad "
               "2006); profiles against the steady flow.\n" if reynolds == 1000 else "Errors of the energy; profiles against the steady flow.\n")
        yield from energy_and_profiles(run, reynolds, n)
        yield ""
    yield "## Walls\n"
    yield ("The same sums beside two kinds of wall, n = 25: the paper's, `dynamic`, and dummies with the pressure of the particle that "
           "reads them, `dummy_linear`. Ends of runs, and errors of the energy at t = 2.5.\n")
    yield from table(["series", *(f"Re = {reynolds}, {wall}{what}" for reynolds in runs.ENDS for wall in ("dynamic", "dummies")
                                  for what in ("", ", t = 2.5"))], walls(run))
    yield "\n## Readings of ambiguous settings\n"
    yield "Model E with `shepard`, Re = 100; one setting changed. Errors of the energy.\n"
    yield from table(["reading", "end", *(f"t = {runs.ENDS[100] * share:g}" for share in (0.05, 0.1, 0.25))], readings(run))


STATEMENTS = [
    ["Re = 100: all but B are close to the reference", "yes, 9 to 17 % slow", "energy at t = 10: A -9 %, C -11 %, D -11 %, E -17 %; B +149 %"],
    ["B clumps and is agitated", "yes", "Re = 100: +16 % at t = 2.5, +149 % at t = 10"],
    ["B fails at Re = 1000 with corrections", "yes", "n = 25: lost at t = 13"],
    ["A is stable with order 0, and noisy", "to t = 40", "u profile at Re = 100: A 0.030, C and D 0.015; Re = 1000, n = 25: lost at t = 43"],
    ["E has spikes of energy, most without correction", "yes", "Re = 100: without correction lost at t = 7.1; shepard and mixed reach the end"],
    ["C is nearly as accurate as D", "yes", "Re = 100: profiles 0.015 and 0.016 (C), 0.015 and 0.012 (D), 0.026 and 0.022 (E)"],
    ["D is the best by a small margin", "yes", "the same; Re = 1000, n = 25, t = 80: u profile 0.110 (D), 0.121 (E), 0.129 (C)"],
    ["Re = 100 at 50 by 50: D is close to the reference", "within 6 %", "D at t = 20: energy -5.3 %, u profile 0.010; wcsph -0.2 %, 0.011"],
    ["Re = 1000: all models have too little energy", "all but B", "t = 10, n = 25: C -53 %, D -55 %, E -55 %, A -16 %, B +100 %; t = 40, n = 50: D -31 %"],
    ["Re = 1000: the models last to t = 80", "C, D, E", "n = 25: C, D, E, and at n = 50 D; A and B are lost"],
    ["more robust than the channel", "yes", "D at Re = 1000 has no end before t = 80 L/U; in the channel E is lost at 19 L/U"],
]
READING = """The walls decide. With the walls of the paper, particles that stay behind the wall and have densities and pressures of their own
(`-wall dynamic`, [(walls:density)](../theory/walls.md#walls:density)), the order of the paper holds at both Reynolds numbers: radial forces (C, D) are the quietest
and the most accurate, B clumps, A is noisy, and at Re = 1000 all but B have too little energy. Before, walls were dummies with the pressure
of the particle that reads them. They pull particles of negative pressure to the wall, energy grows from t = 1 on, and no model outlived
t = 7.2 at Re = 1000; the [table of walls](#walls) has both. No step, reduction of the pressure or correction changes this.

What remains is too little energy: D at Re = 1000 and t = 40 has -55 % at n = 25 and -31 % at n = 50, and u profiles at t = 80 that err by 0.110 U and
0.056 U. The walls' velocities are not its cause: extrapolated from each particle, as those of `dummy_linear`, beside walls with densities, they gave A -32 %, C -52 %,
D -46 % and E -51 % at t = 10, n = 25, which the CSV lacks. The pressure is noisy: that of neighbours differs by up to rho U^2 below the lid (D, Re = 100, t = 5), and the
flow pays for their jostling. With `-density_form continuity` the density drifts where the lid's particles come and go at the corners, and
`-wall dynamic` refuses it; the paper shows sums for this flow too.

The projection has -1.5 % at Re = 100 and -4 % at Re = 1000 with the same 25 by 25 particles. The default of
`-scheme wcsph` has -0.9 % at Re = 100 and -9 % at Re = 1000.

At the paper's 50 by 50 particles and to its times the default of `-scheme wcsph` has the energy within 0.5 % at Re = 100, and profiles within
1.1 % of U, which sound and shifts disturb; the projection has 0.4 to 1 % and 0.06 % in a third of the CPU time. At Re = 1000 both have too
little energy, as in the paper: -1.5 % at t = 40 with the projection, whose profiles at t = 80 are within 0.3 % of U, and -3.9 % with
`-scheme wcsph`, within 1.1 % of U.
"""


def draw_energy(axis, run, reynolds):
    for name, options in runs.SERIES.items():
        colour, line = LOOKS[name]
        points = [(0, 0), *energies(runs.cavity(run, options, reynolds), reynolds)]
        axis.plot(*zip(*points), line, color=colour, lw=1.2, label=name)
    exact = [(float(row["t"]), float(row["KE"])) for row in reference_rows(f"cavity_re{reynolds}_ke.csv")]
    axis.plot(*zip(*[(t, e) for t, e in exact if t <= runs.ENDS[reynolds]]), "k-", lw=2, alpha=0.5, label="finite volumes")
    axis.set(xlabel="t", ylabel="kinetic energy", title=f"Re = {reynolds}", ylim=(0, 0.08))
    axis.legend(ncols=2)


def profiles(run, reynolds):
    """Yields label, name of the series, width of the line and run: Re = 100 at t = 10, Re = 1000 at the end of the paper's runs."""
    if reynolds == 100:
        yield from ((name, name, 1.2, runs.cavity(run, options, reynolds)) for name, options in runs.SERIES.items())
        return
    for n, names, width in ((runs.N, runs.LASTING, 0.7), (runs.LONG_N, runs.LONG, 1.6)):
        yield from ((f"{name}, n = {n}", name, width, runs.long(run, name, reynolds, n)) for name in names)


def draw_profile(axis, run, reynolds):
    for label, name, width, q in profiles(run, reynolds):
        points = [(q[f"point_{k}_u"], y) for k, y in enumerate(runs.HEIGHTS) if f"point_{k}_u" in q]
        if points:
            axis.plot(*zip(*points), LOOKS[name][1], color=LOOKS[name][0], lw=width, label=label)
    files = [("cavity_re100_t10_u.csv", "k-", "finite volumes")] if reynolds == 100 else []
    for file, look, label in (*files, (f"ghia_re{reynolds}_u.csv", "ko", "Ghia et al., steady")):
        rows = [tuple(map(float, list(row.values())[:2])) for row in reference_rows(file)]
        axis.plot([u for _, u in rows], [y for y, _ in rows], look, lw=2, ms=3, alpha=0.5, label=label)
    end = runs.ENDS[100] if reynolds == 100 else runs.LONG_ENDS[reynolds]
    axis.set(xlabel="u", ylabel="y", title=f"x = 1/2, Re = {reynolds}, t = {end:g}", xlim=(-0.6, 1.05))
    axis.legend()


def draw(path, run):
    """Draws the figure in the manner of Figs 9 and 10 of the paper."""
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10, "legend.fontsize": 7, "legend.frameon": False})
    figure, grid = plt.subplots(2, 2, figsize=(12, 9))
    for column, reynolds in zip(grid.T, runs.ENDS):
        draw_energy(column[0], run, reynolds)
        draw_profile(column[1], run, reynolds)
    for axis in grid.flat:
        axis.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
