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


def resolutions(run):
    """Yields rows: series, Re, n, end, errors of the energy to t = 2.5."""
    for name, reynolds in runs.FINE:
        for n, q in ((runs.N, runs.cavity(run, runs.SERIES[name], reynolds)), (runs.FINE_N, runs.fine(run, name, reynolds))):
            yield [name, reynolds, n, state(q), *(off(q, runs.TIMES[reynolds], share) for share in (0.05, 0.1, 0.15, 0.2, 0.25))]


def page(run):
    """Yields the lines of the page."""
    yield "# Viscous models of Basa, Quinlan & Lastiwka (2009) in the lid-driven cavity\n"
    yield ("Written by `studies/basa_cavity`; every run is in [basa_cavity.csv](basa_cavity.csv). The flow is that of section 6.2 "
           f"of Int. J. Numer. Meth. Fluids 60 (2009) 1127-1148, from rest, at Re = 100 and 1000: all models with {runs.N} by "
           f"{runs.N} particles to t = 10, some with {runs.LONG_N} by {runs.LONG_N} to t = 20 and 80 as in the paper. Units are L "
           "and U.\n")
    yield "![Kinetic energy against time, and velocity on the vertical centreline](basa_cavity.png)\n"
    yield "## Statements of the paper\n"
    yield from table(["statement", "found", "in numbers"], STATEMENTS)
    yield "\n" + READING
    yield "## Settings\n"
    yield (f"`isph -case cavity -n {runs.N} -reynolds RE {parts.PAPER} {runs.REDUCED} -correction C -visc_laplacian FORM`; `wcsph` and "
           "`projection` have the defaults of the project. The forms are "
           + ", ".join(f"{model}: `{form}`" for model, form in parts.MODELS.items())
           + f". A run has at most {runs.SECONDS:g} s of CPU time. Walls are dummies whose velocities are extrapolated from each "
           "particle; the wall particles of the paper have densities and pressures of their own.\n")
    for reynolds, end in runs.ENDS.items():
        yield f"## Re = {reynolds}\n"
        yield ("Energy against finite volumes (`cases/reference`), smallest u on the centreline, and root mean squares of the "
               f"errors of both profiles at t = {end:g}, for which Re = 100 has a reference.\n")
        found = {name: runs.cavity(run, options, reynolds) for name, options in runs.SERIES.items()}
        yield from table(head(end), results(found, runs.TIMES[reynolds]))
        yield ""
    for reynolds, end in runs.LONG_ENDS.items():
        yield f"## Re = {reynolds} as in the paper\n"
        yield (f"{runs.LONG_N} by {runs.LONG_N} particles to t = {end:g}. Errors of the energy to t = 40, then the energy itself, which has no "
               "reference; profiles against the steady flow.\n")
        found = {name: runs.long(run, name, reynolds) for name in runs.LONG[reynolds]}
        yield from table(head(end), results(found, runs.LONG_TIMES[reynolds]))
        yield ""
    yield "## Resolution\n"
    yield f"The same with {runs.FINE_N} by {runs.FINE_N} particles, to t = {runs.READING_END:g}; errors of the energy.\n"
    yield from table(["series", "Re", "n", "end", *(f"t = {10 * share:g}" for share in (0.05, 0.1, 0.15, 0.2, 0.25))],
                     resolutions(run))
    yield "\n## Readings of ambiguous settings\n"
    yield "Model E with `shepard`, Re = 100; one setting changed. Errors of the energy.\n"
    yield from table(["reading", "end", *(f"t = {runs.ENDS[100] * share:g}" for share in (0.05, 0.1, 0.25))], readings(run))


STATEMENTS = [
    ["Re = 100: all but B are close to the reference", "C, D", "energy at t = 10: C -3.0 %, D -4.4 %, E +8.5 %; A and B are lost"],
    ["B clumps and is agitated", "yes", "Re = 100: lost at t = 1.8"],
    ["B fails at Re = 1000 with corrections", "yes", "lost at t = 2.2"],
    ["A is stable with order 0, and noisy", "no", "Re = 100: +50 % energy, lost at t = 2.8"],
    ["E has spikes of energy, most without correction", "yes", "Re = 100: up to +47 % with shepard; none: lost at t = 5.4"],
    ["C is nearly as accurate as D", "yes", "Re = 100: u profile 0.015 (C), 0.032 (D), 0.049 (E)"],
    ["D is the best by a small margin", "C, D", "C at Re = 100; at Re = 1000 D holds longest"],
    ["Re = 100 at 50 by 50: D is close to the reference", "within 6 %", "D at t = 20: energy -6.2 %, u profile 0.019; wcsph -0.2 %, 0.011"],
    ["Re = 1000: all models have too little energy", "no", "A to E gain energy from t = 1 on, and are lost before t = 7.2 at n = 25"],
    ["more robust than the channel", "no", "E at Re = 1000: lost at t = 1.7 L/U, in the channel at 19 L/U"],
]
READING = """At Re = 100 the order of the paper holds: radial forces (C, D) are the quietest, E has spikes, B clumps. At Re = 1000
no run with the paper's sums has a useful energy, at n = 25 or 50. The readings below change the energy at Re = 100 by no
more than its scatter, and continuity without diffusion is lost at once. In a run at Re = 1000 without reduction and correction,
which the CSV lacks, particles come to the walls until the clearance of 0.05 dx stops them, and the density varies by 17 %. Walls differ from the paper's: a dummy here has the pressure of the particle that
reads it, so a particle of negative pressure is pulled to the wall, and particles of the paper's walls have densities of
their own. The projection has -1.5 % at Re = 100 and -4 % at Re = 1000 with the same 25 by 25 particles. The default of
`-scheme wcsph` has -0.9 % at Re = 100 and -9 % at Re = 1000; before it kept the volume of the fluid
([(286)](../theory.md#eq-286)) it had -5.0 % at Re = 100, and +43 % near t = 5 at Re = 1000.

At the paper's 50 by 50 particles and to its times the default of `-scheme wcsph` has the energy within 0.5 % at Re = 100, and profiles within
1.1 % of U, which sound and shifts disturb; the projection has 0.4 to 1 % and 0.06 % in a third of the CPU time. At Re = 1000 both have too little energy, as in the paper:
-1.5 % at t = 40 with the projection, whose profiles at t = 80 are within 0.3 % of U, and -3.9 % with `-scheme wcsph`, within
1.1 % of U. Before it kept the volume of the fluid `-scheme wcsph` was lost at t = 55.9 and, with sums in another order, at 65.1.
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


def draw_profile(axis, run, reynolds):
    for name, options in runs.SERIES.items():
        q = runs.cavity(run, options, reynolds)
        points = [(q[f"point_{k}_u"], y) for k, y in enumerate(runs.HEIGHTS) if f"point_{k}_u" in q]
        if points:
            axis.plot(*zip(*points), LOOKS[name][1], color=LOOKS[name][0], lw=1.2, label=name)
    files = [("cavity_re100_t10_u.csv", "k-", "finite volumes")] if reynolds == 100 else []
    for file, look, label in (*files, (f"ghia_re{reynolds}_u.csv", "ko", "Ghia et al., steady")):
        rows = [tuple(map(float, list(row.values())[:2])) for row in reference_rows(file)]
        axis.plot([u for _, u in rows], [y for y, _ in rows], look, lw=2, ms=3, alpha=0.5, label=label)
    axis.set(xlabel="u", ylabel="y", title=f"x = 1/2, Re = {reynolds}, t = {runs.ENDS[reynolds]:g}", xlim=(-0.6, 1.05))
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
