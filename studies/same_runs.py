"""The runs of same.list: their words, and runs of a program in a folder."""
import os
import re
import shlex
import string
import subprocess
import tempfile
from typing import NamedTuple

STUDIES = os.path.dirname(os.path.realpath(__file__))
ROOT = os.path.dirname(STUDIES)
LIST = os.path.join(STUDIES, "same.list")
TIMEOUT = 300  # longest run [s]
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
               "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


class Command(NamedTuple):
    """A run: ranks, arguments, and whether its text on stdout stands for its files."""

    ranks: int
    stdout: bool
    words: list


class Line(NamedTuple):
    """A line of the list; the tolerance is None where the list has none."""

    label: str
    tolerance: float
    commands: list


def read_list(path=LIST):
    """Yields the lines of the list."""
    names = {}
    with open(path) as file:
        for line in file:
            line = line.strip()
            if not line or line.startswith("#"):
                continue
            definition = re.match(r"(\w+) = (.*)", line)
            if definition:
                names[definition[1]] = string.Template(definition[2]).substitute(names)
                continue
            label, *commands = re.split(r"\s+\|\s+", string.Template(line).substitute(names))
            tolerance = re.match(r"tol=(\S+) ", commands[0])
            commands[0] = commands[0][tolerance.end():] if tolerance else commands[0]
            yield Line(label, tolerance and float(tolerance[1]), [read_command(command) for command in commands])


def read_command(text):
    """Returns a command, with full paths for files of the source tree."""
    words = shlex.split(text)
    ranks, stdout = 1, False
    while words and (words[0] == "stdout" or words[0].startswith("np=")):
        word = words.pop(0)
        ranks, stdout = (ranks, True) if word == "stdout" else (int(word[3:]), stdout)
    return Command(ranks, stdout, [re.sub(r"^(file,)?(?=(options|tests)/)", rf"\1{ROOT}/", w) for w in words])


def launched(isph, ranks):
    """Returns the words that start a program on some ranks."""
    return ["mpiexec", "--oversubscribe", "-n", str(ranks), isph] if ranks > 1 else [isph]


def file_words(command, k):
    """Returns the options that give run k of a line its files, but those that the list gives."""
    if command.stdout:
        return []
    pairs = [("-report", f"report{k}.csv"), ("-output", f"flow{k}.h5"), ("-progress", "none")]
    patch = "options/patch.opts" in " ".join(command.words)
    return [word for pair in pairs[:1 if patch else 3] if pair[0] not in command.words for word in pair]


def run(isph, commands, folder, **variables):
    """Makes the runs of a line in a folder; returns status and error sentences of each. Open MPI removes its directory
    with the last of its processes, so that other runs that start then would fail: each line has its own directory."""
    with tempfile.TemporaryDirectory() as mpi:
        return run_all(isph, commands, folder, {**ENVIRONMENT, **variables, "OMPI_MCA_orte_tmpdir_base": mpi})


def run_all(isph, commands, folder, environment):
    """Makes the runs of a line, as run()."""
    ends = []
    for k, command in enumerate(commands, 1):
        try:
            done = subprocess.run([*launched(isph, command.ranks), *command.words, *file_words(command, k)], cwd=folder,
                                  env=environment, text=True, stdin=subprocess.DEVNULL, capture_output=True,
                                  timeout=TIMEOUT, check=False)
        except subprocess.TimeoutExpired:
            ends.append((f"more than {TIMEOUT} s", []))
            continue
        lines = [line for line in done.stderr.replace(folder, ".").splitlines() if line.strip()]
        said = [line for line in lines if line.startswith("isph")]
        ends.append((done.returncode, said or lines[:3] if done.returncode else said))  # lines of MPI, if isph has none
        if command.stdout:
            with open(os.path.join(folder, f"stdout{k}.txt"), "w") as file:
                file.write(done.stdout)
    return ends


def expected(line, ends):
    """Returns true if each run of a line ends as its label says; checkpoints for refused restarts may be written."""
    fails = "refused" in line.label or "fails" in line.label
    return all((status != 0) == fails for (status, _), command in zip(ends, line.commands)
               if not (fails and "-checkpoint" in command.words and status == 0))
