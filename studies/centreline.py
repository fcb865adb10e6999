"""Velocity on the centrelines of the cavity, from cells or particles, and its errors as in reports of `isph`: the
root mean square difference from a reference profile, and extrema refined by a parabola (cases/centreline.c)."""
import os

import numpy as np

HERE = os.path.dirname(os.path.realpath(__file__))
SOURCE, INSTALLED = os.path.join(HERE, "..", "cases", "reference"), os.path.join(HERE, "..", "reference")
REFERENCE = os.environ.get("ISPH_DATA") or (SOURCE if os.path.isdir(SOURCE) else INSTALLED)
FINE = np.linspace(0, 1, 401)  # sampling points of extrema
EXTREMA = {"u_min": ("u", -1), "v_max": ("v", 1), "v_min": ("v", -1)}


def read_columns(path):
    """Returns the first two columns of a CSV file with '#' comments and a header line."""
    with open(path) as file:
        rows = [line for line in file if line.strip() and not line.startswith("#")]
    return np.array([[float(word) for word in row.split(",")[:2]] for row in rows[1:]]).T


def extremum(values, sign):
    """Returns the extremum of samples, refined by the parabola through it and its neighbours."""
    best = 1 + np.argmax(sign * values[1:-1])
    slope = 0.5 * (values[best + 1] - values[best - 1])
    bend = values[best + 1] - 2 * values[best] + values[best - 1]
    return values[best] - 0.5 * slope**2 / bend if sign * bend < 0 else values[best]


def extrema_errors(values, reference):
    """Returns relative errors of extrema by name against reference profiles (file names without _u.csv, _v.csv)."""
    exact = {name: extremum(read_columns(os.path.join(REFERENCE, f"{reference}_{component}.csv"))[1], sign)
             for name, (component, sign) in EXTREMA.items()}
    return {f"{name}_error": abs(values[name] - exact[name]) / abs(exact[name]) for name in EXTREMA}


def judge(line, reference):
    """Returns all quantities of a flow; line(component, s) samples u(0.5, s) or v(s, 0.5)."""
    found = {name: extremum(line(component, FINE), sign) for name, (component, sign) in EXTREMA.items()}
    found.update(extrema_errors(found, reference))
    for component in "uv":
        s, exact = read_columns(os.path.join(REFERENCE, f"{reference}_{component}.csv"))
        found[f"{component}_profile_l2"] = np.sqrt(np.mean((line(component, s) - exact) ** 2))
    return found


def cubic(nodes, values, s):
    """Interpolates by the cubic through the four nodes around each s (Lagrange's form); exact for cubics."""
    first = np.clip(np.searchsorted(nodes, s) - 2, 0, len(nodes) - 4)
    result = np.zeros_like(s)
    for k in range(4):
        weight = np.ones_like(s)
        for m in range(4):
            if m != k:
                weight *= (s - nodes[first + m]) / (nodes[first + k] - nodes[first + m])
        result += weight * values[first + k]
    return result


def of_cells(u, v):
    """Returns line() of a field on square cells, u[j, i] in column i and row j; walls at rest, the lid at 1."""
    n = len(u)
    centres = (np.arange(n) + 0.5) / n
    nodes = np.concatenate([[0], centres, [1]])
    middle = np.array([0.5])
    u_line = [cubic(centres, row, middle)[0] for row in u]
    v_line = [cubic(centres, column, middle)[0] for column in v.T]
    profiles = {"u": np.concatenate([[0], u_line, [1]]), "v": np.concatenate([[0], v_line, [0]])}
    return lambda component, s: cubic(nodes, profiles[component], s)


def of_particles(x, y, u, v, dx):
    """Returns line() of particles: quadratic least-squares fits about each point, as in probes of isph, with points
    on the walls that have the wall velocity."""
    wall = (np.arange(round(1 / dx)) + 0.5) * dx
    zero, one = np.zeros_like(wall), np.ones_like(wall)
    x = np.concatenate([x, wall, wall, zero, one])
    y = np.concatenate([y, zero, one, wall, wall])
    fields = {"u": np.concatenate([u, zero, one, zero, zero]), "v": np.concatenate([v, *[zero] * 4])}

    def fit(place, values):
        reach = 2.6 * dx
        while True:
            q = np.hypot(x - place[0], y - place[1]) / reach
            near = q < 1
            if near.sum() >= 12:
                break
            reach *= 1.2
        X, Y, q = (x[near] - place[0]) / reach, (y[near] - place[1]) / reach, q[near]
        root = np.sqrt((1 - q) ** 4 * (1 + 4 * q))  # square root of the Wendland C2 kernel
        basis = np.array([np.ones_like(X), X, Y, X * X, X * Y, Y * Y])
        return np.linalg.lstsq((basis * root).T, values[near] * root, rcond=None)[0][0]

    def line(component, s):
        places = [(0.5, a) if component == "u" else (a, 0.5) for a in s]
        return np.array([fit(place, fields[component]) for place in places])
    return line
