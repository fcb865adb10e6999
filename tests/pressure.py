"""Tests studies/pressure with cheap flows: the weight on half a circle that a side cuts, the torque on a paddle in a vessel that
turns, and exact pressures; the list, the page and its picture.

    pressure.py STUDY ISPH"""
import csv
import importlib.machinery
import importlib.util
import os
import subprocess
import sys

from interpreter import python_with

python_with("numpy, matplotlib")
study, isph = sys.argv[1:3]
ONLY = r"half circle at rest n=24|mixer fixed n=16|diffuser coupled n=(16|32)"

sys.path.insert(0, os.path.dirname(study))
loader = importlib.machinery.SourceFileLoader("pressure_study", study)
module = importlib.util.module_from_spec(importlib.util.spec_from_loader("pressure_study", loader))
loader.exec_module(module)
flows = module.read_list()
runs = [arguments for flow in flows.values() for n in flow.sides for arguments in flow.runs(n)]
assert len(flows) >= 30 and len(set(runs)) == len(runs), "flows are few or the same"

subprocess.run([sys.executable, study, "--isph", isph, "--column", "after", "--out", os.getcwd(), "--only", ONLY], check=True,
               stdout=subprocess.DEVNULL)
with open("pressure_after.csv", newline="", encoding="utf-8") as file:
    rows = {row["run"]: row for row in csv.DictReader(file)}


def error(label, n, name):
    """Returns the error of a quantity of a flow in %."""
    flow = flows[label]
    return module.errors(flow, [{key: float(value) for key, value in rows[run].items() if key == name or key == name + "_std"}
                                for run in flow.runs(n)])[name][0]


# Buoyancy within 0.1 %. The torques converge from 12 % at n = 16; the forces of the fluid on paddle and vessel have
# opposite signs. Second order of the pressure: a quarter of the error, within a third.
assert abs(error("half circle at rest", 24, "body_1_fy")) < 0.1
assert all(abs(error("mixer fixed", 16, f"{k}_torque")) < 15 for k in ("body_1", "domain"))
coarse, fine = (error("diffuser coupled", n, "pressure_l2") for n in (16, 32))
assert coarse < 2 and fine < coarse / 3, (coarse, fine)
with open("pressure.md", encoding="utf-8") as file:
    page = file.read()
assert "| diffuser coupled | 16, 32 | pressure | not run |" in page and os.path.getsize("pressure.png") > 10000, page
