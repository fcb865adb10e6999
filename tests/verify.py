"""Runs studies/verify for a small case in a directory of its own, and checks its page, its table and the index. A
second call must find that all runs have been made.

    verify.py VERIFY ISPH"""
import csv
import importlib.util
import subprocess
import sys

verify, isph = sys.argv[1:]
picture = [] if importlib.util.find_spec("matplotlib") else ["--rows"]
command = [sys.executable, verify, "poiseuille", "--isph", isph, "--out", "pages", "--n", "8,16", *picture]


def call():
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"studies/verify ended with status {done.returncode}: {done.stderr}")
    return done.stdout.splitlines()


runs = call()
with open("pages/poiseuille.csv", newline="") as file:
    rows = list(csv.DictReader(file))
assert [row["run"] for row in rows] == runs and len(runs) > 1, f"runs made: {runs}, in the file: {rows}"
assert all(not row["failed"] and row["build"] and row["date"] for row in rows), f"failed or unsigned: {rows}"
with open("pages/details/poiseuille.md") as file:
    page = file.read()
first = page[page.index("<!-- studies/verify begins -->"):].split("\n### ")[1].splitlines()
line = next(line for line in first if line.startswith("| profile")).split("|")
coarse, fine, order = (float(cell.strip(" %")) for cell in line[3:6])
# The flow starts from rest, with steps proportional to dx: second order, to within a quarter on these coarse lattices.
assert coarse > fine > 0 and 1.75 < order < 2.25, line
with open("pages/poiseuille.md") as file:
    assert f"| 16 | {line[4].strip()} ({order}) |" in file.read(), "the page lacks the finest error"
with open("pages/README.md") as file:
    assert "(poiseuille.md)" in file.read(), "the index lacks the case"
if not picture:
    with open("pages/poiseuille.png", "rb") as file:
        assert file.read(8) == b"\x89PNG\r\n\x1a\n", "no picture"
assert call() == [], "runs that are in the file were made again"
