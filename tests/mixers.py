"""Tests vessels with rotors that move: torques of a short run of options/kneader.opts against finite elements, no particle
inside a blade, and the outlines of studies/elements_mixers.

    mixers.py FOLDER_OF_STUDIES ISPH"""
import sys

from interpreter import python_with

python_with("numpy, scipy, h5py, matplotlib")
sys.path.insert(0, sys.argv[1])
import os  # noqa: E402 (after the path)
import subprocess  # noqa: E402
import tempfile  # noqa: E402
from importlib.machinery import SourceFileLoader  # noqa: E402

import numpy as np  # noqa: E402

mixers = SourceFileLoader("mixers", os.path.join(sys.argv[1], "mixers")).load_module()
TOLERANCE = 0.03  # second order: 1.7 % of instants at n = 30, 0.8 % at 45

# Both screws wipe each other: at their distance without gaps, tips and roots touch at all angles.
for angle in np.linspace(0, np.pi / 2, 7):
    shapes = [np.concatenate([piece(np.linspace(0, 1, 300)) for piece in mixers.meshes.turned(mixers.REFERENCE.SCREW, a, c)])
              for a, c in ((angle, (-0.8, 0)), (angle + np.pi / 2, (0.8, 0)))]
    near = mixers.cKDTree(shapes[0]).query(shapes[1])[0].min()
    assert near < 0.01, f"the screws are {near} apart at {angle}"

with tempfile.TemporaryDirectory() as folder:
    base = os.path.join(folder, "run")
    subprocess.run([sys.argv[2], "-options_file", os.path.join(mixers.ROOT, "options", "kneader.opts"), "-n", "28", "-t_end", "0.1",
                    "-probe_forces", "-probe_output", base, "-output", base + ".h5"], check=True, stdout=subprocess.DEVNULL)
    t, found = mixers.torques("kneader", base)
    for k, (torque, exact) in enumerate(zip(found, mixers.reference("kneader"))):
        miss = abs(torque[-1] / exact(t[-1]) - 1)
        assert miss < TOLERANCE, f"torque of rotor {k + 1} at {t[-1]}: {torque[-1]}, by finite elements {exact(t[-1])}"
    wrong, gap = mixers.places("kneader", base)
    assert wrong == 0, f"{wrong} particles inside solids"
    assert gap < 1.5, f"a gap of {gap} dx between particles"
