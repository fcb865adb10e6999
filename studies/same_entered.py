"""The functions of the program that the runs of same.list enter, counted by gcov."""
import collections
import glob
import json
import os
import re
import subprocess
import sys
import tempfile

from runs import cpu_seconds
from same_runs import STUDIES, expected, read_list, run

TABLE = os.path.join(STUDIES, "same.entered")
FOLDERS = ("src", "include", "cases")
HEADER = """\
# Source files without their folders, the first line of same.list that enters most of their functions, and the number of
# functions that the list enters, of all. tests/entered.py asks for a row of each file.
# Written by: studies/same --entered BUILD, a build tree with -DISPH_COVERAGE=ON.
"""


def source_of(build):
    """Returns the source tree of a build tree."""
    try:
        with open(os.path.join(build, "CMakeCache.txt")) as file:
            cache = file.read()
    except OSError:
        sys.exit(f"same: {build} is no build tree of CMake")
    if not re.search(r"^ISPH_COVERAGE:BOOL=(ON|1|TRUE|YES)$", cache, re.M):
        sys.exit(f"same: {build} counts no functions; build it with cmake -DISPH_COVERAGE=ON")
    return re.search(r"^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", cache, re.M)[1]


def counted(files, source, folder):
    """Returns {(file, function): entered} from files of counts, or of notes for a program that has not run. Clones of a
    function for kinds of processors are one function."""
    found = collections.defaultdict(bool)
    for start in range(0, len(files), 100):
        text = subprocess.run(["gcov", "--json-format", "--stdout", *files[start:start + 100]], cwd=folder, check=True,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
        for unit in filter(None, text.splitlines()):
            for file in json.loads(unit)["files"]:
                name = os.path.relpath(file["file"], source)
                if name.split(os.sep)[0] in FOLDERS:
                    for function in file["functions"]:
                        found[name, function["name"].split(".")[0]] |= function["execution_count"] > 0
    return found


def notes_of(build):
    """Returns the files in which the compiler has noted the functions of a build tree."""
    found = [os.path.abspath(path) for path in glob.glob(os.path.join(build, "CMakeFiles", "isph*.dir", "**", "*.gcno"),
                                                         recursive=True)]
    return found or sys.exit(f"same: {build} is not built")


def entered_by(line, build, source):
    """Makes the runs of a line; returns the functions that they enter, CPU time, and true if they end as expected."""
    with tempfile.TemporaryDirectory() as folder:
        counts, runs = (os.path.join(folder, name) for name in ("counts", "runs"))
        os.mkdir(runs)
        before = cpu_seconds()
        ends = run(os.path.join(build, "isph"), line.commands, runs, GCOV_PREFIX=counts)
        used = cpu_seconds() - before
        files = glob.glob(os.path.join(counts, "**", "*.gcda"), recursive=True)
        for path in files:
            note = path[:-5] + ".gcno"
            os.symlink(note[len(counts):], note)
        found = counted(files, source, folder)
    return {function for function, entered in found.items() if entered}, used, expected(line, ends)


def table_rows(functions, by_line):
    """Returns (file, label, entered, functions) of each file; the label is of the first line that enters most of it."""
    files = collections.defaultdict(set)
    for name, function in functions:
        files[name].add((name, function))
    everything = set().union(*by_line.values())
    result = []
    for name, inside in files.items():
        label = max(by_line, key=lambda label: len(by_line[label] & inside))  # the first of equals
        result.append((name, label if by_line[label] & inside else "-", len(everything & inside), len(inside)))
    return sorted(result, key=lambda row: (os.path.basename(row[0]), row))


def write_table(rows):
    """Writes the rows of source files, which are named without their folders: they may move."""
    with open(TABLE, "w") as file:
        file.write(HEADER)
        for name, label, some, every in rows:
            if name.endswith(".c"):
                file.write(f"{os.path.basename(name)} | {label} | {some}/{every}\n")


def entered(build, only):
    """Runs all lines once, prints what they enter, and writes the table; returns the number of lines that failed."""
    build = os.path.abspath(build)
    source = source_of(build)
    functions = counted(notes_of(build), source, build)
    by_line, seen, seconds, failed = {}, set(), 0.0, 0
    print(f"{'run':32} {'CPU s':>6} {'entered':>7} {'new':>5}")
    for line in read_list():
        if not re.search(only, line.label):
            continue
        found, used, right = entered_by(line, build, source)
        print(f"{line.label:32} {used:6.2f} {len(found):7} {len(found - seen):5}{'' if right else '  ends otherwise'}",
              flush=True)
        by_line[line.label] = found
        seen |= found
        seconds += used
        failed += not right
    if not by_line:
        sys.exit(f"same: no label matches {only}")
    rows = table_rows(functions, by_line)
    print("\nNot entered:")
    for name, function in sorted(set(functions) - seen):
        print(f"  {name}: {function}")
    print("\nFiles, functions entered and functions:")
    for name, _, some, every in rows:
        print(f"  {name:32} {some:4} {every:4}")
    zero = [name for name, _, some, _ in rows if some == 0]
    print(f"\n{len(seen)} of {len(functions)} functions entered, {100 * len(seen) / len(functions):.1f} %; "
          f"files without: {', '.join(zero) or 'none'}; {seconds:.0f} s of CPU; {failed} lines end otherwise")
    if not only:
        write_table(rows)
    return failed
