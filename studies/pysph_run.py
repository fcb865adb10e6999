"""Runs a flow of PySPH with PySPH's own Python, and times its time loop.

    pysph_run.py FOLDER FLOW OPTION...     options of the flow, for instance --nx

Flows: cavity and taylor_green are PySPH's examples, channel is in pysph_channel.py, dam in pysph_dam.py, drop and column are in
pysph_free.py.

Code that is compiled at first use is compiled before the timed run. Writes to FOLDER run.json (wall_s, cpu_s, steps,
dt, t) and run.npz: x, y, u, v of the fluid, a row for each of the last five outputs.
"""
import json
import os
import sys
import time

import numpy as np
import pysph_channel
import pysph_dam
import pysph_free
from pysph.examples.cavity import LidDrivenCavity
from pysph.examples.taylor_green import TaylorGreen
from pysph.solver.utils import load

FLOWS = {"cavity": LidDrivenCavity, "taylor_green": TaylorGreen, "channel": pysph_channel.Channel, "dam": pysph_dam.ViscousDam,
         "drop": pysph_free.Drop, "column": pysph_free.Column}


def main():
    folder, flow, *options = sys.argv[1:]
    app = FLOWS[flow](fname="run")
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
