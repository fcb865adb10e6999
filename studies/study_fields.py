"""Compares a field of a snapshot with that of a finer run, by least squares over the finer run's particles."""
import glob
import os

import h5py
import numpy as np

from study_runs import UserError

RADIUS = 2.6  # of the fits [dx of the finer run]
FEWEST = {2: 9, 3: 16}  # particles of a fit of degree 2


def read(run, name):
    """Returns places, values and spacing of the fluid in the last snapshot of a run."""
    paths = sorted(glob.glob(os.path.join(run.folder, "flow_*.h5")))
    if not paths:
        raise UserError(f"{run.label}: the run left no snapshot")
    try:
        with h5py.File(paths[-1], "r") as file:
            if name not in file:
                raise UserError(f"--quantity {name}: snapshots have no such field; they have {', '.join(fields(file))}")
            fluid = file["type"][:] == 0
            values = file[name][:][fluid]
            return file["position"][:][fluid], values.reshape(len(values), -1), float(np.ravel(file.attrs["dx"])[0])
    except (OSError, KeyError) as error:
        raise UserError(f"{paths[-1]}: no readable snapshot: {error}") from None


def fields(file):
    return sorted(name for name in file if isinstance(file[name], h5py.Dataset) and file[name].dtype.kind == "f")


def cells(x, size):
    """Returns the particles of each occupied cell of a lattice."""
    index = np.floor(x / size).astype(int)
    order = np.lexsort(index.T)
    heads = np.flatnonzero(np.r_[True, np.any(np.diff(index[order], axis=0), axis=1)])
    return {tuple(index[part[0]]): part for part in np.split(order, heads[1:])}


def fit(away, values, radius):
    """Returns the values at the origin of fits of degree 2 to particles at places `away` (targets, particles, dim)."""
    dim = away.shape[2]
    away = away / radius
    weight = np.clip(1.0 - np.sqrt((away**2).sum(axis=2)), 0.0, 1.0)**3
    pairs = [away[..., a] * away[..., b] for a in range(dim) for b in range(a, dim)]
    basis = np.stack([np.ones(weight.shape), *np.moveaxis(away, 2, 0), *pairs], axis=2)
    matrix = np.einsum("ij,ija,ijb->iab", weight, basis, basis)
    right = np.einsum("ij,ija,jk->iak", weight, basis, values)
    found = np.full((len(away), values.shape[1]), np.nan)
    good = (weight > 0).sum(axis=1) >= FEWEST[dim]
    good[good] = np.linalg.cond(matrix[good]) < 1e10
    found[good] = np.linalg.solve(matrix[good], right[good])[:, 0]
    return found


def interpolate(x, values, targets, radius):
    """Returns values at targets, NaN where too few particles are near."""
    near, found = cells(x, radius), np.full((len(targets), values.shape[1]), np.nan)
    shifts = np.stack(np.meshgrid(*[[-1, 0, 1]] * x.shape[1], indexing="ij"), -1).reshape(-1, x.shape[1])
    for cell, part in cells(targets, radius).items():
        some = [near[key] for shift in shifts if (key := tuple(np.array(cell) + shift)) in near]
        if some:
            some = np.concatenate(some)
            found[part] = fit(x[some][None] - targets[part][:, None], values[some], radius)
    return found


def error(run, reference, name):
    """Returns the relative L2 error of a field against the finer run, and the share of particles that it compares. Means
    are removed from a pressure, whose constant may be free."""
    x, values, _ = read(run, name)
    finer_x, finer, dx = read(reference, name)
    exact = interpolate(finer_x, finer, x, RADIUS * dx)
    good = np.isfinite(exact).all(axis=1)
    if not good.any():
        raise UserError(f"--quantity {name}: no particle of {run.label} lies in the fluid of the reference")
    values, exact = values[good], exact[good]
    if name == "pressure":
        values, exact = values - values.mean(), exact - exact.mean()
    scale = np.sqrt((exact**2).sum())
    return float(np.sqrt(((values - exact)**2).sum()) / (scale or 1.0)), float(good.mean())
