#!/usr/bin/env python3
"""Tests -pressure_average against pressures and forces of each instant.

    average.py means ISPH...      trapezoidal means of probes, forces and snapshots; a pressure linear in time
    average.py ranks ISPH...      the same rows and snapshots on 1, 2 and 3 ranks
    average.py restart ISPH...    a restarted run has the same rows and snapshots to the last bit

ISPH... is the program, followed by the words that start it on several ranks, with {} for their number. Snapshots are
tested if Python has h5py; without it the status is 77."""
import csv
import glob
import os
import subprocess
import sys

from interpreter import python_with

DT, T = 0.02, 0.1
CAVITY = ["-case", "cavity", "-reynolds", "400", "-n", "12", "-dt", f"{DT}"]
PROBES = ["-probe_forces", "-probe_point", "0.25,0.5,0.7,0.6", "-probe_line", "0,0.5,1,0.5,5,0.3,0,0.3,1,4"]
TIGHT = ["-ppe_ksp_rtol", "1e-12", "-visc_ksp_rtol", "1e-12"]
FLOWS = {"lagrangian": ["-motion", "lagrangian"], "eulerian": ["-motion", "eulerian"],
         "same": ["-pressure_points", "same"]}
MEAN = {"forces": ("fx", "fy", "tz"), "point": ("p",), "line": ("p",)}  # averaged columns of files


def run(command, folder, *options):
    os.makedirs(folder, exist_ok=True)
    subprocess.run([*command, "-progress", "none", *options], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def ranked(command, n):
    isph, *mpi = command
    return [word.replace("{}", str(n)) for word in mpi] + [isph] if n > 1 else [isph]


def series(folder, kind):
    """Returns (t, rows of that time), a list, of a probe file."""
    times = {}
    with open(f"{folder}/probe_{kind}.csv", newline="") as file:
        for row in csv.DictReader(file):
            times.setdefault(float(row["t"]), []).append(row)
    return list(times.items())


def columns(row, names):
    return [float(row[name]) for name in names]


def mean_of(instants, t, length):
    """Returns the trapezoidal mean over the last `length` before t of (time, values), without the time 0."""
    kept = [(s, v) for s, v in instants if 0 < s <= t * (1 + 1e-12) and s >= t - length * (1 + 1e-6)]
    if len(kept) == 1:
        return kept[0][1]
    total = [0.0] * len(kept[0][1])
    for (s0, v0), (s1, v1) in zip(kept, kept[1:]):
        total = [sum_ + 0.5 * (s1 - s0) * (a + b) for sum_, a, b in zip(total, v0, v1)]
    return [value / (kept[-1][0] - kept[0][0]) for value in total]


def close(found, wanted, tolerance, where):
    scale = max([1.0, *map(abs, wanted)])
    assert all(abs(a - b) <= tolerance * scale for a, b in zip(found, wanted)), (where, found, wanted)


def compare_probes(instant, averaged, every):
    """Compares the rows of a run with a mean with the means of the rows of the same run without."""
    for kind, names in MEAN.items():
        before = [(t, [x for row in rows for x in columns(row, names)]) for t, rows in series(instant, kind)]
        found = series(averaged, kind)
        assert len(found) == (len(before) if not every else 1 + round(before[-1][0] / every)), (kind, len(found))
        for t, rows in found[1:]:
            values = [x for row in rows for x in columns(row, names)]
            close(values, mean_of(before, t, T), 1e-10, (averaged, kind, t))  # 12 digits in files
        others = [name for name in rows[0] if name in ("u", "v")]
        close([x for row in found[-1][1] for x in columns(row, others)],
              [x for row in series(instant, kind)[-1][1] for x in columns(row, others)], 1e-11, (averaged, kind, "u"))


def snapshots(folder):
    """Returns a list of (time, length of the mean, positions, pressures) in the order of particle ids."""
    import h5py

    found = []
    for path in sorted(glob.glob(f"{folder}/s_*.h5")):
        with h5py.File(path) as file:
            fluid = file["type"][:] == 0
            order = file["id"][:][fluid].argsort()
            time, length = (float(file.attrs[name][()]) for name in ("time", "pressure_average"))
            found.append((time, length, file["position"][:][fluid][order], file["pressure"][:][fluid][order]))
    return found


def means(command):
    command = ranked(command, 1)
    for name, options in FLOWS.items():
        flow = [*CAVITY, *options, "-t_end", "0.4"]
        run(command, f"{name}_0", *flow, *PROBES)
        run(command, f"{name}_T", *flow, *PROBES, "-pressure_average", f"{T}", "-report", "r.csv")
        compare_probes(f"{name}_0", f"{name}_T", 0)
        run(command, f"{name}_every", *flow, *PROBES, "-pressure_average", f"{T}", "-probe_every", "0.2")
        compare_probes(f"{name}_0", f"{name}_every", 0.2)
        with open(f"{name}_T/r.csv", newline="") as file:
            assert [float(row["value"]) for row in csv.DictReader(file) if row["quantity"] == "pressure_average"] == [T]

    # A snapshot has the mean over the last T, or over the time since the last snapshot.
    # Lengths of steps differ in their last bits, and solves are good to 1e-12.
    fixed = [*CAVITY, *TIGHT, "-motion", "eulerian", "-t_end", "0.4", "-output", "s.h5"]
    for name, flow in ("same", fixed), ("coarse", [*fixed, "-pressure_points", "coarse", "-reynolds", "100"]):
        run(command, f"{name}_each", *flow, "-output_every", f"{DT}")
        each = [(t, list(p)) for t, _, _, p in snapshots(f"{name}_each")]
        for every, length in (0.2, T), (0.06, 0.06):
            run(command, f"{name}_{every}", *flow, "-output_every", f"{every}", "-pressure_average", f"{T}")
            for t, found, _, p in snapshots(f"{name}_{every}")[1:]:
                since = min(length, t - max(DT, every * round((t - 1e-9) // every)))  # the first step or last snapshot
                assert abs(found - since) < 1e-9, (t, found, since)
                close(p, mean_of(each, t, found), 1e-9, (name, every, t))

    # A fluid at rest under the force t: the pressure grows with time, and the mean belongs to the middle of its time.
    # The pressure of a step lags by a fraction of dt that hardly changes after the start.
    rest = ["-case", "scene", "-body_force", "t,0", "-viscosity", "0.1", "-n", "12", "-dt", f"{DT}", "-t_end", "0.6", *TIGHT]
    for name, options in FLOWS.items():
        slopes = []
        for length in 0, T:
            run(command, f"rest_{name}_{length}", *rest, *options, "-output", "s.h5", "-output_every", "0.2",
                "-pressure_average", f"{length}")
            _, found, x, p = snapshots(f"rest_{name}_{length}")[-1]
            assert abs(found - length) < 1e-9, found
            s = x[:, 0] - x[:, 0].mean()
            slopes.append((p @ s) / (s @ s))
        # moving particles drift by less than 1e-3 L/s times T, and the slope along their way is 1 Pa/m
        assert abs(slopes[1] - (slopes[0] - T / 2)) < (1e-6 if name == "eulerian" else 1e-4), (name, slopes)


def ranks(command):
    for name, options in FLOWS.items():
        found = []
        for n in 1, 2, 3:
            folder = f"{name}{n}"
            run(ranked(command, n), folder, *CAVITY, *TIGHT, *options, "-t_end", "0.2", *PROBES, "-output", "s.h5",
                "-probe_every", "0.1", "-pressure_average", f"{T}")
            rows = [x for kind, names in MEAN.items() for _, rows in series(folder, kind) for row in rows
                    for x in columns(row, names)]
            found.append((rows, snapshots(folder)[-1]))
        for rows, (t, length, _, p) in found[1:]:
            first, last = found[0]
            close(rows, first, 1e-6, (name, "rows"))
            assert t == last[0] and abs(length - last[1]) < 1e-12 and length > 0.9 * T, (length, last[1])
            close(p, last[3], 1e-6, (name, "snapshot"))


def restart(command):
    """The checkpoint of step 12 lies in a mean of the snapshot and in means of the rows."""
    for n in 1, 3:
        for name, flow in FLOWS.items():
            folder = f"{name}{n}"
            options = [*CAVITY, *flow, "-t_end", "0.3", "-skin", "0.5", *PROBES, "-probe_every", "0.1", "-output",
                       "s.h5", "-checkpoint_every", "0.24", "-pressure_average", f"{T}"]
            start = ranked(command, n)
            run(start, folder, *options, "-checkpoint", "a.h5")
            run(start, f"{folder}_again", *options, "-checkpoint", "b.h5", "-max_steps", "12")
            for path in glob.glob(f"{folder}_again/s_*.h5"):
                os.remove(path)  # of step 12: the whole run has none
            run(start, f"{folder}_again", *options, "-checkpoint", "c.h5", "-restart", "b.h5")
            for kind in MEAN:
                assert series(folder, kind) == series(f"{folder}_again", kind), (folder, kind)
            (t, length, _, p), (t2, length2, _, p2) = snapshots(folder)[-1], snapshots(f"{folder}_again")[-1]
            assert (t, length) == (t2, length2) and abs(length - T) < 1e-9, (length, length2)
            assert (p == p2).all(), (folder, abs(p - p2).max())

            # other probes begin their means anew
            run(start, f"{folder}_other", *options[:options.index("-probe_forces")], "-probe_forces", "-pressure_average",
                f"{T}", "-restart", f"../{folder}_again/b.h5", "-t_end", "0.3")


python_with("h5py")
{"means": means, "ranks": ranks, "restart": restart}[sys.argv[1]](sys.argv[2:])
