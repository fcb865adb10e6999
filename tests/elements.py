"""Tests studies/elements.py and meshes.py: orders of convergence on Kovasznay's flow, force and torque in a journal bearing,
a channel that starts between periodic sides, a turning frame, and refusals of meshes.

    elements.py FOLDER_OF_STUDIES"""
import sys

from interpreter import python_with

python_with("numpy, scipy")
sys.path.insert(0, sys.argv[1])
import numpy as np  # noqa: E402 (after the path)
import elements  # noqa: E402
import meshes  # noqa: E402

# Kovasznay's flow at Re = 40 with its velocity on all sides: third and second order in velocity and pressure.
DECAY = 20 - np.sqrt(400 + 4 * np.pi**2)


def kovasznay(x):
    """Returns the velocity of Kovasznay's flow."""
    wave, fade = 2 * np.pi * x[:, 1], np.exp(DECAY * x[:, 0])
    return np.stack([1 - fade * np.cos(wave), DECAY / (2 * np.pi) * fade * np.sin(wave)], 1)


errors = []
for h in (0.16, 0.08):
    mesh = meshes.Mesh([meshes.polygon((-0.5, -0.5), (1, -0.5), (1, 0.5), (-0.5, 0.5))], h)
    assert mesh.least_angle() > 22, f"least angle {mesh.least_angle()}"
    flow = elements.Flow(mesh, mu=1 / 40, rho=1, velocity={(0, j): kovasznay for j in range(4)})
    points = np.random.default_rng(1).uniform((-0.45, -0.45), (0.95, 0.45), (300, 2))
    found, u = flow.at(flow.steady(), points), kovasznay(points)
    p = -np.exp(2 * DECAY * points[:, 0]) / 2
    errors.append((np.abs(found[:, :2] - u).max(), np.std(found[:, 2] - p)))
order = np.log2(np.array(errors[0]) / errors[1])
assert order[0] > 2.6 and order[1] > 1.7, f"orders on Kovasznay's flow {order}, errors {errors}"

# Force and torque on the turning inner cylinder of options/journal_bearing.opts, by complex potentials.
misses = []
for h in (0.12, 0.06):
    mesh = meshes.Mesh([meshes.circle((0, 0), 1), meshes.circle((0.3, 0), 0.3)], h)
    turning = elements.turning(1 / 0.3, (0.3, 0))
    flow = elements.Flow(mesh, velocity={(k, j): turning if k else elements.still for k in (0, 1) for j in range(4)})
    w = flow.steady()
    force = flow.reaction(w, [(1, j) for j in range(4)], (0.3, 0))
    misses.append(np.abs(force - (0, 2.8453062, -4.3937727)).max())
    assert abs(flow.dissipation(w) + force[2] / 0.3) < 1e-9, "the power of the torque is dissipated"
assert misses[1] < 1e-3 and misses[1] < misses[0] / 6, f"forces in a journal bearing are off by {misses}, third order or better"

# The force 1 starts a channel of width 1, nu = 1, between periodic sides (closed form as a series).
mesh = meshes.Mesh([meshes.polygon((0, 0), (0.5, 0), (0.5, 1), (0, 1))], 0.2, periodic=[(1, 3)])
sides = {(0, 0): elements.still, (0, 2): elements.still}
flow = elements.Flow(mesh, rho=1, velocity=sides, force=(1, 0), periodic=[(1, 3)])
k = np.arange(1, 80, 2)
exact = 0.125 - np.sum(4 / (np.pi * k) ** 3 * np.sin(np.pi * k / 2) * np.exp(-(np.pi * k) ** 2 * 0.1))
speeds = [flow.at(flow.advance(np.zeros(flow.size), 0.1 / n, n), [(0.25, 0.5)])[0, 0] for n in (8, 16)]
misses = [abs(speed - exact) / exact for speed in speeds]
assert misses[1] < 0.01 and misses[1] < misses[0] / 2.5, f"starting channel {misses}"

# Couette's flow between circles at Re = 10, in the frame of the inner one that turns.
mesh = meshes.Mesh([meshes.circle((0, 0), 1), meshes.circle((0, 0), 0.5)], 0.15)
back = elements.turning(-1.0)
flow = elements.Flow(mesh, rho=10, omega=1.0, velocity={(k, j): elements.still if k else back for k in (0, 1) for j in range(4)})
torque = flow.reaction(flow.steady(), [(1, j) for j in range(4)])[2]
assert abs(torque / (-4 * np.pi * 0.25 / 0.75) - 1) < 1e-3, f"turning frame {torque}"
