"""Runs of a scene for isph-study: each in a folder of its own, made once, and kept as a record when it has ended."""
import csv
import fcntl
import glob
import hashlib
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time

from runs import build_of

SAID = r"not \w+:|\w+ not kept:|\w+ [^,]+, should be at most"  # warnings in the report of a run
READ = ("-options_file", "-particles", "-restart", "-library")  # options that name files to read
WRITTEN = {"-report": "report.csv", "-output": "flow.h5", "-checkpoint": "checkpoint.h5", "-probe_output": "probe"}
EITHER = {"-viscosity": "-reynolds", "-reynolds": "-viscosity"}  # a varied option replaces the other one
PSEUDO = ("-ranks", "-isph", "-start")  # settings of a run that are no options of isph
START_STEP = 1e-5  # of the jitter from start to start [dx]
JITTER_MOST = 0.5  # the range of -jitter [dx]
NO_SHARED_LOCKS = {"OMPI_MCA_sharedfp": "^sm"}  # which Open MPI names after files without their folders
PATIENCE = 10.0  # between the signals that ask a run to end and that kill it [s]
GOOD = ("holds", "doubtful")  # runs that reach their end


class UserError(Exception):
    """An error that the user can mend, in one line."""


def is_option(word):
    return re.match(r"-[A-Za-z]", word) is not None


def last(words, name):
    """Returns the last value of an option in a list of words, None without it; names have no case."""
    found = [after for word, after in zip(words, words[1:]) if word.lower() == name]
    return found[-1] if found else None


def without(words, names):
    """Returns the words without options of these names and their values."""
    kept, own = [], False
    for word in words:
        if is_option(word):
            own = word.lower() in names
        if not own:
            kept.append(word)
    return kept


def split(text, option):
    """Splits a text into words as a shell does."""
    try:
        return shlex.split(text)
    except ValueError as error:
        raise UserError(f"{option} {text}: {error}") from None


def file_words(path):
    """Returns the words of an options file."""
    try:
        with open(path) as file:
            return shlex.split(file.read(), comments=True)
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def absolute(words):
    """Returns words in which files to be read have absolute paths."""
    return [os.path.abspath(word) if before.lower() in READ else word for before, word in zip(["", *words], words)]


class Scene:
    """The command of isph that a study repeats. `words` name files by absolute paths, because runs have other folders;
    `known` holds the words of its options files too."""

    def __init__(self, words):
        self.typed = shlex.join(words)
        self.words, self.known = absolute(words), []
        for name, path in zip(words, words[1:]):
            if name.lower() == "-options_file":
                self.known += file_words(path)
        named = [(name, path) for name in READ if (path := last(self.known, name)) and not last(words, name)]
        self.words += absolute([word for pair in named for word in pair])
        self.known += self.words

    def base(self, extra):
        """Returns the words of the scene that `extra` follows, without an option that it replaces."""
        replaced = [EITHER[word.lower()] for word in extra if word.lower() in EITHER]
        if not any(last(self.known, name) for name in replaced):
            return self.words
        return without(self.known, ["-options_file", *replaced])

    def texts(self):
        """Returns what decides the flow besides the words: contents of options files, sizes and times of others."""
        for name, path in zip(self.words, self.words[1:]):
            if name.lower() in READ[:2]:
                with open(path, errors="replace") as file:
                    yield file.read()
            elif name.lower() in READ and os.path.exists(path):
                yield f"{os.path.getsize(path)} {os.path.getmtime(path)}"


class Run:
    """A run of a scene with more words. `record` holds how it ended: kind (holds, doubtful, fails, refused, late), reason,
    t, step, what it said, and the numbers of its report and probes at the end; at earlier times they are name@time."""

    def __init__(self, scene, extra, isph, out, more=()):
        self.extra, start = absolute(without(extra, PSEUDO)), last(extra, "-start")
        if start:
            self.extra += start_words([*scene.known, *self.extra], whole(start, "start"))
        self.ranks, self.label = whole(last(extra, "-ranks") or "1", "ranks"), shlex.join(extra) or "as typed"
        self.isph = os.path.abspath(last(extra, "-isph") or isph)
        words = [*scene.base(self.extra), *more, *self.extra]
        outputs = {name: file for name, file in WRITTEN.items()
                   if name == "-report" or last([*scene.known, *more, *self.extra], name)}
        self.words = [*words, *(word for pair in outputs.items() for word in pair)]
        key = "\n".join([*self.words, str(self.ranks), build(self.isph), *scene.texts()])
        slug = re.sub(r"[^A-Za-z0-9.]+", "_", self.label).strip("_")[:60]
        self.folder = os.path.join(out, "runs", f"{slug}_{hashlib.sha256(key.encode()).hexdigest()[:8]}")
        self.record = None

    def load(self, seconds):
        """Returns true if the folder holds the record of a run that ended; one that took too long may get more time."""
        try:
            with open(os.path.join(self.folder, "record.json")) as file:
                record = json.load(file)
        except (OSError, ValueError):
            return False
        if not isinstance(record, dict) or not {"kind", "numbers", "cpu_s"} <= record.keys():
            return False
        if record["kind"] == "late" and (seconds is None or seconds > record["seconds"]):
            return False
        self.record = record
        return True

    def begin(self):
        """Starts the run in an empty folder, as the first of a group of processes."""
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)
        launch = ["mpiexec", "--oversubscribe", "--bind-to", "none", "-n", str(self.ranks)] if self.ranks > 1 else []
        command = [*launch, self.isph, *self.words, "-progress", "none"]
        with open(os.path.join(self.folder, "command"), "w") as file:
            file.write(shlex.join(command) + "\n")
        with open(os.path.join(self.folder, "stdout"), "w") as out, open(os.path.join(self.folder, "stderr"), "w") as err:
            self.began, self.asked = time.monotonic(), None
            self.process = subprocess.Popen(command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err,
                                            start_new_session=True, env={**NO_SHARED_LOCKS, **os.environ})

    def signal(self, number):
        try:
            os.killpg(self.process.pid, number)
        except ProcessLookupError:
            pass

    def alive(self):
        """Returns true until the process has ended, of a run that is given up."""
        try:
            return os.wait4(self.process.pid, os.WNOHANG)[0] == 0
        except ChildProcessError:
            return False
        finally:
            self.process.returncode = self.process.returncode or 0

    def ended(self, seconds):
        """Returns true if the run has ended, and makes its record. After `seconds` it is asked to end, then killed."""
        pid, status, used = os.wait4(self.process.pid, os.WNOHANG)
        if not pid:
            now = time.monotonic()
            if self.asked is None and seconds is not None and now - self.began > seconds:
                self.asked = now
                self.signal(signal.SIGTERM)
            elif self.asked is not None and now - self.asked > PATIENCE:
                self.signal(signal.SIGKILL)
            return False
        self.process.returncode = os.waitstatus_to_exitcode(status)
        self.keep({"cpu_s": used.ru_utime + used.ru_stime, "rss_mb": used.ru_maxrss / 1024}, seconds)
        return True

    def keep(self, cost, seconds):
        """Writes the record of the ended run; one that a signal of another program ended has none, and is made again."""
        with open(os.path.join(self.folder, "stdout"), errors="replace") as out, \
                open(os.path.join(self.folder, "stderr"), errors="replace") as err:
            printed, errors = out.read(), err.read().splitlines()
        columns, numbers, references, relative = read_report(os.path.join(self.folder, "report.csv"))
        if "t" in columns:
            for path in sorted(glob.glob(os.path.join(self.folder, "probe_*.csv"))):
                for name, value in last_rows(path).items():
                    numbers.setdefault(name, value)
        said = [line for line in printed.splitlines() if re.match(SAID, line)]
        record = {"label": self.label, "said": said, "numbers": numbers, "references": references, "errors": relative,
                  **cost, **columns}
        code, doubts = self.process.returncode, [numbers.get(name) == 0.0 for name in ("resolved", "trust")]
        record["kind"] = "doubtful" if said or any(doubts) else "holds"
        if code:
            sentences = [line[6:] for line in errors if line.startswith("isph: ")]
            sentences += [line for line in errors if re.search("[a-z]", line)]
            record["reason"] = sentences[0] if sentences else f"ended by signal {-code}" if code < 0 else f"exit status {code}"
            where = re.match(r"step (\d+) \(t = ([^)]+)\)", record["reason"])
            if where:
                record.update(step=int(where[1]), t=float(where[2]))
            record["kind"] = "fails" if where or columns else "refused"
        if self.asked is not None:
            record.update(kind="late", seconds=seconds, reason=f"took more than {seconds:g} s")
        elif code < 0 or code > 128 and "interrupted by SIG" in record.get("reason", ""):
            raise UserError(f"a signal of another program ended a run ({self.label}); the same command continues")
        path = os.path.join(self.folder, "record.json")
        with open(path + ".new", "w") as file:
            json.dump(record, file, indent=1)
        os.replace(path + ".new", path)
        self.record = record


def whole(text, what):
    """Returns a whole number above 0."""
    if not re.fullmatch("[1-9][0-9]{0,5}", text):
        raise UserError(f"{what} {text}: a whole number above 0 is required")
    return int(text)


def start_words(known, k):
    """Returns the words of start k: a jitter that differs by less than 1e-3 dx, another draw of a chaotic flow."""
    typed = last(known, "-jitter") or "0"
    try:
        jitter = float(typed)
    except ValueError:
        raise UserError(f"-jitter {typed}: a number is required") from None
    return ["-jitter", f"{jitter + (START_STEP if jitter < JITTER_MOST / 2 else -START_STEP) * k:.12g}"]


BUILDS = {}


def build(isph):
    """Returns eight characters that tell builds apart."""
    if isph not in BUILDS:
        try:
            BUILDS[isph] = build_of(isph)
        except OSError as error:
            raise UserError(f"--isph {isph}: {error.strerror}") from None
        if not os.access(isph, os.X_OK):
            raise UserError(f"--isph {isph}: is no program")
    return BUILDS[isph]


def real(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return None


def read_report(path):
    """Returns columns of the run, and numbers, references and relative errors by name, of the rows of a run."""
    if not os.path.exists(path):
        return {}, {}, {}, {}
    with open(path, newline="", errors="replace") as file:
        rows = [row for row in csv.DictReader(file) if None not in row.values()]
    if not rows:
        return {}, {}, {}, {}
    found = {"value": {}, "reference": {}, "error": {}}
    for row in rows:
        name = row["quantity"] + ("" if row["t"] == rows[-1]["t"] else f"@{float(row['t']):.4g}")
        for kind, numbers in found.items():
            if row["quantity"] and real(row[kind]) is not None:
                numbers[name] = float(row[kind])
    wanted = ("t", "steps", "n", "particles", "wall_s", "cpu_s", "rss_mb", "visc_its", "ppe_its")
    columns = {name: value for name in wanted if (value := real(rows[-1].get(name))) is not None}
    return columns, found["value"], found["reference"], found["error"]


def last_rows(path):
    """Returns the numbers in the last rows of a file of probes: body_1_fx, point_0_u, flux_0_flux, line_0_3_p."""
    kind = re.search(r"probe_(\w+)\.csv$", path).group(1)
    with open(path, newline="", errors="replace") as file:
        rows = [row for row in csv.DictReader(file) if None not in row.values()]
    found, rows = {}, [row for row in rows if row["t"] == rows[-1]["t"]]
    if not rows:
        return found
    names = list(rows[0])[2:]
    labelled = real(rows[0][names[0]]) is None or float(rows[0][names[0]]).is_integer() and len(names) > 1
    for k, row in enumerate(rows):
        which = row[names[0]] if labelled else ""
        base = which if real(which) is None and which else f"{kind}_{which}" if which else kind
        if kind == "line":
            base += f"_{sum(other[names[0]] == which for other in rows[:k])}"
        for name in names[1 if labelled else 0:]:
            if name not in "xyz" and real(row[name]) is not None:
                found[f"{base}_{name}"] = float(row[name])
    return found


def make(runs, options, after=lambda: None):
    """Makes the runs that have no record, --jobs at a time; calls `after` when one has ended."""
    waiting = [run for run in dict.fromkeys(runs) if not run.load(options.timeout)]
    whole, made, going = len(waiting), 0, []
    try:
        while waiting or going:
            while waiting and len(going) < options.jobs:
                waiting[0].begin()
                going.append(waiting.pop(0))
            for run in [run for run in going if run.ended(options.timeout)]:
                going.remove(run)
                made += 1
                told = run.record.get("reason", f"{run.record['cpu_s']:.3g} s")
                print(f"[{made}/{whole}] {run.label}: {told}", file=sys.stderr, flush=True)
                after()
            time.sleep(0.01)
    finally:
        for run in going:
            run.signal(signal.SIGTERM)
        end = time.monotonic() + PATIENCE
        while any(run.alive() for run in going):
            if time.monotonic() > end:
                for run in going:
                    run.signal(signal.SIGKILL)
            time.sleep(0.01)


def claim(out):
    """Creates the folder of a study and keeps other studies out of it; returns the file that holds the lock."""
    try:
        os.makedirs(os.path.join(out, "runs"), exist_ok=True)
        lock = open(os.path.join(out, ".lock"), "w")
    except OSError as error:
        raise UserError(f"--out {out}: {error.strerror}") from None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise UserError(f"--out {out}: another study is at work there") from None
    return lock


def write_rows(path, rows):
    """Writes dictionaries as a CSV file, complete or not at all."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    with open(path + ".new", "w", newline="") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    os.replace(path + ".new", path)


def say(path, lines):
    """Prints lines, and writes them to a file."""
    text = "\n".join(lines) + "\n"
    with open(path + ".new", "w") as file:
        file.write(text)
    os.replace(path + ".new", path)
    print(text, end="")


def pyplot():
    """Returns matplotlib's pyplot for files, None without matplotlib, which is told."""
    try:
        import matplotlib
    except ImportError:
        print(f"no picture: {sys.executable} has no matplotlib (Debian: python3-matplotlib)")
        return None
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    return plt
