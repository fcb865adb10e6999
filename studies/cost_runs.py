"""Runs of the study of costs: user CPU time, memory, and errors of isph, icoFoam and the spectral code.

A run is a line of words, kept as a row of a CSV file. Its first word is the program: isph, mpiexec, icoFoam or spectral.
A line that ends in " # k" is repetition k of the same run. The study adds options for files (-report, -output,
-probe_point) to lines of isph; they leave the flow unchanged.
"""
import csv
import os
import re
import resource
import shlex
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from datetime import datetime, timezone
from typing import NamedTuple

import centreline
import icofoam
import icofoam_flows
import numpy as np
import spectral
from runs import ROOT, Runs

SHELL = ("sh", "-c", '"$@"; exit $?', "sh")  # keeps Python's memory out of the largest memory of isph
LONG = 5  # user time of a run that is not repeated [s]
CENTRE, RADIUS = (0.5, 0.55), 0.15
BODY = f"circle,{CENTRE[0]},{CENTRE[1]},{RADIUS}"
LINES = [(x, 0.05 + 0.05 * k) for x in (0.2, 0.8) for k in range(19)]
POINTS = LINES + [(0.5, 0.05 + 0.05 * k) for k in (*range(7), *range(14, 19))]  # without the cylinder
TEXTS = ("run", "failed", "build", "date", "profile")
EXTREMA = tuple(f"{name}_error" for name in centreline.EXTREMA)
ENERGY = "kinetic_energy_error"
REPORTED = ("u_min", "v_max", "v_min", "kinetic_energy", "velocity_l2", "pressure_l2", "trust")


class Periodic(NamedTuple):
    """A flow in the periodic unit square, with the spectral resolution of its reference."""
    velocity: object
    reynolds: float
    t_end: float
    modes: int


PERIODIC = {"taylor_green": Periodic(spectral.taylor_green, 100, 1, 64),
            "double_shear": Periodic(spectral.double_shear, 1e4, 1, 384)}


def timed(command, folder):
    """Runs a command; returns its output, its status and its times."""
    path = os.path.join(folder, "log")
    environment = {**icofoam.environment(), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
                   "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    with open(path, "w") as log:
        start = time.perf_counter()
        child = subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(child.pid, 0)
        wall = time.perf_counter() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    with open(path, errors="replace") as log:
        printed = log.read()
    return printed, child.returncode, {"user_s": used.ru_utime, "system_s": used.ru_stime, "wall_s": wall}


def reason(printed, status):
    """Returns the error sentence of a failed run, or the signal that ended it; icoFoam's SIGFPE is a flow that diverged."""
    lines = [line.strip() for line in printed.splitlines() if re.search("[a-z]", line)]
    told = [line[6:] for line in lines if line.startswith("isph: ")]
    if status < 0 and not told:
        return f"ended by signal {signal.Signals(-status).name}"
    return (told or lines[-1:] or [f"status {status}"])[0][:200]


def value(words, name, kind=float):
    """Returns the value of an option in a list of words."""
    return kind(words[words.index(name) + 1])


class Ledger(Runs):
    """Stores the runs of all programs, each with its build and date."""

    def __init__(self, path, isph, repeats):
        super().__init__(path, isph)
        self.repeats, self.fields = repeats, {}

    def numbers(self, arguments):
        return {k: v if k in TEXTS else float(v) for k, v in self.rows[arguments].items()}

    def make(self, arguments, watch=""):
        program, *words = shlex.split(arguments, comments=True)
        with tempfile.TemporaryDirectory() as folder:
            try:
                row = PROGRAMS[program](self, words, folder, watch)
            except (OSError, ValueError, KeyError) as error:
                row = {"failed": str(error)[:200]}
        row = {name: item if isinstance(item, str) else f"{item:.6g}" for name, item in row.items()}
        return {"run": arguments, "failed": "", "build": self.build,
                "date": datetime.now(timezone.utc).date().isoformat(), **row}

    def measure(self, line, flow, below):
        """Makes a run, and its repetitions if it takes less user time than `below`."""
        first = self(line, flow)
        if "failed" not in first and first["user_s"] < below:
            for k in range(2, self.repeats + 1):
                self(f"{line} # {k}", flow)

    def median(self, line):
        """Returns the numbers of a run with the medians of its times and memory, or None."""
        if line not in self.rows:
            return None
        kept = [self.numbers(key) for key in (line, *(f"{line} # {k}" for k in range(2, 100))) if key in self.rows]
        for row in kept:
            self.asked.add(row["run"])
        good = [row for row in kept if "failed" not in row]
        if not good:
            return kept[0]
        medians = {name: statistics.median(row[name] for row in good)
                   for name in ("user_s", "wall_s", "loop_s", "rss_mb") if name in good[0]}
        return {**good[0], **medians, "repeats": len(good)}

    def told(self):
        """Returns a sentence on the time of the used runs; prints the number of runs of other builds of isph."""
        rows = [self.rows[line] for line in self.asked]
        others = sum(row["build"] != self.build for row in rows if row["run"].startswith(("isph", "mpiexec")))
        if others:
            print(f"{others} runs are of another build of isph; without their rows in {self.path} they are made anew")
        if not rows:
            return ""
        spent = sum(float(row.get("user_s", 0)) for row in rows)
        return f"The {len(rows)} runs together took {spent / 3600:.2g} hours of user time."

    def reference(self, name):
        """Returns the spectral Field of a periodic flow; computes it at the first call."""
        if name not in self.fields:
            flow = PERIODIC[name]
            print(f"spectral {name} -n {flow.modes}", flush=True)
            self.fields[name] = spectral.solve(flow.velocity, 1 / flow.reynolds, flow.t_end, flow.modes)
        return self.fields[name]

    def periodic_error(self, name, x, y, u):
        """Returns the L2 error of a velocity at points, relative to the reference there."""
        exact = self.reference(name).at(x, y)
        return float(np.sqrt(np.sum((u - exact) ** 2) / np.sum(exact**2)))


def report_row(path):
    """Returns the numbers at the end of a -report file."""
    with open(path, newline="") as file:
        lines = list(csv.DictReader(file))
    row = {name: float(lines[-1][name]) for name in ("steps", "particles", "t", "rss_mb")}
    row["loop_s"] = float(lines[-1]["wall_s"])
    for line in lines:
        if line["quantity"] in REPORTED and line["t"] == lines[-1]["t"]:
            row[line["quantity"]] = float(line["value"])
            if line["error"]:
                row[f"{line['quantity']}_error"] = float(line["error"])
    return row


def run_isph(ledger, words, folder, flow, launch=SHELL):
    """Makes a run of isph; its velocity is measured at the points of the flow."""
    words = [os.path.join(ROOT, word) if before == "-options_file" else word for before, word in zip(["", *words], words)]
    watch = []
    if flow == "cylinder":
        points = ",".join(f"{coordinate:.12g}" for point in POINTS for coordinate in point)
        watch = ["-probe_point", points, "-probe_every", str(value(words, "-t_end"))]
    if flow in PERIODIC:
        watch = ["-output", "flow.h5"]
    printed, status, cost = timed([*launch, ledger.isph, *words, "-progress", "none", "-report", "run.csv", *watch], folder)
    if status:
        return {**cost, "failed": reason(printed, status)}
    row = {**cost, **report_row(os.path.join(folder, "run.csv"))}
    if flow == "cylinder":
        with open(os.path.join(folder, "probe_point.csv"), newline="") as file:
            last = list(csv.DictReader(file))[-len(POINTS):]
        row["profile"] = profile_text(np.array([[float(line[name]) for line in last] for name in "uv"]))
    if flow in PERIODIC:
        row["velocity_error"] = ledger.periodic_error(flow, *read_snapshot(os.path.join(folder, "flow_0001.h5")))
    return row


def read_snapshot(path):
    """Returns x, y and the velocity (2 x N) of the fluid particles of a snapshot."""
    import h5py
    with h5py.File(path) as file:
        fluid = file["type"][:] == 0
        x, u = file["position"][:][fluid], file["velocity"][:][fluid]
    return x[:, 0], x[:, 1], u.T


def run_mpiexec(ledger, words, folder, flow):
    """Makes a run of isph on several ranks; the words begin with -n RANKS isph."""
    return run_isph(ledger, words[3:], folder, flow,
                    ["mpiexec", "--oversubscribe", "--bind-to", "none", *words[:2]])


def write_foam(flow, words, folder):
    """Writes a case of icoFoam; returns (dt, steps)."""
    n, courant, t_end = value(words, "-n", int), value(words, "-courant"), value(words, "-t_end")
    reynolds = value(words, "-reynolds")
    if flow == "cylinder":
        return icofoam_flows.write_cylinder(folder, CENTRE, RADIUS, reynolds, n, t_end, courant)
    if flow in PERIODIC:
        return icofoam_flows.write_periodic(folder, PERIODIC[flow].velocity, reynolds, n, t_end, courant)
    return icofoam.write_case(folder, reynolds, n, t_end, courant)


def run_icofoam(ledger, words, folder, flow):
    """Makes a run of icoFoam; its time is without the mesh."""
    _, steps = write_foam(flow, words, folder)
    for command in (icofoam.MESH, icofoam.SOLVE):
        printed, status, cost = timed(command, folder)
        if status:
            return {**cost, "failed": reason(printed, status)}
    n = value(words, "-n", int)
    version = re.search(r"OPENFOAM=(\S+)", printed)
    row = {**cost, "steps": steps, "build": f"OpenFOAM {version[1] if version else ''}".strip()}
    u = icofoam_flows.read_vectors(folder, "U")
    if not np.isfinite(u).all():
        return {**row, "failed": "the velocity is no number"}
    row["particles"] = u.shape[1]
    if flow == "cylinder":
        subprocess.run(["postProcess", "-func", "writeCellCentres", "-latestTime"], cwd=folder, check=True,
                       env=icofoam.environment(), stdout=subprocess.DEVNULL)
        x, y = icofoam_flows.read_vectors(folder, "C")
        row["profile"] = profile_text(icofoam_flows.profile(x, y, u, POINTS, 1 / n))
    elif flow in PERIODIC:
        row["velocity_error"] = ledger.periodic_error(flow, *icofoam_flows.cell_centres(n), u)
    else:
        row.update(cavity_errors(u.reshape(2, n, n), value(words, "-t_end")))
    return row


def cavity_errors(u, t_end):
    """Returns errors of the extrema and of the energy of cells of the cavity at Re = 1000."""
    reference = "cavity_re1000_t40" if t_end < 40.1 else "cavity_re1000"
    found = centreline.judge(centreline.of_cells(*u), reference)
    row = {name: found[name] for name in EXTREMA}
    times, energies = centreline.read_columns(os.path.join(centreline.REFERENCE, "cavity_re1000_ke.csv"))
    if t_end <= times[-1]:
        exact = np.interp(t_end, times, energies)
        row[ENERGY] = abs(0.5 * np.sum(u**2) / u[0].size / exact - 1)
    return row


def run_spectral(ledger, words, folder, flow):
    """Makes a run of the spectral code in this process; its error is at 2000 random points."""
    n, case = value(words, "-n", int), PERIODIC[flow]
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    start = time.perf_counter()
    field = spectral.solve(case.velocity, 1 / case.reynolds, case.t_end, n)
    row = {"wall_s": time.perf_counter() - start,
           "user_s": resource.getrusage(resource.RUSAGE_SELF).ru_utime - before, "particles": n * n, "build": "numpy "
           + np.__version__}
    x, y = np.random.default_rng(1).random((2, 2000))
    return {**row, "velocity_error": ledger.periodic_error(flow, x, y, field.at(x, y))}


def profile_text(values):
    """Returns u of all points and then v, as words."""
    if not np.isfinite(values).all():
        raise ValueError("the velocity is no number")
    return " ".join(f"{number:.7g}" for number in np.ravel(values))


def profile_values(row):
    """Returns u and v of the points of a row."""
    return np.array(row["profile"].split(), dtype=float)


def extrapolated(coarse, fine, ratio=2):
    """Returns Richardson's extrapolation of second order of two profiles."""
    return fine + (fine - coarse) / (ratio**2 - 1)


def profile_error(values, reference):
    """Returns the root mean square difference of profiles over the root mean square of the reference."""
    return float(np.sqrt(np.sum((values - reference) ** 2) / np.sum(reference**2)))


PROGRAMS = {"isph": run_isph, "mpiexec": run_mpiexec, "icoFoam": run_icofoam, "spectral": run_spectral}


def absent(program, isph):
    """Returns a sentence about a missing program, or None."""
    if program in ("isph", "mpiexec"):
        return None if os.access(isph, os.X_OK) else "no program isph (--isph PATH)"
    return icofoam.absent() if program == "icoFoam" else None


def complain(sentence):
    """Prints a sentence on standard error."""
    print(sentence, file=sys.stderr, flush=True)
