"""agree.py TOLERANCE QUANTITY[,QUANTITY...] COMMAND_A... --and COMMAND_B... [--and COMMAND_C...]

Runs all commands with -report in separate directories: first A in a/, then B in b/ and so on, so that B may read
../a/. Passes if the last values of every quantity agree with those of A: |a - b| <= TOLERANCE max(|a|, |b|).
"""

import csv
import math
import os
import string
import subprocess
import sys


def run(name, command):
    """Runs a command and returns the last value of every quantity in its report."""
    os.makedirs(name)
    print(f"{name}: {' '.join(command)}", flush=True)
    done = subprocess.run(command + ["-report", "report.csv"], cwd=name, text=True,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if done.returncode != 0:
        sys.exit(f"{done.stdout}\n{name}: exit status {done.returncode}")
    with open(os.path.join(name, "report.csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        if row["status"] != "ok":
            sys.exit(f"{done.stdout}\n{name}: status {row['status']}")
    return {row["quantity"]: float(row["value"]) for row in rows if row["value"]}


def compare(tolerance, quantities, name, a, b):
    """Prints the quantities of run A and of another run; returns True if they agree."""
    agree = True
    print(f"{'quantity':20} {'a':>22} {name:>22} {'relative':>10}   tolerance {tolerance:g}")
    for quantity in quantities:
        if quantity not in a or quantity not in b:
            agree = False
            print(f"{quantity:20} not reported; there are {', '.join(sorted(a.keys() & b.keys()))}")
            continue
        va, vb = a[quantity], b[quantity]
        size = max(abs(va), abs(vb))
        relative = abs(va - vb) / size if size > 0 else abs(va - vb)
        good = math.isfinite(relative) and relative <= tolerance
        agree = agree and good
        verdict = "ok" if good else "DIFFERS"
        print(f"{quantity:20} {va:22.14e} {vb:22.14e} {relative:10.2e}   {verdict}")
    return agree


def main():
    tolerance, quantities = float(sys.argv[1]), sys.argv[2].split(",")
    commands = [[]]
    for word in sys.argv[3:]:
        if word == "--and":
            commands.append([])
        else:
            commands[-1].append(word)
    first = run("a", commands[0])
    verdicts = [compare(tolerance, quantities, name, first, run(name, command))
                for name, command in zip(string.ascii_lowercase[1:], commands[1:])]
    sys.exit(0 if len(verdicts) == len(commands) - 1 and all(verdicts) else 1)


main()
