"""Runs an example of PySPH with PySPH's own Python, and times its time loop.

    pysph_run.py FOLDER cavity|taylor_green|dam OPTION...     options of the example; dam is that of pysph_dam.py

Code that is compiled at first use is compiled before the timed run. Writes to FOLDER run.json (wall_s, cpu_s, steps,
dt, t) and run.npz: x, y, u, v of the fluid, a row for each of the last five outputs.
"""
import json
import os
import sys
import time

import numpy as np
import pysph_dam
from pysph.examples.cavity import LidDrivenCavity
from pysph.examples.taylor_green import TaylorGreen
from pysph.solver.utils import load

EXAMPLES = {"cavity": LidDrivenCavity, "taylor_green": TaylorGreen, "dam": pysph_dam.ViscousDam}


def main():
    folder, example, *options = sys.argv[1:]
    app = EXAMPLES[example](fname="run")
    app.setup([*options, "--no-openmp", "--cache-nnps", "--quiet", "--directory", os.path.join(folder, "out")])
    wall, cpu = time.perf_counter(), time.process_time()
    app.solve()
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    solver = app.solver
    with open(os.path.join(folder, "run.json"), "w") as file:
        json.dump({"wall_s": wall, "cpu_s": cpu, "steps": solver.count, "dt": solver.t / solver.count,
                   "t": solver.t}, file)
    fluids = [load(path)["arrays"]["fluid"] for path in app.output_files[-5:]]
    np.savez(os.path.join(folder, "run.npz"),
             **{name: np.array([getattr(fluid, name) for fluid in fluids]) for name in "xyuv"})


main()
