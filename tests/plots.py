#!/usr/bin/env python3
"""Draws every kind of picture of studies/plot from a short run, and checks the messages for unsuitable files.

    plots.py PLOT COMMAND...         PLOT is the script; COMMAND starts the program, on some ranks

Exits with status 77 if no Python can draw."""
import glob
import subprocess
import sys

PLOT, *COMMAND = sys.argv[1:]


def drawing_python():
    """Returns the first Python that can draw, which need not be the Python of the tests."""
    for python in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([python, "-c", "import h5py, matplotlib"], capture_output=True, check=False).returncode == 0:
            return python
    print("no Python has h5py and matplotlib")
    sys.exit(77)


def main():
    plot = [drawing_python(), PLOT]
    for n in "10", "14":
        subprocess.run([*COMMAND, "-case", "cavity", "-reynolds", "100", "-n", n, "-t_end", "0.3", "-progress", "none",
                        "-output", "run.h5", "-output_every", "0.1", "-report", "run.csv"],
                       check=True, stdout=subprocess.DEVNULL)
    snapshots = sorted(glob.glob("run_*.h5"))
    assert len(snapshots) == 4, snapshots
    for kind, files, options, start in (("field", snapshots, [], b"\x89PNG"), ("profiles", snapshots, [], b"\x89PNG"),
                                        ("cavity", snapshots, [], b"\x89PNG"), ("animate", snapshots, [], b"GIF8"),
                                        ("cost", ["run.csv"], ["--quantity", "kinetic_energy", "--group", "motion"],
                                         b"\x89PNG")):
        picture = kind + (".gif" if start == b"GIF8" else ".png")
        subprocess.run([*plot, kind, *files, *options, "-o", picture], check=True)
        with open(picture, "rb") as file:
            data = file.read()
        assert data.startswith(start) and len(data) > 5000, picture

    for arguments, told in ((["cost", "run.csv", "--quantity", "wrong"], "wrong has no error"),
                            (["cost", "run.csv", "--group", "wrong"], "wrong is no column"),
                            (["cost", snapshots[0]], "is no file of -report"),
                            (["animate", "run.csv"], "is not a readable snapshot"),
                            (["field", "absent.h5"], "is not a readable snapshot")):
        done = subprocess.run([*plot, *arguments, "-o", "none.gif"], capture_output=True, text=True, check=False)
        assert done.returncode == 1 and done.stderr.count("\n") == 1 and told in done.stderr, done.stderr


main()
