#!/usr/bin/env python3
"""Tests -probe_budget: the energies of all parts of a step and all boxes add up to the change of the kinetic energy.

    budget.py sum ISPH...         moving, fixed and periodic flows and -scheme coupled on 1 and 2 ranks; the probe
                                  leaves the flow unchanged; exact energy of a body force
    budget.py ranks ISPH...       the same rows on 1 and 2 ranks
    budget.py restart ISPH...     a restarted run has the same rows to the last bit, on 1 and 2 ranks

ISPH... is the program, followed by the words that start it on several ranks, with {} for their number."""
import csv
import os
import subprocess
import sys

BOXES = "0,0.8,0.2,1,0,0.8,1,1"
CAVITY = ["-case", "cavity", "-reynolds", "1000", "-n", "16", "-t_end", "1"]
DISC = ["-case", "cavity_cylinder", "-reynolds", "1000", "-n", "16", "-t_end", "0.5", "-pressure_points", "same"]
FIXED = ["-case", "cavity", "-reynolds", "100", "-n", "16", "-t_end", "0.5", "-motion", "eulerian"]
VORTICES = ["-case", "taylor_green", "-n", "16", "-t_end", "0.3"]
FORCED = ["-case", "scene", "-scene_periodic", "x,y", "-body_force", "3,4", "-n", "12", "-dt", "0.1", "-max_steps", "1",
          "-t_end", "1"]
TIGHT = ["-ppe_ksp_rtol", "1e-12", "-visc_ksp_rtol", "1e-12"]


def ranked(command, n):
    isph, *mpi = command
    return [word.replace("{}", str(n)) for word in mpi] + [isph] if n > 1 else [isph]


def run(command, folder, *options):
    """Makes a run in a folder; returns the rows of its report as texts."""
    os.makedirs(folder, exist_ok=True)
    if os.path.exists(f"{folder}/r.csv"):
        os.remove(f"{folder}/r.csv")
    subprocess.run([*command, "-progress", "none", "-report", "r.csv", *options], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    with open(f"{folder}/r.csv", newline="") as file:
        return {row["quantity"]: row["value"] for row in csv.DictReader(file)}


def rows(folder):
    with open(f"{folder}/probe_budget.csv", newline="") as file:
        return list(csv.DictReader(file))


def energy(table, **where):
    return sum(float(row["energy"]) for row in table if all(row[k] == v for k, v in where.items()))


def add_up(isph):
    # Energies of the start: 0 at rest, and rho U^2 L^2/4 of Taylor-Green vortices, whose sum on a lattice is exact.
    for ranks in 1, 2:
        for flow, start in ((CAVITY, 0), (DISC, 0), (FIXED, 0), ([*FIXED, "-scheme", "coupled"], 0), (VORTICES, 0.25)):
            folder = f"sum-{ranks}"
            values = run(ranked(isph, ranks), folder, *flow, "-probe_budget", BOXES)
            end = float(values["kinetic_energy"])
            # Columns have 12 digits; each sum of some hundred particles rounds by 1e-14 of the energy.
            assert abs(start + energy(rows(folder)) - end) < 1e-11 * (start + end), (ranks, flow)
            assert values == run(ranked(isph, ranks), folder, *flow), flow

    run(ranked(isph, 1), "forced", *FORCED, *TIGHT, "-probe_budget", "0,0,1,0.5")
    for box in "0", "rest":  # the first step is a backward Euler step: V/2 f dt.u = (1/2) (5/10)^2, of which half is lost
        assert abs(energy(rows("forced"), part="force", box=box) - 0.125) < 1e-10
        assert abs(energy(rows("forced"), part="time", box=box) + 0.0625) < 1e-10
    for row in rows("forced"):
        assert float(row["share"]) == 0.5 and float(row["divergence_max"]) < 1e-6


def same_on_ranks(isph):
    for ranks in 1, 2:
        run(ranked(isph, ranks), f"ranks-{ranks}", *CAVITY, "-max_steps", "8", *TIGHT, "-probe_budget", BOXES)
    here, there = rows("ranks-1"), rows("ranks-2")
    assert len(here) == len(there) == 8 * 8 * 3
    # Rounding: builds for one kind of processor and for all of them differ by up to 3e-9 of the largest energy.
    for name, tolerance in ("energy", 1e-8), ("divergence_rms", 1e-5), ("divergence_max", 1e-5):
        largest = max(abs(float(row[name])) for row in here)
        for a, b in zip(here, there):
            assert (a["step"], a["part"], a["box"]) == (b["step"], b["part"], b["box"])
            assert abs(float(a[name]) - float(b[name])) < tolerance * largest, (name, a, b)


def restarted(isph):
    """All runs write a checkpoint after step 12, which starts an epoch."""
    for ranks in 1, 2:
        folder, command = f"restart-{ranks}", ranked(isph, ranks)
        options = [*CAVITY, "-t_end", "0.5", "-dt", "0.02", "-probe_budget", BOXES, "-checkpoint_every", "0.24"]
        run(command, folder, *options, "-checkpoint", "a.h5")
        whole = rows(folder)
        run(command, folder, *options, "-checkpoint", "b.h5", "-max_steps", "12")
        assert len(rows(folder)) < len(whole)
        run(command, folder, *options, "-checkpoint", "c.h5", "-restart", "b.h5")
        assert rows(folder) == whole, ranks


TESTS = {"sum": add_up, "ranks": same_on_ranks, "restart": restarted}
TESTS[sys.argv[1]](sys.argv[2:])
