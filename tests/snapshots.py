#!/usr/bin/env python3
"""Snapshots: their times in the index.

    snapshots.py times COMMAND...      the program, on some ranks
"""
import re
import subprocess
import sys


def run(*options):
    subprocess.run([*sys.argv[2:], "-progress", "none", *options], check=True, stdout=subprocess.DEVNULL)


def index_times(path):
    """Returns the times in an index."""
    with open(path) as file:
        return [float(t) for t in re.findall(r'<Time Value="([^"]*)"', file.read())]


def times():
    """Snapshots lie at multiples of -output_every, whatever the steps are."""
    for motion in "lagrangian", "eulerian":
        run("-case", "cavity", "-n", "12", "-t_end", "1", "-motion", motion, "-output", "s.h5", "-output_every", "0.15",
            "-report_times", "0.2,0.3", "-cfl", "0.7")
        wanted = [*(0.15 * k for k in range(7)), 1]
        found = index_times("s.xdmf")
        assert len(found) == len(wanted), found
        for a, b in zip(found, wanted):
            assert abs(a - b) < 1e-12, (a, b)


{"times": times}[sys.argv[1]]()
