"""The frequency at which a plane viscous jet folds on a belt (options/jet_folds.opts), a part of studies/jet_buckling."""
import glob
import os
import shlex
import tempfile

import h5py
import matplotlib.pyplot as plt
import numpy as np
import thin_sheet
from runs import Runs, table
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

AXIS, HEIGHT, OUTFLOW = 3.5, 11.0, 9.0  # places of the slit and of the outflow [D]
LEVEL, BAND = 0.5 * HEIGHT, 0.5  # height at which the place of the jet is taken, and of the band of its mean [D]
EVERY = 0.5  # time between snapshots [D/U]
START, END = HEIGHT + 9, 80.0  # of the time in which folds are counted [D/U]
FAR = 0.1  # least distance of the jet from its mean place on both sides in a fold [D]
LINK = 2.0  # distance up to which particles are of one group [dx]
JETS = [(n, seed) for n, starts in ((6, 3), (8, 3), (12, 3), (16, 3), (24, 2)) for seed in range(starts)]  # particles along D, start
SPEED, SPEEDS = 0.5, (0.5, 0.7)  # of the belt [U]; those with 8 particles along D


def line_of(n, seed, speed=SPEED):
    """Returns the arguments of a run."""
    belt = "" if speed == SPEED else f" -scene_wall_bottom_velocity {speed:g},0"
    return f"-options_file options/jet_folds.opts -n {n} -jitter 0.1 -seed {seed} -t_end {END:g} -progress none{belt}"


def stray(x, distance, outflow=np.inf):
    """Returns the number of particles outside the largest group that are in no group beside the outflow at x = outflow either: such a
    group is the end of a fold that leaves. Particles nearer than a distance are of one group."""
    _, group = connected_components(cKDTree(x).sparse_distance_matrix(cKDTree(x), distance))
    leaving = group[x[:, 0] > outflow - distance]
    return np.isin(group, [np.bincount(group).argmax(), *leaving], invert=True).sum()


class Belts(Runs):
    """Runs with the place of the jet in the course of time, and with counts of stray particles."""

    def make(self, arguments, watch=""):
        n = int(shlex.split(arguments)[shlex.split(arguments).index("-n") + 1])
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "jet.h5")
            row = super().make(f"{arguments} -output {shlex.quote(path)} -output_every {EVERY}", watch)
            row.update({"run": arguments, "stray": 0})
            for k, snapshot in enumerate(sorted(glob.glob(os.path.join(folder, "jet_*.h5")))):
                with h5py.File(snapshot, "r") as file:
                    x = file["position"][:][file["type"][:] == 0]
                row["stray"] = max(row["stray"], stray(x, LINK / n, OUTFLOW))
                band = x[abs(x[:, 1] - LEVEL) < BAND / 2, 0]
                if len(band):
                    row[f"place@{k * EVERY:g}"] = f"{band.mean() - AXIS:.4g}"
        return row


def places(q):
    """Returns times and places of the jet at the level, by time."""
    return np.array(sorted((float(name[6:]), place) for name, place in q.items() if name.startswith("place@")))


def crossings(t, x):
    """Returns the times at which a jet crosses its mean place to the right, between places far from it on both sides."""
    x = x[t >= START] - x[t >= START].mean()
    t = t[t >= START]
    found, last, left = [], None, False
    for k in range(1, len(t)):
        if x[k - 1] < 0 <= x[k]:
            last = t[k - 1] - x[k - 1] * (t[k] - t[k - 1]) / (x[k] - x[k - 1])
        left |= x[k] < -FAR
        if x[k] > FAR and left and last is not None:
            found.append(last)
            left = False
    return np.array(found)


def measure(run):
    """Makes the runs; returns them by particles along D and start, and by the speed of the belt."""
    sides = {(n, seed): run(line_of(n, seed)) for n, seed in JETS}
    speeds = {speed: run(line_of(8, 0, speed)) for speed in SPEEDS}
    run.save()
    return sides, speeds


def cells(q):
    """Returns the cells of a run: times of folds, their mean distance and its spread, frequency, and what a run says of itself."""
    if "failed" in q:
        return [q["failed"], "", "", "", "", "", q["date"]]
    t = crossings(*places(q).T)
    period = np.diff(t)
    return [", ".join(f"{x:.1f}" for x in t), f"{period.mean():.2f}", f"{period.std(ddof=1):.2f}", f"{HEIGHT / period.mean():.3f}",
            f"{q['stray']:.0f}", f"{100 * (q['fluid_volume'] / q['fluid_volume_reference'] - 1):+.1f} %" if "fluid_volume" in q else "", q["date"]]


def sheets(speeds):
    """Returns a sentence with the frequencies at which a thin sheet folds on belts."""
    found = []
    for speed in speeds:
        t = crossings(*thin_sheet.places(HEIGHT, 5.0, 0.1, speed, LEVEL, 120.0).T)
        found.append(f"{HEIGHT / np.diff(t[t > 40]).mean():.2f} ({speed:g} U)")
    return ", ".join(found)


def frequencies(sides):
    """Returns a sentence with the mean frequency of the starts at each resolution."""
    means = {}
    for (n, _), q in sides.items():
        if "failed" not in q:
            means.setdefault(n, []).append(HEIGHT / np.diff(crossings(*places(q).T)).mean())
    return "Means of the starts and their standard errors: f H/U = " + ", ".join(f"{np.mean(f):.3f} {spread(f)}(n = {n})" for n, f in means.items())


def spread(values):
    """Returns the standard error of a mean with its sign, or nothing for a single value."""
    return f"± {np.std(values, ddof=1) / len(values) ** 0.5:.3f} " if len(values) > 1 else ""


def part(sides, speeds, run):
    """Yields the lines of the page on folds on a belt."""
    head = ["times of folds, U t/D", "mean period", "spread", "f H/U", "stray particles", "volume", "made"]
    yield "\n## Folds on a belt, Re = 0.2, H/D = 11\n"
    yield (f"`options/jet_folds.opts`; the runs are in [jet_folds.csv](jet_folds.csv). The floor is a belt with the speed {SPEED:g} U. It carries the "
           "folds through an outflow, so that no heap grows. A fold is a crossing of the "
           f"jet's mean place at the height {LEVEL:g} D, to the right, from U t/D = {START:g} to {END:g}; periods are in D/U, and f is the "
           "inverse of their mean. Stray particles are those that are farther than 2 dx from the largest group, the most of all snapshots "
           f"(every {EVERY:g} D/U), without groups beside the outflow: a fold that leaves is in two parts for a time. The volume "
           "is the error of the volume inside the surface at the end.\n")
    yield from table(["n", "start", *head], [[n, seed, *cells(q)] for (n, seed), q in sides.items()])
    yield (f"\n{frequencies(sides)}. A thin sheet without contact of its folds (`studies/thin_sheet.py`, after Ribe, Phys. Rev. E 68 (2003) 036305) has "
           f"{sheets(SPEEDS)} on belts of these speeds; at the speed U of the jet its place varies by 0.01 D only. The folds of jets lie "
           "on each other, so that their free height is less than H.\n")
    yield ("On a belt with the speed U, jets with the gradient of fits folded with f H/U = 0.90, 0.77, 0.70 at n = 6, 8, 12: their bending was "
           "five times too stiff and their stretching a fifth too soft, at any n ([theory](../theory/surface.md#eq-340)). With "
           "reactions a jet with n = 6 sways there by 0.14 D (root mean square at 3.3 D) and folds once from U t/D = 20 to 80.\n")
    yield "![Place of jets on a belt in the course of time](jet_folds.png)\n"
    yield "Belts of other speeds, n = 8, first start:\n"
    yield from table(["belt / U", *head], [[f"{speed:g}", *cells(q)] for speed, q in speeds.items()])
    yield "\n" + run.told()


def figure(sides, path):
    """Draws the place of the jets at the level in the course of time."""
    with plt.rc_context({"font.size": 9, "legend.frameon": False}):
        numbers = sorted({n for n, _ in sides})
        fig, axes = plt.subplots(len(numbers), 1, figsize=(8, 1.7 * len(numbers)), sharex=True, sharey=True)
        for axis, n in zip(axes, numbers):
            for (seed, q), colour in zip([(seed, q) for (m, seed), q in sides.items() if m == n], ("#0072B2", "#D55E00", "#009E73")):
                axis.plot(*places(q).T, lw=1.2, color=colour, label=f"start {seed}")
                t = crossings(*places(q).T)
                axis.plot(t, 0 * t + places(q)[:, 1].mean(), "o", color=colour, mfc="none", ms=4)
            axis.set(title=f"n = {n}", ylabel="place / D")
            axis.grid(alpha=0.3)
        axes[0].legend(ncols=2, loc="upper left")
        axes[-1].set(xlabel="t U/D")
        fig.tight_layout()
        fig.savefig(path, dpi=120)
