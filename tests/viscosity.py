"""Tests studies/viscosity: its closed forms against the equations and against formulas, its list and its references; cheap runs,
their page and picture.

    viscosity.py STUDY ISPH"""
import importlib.machinery
import importlib.util
import math
import os
import subprocess
import sys

from interpreter import python_with

python_with("numpy, matplotlib, h5py")
study, isph = sys.argv[1:3]
ONLY = r"layers 1e3 coupled n=20|channel power 0.5 coupled n=(20|40)|turning newtonian coupled n=20|cylinder newtonian coupled n=24"

sys.path.insert(0, os.path.dirname(study))
loader = importlib.machinery.SourceFileLoader("viscosity_study", study)
module = importlib.util.module_from_spec(importlib.util.spec_from_loader("viscosity_study", loader))
loader.exec_module(module)
import numpy as np  # noqa: E402 (after the check of modules)
import viscosity_exact as exact  # noqa: E402

flows = module.read_list()
runs = [arguments for flow in flows.values() for n in flow.sides for arguments in flow.runs(n)]
assert len(flows) >= 100 and len(set(runs)) == len(runs), "flows are few or the same"
for flow in flows.values():  # each reference of finite elements is there, and its meshes agree
    if flow.kind == "points":
        points, words = module.reference(flow.words[0])
        assert points.shape[0] == 6 and points.shape[1] >= 30 and words["kinetic_energy"] > 0, flow.label

# A drop: div u = 0, div of the stress = 0, and velocity and shear stress continuous at its surface.
STEP = 1e-4


def gradients(fields, x, y):
    """Returns values (3), gradients (3, 2) and Laplacians (3) of u, v and p by differences."""
    at = [np.concatenate([u, [p]])[:, 0] for u, p in (fields(np.array([x + STEP * a]), np.array([y + STEP * b]))
                                                     for a, b in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)))]
    return at[0], np.array([at[1] - at[2], at[3] - at[4]]).T / (2 * STEP), (sum(at[1:]) - 4 * at[0]) / STEP**2


for ratio in (1e-3, 10):
    fields = exact.drop(ratio).fields
    for x, y, nu in ((0.3, 0.2, 1), (-0.1, 0.25, 1), (0.1, 0.05, ratio)):
        _, slope, laplacian = gradients(fields, x, y)
        assert abs(slope[0, 0] + slope[1, 1]) < 1e-5 and np.abs(nu * laplacian[:2] - slope[2]).max() < 1e-3, (ratio, x, y)
    for angle in (0.3, 2.0):
        normal, along = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        sides = [gradients(fields, *(normal * (exact.RADIUS + way * 1.01 * STEP))) for way in (-1, 1)]
        shear = [nu * along @ (slope[:2] + slope[:2].T) @ normal for nu, (_, slope, _) in zip((ratio, 1), sides)]
        assert np.abs(sides[0][0][:2] - sides[1][0][:2]).max() < 2e-3 and abs(shear[0] - shear[1]) < 0.02 * max(1, abs(shear[0])), (ratio, angle)
# Torques: M. Couette's 4 pi nu/(1/a^2 - 1/b^2); where nu ~ r^2 the quartic powers take the place of the squares.
assert abs(exact.turning_named("newtonian", 1).values["domain_torque"] / (4 * math.pi / (16 - 4)) - 1) < 1e-6
assert abs(exact.turning_named("field", 2).values["domain_torque"] / (8 * math.pi / 0.25**2 / (256 - 16)) - 1) < 1e-6
assert abs(exact.turning_named("fluids", 1).values["domain_torque"] / (4 * math.pi / (16 - 4)) - 1) < 1e-6
assert abs(exact.turning_named("bingham", 1).values["domain_torque"] - 1.7731) < 1e-4  # 4 pi (1 + ln 2)/12
assert abs(exact.channel_named("power", 1).fields(np.zeros(1), np.array([0.5]))[0][0, 0] - 1.5) < 1e-5

subprocess.run([sys.executable, study, "--isph", isph, "--column", "after", "--out", os.getcwd(), "--only", ONLY], check=True,
               stdout=subprocess.DEVNULL)
column = module.Measured("viscosity_after.csv", isph)


def error(label, n, name):
    """Returns the error of a quantity of a flow in %."""
    return abs(module.quantities(column.known(flows[label], n, ""))[name])


# Second order of smooth flows: a quarter of the error, within a third. Layers are exact. Force on the cylinder: 14 particles
# along its diameter at n = 48, 7 here.
assert error("layers 1e3 coupled", 20, "velocity_out") < 1
assert error("channel power 0.5 coupled", 40, "velocity") < error("channel power 0.5 coupled", 20, "velocity") / 3 < 1
assert error("turning newtonian coupled", 20, "velocity") < 2 and error("turning newtonian coupled", 20, "body_1_torque") < 0.2
assert error("cylinder newtonian coupled", 24, "body_1_fx") < 5
with open("viscosity.md", encoding="utf-8") as file:
    page = file.read()
assert "| channel power 0.5 coupled | 20, 40 | velocity | not run |" in page and os.path.getsize("viscosity.png") > 10000, page
