"""Tests studies/spectral.py: exact vortices at rest and carried along, convergence in space and time, and the Fourier series
between grid points.

    spectral.py FOLDER_OF_STUDIES"""
import sys

from interpreter import python_with

python_with("numpy")
sys.path.insert(0, sys.argv[1])
import numpy as np  # noqa: E402 (after the path)
import spectral  # noqa: E402

X, Y = np.random.default_rng(1).random((2, 500))


def carried(x, y):
    """Returns the vortices with a mean velocity (1, 0.5), which carries them along."""
    u, v = spectral.taylor_green(x, y)
    return u + 1, v + 0.5


def difference(a, b):
    return np.sqrt(np.sum((a - b) ** 2) / np.sum(b**2))


nu, t = 0.01, 0.5
decay = np.exp(-8 * np.pi**2 * nu * t)
found = spectral.solve(spectral.taylor_green, nu, t, 16).at(X, Y)
exact = decay * np.array(spectral.taylor_green(X, Y))
assert difference(found, exact) < 1e-12, f"vortices at rest: {difference(found, exact)}"

exact = decay * np.array(spectral.taylor_green(X - t, Y - 0.5 * t)) + np.array([[1], [0.5]])
errors = [difference(spectral.solve(carried, nu, t, 16, courant).at(X, Y), exact) for courant in (0.8, 0.4)]
assert errors[1] < 1e-5 and 14 < errors[0] / errors[1] < 18, f"fourth order in time, 2^4 = 16: {errors}"

fine, coarse, coarser = (spectral.solve(spectral.double_shear, 1e-3, 0.2, n).at(X, Y) for n in (96, 64, 48))
errors = difference(coarser, fine), difference(coarse, fine)
assert errors[1] < 1e-3 and errors[0] > 4 * errors[1], f"convergence in space: {errors}"
