"""Sway of a plane viscous jet that falls on a plate with edges (options/jet_buckling.opts), a part of studies/jet_buckling.

The heap on the plate keeps its height, because fluid leaves over its edges: the flow is steady below the threshold, and above it the
jet sways without end."""
import glob
import os
import shlex
import tempfile

import h5py
import jet_folds
import numpy as np
from runs import Runs, table

AXIS, PLATE = 4.0, 4.0  # of the slit, width of the plate [D]
LEVEL, BAND = 0.6, 1.0  # height at which the place of the jet is taken [H], and of the band of its mean [D]
EVERY = 0.5  # time between snapshots [D/U]
START, END = 20.0, 45.0  # of the time of a mean; the heap is steady at START [D/U]
WINDOW = 12.0  # time of a mean, about a period of folds [D/U]
LINK = 2.0  # distance up to which particles are of one group [dx]
HEIGHTS = {4: 1, 6: 1, 7: 3, 8: 3, 9: 3, 11: 3}  # starts by height at Re = 0.2
FAST = {8: 1, 11: 2, 14: 1}  # starts by height at Re = 0.56
REYNOLDS = {0.2: 1, 0.4: 2, 0.56: 2}  # starts by Re at H/D = 11
FINE = (4, 8, 9, 11)  # heights of jets with 8 particles along D, one start


def line_of(n, height, reynolds, seed):
    """Returns the arguments of a run."""
    half = PLATE / 2
    return (f"-options_file options/jet_buckling.opts -scene_box {AXIS - half:g},0,{AXIS + half:g},{height:g} "
            f"-scene_filled_1 box,{AXIS - 0.5},0,{AXIS + 0.5},{height:g} -scene_outflow left,right "
            f"-viscosity {1 / reynolds:.6g} -n {n} -jitter 0.1 -seed {seed} -dt_adapt retry -t_end {END:g} -progress none")


def fluid(path):
    """Returns the places of the fluid particles of a snapshot."""
    with h5py.File(path) as file:
        return file["position"][:][file["type"][:] == 0]


class Plates(Runs):
    """Runs with the place of the jet at LEVEL by time, and the most particles that are far from all others."""

    def make(self, arguments, watch=""):
        level = LEVEL * float(arguments.split("-scene_box ")[1].split()[0].split(",")[3])
        side = int(arguments.split("-n ")[1].split()[0])
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "jet.h5")
            row = super().make(f"{arguments} -output {shlex.quote(path)} -output_every {EVERY}", watch)
            found, stray = {}, 0
            for k, snapshot in enumerate(sorted(glob.glob(os.path.join(folder, "jet_*.h5")))):
                x = fluid(snapshot)
                band = x[np.abs(x[:, 1] - level) < BAND / 2, 0]
                stray = max(stray, jet_folds.stray(x, LINK / side))
                if len(band) > 2:
                    found[f"place@{k * EVERY:g}"] = f"{band.mean() - AXIS:.4g}"
        row.update({"run": arguments, "stray": stray, **found})
        return row


def places(q):
    """Returns times and places of a jet at LEVEL."""
    return np.array(sorted((float(name[6:]), place) for name, place in q.items() if name.startswith("place@")))


def measure(run):
    """Makes the runs; returns them by height at Re = 0.2 and 0.56, by Re at H/D = 11, and with finer particles by height."""
    heights, fast = ({h: [run(line_of(6, h, re, seed)) for seed in range(starts)] for h, starts in rows.items()}
                     for re, rows in ((0.2, HEIGHTS), (0.56, FAST)))
    speeds = {re: [run(line_of(6, 11, re, seed)) for seed in range(starts)] for re, starts in REYNOLDS.items()}
    fine = {h: run(line_of(8, h, 0.2, 0)) for h in FINE}
    run.save()
    return heights, fast, speeds, fine


def sway(q):
    """Returns the root mean square distance of a jet from its mean place, in two windows of a period of folds [D]."""
    t, x = places(q).T
    parts = [x[(t >= START + k * WINDOW) & (t < START + (k + 1) * WINDOW)] for k in (0, 1)]
    return np.sqrt(np.mean([part.var() for part in parts]))


def volume(q):
    """Returns the error of the volume inside the surface at the end."""
    return q["fluid_volume"] / q["fluid_volume_reference"] - 1


def period(runs):
    """Returns the mean time between folds of all runs of a list, or nothing if none folds twice [D/U]."""
    found = np.concatenate([np.diff(jet_folds.crossings(*places(q).T)) for q in runs])
    return f"{found.mean():.1f}" if len(found) else ""


def cells(runs):
    """Returns the cells of runs: sways, mean period, most stray particles in a snapshot, volume, repeated steps, day."""
    kept = [q for q in runs if "failed" not in q]
    return [", ".join("lost" if "failed" in q else f"{sway(q):.2f}" for q in runs), period(kept), f"{max(q['stray'] for q in runs):.0f}",
            ", ".join(f"{100 * volume(q):+.0f} %" for q in kept), ", ".join(f"{q['retries']:.0f}" for q in kept), ", ".join(sorted({q["date"] for q in runs}))]


def told_of(rows, name):
    """Returns a sentence on the rows in which jets fold."""
    folds = {key: [len(jet_folds.crossings(*places(q).T)) > 1 for q in runs] for key, runs in sorted(rows.items())}
    return "Starts that fold: " + ", ".join(f"{sum(found)} of {len(found)} at {name} = {key:g}" for key, found in folds.items()) + "."


def part(found):
    """Yields the part of the page on jets on plates."""
    heights, fast, speeds, fine = found
    head = ["sways / D", "period", "stray", "volume", "repeated steps", "made"]
    yield (f"The floor is a plate of width {PLATE:g} D without slip, and fluid leaves over its edges: the heap keeps its height, and below the threshold the flow is steady. "
           "Jets begin as columns from slit to plate, disordered by 0.1 dx, with n = 6 particles along D. Sway: root mean square distance of the jet from its mean "
           f"place at the height {LEVEL:g} H, in two windows of {WINDOW:g} D/U from U t/D = {START:g} on, of up to three starts. The disorder of particles lets "
           f"straight jets sway by some 0.05 D. A fold is a crossing of the mean place to the right between places {jet_folds.FAR:g} D off it on both sides, "
           f"U t/D = {START:g} to {END:g}; periods are in D/U. Stray particles are farther than 2 dx from the largest group, the most of all snapshots "
           f"(every {EVERY:g} D/U). Volume is the error of the volume inside the surface at the end: the surface of the heap shortens, particles crowd in it, "
           "and the control of the volume ([theory](../theory/surface-schemes.md#1512-volume)) follows with a delay. Without it the errors were -17 to -29 %. "
           "Steps in which a velocity left its bounds are repeated with half of their length (`-dt_adapt retry`).\n")
    yield "## Height, Re = 0.2\n"
    yield from table(["H/D", *head], [[f"{h}", *cells(runs)] for h, runs in heights.items()])
    yield "\n" + told_of(heights, "H/D") + " In experiments the threshold is about 10.\n"
    yield "## Height, Re = 0.56\n"
    yield from table(["H/D", *head], [[f"{h}", *cells(runs)] for h, runs in fast.items()])
    yield "\n" + told_of(fast, "H/D") + "\n"
    yield "## Reynolds number, H/D = 11\n"
    yield from table(["Re", *head], [[f"{re}", *cells(runs)] for re, runs in speeds.items()])
    yield "\n" + told_of(speeds, "Re") + " In experiments it is 0.56.\n"
    yield "## Finer particles, Re = 0.2\n"
    yield "n = 8 particles along D, one start.\n"
    yield from table(["H/D", *head], [[f"{h}", *cells([q])] for h, q in fine.items()])


def draw(axes, found):
    """Draws sways by height and by Reynolds number, and places of jets in the course of time."""
    heights, _, speeds, fine = found
    for h, runs in heights.items():
        axes[0].plot([h] * len(runs), [sway(q) for q in runs], "o", color="#0072B2", mfc="none", ms=4, label="n = 6" if h == min(heights) else None)
    axes[0].plot(list(fine), [sway(q) for q in fine.values()], "^", color="black", mfc="none", ms=5, label="n = 8")
    axes[0].axvline(10, color="black", lw=0.8, ls="--")
    axes[0].set(xlabel="H/D at Re = 0.2", title="sway / D")
    axes[0].legend()
    for re, runs in speeds.items():
        axes[1].plot([re] * len(runs), [sway(q) for q in runs], "o", color="#0072B2", mfc="none", ms=4)
    axes[1].axvline(0.56, color="black", lw=0.8, ls="--")
    axes[1].set(xlabel="Re at H/D = 11", title="sway / D")
    for h in (7, 8, 11):
        axes[2].plot(*places(heights[h][0]).T, lw=1.2, label=f"H/D = {h}")
    for axis in axes[:2]:
        axis.set_ylim(bottom=0)
    axes[2].set(xlabel="t U/D", title=f"place at {LEVEL:g} H / D, Re = 0.2")
    axes[2].legend()
