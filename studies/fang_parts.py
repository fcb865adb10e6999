"""Runs with kept particles, measures and pictures of studies/fang."""
import hashlib
import os
import tempfile

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
from matplotlib import tri  # noqa: E402
from runs import Runs  # noqa: E402

COLOURS = {"SPH": "#D55E00", "CPH": "#009E73", "FPH": "#0072B2", "coupled": "#E69F00"}
HOLE = 2.0  # radius of the least empty circle that is a hole [dx]
CLOSE = 0.3  # distance of particles that are clumps [dx]


def lattice(path, points):
    """Writes positions as a file of -particles."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with h5py.File(path + ".new", "w") as file:
        file["position"] = np.array(points, dtype=float)
    os.replace(path + ".new", path)


def disc(m):
    """Returns the points of a square lattice of spacing 1/m in the unit circle, its centre and its border included."""
    return [(i / m, j / m) for j in range(-m, m + 1) for i in range(-m, m + 1) if i * i + j * j <= m * m]


def square(m):
    """Returns (2m + 1)^2 points of spacing 1/m in a square of half-side 1."""
    return [(i / m, j / m) for j in range(-m, m + 1) for i in range(-m, m + 1)]


def stretching_drop(times, steps=2000):
    """Returns semi-axes and pressure at the centre at ascending times: da/dt = -A a, db/dt = A b, dA/dt = A^2 (a^2 -
    b^2)/(a^2 + b^2), p = A^2 a^2 b^2/(a^2 + b^2), from A = a = b = 1, by the fourth-order Runge-Kutta method."""
    def slope(y):
        a, b, rate = y
        return -rate * a, rate * b, rate**2 * (a * a - b * b) / (a * a + b * b)

    def moved(y, k, dt):
        return [value + dt * change for value, change in zip(y, k)]

    y, t, found = [1.0, 1.0, 1.0], 0.0, []
    for end in times:
        dt = (end - t) / steps
        for _ in range(steps):
            k1 = slope(y)
            k2 = slope(moved(y, k1, dt / 2))
            k3 = slope(moved(y, k2, dt / 2))
            k4 = slope(moved(y, k3, dt))
            y = [value + dt / 6 * (p + 2 * q + 2 * r + s) for value, p, q, r, s in zip(y, k1, k2, k3, k4)]
        t, (a, b, rate) = end, y
        found.append({"a": a, "b": b, "p": rate**2 * a * a * b * b / (a * a + b * b)})
    return found


def read(path):
    """Returns time, positions, velocities and pressures of the fluid in a snapshot."""
    with h5py.File(path, "r") as file:
        fluid = file["type"][:] == 0
        return (float(np.asarray(file.attrs["time"]).reshape(-1)[0]), file["position"][:][fluid, :2],
                file["velocity"][:][fluid, :2], file["pressure"][:][fluid])


def measure(x, u, p):
    """Returns the half-width along x, the root of the mean square of x, the pressure of the particle nearest to the
    origin, angular momentum and momentum (mean over the particles, of the latter over the mean speed), and the energy."""
    speed = np.linalg.norm(u, axis=1)
    return (np.ptp(x[:, 0]) / 2, np.sqrt(np.mean((x[:, 0] - x[:, 0].mean())**2)), p[np.argmin((x**2).sum(axis=1))],
            np.mean(x[:, 0] * u[:, 1] - x[:, 1] * u[:, 0]), np.linalg.norm(u.mean(axis=0)) / speed.mean(),
            np.mean(speed**2) / 2)


class Flows(Runs):
    """Runs whose series and particles are kept in a folder. A run is made again if the folder has lost its file."""

    def __init__(self, path, isph, keep, seconds):
        super().__init__(path, isph, seconds)
        self.keep, self.every, self.pictures = keep, None, ()
        os.makedirs(keep, exist_ok=True)

    def file(self, arguments):
        return os.path.join(self.keep, hashlib.sha256(arguments.encode()).hexdigest()[:16] + ".npz")

    def flow(self, arguments, every, pictures):
        """Returns the quantities of a run, its series, sampled at multiples of `every`, and its particles at the
        times `pictures`."""
        if not os.path.exists(self.file(arguments)):
            self.rows.pop(arguments, None)
        self.every, self.pictures = every, pictures
        found = self(arguments)
        with np.load(self.file(arguments)) as data:
            kept = {name: data[name] for name in data.files}
        return found, kept

    def make(self, arguments, watch=""):
        """Makes a run with snapshots, and keeps their series and the wanted particles."""
        with tempfile.TemporaryDirectory() as folder:
            row = super().make(f"{arguments} -output {folder}/flow.h5 -output_every {self.every:g}", watch)
            row["run"] = arguments
            paths = sorted(os.path.join(folder, name) for name in os.listdir(folder) if name.endswith(".h5"))
            series, kept = [], {}
            for path in paths:
                t, x, u, p = read(path)
                series.append((t, *measure(x, u, p)))
                for wanted in self.pictures:
                    if abs(t - wanted) < 1e-6:
                        kept[f"x@{wanted:g}"], kept[f"p@{wanted:g}"] = x, p
        if series:
            row["t"] = f"{series[-1][0]:.6g}"
        names = ("t", "a", "moment", "p", "L", "P", "energy")
        columns = np.array(series).reshape(-1, len(names)).T
        np.savez_compressed(self.file(arguments), **dict(zip(names, columns)), **kept)
        return row


def at(series, name, t):
    """Returns a column of a series at a time; None if the run ended before it."""
    near = np.flatnonzero(np.abs(series["t"] - t) < 1e-6)
    return series[name][near[0]] if len(near) else None


def pieces(x, dx):
    """Returns the numbers of pieces, holes and single particles: triangles of Delaunay with a circumcircle below HOLE dx
    are fluid, particles in none of them are single, and Euler's characteristic counts the holes."""
    triangles = tri.Triangulation(x[:, 0], x[:, 1]).triangles
    a, b, c = (np.linalg.norm(x[triangles[:, k]] - x[triangles[:, k - 1]], axis=1) for k in range(3))
    half = (a + b + c) / 2
    area = np.sqrt(np.maximum(half * (half - a) * (half - b) * (half - c), 1e-300))
    triangles = triangles[a * b * c / (4 * area) < HOLE * dx]
    edges = np.unique(np.sort(np.vstack([triangles[:, [k, k - 1]] for k in range(3)]), axis=1), axis=0)
    used = np.unique(triangles)
    root = np.arange(len(x))
    while True:  # each edge gives both ends the smaller number, until nothing changes
        before = root.copy()
        least = np.minimum(root[edges[:, 0]], root[edges[:, 1]])
        for k in range(2):
            np.minimum.at(root, edges[:, k], least)
        root = root[root]
        if np.array_equal(root, before):
            break
    parts = len(np.unique(root[used]))
    return parts, parts - (len(used) - len(edges) + len(triangles)), len(x) - len(used)


def clumps(x, dx):
    """Returns the share of particles with another within CLOSE dx."""
    square = ((x[:, None, :] - x[None, :, :])**2).sum(axis=2)
    np.fill_diagonal(square, np.inf)
    return np.mean(square.min(axis=1) < (CLOSE * dx)**2)


def style(axis, **labels):
    axis.set(**labels)
    axis.grid(alpha=0.3)


def draw_curves(path, exact, stretching, rotating):
    """Draws error of the semi-axis, pressure at the centre and angular momentum; stretching, rotating: {method: series}."""
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10, "legend.fontsize": 7, "legend.frameon": False})
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12.6, 3.8))
    middle.plot(exact["t"], exact["p"], color="black", lw=1, label="exact")
    for method, s in stretching.items():
        a = np.interp(s["t"], exact["t"], exact["a"])
        left.plot(s["t"], 100 * (s["a"] / a - 1), color=COLOURS[method], lw=1.2, label=method)
        middle.plot(s["t"], s["p"], color=COLOURS[method], lw=0.8, label=method)
    for method, s in rotating.items():
        right.plot(s["t"], s["L"] / s["L"][0], "--" if method == "CPH" else "-", color=COLOURS[method], lw=1.2, label=method,
                   zorder=3 if method == "CPH" else 2)
    style(left, xlabel="A0 t", ylabel="error of a [%]", title="stretching drop, semi-axis")
    style(middle, xlabel="A0 t", ylabel="p/(rho A0^2 R^2)", title="stretching drop, pressure at the centre")
    style(right, xlabel="omega t", ylabel="L/L0", title="rotating drop, angular momentum")
    low, high = middle.get_ylim()
    middle.set_ylim(max(low, -0.5), min(high, 1.0))
    for axis in left, middle, right:
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)


def draw_particles(path, rows, box, size):
    """Draws particles; rows: lists of (title, positions or None)."""
    plt.rcParams.update({"font.size": 8, "axes.titlesize": 8})
    columns = max(len(row) for row in rows)
    aspect = (box[3] - box[2]) / (box[1] - box[0])
    figure, grid = plt.subplots(len(rows), columns, figsize=(2.2 * columns, 2.2 * aspect * len(rows) + 0.3), squeeze=False)
    for axes, row in zip(grid, rows):
        for axis in axes[len(row):]:
            axis.axis("off")
        for axis, (title, x) in zip(axes, row):
            if x is None:
                axis.text(0.5, 0.5, "lost", ha="center", transform=axis.transAxes)
            else:
                axis.plot(x[:, 0], x[:, 1], "o", ms=size, mew=0, color="#0072B2")
            axis.set(title=title, xlim=box[:2], ylim=box[2:], aspect="equal", xticks=[], yticks=[])
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)
