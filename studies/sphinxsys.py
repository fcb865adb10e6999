"""Two examples of SPHinXsys, as it ships them: a lid-driven cavity at Re = 100 and a channel that starts from rest.

Each is a program of its own without options for the flow, so that n and the steps are the example's: 50 along the cavity, 20
across the channel of length 6. A program needs the folder `input` beside it, which its build makes. A run is stopped as soon as
the output at its time is there. The number of acoustic steps follows
from the steps dt that the program prints every hundred advective steps. Both run on a single core.
"""
import glob
import os
import re
import shutil
import subprocess
import time
from typing import NamedTuple

import numpy as np


class Example(NamedTuple):
    program: str
    n: int
    t: float  # in its units
    unit: float  # our unit of time over its own


EXAMPLES = {  # the channel has nu = 0.1 and the largest velocity 1.5
    "cavity": Example("test_2d_lid_driven_cavity_corrected", 50, 10, 1),
    "channel": Example("test_2d_poiseuille_flow", 20, 2, 1.5),
}
LINE = re.compile(r"N=(\d+)\s+Time = (\S+)\s.*\bdt = (\S+)")


def absent():
    """Returns a sentence about the missing programs, or None."""
    if all(shutil.which(example.program) for example in EXAMPLES.values()):
        return None
    return f"no SPHinXsys (its examples {', '.join(example.program for example in EXAMPLES.values())} on the PATH)"


def last_output(folder, t):
    """Returns the text of the first complete output of the fluid from time t on, or None."""
    for path in sorted(glob.glob(os.path.join(folder, "output", "WaterBody_[0-9]*.vtp"))):
        if int(re.search(r"_(\d+)\.vtp", path).group(1)) >= 1e6 * t:
            with open(path) as file:
                said = file.read()
            return said if said.rstrip().endswith("</VTKFile>") else None
    return None


def run(name, folder):
    """Runs an example; returns its text, what it printed, and its user and system time."""
    example, core = EXAMPLES[name], {min(os.sched_getaffinity(0))}
    program = shutil.which(example.program)
    given = os.path.join(os.path.dirname(os.path.realpath(program)), "input")
    if os.path.isdir(given):
        shutil.copytree(given, os.path.join(folder, "input"))
    with open(os.path.join(folder, "log"), "w") as log:
        start = time.perf_counter()
        child = subprocess.Popen(["stdbuf", "-oL", program], cwd=folder, stdout=log, stderr=subprocess.STDOUT,
                                 preexec_fn=lambda: os.sched_setaffinity(0, core))
        ended, output = 0, None
        while not ended and output is None:
            time.sleep(0.02)
            output = last_output(folder, example.t)
            ended, _, used = os.wait4(child.pid, os.WNOHANG)
        if not ended:
            child.terminate()
            _, _, used = os.wait4(child.pid, 0)
        child.returncode, wall = 0, time.perf_counter() - start
    with open(os.path.join(folder, "log"), errors="replace") as log:
        said = log.read()
    return output, said, {"wall_s": wall, "cpu_s": used.ru_utime + used.ru_stime}


def array(output, name):
    """Returns the numbers of an array of a .vtp file as text, three in a row."""
    numbers = re.search(rf'<DataArray Name="{name}"[^>]*>(.*?)</DataArray>', output, re.DOTALL).group(1)
    return np.array(numbers.split(), dtype=float).reshape(-1, 3)


def read(name, output, said):
    """Returns the result of a run without errors, and its outputs, in the units of our flows."""
    unit = EXAMPLES[name].unit
    places, velocities = array(output, "Position"), array(output, "Velocity") / unit
    t = float(re.search(r'Name="TimeValue"[^>]*>\s*(\S+)', output).group(1))
    times, dt = np.array([(float(found[2]), float(found[3])) for found in LINE.finditer(said)]).T
    steps = np.sum(np.diff(np.concatenate([[0], times, [t]])) / np.concatenate([dt, dt[-1:]]))
    row = {"steps": round(steps), "dt": t * unit / steps, "t": t * unit, "particles": len(places)}
    return row, {key: [field] for key, field in zip("xyuv", (*places.T[:2], *velocities.T[:2]))}
