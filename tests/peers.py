"""Makes tiny runs of isph for studies/peers and studies/peers_free, and checks their pages.

    peers.py FOLDER ISPH     FOLDER has the programs of both studies"""
import os
import subprocess
import sys

from interpreter import python_with

python_with("numpy, matplotlib")
folder, isph = sys.argv[1:]


def rows_of(study, only, beginning):
    """Makes the runs of a study that hold a word; returns the rows of its page that begin with these cells."""
    words = ["--isph", isph, "--out", "runs", "--only", only]
    done = subprocess.run([sys.executable, os.path.join(folder, study), *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with open(f"runs/{study}.md") as file:
        found = [line.strip("| \n").split(" | ") for line in file if line.startswith(beginning)]
    assert found, f"{study}: no row {beginning}"
    return found


# Twice the errors of docs/developers/results: 1.6 % of the vortices; 0.39 % of the channel; of the drop 2.4 %, and 1.1 % of its rate.
for row in rows_of("peers", "isph -case taylor_green -reynolds 100 -t_end 1 -n 16 ", "| isph, moving"):
    assert 0 < float(row[7].removesuffix(" %")) < 3, f"Taylor-Green vortices: {row}"
for row in (row for row in rows_of("peers", "-n 10 -motion eulerian", "| isph, fixed") if row[2] == "10"):
    assert 0 < float(row[7].removesuffix(" %")) < 0.8, f"channel from rest: {row}"
for row in rows_of("peers_free", "-n 8 -dt 1e-2", "| isph, "):
    error, rate = (float(cell.removesuffix(" %")) for cell in row[7:9])
    assert 0 < error < 5 and abs(rate) < 2, f"mode 2 of a drop: {row}"
