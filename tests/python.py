#!/usr/bin/env python3
"""Runs flows from Python: python.py SOURCE LIBRARY

The flow is that of a program in C (tests/test_library.c); here are the conversions: options, functions and their exceptions,
arrays without copies, boundaries, particles that enter and leave, studies, pictures, and the examples."""
import os
import runpy
import sys
import warnings
from importlib.util import find_spec

from interpreter import python_with

python_with("numpy")
source, os.environ["ISPH_LIBRARY"] = sys.argv[1:]
sys.path.insert(0, f"{source}/python")
import numpy  # noqa: E402 (after the interpreter)

import isph  # noqa: E402


def raises(kind, text, function, *arguments, **keywords):
    """Asserts that a call raises an exception with a text."""
    try:
        function(*arguments, **keywords)
    except kind as fault:
        assert text in str(fault), fault
        return
    raise AssertionError(f"no {kind.__name__}")


typed, called = (isph.Flow(case="scene", n=12, reynolds=10, scene_wall_top_velocity=lid).run(until=0.1)
                 for lid in ("x*(1-x)*t,0", (lambda x, t: x * (1 - x) * t, 0)))
assert abs(called.t - 0.1) < 1e-12 and called.steps == typed.steps
assert numpy.array_equal(called["velocity"][0], typed["velocity"][0])
u = called["velocity"][0]
u[0] = 7.0
assert called["velocity"][0][0] == 7.0, "a copy"
called.changed()
assert list(called.boundaries) == ["left", "right", "bottom", "top"]
assert called.force("top").force[0] < 0.0 and called.probe([[0.5, 0.5]])[0].shape == (1, 2)
flow = isph.Flow(case="cavity", n=8, t_end=0.02)
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    flow.run(until=0.03)
assert "ended at t = 0.02, before 0.03" in str(told[0].message), told
raises(KeyError, "front: the boundaries are left, right", called.force, "front")
raises(isph.Error, "-foo: unknown option", isph.Flow, case="cavity", foo=1)
raises(ZeroDivisionError, "division", isph.Flow, case="scene", n=12, scene_wall_top_velocity=(lambda x: 1 / 0, 0))


def interrupt(flow):
    raise KeyboardInterrupt("as by Ctrl-C")


flow = isph.Flow(case="taylor_green", n=12, t_end=0.1)
raises(KeyboardInterrupt, "Ctrl-C", flow.run, each=interrupt)
assert flow.steps == 1 and not flow.over
flow.remove(flow.ids[:2])
assert flow.n == 142
flow.insert([[0.2, 0.3], [0.6, 0.7]], velocity=[0.0, 0.0])
flow.run(each=lambda flow: flow.steps == 3)
assert flow.n == 144 and flow.steps == 3 and flow["boundary"].max() == -1
assert flow.run().over and "kinetic_energy" in flow.measure()
flow.write("python.h5")
flow.close()
raises(ValueError, "closed", flow.step)

rows = isph.study(case="cavity", n=[8, 12], reynolds=[10, -1], t_end=0.05, measure=lambda flow: {"steps": flow.steps})
rows = rows if isinstance(rows, list) else rows.to_dict("records")
assert len(rows) == 4 and rows[0]["steps"] > 0 and "-reynolds -1: allowed" in rows[3]["error"], rows
mixer = runpy.run_path(f"{source}/python/examples/mixer.py") if find_spec("scipy") else None
assert not mixer or mixer["batch"](4.0, n=12)[0] > 0.0
sweep = runpy.run_path(f"{source}/python/examples/sweep.py")
assert sweep["torque"](isph.Flow(**{**sweep["SCENE"], "n": 16}, rheology_exponent=0.5, scene_body_1_rotation=2.0).run())["torque"] > 0.0
try:
    import matplotlib
except ImportError:
    sys.exit()
matplotlib.use("Agg")
called.picture(path="speed.png")
assert os.path.getsize("speed.png") > 10000
