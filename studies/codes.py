"""The compared codes: commands, timing and errors of their runs on a single core.

A run is a line of words that begins with the name of the code. Its result is a dict of numbers, or of the sentence
`failed`. wall_s and cpu_s cover the whole program with its children, but for PySPH only its time loop.
"""
import csv
import json
import os
import shlex
import subprocess
import sys
import time

import centreline
import dualsphysics
import dualsphysics_flows
import icofoam
import numpy as np
import sphinxsys

STUDIES = os.path.dirname(os.path.realpath(__file__))


def timed(command, folder):
    """Runs a command on a core; returns its output, exit status, and time with all its children."""
    path = os.path.join(folder, "log")
    environment = {**icofoam.environment(), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with open(path, "w") as log:
        start = time.perf_counter()
        child = subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(child.pid, 0)
        wall = time.perf_counter() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    with open(path, errors="replace") as log:
        said = log.read()
    return said, child.returncode, {"wall_s": wall, "cpu_s": used.ru_utime + used.ru_stime}


def end_of(said, status):
    """Returns the reason of a failed run as a line."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    told = [line[6:] for line in lines if line.startswith("isph: ")]
    return {"failed": (told or lines[-1:] or [f"status {status}"])[0][:200]}


def option(words, name, kind=float):
    return kind(words[words.index(name) + 1])


def run_isph(flow, words, folder, isph):
    said, status, cost = timed([isph, *words, "-progress", "none", "-report", "run.csv"], folder)
    if status:
        return end_of(said, status)
    with open(os.path.join(folder, "run.csv"), newline="") as file:
        lines = list(csv.DictReader(file))
    row = {**cost, "steps": lines[-1]["steps"], "dt": flow.t_end / float(lines[-1]["steps"])}
    found = {line["quantity"]: float(line["value"]) for line in lines}
    if flow.reference:
        found.update(centreline.extrema_errors(found, flow.reference))
    keep = {*flow.quantities, *centreline.EXTREMA, "u_profile_l2", "v_profile_l2",
            *(f"{name}_error" for name in centreline.EXTREMA)}
    return {**row, **{name: value for name, value in found.items() if name in keep}}


def run_icofoam(flow, words, folder, isph):
    n, t_end = option(words, "-n", int), option(words, "-t_end")
    dt, steps = icofoam.write_case(folder, option(words, "-reynolds"), n, t_end, option(words, "-courant"))
    for command in (icofoam.MESH, icofoam.SOLVE):
        said, status, cost = timed(command, folder)
        if status:
            return end_of(said, status)
    try:
        u, v = icofoam.read_velocity(folder, n)
    except (OSError, ValueError) as error:
        return {"failed": str(error)}
    if not np.isfinite(u).all():
        return {"failed": "the velocity is no number"}
    return {**cost, "steps": steps, "dt": dt, **centreline.judge(centreline.of_cells(u[0], v[0]), flow.reference)}


def run_pysph(flow, words, folder, isph):
    said, status, _ = timed([pysph_python(), os.path.join(STUDIES, "pysph_run.py"), folder, *words], folder)
    if status:
        return end_of(said, status)
    with open(os.path.join(folder, "run.json")) as file:
        row = json.load(file)
    outputs = np.load(os.path.join(folder, "run.npz"))
    return {**row, **judge_particles(flow, outputs, row["t"], 1 / option(words, "--nx"))}


def dualsphysics_outputs(case, folder):
    """Runs a case of DualSPHysics; returns its result without errors, and its outputs, None of a failed run."""
    dualsphysics.write_case(folder, case)
    said, status, cost = timed(dualsphysics.command(), folder)
    if status:
        return end_of(said, status), None
    try:
        steps, outputs = dualsphysics.read(folder, case)
    except ValueError as error:
        return {"failed": str(error)}, None
    return {**cost, "steps": steps, "dt": case.times[-1] / steps, "particles": len(case.fluid)}, outputs


def run_dualsphysics(flow, words, folder, isph):
    n = option(words, "-n", int)
    case = dualsphysics_flows.FLOWS[words[0]](n, option(words, "-reynolds"), option(words, "-t_end"), option(words, "-walls", str),
                                              option(words, "-shifting", int))
    row, outputs = dualsphysics_outputs(case, folder)
    return {**row, **judge_particles(flow, outputs, case.times[-1], 1 / n)} if outputs else row


def run_sphinxsys(flow, words, folder, isph):
    output, said, cost = sphinxsys.run(words[0], folder)
    if output is None:
        return end_of(said, "its output is missing")
    row, outputs = sphinxsys.read(words[0], output, said)
    return {**cost, **row, **judge_particles(flow, outputs, row["t"], 1 / sphinxsys.EXAMPLES[words[0]].n)}


def vortices(x, y, t):
    """Returns the exact velocity of the Taylor-Green vortices at Re = 100."""
    decay = np.exp(-8 * np.pi**2 * t / 100)
    return (-decay * np.cos(2 * np.pi * x) * np.sin(2 * np.pi * y), decay * np.sin(2 * np.pi * x) * np.cos(2 * np.pi * y))


def channel(x, y, t):
    """Returns the exact velocity of the channel at Re = 15 that starts from rest (cases/poiseuille.c), from nu t/L^2 = 0.1 on;
    the second term of the series, left out, is below 1e-5 then."""
    return 4 * y * (1 - y) - 32 / np.pi**3 * np.sin(np.pi * y) * np.exp(-np.pi**2 * t / 15), np.zeros_like(y)


def judge_particles(flow, outputs, t, dx):
    """Returns the errors of particles, of which the last output is at time t."""
    outputs = {name: np.asarray(outputs[name]) for name in "xyuv"}
    if not all(np.isfinite(field).all() for field in outputs.values()):
        return {"failed": "the velocity is no number"}
    if flow.reference:
        return judge_outputs(flow, outputs, dx)
    x, y, u, v = (outputs[name][-1] for name in "xyuv")
    u_exact, v_exact = flow.exact(x, y, t)
    square = np.sum((u - u_exact)**2 + (v - v_exact)**2) / np.sum(u_exact**2 + v_exact**2)
    return {"velocity_l2": np.sqrt(square)}


def judge_outputs(flow, outputs, dx):
    """Returns the better result of two: the last output, or the mean of the last outputs as in the example's plots."""
    lines = [centreline.of_particles(*(outputs[name][k] for name in "xyuv"), dx) for k in range(len(outputs["x"]))]
    samples = {}

    def mean(component, s):
        return np.mean([line(component, s) for line in lines], axis=0)

    for averaged, line in ((1, lines[-1]), (len(lines), mean)):
        samples[averaged] = {**centreline.judge(line, flow.reference), "averaged": averaged}
    return min(samples.values(), key=lambda found: max(found[name] for name in flow.quantities))


def pysph_python():
    """Returns an interpreter with PySPH, or None; the first python3 of the PATH may lack it."""
    for python in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([python, "-c", "import pysph"], capture_output=True, check=False).returncode == 0:
            return python
    return None


CODES = {  # by the first word of a run's arguments: function for the missing program, function for a run
    "isph": (lambda isph: None if os.access(isph, os.X_OK) else "no program isph (--isph PATH)", run_isph),
    "icoFoam": (lambda isph: icofoam.absent(), run_icofoam),
    "pysph": (lambda isph: None if pysph_python() else "no PySPH (Debian package python3-pysph)", run_pysph),
    "dualsphysics": (lambda isph: dualsphysics.absent(), run_dualsphysics),
    "sphinxsys": (lambda isph: sphinxsys.absent(), run_sphinxsys),
}


def run(flow, arguments, folder, isph):
    """Makes a run in an empty folder and returns its result."""
    code, *words = shlex.split(arguments)
    return CODES[code][1](flow, words, folder, isph)


def absent(code, isph):
    """Returns a sentence about the missing program of a code, or None."""
    return CODES[code][0](isph)
