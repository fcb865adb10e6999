#!/usr/bin/env python3
"""Draws every kind of picture of studies/plot from a short run, and checks the messages for unsuitable files; compares
the area that is drawn as fluid with the volume of the fluid.

    plots.py PLOT COMMAND...         PLOT is the script; COMMAND starts the program, on some ranks

Exits with status 77 if no Python can draw."""
import glob
import math
import os
import subprocess
import sys

from interpreter import python_with

PLOT, *COMMAND = sys.argv[1:]


SCENE = ["-case", "scene", "-viscosity", "0.5", "-max_steps", "1"]
BODIES = ["-scene_body_1", "circle,0.3,0.3,0.15", "-scene_body_2", "polygon,0.6,0.6,0.8,0.6,0.7,0.85"]
FILLED = ["-scene_box", "0,0,2,1.5", "-body_force", "0,-1"]
AREAS = (  # run, its area, its width on the floor; a pixel and the surface's polygon err
    ([*SCENE, *BODIES, "-n", "32"], 1 - math.pi * 0.15**2 - 0.025, 1),
    ([*SCENE, "-scene_box", "-1,-1,1,1", "-scene_body_1", "circle,0,0,0.9", "-scene_body_1_around", "-n", "16"],
     math.pi * 0.81, 0),
    ([*SCENE, *FILLED, "-scene_filled_1", "box,0,0,1,0.75", "-n", "16"], 0.75, 1),
    ([*SCENE, *FILLED, "-scene_filled_1", "circle,1,0.2,0.3", "-n", "24"],
     0.09 * (math.pi - math.acos(2 / 3)) + 0.2 * 0.05**0.5, 2 * 0.05**0.5),
    ([*SCENE, *FILLED, "-scene_filled_1", "circle,0.6,0.7,0.3", "-scene_filled_2", "circle,1.4,0.7,0.3", "-n", "20"],
     0.18 * math.pi, 0),
    ([*SCENE, "-scene_periodic", "x", "-scene_box", "0,0,1,1", "-scene_filled_1", "box,0,0,1,0.4", "-n", "16"], 0.4, 1),
)


def areas():
    """The area that is drawn is the volume of the fluid, beside walls, bodies and surfaces."""
    sys.path.insert(0, os.path.dirname(PLOT))
    from snapshot import Snapshot

    for run, area, foot in AREAS:
        subprocess.run([*COMMAND, *run, "-progress", "none", "-output", "a.h5"], check=True, stdout=subprocess.DEVNULL)
        snapshot = Snapshot("a_0001.h5")
        x, y, u, _ = snapshot.on_grid(snapshot.box)
        pixel, fluid = (x[1] - x[0], y[1] - y[0]), u.mask == 0
        assert abs(fluid.sum() * pixel[0] * pixel[1] / area - 1) < 0.01, (run, fluid.sum() * pixel[0] * pixel[1], area)
        assert abs(fluid[0].sum() * pixel[0] - foot) < 0.25 * snapshot.dx, (run, fluid[0].sum() * pixel[0], foot)


def main():
    python_with("h5py, matplotlib")
    areas()
    plot = [sys.executable, PLOT]
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
