"""Page and figures of studies/basa_poiseuille."""
import basa_parts as parts
import basa_poiseuille_runs as runs
import basa_rows as rows
import matplotlib
from runs import table

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

STATES = {"tait": "Tait", "gas": "gas"}
SHOWN = (0.1, 1, 3, 30)  # t* of errors in tables
OWN_COLOURS = dict(zip(runs.OWN, ["#0072B2", "#009E73", "#D55E00", "#56B4E9"]))


def at(q, star):
    """Returns the RMS error at the report nearest to t*, None where the run did not come within a fifth of it."""
    near = min(runs.curve(q), key=lambda point: abs(point[0] - star), default=None)
    return near[1] if near and abs(near[0] / star - 1) < 0.2 else None


def failed(q):
    """Returns the t* of the failure as text; > the end of a run that has not failed."""
    if not q:
        return ""
    star, lost = runs.failure(q)
    return f"{'' if lost else '> '}{star:.2g}"


def errors(channel):
    """Yields rows: model, correction, errors with both equations of state at Re = 0.5."""
    for correction, models in parts.CORRECTIONS.items():
        for model in models:
            row = [f"{model}, `{parts.MODELS[model].split()[0]}`", correction]
            for state in STATES:
                q = channel.model(model, correction, state, 0.5)
                row += [parts.percent(at(q, star)) for star in SHOWN[:-1 if state == "gas" else None]]
            yield row


def failures(channel):
    """Yields rows: equation of state, model, correction, t* of the failure by Reynolds number."""
    for state in STATES:
        planned = {reynolds: list(runs.sweep(state, reynolds)) for reynolds in runs.REYNOLDS[state]}
        for correction, models in parts.CORRECTIONS.items():
            for model in models:
                row = [STATES[state], model, correction]
                for reynolds in runs.REYNOLDS["tait"]:
                    made = (model, correction) in planned.get(reynolds, ())
                    row.append(failed(channel.model(model, correction, state, reynolds)) if made else "")
                yield row


def reductions(channel):
    """Yields rows: model, errors of the gas with and without pressure reduction."""
    for model in sorted(runs.RAW):
        row = [model]
        for reduced in True, False:
            q = channel.model(model, "none", "gas", 0.5, reduced=reduced)
            row += [*(parts.percent(at(q, star)) for star in SHOWN[:-1]), failed(q)]
        yield row


def readings(channel):
    """Yields rows: reading, errors of model E."""
    for name, more in runs.READINGS.items():
        q = channel.model("E", "none", "tait", 0.5, more=more)
        yield [name, *(parts.percent(at(q, star)) for star in SHOWN), failed(q)]


def walls():
    """Yields rows: reading of the walls of model B, its errors on a lattice that keeps its rows."""
    for reading in rows.READINGS:
        yield [reading, *map(parts.percent, rows.errors(reading, SHOWN))]


def own(channel):
    """Yields rows: Reynolds number, method, end of the run, errors of the seeds."""
    planned = list(runs.own_runs())
    for reynolds in runs.OWN_REYNOLDS:
        for name in runs.OWN:
            found = [channel.own(name, reynolds, seed) for seed in runs.SEEDS if (name, reynolds, seed) in planned]
            found = [q for q in found if runs.curve(q)]
            if not found:
                continue
            late = [[e for star, e in runs.curve(q) if star > 0.9] for q in found]
            yield [f"{reynolds:g}", name, len(found), f"{min(runs.curve(q)[-1][0] for q in found):.2g}",
                   *(parts.percent(max((at(q, star) for q in found if at(q, star) is not None), default=None))
                     for star in (0.1, 1)),
                   parts.percent(max((max(e) for e in late if e), default=None)),
                   parts.percent(max(runs.curve(q)[-1][1] for q in found)), "; ".join(sorted({failed(q) for q in found}))]


def page(channel):
    """Yields the lines of the page."""
    yield "# Viscous models of Basa, Quinlan & Lastiwka (2009) in the Poiseuille channel\n"
    yield ("Written by `studies/basa_poiseuille`; every run is in [basa_poiseuille.csv](basa_poiseuille.csv). The flow is that "
           "of section 6.1 of Int. J. Numer. Meth. Fluids 60 (2009) 1127-1148: start-up of plane Poiseuille flow, nu = 1 m^2/s, "
           "d = L/2 = 0.5 m, 20 particles across, Re = U d/nu. Errors are the RMS of the relative error (Eq. 38), times "
           "t* = pi^2 nu t/(4 d^2) (Eq. 39). The exact solution is Eq. (36) with the series not multiplied by (y/d)^2, "
           "as `cases/poiseuille.c` explains.\n")
    yield ("![Time of failure against the Reynolds number and error against time, for three corrections and two equations of "
           "state](basa_poiseuille.png)\n")
    yield "## Statements of the paper\n"
    yield from table(["statement", "found", "in numbers"], STATEMENTS)
    yield "\n" + READING
    yield "## Settings\n"
    yield (f"`isph {runs.CHANNEL} {parts.PAPER} {runs.REDUCED} -reynolds RE -speed 2RE -correction C -visc_laplacian FORM`, and "
           f"`{runs.STATES['tait']}` or `{runs.STATES['gas']}`, the speed of sound at 125 kPa and 1 kg/m^3.\n")
    yield from table(["quantity", "paper", "here"], SETTINGS)
    yield (f"\nA run ends at t* = 30, after {runs.SECONDS:g} s of CPU time ({runs.LONG:g} s at Re = 10,000), or at t* = 0.76 if it "
           "has failed until then. It has failed from the report on after which the error stays at 12 % or more, or when it is "
           "lost; the 25 reports are at t* = 0.01 to 30, equally spaced in log t*. A start-up error that decays again is no "
           "failure. > marks the end of a run that has not failed.\n")
    yield "## Accuracy at Re = 0.5\n"
    yield from table(["model", "correction", *(f"Tait, t* = {s:g}" for s in SHOWN), *(f"gas, t* = {s:g}" for s in SHOWN[:-1])],
                     errors(channel))
    yield "\n## Time t* of failure\n"
    yield ("`shepard` has runs with model A only at Re other than 0.5, and `mixed` at Re = 0.5 and 100 (Tait) or 10 (gas). "
           "Empty: no run.\n")
    yield from table(["state", "model", "correction", *(f"Re = {r:g}" for r in runs.REYNOLDS["tait"])], failures(channel))
    yield "\n## Pressure reduction\n"
    yield "Gas, Re = 0.5, no correction: errors and time of failure with `-pressure_reduction local_mean` and `none`.\n"
    yield from table(["model", *(f"reduced, t* = {s:g}" for s in SHOWN[:-1]), "failure",
                      *(f"not reduced, t* = {s:g}" for s in SHOWN[:-1]), "failure"], reductions(channel))
    yield "\n## Readings of ambiguous settings\n"
    yield "Model E, Tait, no correction, Re = 0.5; one setting changed.\n"
    yield from table(["reading", *(f"t* = {s:g}" for s in SHOWN), "failure"], readings(channel))
    yield "\n### Walls of model B\n"
    yield WALLS
    yield from table(["velocities behind walls; stress behind walls", *(f"t* = {s:g}" for s in SHOWN)], walls())
    yield "\n## Schemes of the project from a disordered start\n"
    yield ("`-jitter 0.2 -seed 1, 2, 3`, all other options at their defaults: `-scheme projection`, the same with "
           "`-visc_laplacian morris`, the same in steps of at most t* = 0.05, and `-scheme wcsph`. Largest errors of the seeds; the "
           "default projection has " + ", ".join(f"{s:g} s of CPU time at Re = {r:g}" for r, s in runs.OWN_LONG.items()) + ".\n")
    yield ("![Error of the project's schemes against time](basa_poiseuille_own.png)\n")
    yield from table(["Re", "scheme", "seeds", "end t*", "t* = 0.1", "t* = 1", "largest, t* > 0.9", "end", "failure"],
                     own(channel))
    yield "\n" + OWN_READING


SETTINGS = [
    ["box", "20 by 20 particles, periodic", "8 by 20: the case has a length of 8 dx"],
    ["kernel, h", "cubic spline, dx/h = 0.637", "the same"],
    ["time", "Runge-Kutta of order 2", "order 3 at acoustic CFL 0.5; order 2 in a reading"],
    ["density", "summation, Eqs (8), (11)", "the same"],
    ["gas", "p = rho R T, 125 kPa, energy by Eq. (14)", "the same: p = 0.4 rho e"],
    ["Tait", "gamma = 7, c0 not stated", "c0 = 10 max(U, (nu U/L)^(1/2), (f L)^(1/2))"],
    ["pressure", "less the mean of the neighbours, Eq. (20)", "the same"],
    ["walls", "mirror particles, velocities extrapolated linearly", "dummies on a lattice, extrapolated from each particle"],
    ["shift, diffusion", "none", "none"],
    ["first order, model A", "not explained", "left out"],
]
STATEMENTS = [
    ["A is unstable without correction", "yes", "12 % at t* = 0.04 at Re = 0.5 to 100, 28 % at t* = 0.1"],
    ["order 0 makes A stable", "yes", "Re = 0.5: 2.4 to 4.6 % from t* = 0.1 to 25, no failure; Re = 1000: fails at 0.06, before B to E"],
    ["B is the least robust", "yes", "Re = 10: fails at t* = 5.7, E 7.9, C and D more than 9; Re = 100: 1.1, E 1.3; at Re = 0.5 B to E reach 30"],
    ["B is accurate", "by its walls", "t* = 1: 2.5 %, with parabolas behind walls 0.9 %; t* = 30: 2.7 %, mixed 1.5 %, as C and D; t* = 0.1: 15 %"],
    ["B gains much by order 0", "no", "2.5 and 2.7 % at t* = 1: on a lattice in rows the sums are even"],
    ["D and E are best", "E", "Tait at t* = 30: E 0.74 %, D 2.5 %, C 3.6 %"],
    ["C is almost as robust as D and E, and less accurate", "yes", "failure at Re = 1000: C and D 0.10, E 0.09; errors above"],
    ["corrections help C, D, E little; order 1 degrades D", "C, D: yes", "C 3.6 to 2.6 %, D 2.5 to 2.8 %, E 0.74 to 0.13 %"],
    ["the gas needs pressure reduction without correction", "yes", "Re = 0.5: A, D, E lost at t* = 0.02 to 0.03; E with it 0.69 % at t* = 3"],
    ["in Tait's fluid it matters less", "yes", "E 0.74 % with and without it"],
    ["failure comes earlier at higher Re, without turbulence", "yes", "E, t* = 7.9, 1.3, 0.09, 0.005 at Re = 10, 100, 1000, 10,000"],
    ["summation and continuity differ little", "yes", "E 0.735 and 0.743 % at t* = 30"],
    ["failure does not depend on the step", "yes", "Runge-Kutta of orders 2 and 3 agree to 0.1 %"],
]
READING = """The density of a lattice by Eq. (11) is 0.33 % too high with this kernel. The masses are divided by this sum; before, the
errors of model E with no correction were twice as large (0.39 in place of 0.23 % at t* = 0.76), and those with continuity had
the present size. Model C has the factor 8 of Eq. (33), twice the exact 4 of two dimensions, where this lattice needs 2 x 4.22;
its viscosity is 5 % too low, and 4.24 of model D is fitted to the lattice. Shear moves particles off the lattice, and
then the fit no longer holds: from t* = 1 on the error of D grows to 2.5 %. The error of model B comes from the walls: a table below
has it for [readings of them](#walls-of-model-b). At the start the stress reaches the whole support of the kernel, where the flow has a layer of a few rows. Before, the pressure behind walls
balanced the force along them a second time ([theory, (wcsph:shear)](../theory/wcsph.md#wcsph:shear)), and B had 5.8 % at t* = 1 and failed at t* = 15. At Re = 1000 the error of the start does not decay
before the flow breaks. Velocities that alternate from row to row have no slope in its first sum on a lattice, and so no viscous
force; rows of particles dissolve in it first.
"""
WALLS = """Errors of model B at Re = 0.5, no correction, if rows of particles keep their order (`studies/basa_rows.py`: 20 velocities, a linear
system). The first two rows agree with `-scheme wcsph` now and before to two digits up to t* = 1. The paper chose "linear extrapolation" with boundaries twice as
thick as for other models; its Fig. 3 has stresses of wall particles. Eq. (29) without differences is the same on a
lattice. Gradients of first order change the first row little: 15, 6.3 and 2.5 % at t* = 0.1, 0.31 and 1.
"""
OWN_READING = """**Below 1 %?** From t* = 1 to 30 `-scheme projection` stays below 0.25 % at Re = 1 to 1000 (three seeds), and ends
below 0.007 %. At Re = 10,000 its error is 0.16 % at t* = 1, grows to 0.22 % at t* = 11 and stays there to t* = 30. The worst error of
three seeds after t* = 0.9 is 0.23 %.
Before the velocity filter damped disturbances across a shear ([theory, (filters:shear)](../theory/filters.md#filters:shear)), waves of four spacings made it
1.0 % from t* = 8 on. At Re = 0.1 its error is 1.6 % near t* = 2, because a step of CFL number 0.5 is t* =
1.2 long; in steps of t* = 0.05 it is 0.2 %. At t* = 0.01 every scheme errs by 2 to 6 %, because the layers beside the walls are
thinner than two particles. `-scheme wcsph` comes below 0.4 % at Re = 1 to 100; at Re = 0.1 it has 1.4 % at t* =
1, because particles hardly move and remain disordered, and 0.24 % at the end. Its steps by sound end the runs at Re = 1000
and 10,000 before t* = 1. The form `morris` in the projection does not get below 1.6 %: on disordered particles
its error does not fall with dx.
"""


def draw_failures(axis, channel, state, correction):
    for model in parts.CORRECTIONS[correction]:
        made = [r for r in runs.REYNOLDS[state] if (model, correction) in list(runs.sweep(state, r))]
        made = [r for r in made if channel.model(model, correction, state, r)]
        ends = [runs.failure(channel.model(model, correction, state, r)) for r in made]
        axis.loglog(made, [star for star, _ in ends], "-", color=parts.COLOURS[model], lw=1)
        for reynolds, (star, lost) in zip(made, ends):
            axis.loglog([reynolds], [star], parts.MARKERS[model], color=parts.COLOURS[model], ms=5,
                        mfc=None if lost else "white", zorder=3)
    axis.set(xlim=(0.05, 2e4), ylim=(0.01, 40), title=f"{STATES[state]}, {parts.ORDERS[correction]}", ylabel="t* at failure")


def draw_errors(axis, channel, state, correction):
    for model in parts.CORRECTIONS[correction]:
        points = runs.curve(channel.model(model, correction, state, 0.5)) or [(float("nan"), float("nan"))]
        axis.loglog([100 * e for _, e in points], [star for star, _ in points], parts.MARKERS[model] + "-", ms=3, lw=1,
                    color=parts.COLOURS[model], label=f"{model}, {parts.MODELS[model].split()[0]}")
    axis.axvline(100 * parts.FAILED, color="#999999", lw=0.8)
    axis.set(xlim=(0.1, 100), ylim=(0.01, 40), title=f"{STATES[state]}, Re = 0.5")
    axis.legend()


def draw(path, channel):
    """Draws the figure in the manner of Fig. 5 of the paper: open symbols are ends of runs that have not failed."""
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10, "legend.fontsize": 7, "legend.frameon": False})
    figure, grid = plt.subplots(3, 4, figsize=(15, 10))
    for row, correction in zip(grid, parts.CORRECTIONS):
        for k, state in enumerate(STATES):
            draw_failures(row[2 * k], channel, state, correction)
            draw_errors(row[2 * k + 1], channel, state, correction)
    for axis in grid.flat:
        axis.grid(alpha=0.3)
    for k in range(4):
        grid[-1][k].set_xlabel("RMS error [%]" if k % 2 else "Re; open: not failed at its end")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_own(path, channel):
    """Draws errors of the project's schemes against time, a panel for each Reynolds number."""
    figure, grid = plt.subplots(2, 3, figsize=(12, 7), sharex=True, sharey=True)
    for axis, reynolds in zip(grid.flat, runs.OWN_REYNOLDS):
        for name, of, seed in runs.own_runs():
            if of == reynolds:
                points = runs.curve(channel.own(name, reynolds, seed)) or [(float("nan"), float("nan"))]
                axis.loglog(*zip(*points), "-", color=OWN_COLOURS[name], lw=1.2)
                axis.loglog(*points[-1], "o", color=OWN_COLOURS[name], ms=4)
        axis.axhline(0.01, color="#999999", lw=0.8)
        axis.set(title=f"Re = {reynolds:g}", ylim=(1e-5, 1), xlim=(0.01, 40))
        axis.grid(alpha=0.3)
    grid[0][0].legend([plt.Line2D([], [], color=colour) for colour in OWN_COLOURS.values()], OWN_COLOURS)
    for axis in grid[-1]:
        axis.set_xlabel("t*")
    for axis in grid[:, 0]:
        axis.set_ylabel("RMS error")
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
