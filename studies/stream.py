"""Creeping flow in the unit square below a lid that moves with the speed 1, with a round drop of another viscosity, for references.

The stream function psi, u = d psi/dy, v = -d psi/dx, makes the dissipation least:

    D = int mu ((psi_xx - psi_yy)^2 + 4 psi_xy^2) dV,    psi = 0 and grad psi given on the walls.

Differences of second order on n x n cells, psi in the corners of cells, the first bracket there and psi_xy in the middles.
Viscosities are means over a cell's area, which is of order 1 beside the interface. The velocity is that of a cubic spline.
"""
import numpy as np
from scipy.interpolate import RectBivariateSpline
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

PARTS = 8  # points along a side of a cell in the mean of a viscosity


def mean_viscosity(x, y, h, drop):
    """Returns means over cells about points; drop is its centre, its radius and its viscosity over that outside."""
    cx, cy, radius, ratio = drop
    offsets = ((np.arange(PARTS) + 0.5) / PARTS - 0.5) * h
    share = sum(((x + a - cx) ** 2 + (y + b - cy) ** 2 < radius**2).astype(float) for a in offsets for b in offsets) / PARTS**2
    return 1 + (ratio - 1) * share


def terms(i, j, stencil, weights, n):
    """Returns columns, values and constants of weighted differences; values beyond a wall follow from its velocity."""
    columns, values, constants = [], [], np.zeros(i.size)
    for di, dj, factor in stencil:
        a, b = i + di, j + dj
        constants += np.where(b == n + 1, 2 / n, 0) * factor * weights  # the lid: psi_y = 1
        a, b = (np.where(k < 0, 1, np.where(k > n, n - 1, k)) for k in (a, b))
        inside = (a > 0) & (a < n) & (b > 0) & (b < n)
        columns.append(np.where(inside, (a - 1) * (n - 1) + b - 1, 0))
        values.append(np.where(inside, factor * weights, 0))
    return np.array(columns).T, np.array(values).T, constants


def velocity(points, n, drop):
    """Returns the velocity at points by n x n cells."""
    h = 1 / n
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    edge = np.where((i == 0) | (i == n), 0.5, 1) * np.where((j == 0) | (j == n), 0.5, 1)  # share of a cell in the square
    parts = [terms(i, j, [(1, 0, 1), (-1, 0, 1), (0, 1, -1), (0, -1, -1)],
                   np.sqrt(edge * mean_viscosity(i * h, j * h, h, drop)) / h**2, n)]
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    parts.append(terms(i, j, [(1, 1, 1), (0, 0, 1), (1, 0, -1), (0, 1, -1)],
                       2 * np.sqrt(mean_viscosity((i + 0.5) * h, (j + 0.5) * h, h, drop)) / h**2, n))
    columns, values = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
    constants = np.concatenate([part[2] for part in parts])
    rows = np.repeat(np.arange(len(columns)), 4)
    matrix = csr_matrix((values.ravel(), (rows, columns.ravel())), shape=(len(columns), (n - 1) ** 2))
    factors = splu((matrix.T @ matrix).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    psi = np.pad(factors.solve(-matrix.T @ constants).reshape(n - 1, n - 1), 1)
    spline = RectBivariateSpline(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), psi)
    x, y = points.T
    return np.stack([spline(x, y, dy=1, grid=False), -spline(x, y, dx=1, grid=False)], axis=1)
