#!/usr/bin/env python3
"""Draws every kind of picture of studies/plot from a short run, and checks the messages for unsuitable files; compares
the area that is drawn as fluid with the volume of the fluid.

    plots.py PLOT COMMAND...         PLOT is the script; COMMAND starts the program, on some ranks

Exits with status 77 if no Python can draw."""
import glob
import math
import os
import runpy
import subprocess
import sys

from interpreter import python_with

PLOT, *COMMAND = sys.argv[1:]


SCENE = ["-case", "scene", "-viscosity", "0.5", "-max_steps", "1"]
BODIES = ["-scene_body_1", "circle,0.3,0.3,0.15", "-scene_body_2", "polygon,0.6,0.6,0.8,0.6,0.7,0.85"]
FILLED = ["-scene_box", "0,0,2,1.5", "-body_force", "0,-1"]
AREAS = (  # run, its area, its width on the floor; a pixel and the surface's polygon err
    ([*SCENE, *BODIES, "-n", "32"], 1 - math.pi * 0.15**2 - 0.025, 1),
    ([*SCENE, "-scene_box", "-1,-1,1,1", "-scene_domain", "circle,0,0,0.9", "-n", "16"],
     math.pi * 0.81, 0),
    ([*SCENE, *FILLED, "-scene_filled_1", "box,0,0,1,0.75", "-n", "16"], 0.75, 1),
    ([*SCENE, *FILLED, "-scene_filled_1", "circle,1,0.2,0.3", "-n", "24"],
     0.09 * (math.pi - math.acos(2 / 3)) + 0.2 * 0.05**0.5, 2 * 0.05**0.5),
    ([*SCENE, *FILLED, "-scene_filled_1", "circle,0.6,0.7,0.3", "-scene_filled_2", "circle,1.4,0.7,0.3", "-n", "20"],
     0.18 * math.pi, 0),
    ([*SCENE, "-scene_periodic", "x", "-scene_box", "0,0,1,1", "-scene_filled_1", "box,0,0,1,0.4", "-n", "16"], 0.4, 1),
    ([*SCENE, "-scene_box", "0,0,0.12,0.1", "-length", "0.01", "-scene_body_1", "box,0.02,0,0.1,0.005 + box,0.02,0,0.025,0.05", "-n", "6"],
     0.011375, 0.04),
)


def areas():
    """The area that is drawn is the volume of the fluid, beside walls, bodies and surfaces; a level of 1/2 lacks some per cent of small circles."""
    sys.path.insert(0, os.path.dirname(PLOT))
    import numpy as np
    from snapshot import Snapshot

    for run, area, foot in AREAS:
        subprocess.run([*COMMAND, *run, "-progress", "none", "-output", "a.h5"], check=True, stdout=subprocess.DEVNULL)
        snapshot = Snapshot("a_0001.h5")
        for shape, numbers, *_ in snapshot.solids:  # corners of an outline are apart
            corners = numbers.reshape(-1, 2) if shape == "outline" else np.eye(2)
            assert np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).min() > 1e-3 * snapshot.dx, run
        x, y, u, _ = snapshot.on_grid(snapshot.box)
        pixel, fluid = (x[1] - x[0], y[1] - y[0]), u.mask == 0
        assert abs(fluid.sum() * pixel[0] * pixel[1] / area - 1) < 0.03, (run, fluid.sum() * pixel[0] * pixel[1], area)
        assert abs(fluid[0].sum() * pixel[0] - foot) < snapshot.dx, (run, fluid[0].sum() * pixel[0], foot)


SOLIDS = ("ball,-0.9,-0.6,0.6,0.2", "box,0.7,0.4,0.45,1.05,0.7,0.75", "cylinder,-0.9,0.6,0.15",
          "prism,0.7,-0.7,1.1,-0.7,0.9,-0.4", "revolved,0,0.4,0.2,0.4,0,0.7")


def space():
    """Surfaces of bodies lie where their wall particles are; a drop is drawn round, with light."""
    import h5py
    import numpy as np
    from balls import picture, solid_distance
    from snapshot import Snapshot

    bodies = [word for k, shape in enumerate(SOLIDS, 1) for word in (f"-scene_body_{k}", shape)]
    quiet = {"check": True, "stdout": subprocess.DEVNULL}
    subprocess.run([*COMMAND, *SCENE, *bodies, "-dim", "3", "-scene_box", "-1.5,-1.2,0,1.5,1.2,1.2", "-n", "10", "-motion",
                    "eulerian", "-output", "solid.h5", "-progress", "none"], **quiet)
    solids = Snapshot("solid_0001.h5").solids
    with h5py.File("solid_0001.h5") as file:
        for k, solid in enumerate(solids):
            wall = file["position"][:][file["boundary"][:] == 6 + k]
            assert len(wall) and abs(solid_distance([solid], wall)).max() < 1e-9, solid
    subprocess.run([*COMMAND, *SCENE, "-dim", "3", "-scene_filled_1", "ball,0.5,0.5,0.5,0.3", "-n", "10", "-output",
                    "space.h5", "-progress", "none"], **quiet)
    drop = Snapshot("space_0001.h5")
    image = picture(drop, np.tile([1.0, 0, 0], (len(drop.place), 1)), azimuth=0, elevation=0, pixels=200)
    red = image[..., 0] > image[..., 1] + 0.2
    radius = (red.sum() / np.pi) ** 0.5 * 1.04 / 200  # the box and a margin are 200 pixels wide
    assert abs(radius - 0.3) < 0.25 * drop.dx, radius
    assert np.quantile(image[red, 0], 0.95) > 1.5 * np.quantile(image[red, 0], 0.05)


def plot(*words):
    """Runs studies/plot in this process, which has loaded matplotlib; returns its message of error."""
    sys.argv = [PLOT, *words]
    try:
        runpy.run_path(PLOT, run_name="__main__")
    except SystemExit as error:
        return error.code


def main():
    python_with("h5py, matplotlib")
    areas()
    space()
    for n in "10", "14":
        subprocess.run([*COMMAND, "-case", "cavity", "-reynolds", "100", "-n", n, "-t_end", "0.3", "-progress", "none",
                        "-output", "run.h5", "-output_every", "0.1", "-report", "run.csv"],
                       check=True, stdout=subprocess.DEVNULL)
    snapshots = sorted(glob.glob("run_*.h5"))
    assert len(snapshots) == 4, snapshots
    for kind, files, options, start in (("field", snapshots, [], b"\x89PNG"), ("profiles", snapshots, [], b"\x89PNG"),
                                        ("cavity", snapshots, [], b"\x89PNG"), ("animate", snapshots[-2:], [], b"GIF8"),
                                        ("field", [snapshots[-1]], ["--field", "p"], b"\x89PNG"),
                        ("animate", snapshots[-2:], ["--field", "vorticity"], b"GIF8"),
                        ("space", ["space_0001.h5"], ["--field", "p"], b"\x89PNG"),
                                        ("cost", ["run.csv"], ["--quantity", "kinetic_energy", "--group", "motion"],
                                         b"\x89PNG")):
        picture = kind + (".gif" if start == b"GIF8" else ".png")
        assert not plot(kind, *files, *options, "-o", picture), picture
        several = len(files) > 1 and start != b"GIF8" and kind != "cost"
        for name in [f"{kind}_{k}.png" for k in range(len(files))] if several else [picture]:
            with open(name, "rb") as file:
                data = file.read()
            assert data.startswith(start) and len(data) > 5000, name
            os.remove(name)

    for arguments, told in ((["cost", "run.csv", "--quantity", "wrong"], "wrong has no error"),
                            (["cost", "run.csv", "--group", "wrong"], "wrong is no column"),
                            (["cost", snapshots[0]], "is no file of -report"),
                            (["animate", "run.csv"], "is not a readable snapshot"),
                            (["space", "run_0000.h5"], "is a snapshot of a plane"),
                            (["field", "run_0000.h5", "--field", "T"], "has no field T; it has speed, density, pressure")):
        error = plot(*arguments, "-o", "none.gif")
        assert error.startswith("plot: ") and "\n" not in error and told in error, error
    done = subprocess.run([sys.executable, PLOT, "field", "absent.h5", "-o", "none.png"], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and "is not a readable snapshot" in done.stderr, done.stderr


main()
