"""Runs of isph for the studies, each made once and kept as a row of a CSV file."""
import csv
import datetime
import glob
import hashlib
import importlib.util
import os
import re
import resource
import shlex
import signal
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
FORMS = ["morris", "gotoh", "schwaiger", "corrected", "direct_scalar", "fatehi_manzari", "lsph", "mls",
         "mls3"]
COLOURS = dict(zip(FORMS, ["#000000", "#E69F00", "#56B4E9", "#009E73", "#999999", "#CC79A7", "#8C6D31",
                           "#0072B2", "#D55E00"]))  # distinct for colour-blind readers too
OWN = r"-(?:visc|ppe)_laplacian (?:corrected|direct_difference|mls3|fatehi_manzari|lsph)\b"  # forms of studies/forms.c
WARNING = r"^(?:not (trusted):|(\w+)(?: not kept:| [^,\n]+, should be at most))"  # in the report of a run
MARKERS = dict(zip(FORMS, "osd^xPvD*"))


def own_forms(isph, arguments):
    """Returns the options that a run with a form of studies/forms.c needs besides; the build of isph has the object."""
    path = os.path.join(os.path.dirname(os.path.abspath(isph)), "studies", "forms.so")
    return ["-library", path] if re.search(OWN, arguments) else []


def cpu_seconds():
    """Returns the CPU time of finished child processes."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def build_of(isph):
    """Returns eight characters that tell builds apart: of the program and of the library beside it, which has its code."""
    found = hashlib.sha256()
    for path in (isph, os.path.join(os.path.dirname(isph), "libisph.so")):
        if path == isph or os.path.exists(path):
            with open(path, "rb") as file:
                found.update(file.read())
    return found.hexdigest()[:8]


class Runs:
    """Quantities at the end of runs by their arguments; quantities at earlier -report_times have the name name@time. A
    failed run has its error sentence in `failed`, and in `failed_t` the time at which it failed; `not_kept` has the
    quantities that a run says that it has not kept, and `said` those that its report warns of. A run that takes more
    than `seconds` of CPU time is stopped and fails; quantities of its last step, at t, are kept. Each row names the
    build that made it and the day; rows of other builds are kept, and told() counts them. Runs take one rank, or
    `ranks` of them."""

    def __init__(self, path, isph, seconds=None, ranks=1):
        self.path, self.isph, self.seconds, self.rows, self.unsaved, self.made = path, isph, seconds, {}, 0, 0
        self.build, self.asked = "", set()
        self.launch = [isph]
        if ranks > 1:
            self.launch = ["mpiexec", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), isph]
        if os.path.isfile(isph):
            self.build = build_of(isph)
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        if os.path.exists(path):
            with open(path, newline="") as file:
                for row in csv.DictReader(file):
                    self.rows[row["run"]] = {k: v for k, v in row.items() if v}

    def __call__(self, arguments, watch=""):
        """Returns the quantities of a run as numbers; makes the run unless the file has it. `watch` holds -probe_
        options, which leave the run unchanged: the last rows of their files become quantities, such as forces_left_fx
        or point_0_p."""
        if arguments not in self.rows:
            print(arguments, flush=True)
            start = time.monotonic()
            self.rows[arguments] = {k: v for k, v in self.make(arguments, watch).items() if v != ""}
            self.unsaved += 1
            self.made += 1
            if self.unsaved >= 20 or time.monotonic() - start > 5.0:
                self.save()
        self.asked.add(arguments)
        return self.numbers(arguments)

    def numbers(self, arguments):
        """Returns the quantities of a run in the file as numbers."""
        return {k: v if k in ("run", "failed", "not_kept", "said", "build", "date") else float(v) for k, v in self.rows[arguments].items()}

    def told(self):
        """Returns a sentence on the time of the used runs; prints the number of runs of other builds."""
        rows = [self.rows[arguments] for arguments in self.asked]
        others = sum(row.get("build") != self.build for row in rows)
        if others:
            print(f"{others} of {len(rows)} runs are of another build; without their rows in {self.path} they are made anew")
        if not all("cpu_s" in row for row in rows):
            return ""
        spent = sum(float(row["cpu_s"]) for row in rows)
        return (f"The {len(rows)} runs together took "
                + (f"{spent / 3600:.1f} hours" if spent >= 5400 else f"{spent / 60:.2g} minutes") + " of CPU time.")

    def bound(self):
        """Limits the CPU time of a run, called in its process; a step that does not end is killed."""
        if self.seconds:
            resource.setrlimit(resource.RLIMIT_CPU, (int(self.seconds), int(1.5 * self.seconds)))

    def why(self, done):
        """Returns the error sentence of a run and the time in it."""
        if done.returncode == -signal.SIGKILL and self.seconds:
            return {"failed": f"more than {1.5 * self.seconds:g} s of CPU time, killed"}
        if "interrupted by SIGXCPU" in done.stderr:
            return {"failed": f"more than {self.seconds:g} s of CPU time"}
        sentence = [line[6:] for line in done.stderr.splitlines() if line.startswith("isph: ")]
        sentence += [f"status {done.returncode}, {line}" for line in done.stderr.splitlines() if re.search("[a-z]", line)]
        row = {"failed": sentence[0] if sentence else f"status {done.returncode}"}
        time_named = re.match(r"step \d+ \(t = ([^)]+)\)", row["failed"])
        if time_named:
            row["failed_t"] = time_named.group(1)
        return row

    def make(self, arguments, watch=""):
        with tempfile.TemporaryDirectory() as folder:
            path, probes = os.path.join(folder, "run.csv"), os.path.join(folder, "probe")
            words = [*shlex.split(arguments), *own_forms(self.isph, arguments), *shlex.split(watch), *(["-probe_output", probes] if watch else [])]
            before = cpu_seconds()
            done = subprocess.run([*self.launch, *words, "-report", path], preexec_fn=self.bound,
                                  capture_output=True, text=True, check=False)
            row = {"run": arguments, "build": self.build, "cpu_s": f"{cpu_seconds() - before:.4g}",
                   "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat()}
            if done.returncode:
                row.update(self.why(done))
            told = re.findall(r"^(\w+) not kept:", done.stdout, re.MULTILINE)
            if told:
                row["not_kept"] = " ".join(told)
            said = [found.group(1) or found.group(2) for found in re.finditer(WARNING, done.stdout, re.MULTILINE)]
            if said:
                row["said"] = " ".join(said)
            lines = []
            if os.path.exists(path):
                with open(path, newline="") as file:
                    lines = list(csv.DictReader(file))
            if not lines:
                return row
            for line in lines:
                if not line["quantity"]:  # row of a failed run
                    continue
                when = "" if line["t"] == lines[-1]["t"] else f"@{float(line['t']):.4g}"
                row[line["quantity"] + when] = line["value"]
                if line["reference"]:
                    row[f"{line['quantity']}_reference{when}"] = line["reference"]
            for file in sorted(glob.glob(f"{probes}_*.csv")):
                row.update(last_rows(file, float(lines[-1]["t"])))
            row.update({name: lines[-1][name] for name in ("t", "wall_s", "particles", "steps", "visc_its")})
            return row

    def save(self):
        names = ["run", "failed"]
        for row in self.rows.values():
            names += [name for name in row if name not in names]
        with open(self.path + ".new", "w", newline="") as file:
            writer = csv.DictWriter(file, names, lineterminator="\n")
            writer.writeheader()
            writer.writerows(self.rows.values())
        os.replace(self.path + ".new", self.path)
        self.unsaved = 0


def instructions(isph, arguments, numbers, folder):
    """Returns the instructions of a particle and step by valgrind, from runs of two numbers of steps; a sentence if one fails."""
    counts, steps = [], []
    for number in numbers:
        path = os.path.join(folder, f"{number}.csv")
        done = subprocess.run(["valgrind", "--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null", isph,
                               *shlex.split(arguments), "-max_steps", str(number), "-progress", "none", "-report", path],
                              capture_output=True, text=True, check=False)
        told = re.search(r"I\s+refs:\s+([\d,]+)", done.stderr)
        if done.returncode or not told:
            return f"valgrind: {(done.stderr.strip().splitlines() or [''])[-1]}"
        counts.append(int(told.group(1).replace(",", "")))
        with open(path, newline="") as file:
            row = list(csv.DictReader(file))[-1]
        os.remove(path)
        steps.append(int(row["steps"]))
    return (counts[1] - counts[0]) / (steps[1] - steps[0]) / int(row["particles"])


def last_rows(path, end):
    """Returns the quantities in the last rows of a -probe_ file."""
    kind = re.search(r"_(\w+)\.csv$", os.path.basename(path)).group(1)
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if abs(float(row["t"]) - end) <= 1e-9 * abs(end)]
    found = {}
    for row in rows:
        which = list(row)[2]  # the column after time and step: number of a point or name of a wall
        for name in [name for name in ("u", "v", "p", "fx", "fy", "tz", "flux") if row.get(name)]:
            found[f"{kind}_{row[which]}_{name}"] = row[name]
    return found


def reference_rows(name):
    """Returns the rows of a file of cases/reference, whose lines with # are comments, as dictionaries."""
    with open(os.path.join(ROOT, "cases", "reference", name), newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def redirect():
    """Runs the program by Debian's Python if that can draw and this one cannot."""
    debian, modules = "/usr/bin/python3", "/usr/lib/python3/dist-packages"
    if not importlib.util.find_spec("matplotlib") and modules not in sys.path and os.path.isdir(f"{modules}/matplotlib"):
        os.execv(debian, [debian, *sys.argv])


def need(*modules):
    """Ends the program with a line of error if a module is missing."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing:
        sys.exit(f"{os.path.basename(sys.argv[0])}: {sys.executable} has no {', '.join(missing)}: install Debian's "
                 f"{', '.join('python3-' + name for name in missing)} and use /usr/bin/python3")


def front(points):
    """Returns the Pareto front by time; points begin with time and error."""
    best, kept = float("inf"), []
    for point in sorted(points, key=lambda point: point[:2]):
        if point[1] < best:
            best = point[1]
            kept.append(point)
    return kept


def table(head, rows):
    """Yields lines of a Markdown table."""
    yield "| " + " | ".join(head) + " |"
    yield "|" + " --- |" * len(head)
    for row in rows:
        yield "| " + " | ".join(str(cell) for cell in row) + " |"


def write(path, lines, run=None):
    """Writes a page, with the time of all its runs at its end."""
    with open(path, "w") as file:
        file.writelines(line + "\n" for line in lines)
        told = run.told() if run else ""
        if told:
            file.write(f"\n{told}\n")
