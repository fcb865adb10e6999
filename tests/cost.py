"""Makes a few tiny runs of studies/cost, and checks its page, and that a second call makes no run.

    cost.py COST ISPH"""
import csv
import subprocess
import sys

from interpreter import python_with

python_with("numpy, matplotlib, h5py")
cost, isph = sys.argv[1:]
ONLY = "taylor_green:moving default ,order:regularised,step:eulerian -n 16,step:eulerian -n 8"


def call():
    words = ["--isph", isph, "--quick", "--repeats", "2", "--out", "runs", "--only", ONLY]
    done = subprocess.run([sys.executable, cost, *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [line for line in done.stdout.splitlines() if line.startswith("isph ")]


def row_of(page, *words):
    """Returns the numbers of the row of a table that begins with these cells."""
    beginning = "| " + " | ".join(words) + " | "
    found = [line for line in page.splitlines() if line.startswith(beginning)]
    assert found, f"no row {beginning}"
    return found[0].removeprefix(beginning).strip("| ").split(" | ")


made = call()
assert any(line.endswith(" # 2") for line in made), "no run was repeated"
with open("runs/cost.csv", newline="") as file:
    rows = list(csv.DictReader(file))
assert all(row["build"] and row["date"] for row in rows), rows
assert not [row["run"] for row in rows if row["failed"]], rows
with open("runs/cost.md") as file:
    text = file.read()
_, error = row_of(text, "isph, moving", "default", "24")
assert 0 < float(error.removesuffix(" %")) < 2, f"Taylor-Green vortices: {error}"
assert float(row_of(text, "2D", "16", "fixed", "5 to 20", "")[2]) > 0, "no memory"
order = row_of(text, "Regularised cavity of Shih, Re = 1, t = 0.5", "velocity")[2]
assert 2 < float(order) < 6, f"order of quartic fits: {order}"
assert not call(), "runs that are in the folder were made again"
