"""Reads snapshots of isph as fields for drawing."""
import sys

import h5py
import numpy as np
from matplotlib import tri


class Snapshot:
    """Particles of a plane at a time, with an interpolant of their velocity."""

    def __init__(self, path, box=None, length="[m]", speed="[m/s]"):
        try:
            with h5py.File(path, "r") as file:
                x, u = file["position"][:], file["velocity"][:]
                fluid = file["type"][:] == 0
                self.attributes = {name: plain(value) for name, value in file.attrs.items()}
        except (OSError, KeyError) as error:
            sys.exit(f"plot: {path} is not a readable snapshot: {error}")
        self.length, self.speed = length, speed  # units on the axes
        self.time = float(self.attributes.get("time", 0))
        lo, hi = x[fluid].min(axis=0), x[fluid].max(axis=0)
        self.dim = x.shape[1]
        self.dx = 0
        for _ in range(20):  # each particle fills a cube of side dx, which extends half beyond lo and hi
            self.dx = (np.prod(hi - lo + self.dx) / fluid.sum()) ** (1 / self.dim)

        if self.dim == 3:
            above = (x[:, 2] - (lo[2] + hi[2]) / 2) / self.dx
            layer = (above > -0.01) & (above < 0.99)
            x, u = x[layer], u[layer]

        # Wall particles count if they touch the fluid: layers behind them hold extrapolated values.
        lo, hi, margin = lo[:2], hi[:2], 0.75 * self.dx
        if box is not None:
            lo, hi, margin = np.array(box[::2]), np.array(box[1::2]), 0.1 * self.dx
        inside = np.all((x[:, :2] >= lo - margin) & (x[:, :2] <= hi + margin), axis=1)
        x, u = x[inside, :2], u[inside, :2]
        if box is None:
            box = x[:, 0].min(), x[:, 0].max(), x[:, 1].min(), x[:, 1].max()
        self.box = box  # left, right, bottom, top
        _, distinct = np.unique(np.round(x / (1e-6 * self.dx)), axis=0, return_index=True)
        x, u = x[distinct], u[distinct]

        triangles = tri.Triangulation(x[:, 0], x[:, 1])
        corner = x[triangles.triangles]
        edge = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
        triangles.set_mask(edge.max(axis=1) > 4 * self.dx)  # no interpolation across holes
        self.triangles, self.velocity = triangles, u.T

    def title(self):
        parts = [str(self.attributes[name]) for name in ["case"] if name in self.attributes]
        if "reynolds" in self.attributes:
            parts.append(f"Re = {float(self.attributes['reynolds']):g}")
        return ", ".join(parts + [f"t = {self.time:g}"])


def plain(value):
    """Returns an HDF5 attribute as a Python number or string."""
    value = np.asarray(value).reshape(-1)[0]
    return value.decode() if isinstance(value, bytes) else value
