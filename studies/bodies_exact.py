"""Exact creeping flows about bodies beside a plane wall, and about an oscillating cylinder, for studies/bodies.

Each is given to isph as velocities of the sides of a box, so that the box need not be large."""
import math

import numpy as np

CYLINDER = {"towards": (-1j, 0), "along": (1, 0), "turning": (0, 1)}  # velocity and spin of the surface


def singular(z, place, sign):
    """Yields names, powers and velocities of singularities at `place`, a stokeslet, its pair and two of the source kind."""
    d = z - place
    for a in (1, 1j):
        yield ("S", sign, a), 2 * a * np.log(abs(d)) - z * np.conj(a) / np.conj(d)
        yield ("P", sign, a), a / d + z * np.conj(a) / np.conj(d) ** 2
        yield ("1", sign, a), -np.conj(a / d)
        yield ("2", sign, a), -np.conj(a / d ** 2)


def cylinder(h, kind):
    """Returns singularities and their factors of the flow about the cylinder of radius 1 about (0, h) beside the wall
    y = 0, by Goursat's functions u + iv = phi - z conj(phi') - conj(psi): finite sums at the foci +-i sqrt(h^2 - 1),
    whose factors meet the velocities on both surfaces to rounding. Also the largest error there and the load
    [mu U or mu U a]: the force along the motion, or the torque."""
    s = math.sqrt(h * h - 1)
    turn = (np.arange(400) + 0.5) * 2 * np.pi / 400
    z = np.concatenate([1j * h + np.exp(1j * turn), h * np.tan(turn / 2 - np.pi / 2)])
    u, spin = CYLINDER[kind]
    given = np.where(np.arange(800) < 400, u + spin * 1j * (z - 1j * h), 0)
    terms = [*singular(z, 1j * s, 1), *singular(z, -1j * s, -1), (("C", 0, 1), 1 + 0 * z), (("C", 0, 1j), 1j + 0 * z)]
    matrix = np.array([np.concatenate([column.real, column.imag]) for _, column in terms]).T
    right = np.concatenate([given.real, given.imag])
    factor = np.linalg.lstsq(matrix, right, rcond=None)[0]
    factors = {name: c for (name, _), c in zip(terms, factor)}
    load = 8 * math.pi * abs(factors["S", 1, 1] + 1j * factors["S", 1, 1j])
    if kind == "turning":  # the torque is that of the rotlet in psi, and of pairs
        load = abs(factors["1", 1, 1j]) * 4 * math.pi
    return s, factors, abs(matrix @ factor - right).max(), load


def cylinder_velocity(h, kind):
    """Returns the velocity of that flow as expressions of x and y."""
    s, factors, _, _ = cylinder(h, kind)
    u, v = [], []
    for (name, sign, a), c in factors.items():
        if abs(c) < 1e-11:
            continue
        y = f"(y-({sign * s:.12g}))"
        r = f"(x^2+{y}^2)"
        d2 = f"(x^2-{y}^2)", f"(2*x*{y})"
        if name == "C":
            re, im = ("1", "0") if a == 1 else ("0", "1")
        elif name == "S":
            re, im = f"(x^2-y*{y})/{r}", f"x*(y+{y})/{r}"  # z/conj(d), times conj(a)
            re, im = (f"log({r})-{re}", f"-{im}") if a == 1 else (f"-{im}", f"log({r})+{re}")
        elif name == "P":
            re, im = f"(x*{d2[0]}-y*{d2[1]})/{r}^2", f"(x*{d2[1]}+y*{d2[0]})/{r}^2"
            re, im = (f"x/{r}+{re}", f"-{y}/{r}+{im}") if a == 1 else (f"{y}/{r}+{im}", f"x/{r}-{re}")
        elif name == "1":
            re, im = (f"-x/{r}", f"-{y}/{r}") if a == 1 else (f"-{y}/{r}", f"x/{r}")
        else:
            re, im = (f"-{d2[0]}/{r}^2", f"-{d2[1]}/{r}^2") if a == 1 else (f"-{d2[1]}/{r}^2", f"{d2[0]}/{r}^2")
        u.append(f"({c:.12g})*({re})")
        v.append(f"({c:.12g})*({im})")
    return "+".join(u), "+".join(v)


def stokeslet(x, y, z, at):
    """Returns the velocity G_ij along i of a force along j at a point beside the wall z = 0, times 8 pi mu: J. R. Blake,
    Proc. Camb. Phil. Soc. 70 (1971) 303."""
    h = at[2]
    r, image = np.array([x - at[0], y - at[1], z - h]), np.array([x - at[0], y - at[1], z + h])
    length, far = np.sqrt((r ** 2).sum(0)), np.sqrt((image ** 2).sum(0))
    g = np.zeros((3, 3, *length.shape))
    for i in range(3):
        for j in range(3):
            same, up = float(i == j), float(i == 2)
            pair = -up * image[j] / far ** 3 + (same * image[2] + (image[i] if j == 2 else 0)) / far ** 3 - 3 * image[i] * image[2] * image[j] / far ** 5
            g[i, j] = same / length + r[i] * r[j] / length ** 3 - same / far - image[i] * image[j] / far ** 3
            g[i, j] += 2 * h * (1 if j < 2 else -1) * (h * (same / far ** 3 - 3 * image[i] * image[j] / far ** 5) - pair)
    return g


class Ball:
    """The flow about the ball of radius 1 about (0, 0, h) that moves along -z towards the wall z = 0: rings of
    stokeslets of the wall on a ball inside it, coaxal with both, whose strengths meet the velocity on the ball.
    `drag` is that over 6 pi mu, `error` the largest of the velocity there."""

    def __init__(self, h, rings=28, around=96):
        focus, way = math.sqrt(h * h - 1), 1.6 * math.acosh(h) + 0.18
        radius, height, turn = focus / math.sinh(way), focus / math.tanh(way), (np.arange(rings) + 0.5) / rings * np.pi
        self.rings = [(radius * math.sin(t), height + radius * math.cos(t)) for t in turn]
        self.around = 2 * np.pi * np.arange(around) / around
        turn = (np.arange(120) + 0.5) / 120 * np.pi
        columns = self.columns(np.sin(turn), 0 * turn, h + np.cos(turn))
        matrix, given = np.concatenate([columns[:, 0], columns[:, 2]], axis=1).T, np.concatenate([0 * turn, -1 + 0 * turn])
        self.strength = np.linalg.lstsq(matrix, given, rcond=1e-14)[0]
        self.error, self.drag = abs(matrix @ self.strength - given).max(), -8 / 6 * self.strength[1::2].sum()

    def columns(self, x, y, z):
        """Returns the velocities of the rings, of radial forces and of those along z."""
        found = []
        for r, height in self.rings:
            both = 0
            for angle in self.around:
                g = stokeslet(x, y, z, (r * math.cos(angle), r * math.sin(angle), height))
                both = both + np.array([g[:, 0] * math.cos(angle) + g[:, 1] * math.sin(angle), g[:, 2]])
            found += [*(both / len(self.around))]
        return np.array(found)

    def velocity(self, x, y, z):
        """Returns the velocity at points."""
        return np.tensordot(self.strength, self.columns(x, y, z), 1)


def nested(row, variable):
    """Returns a polynomial as nested products."""
    text = f"{row[-1]:.7g}"
    for c in row[-2::-1]:
        text = f"({c:.7g}+{variable}*{text})"
    return text


def ball_sides(ball, w, top):
    """Returns the velocities on the sides of the box from (-w, -w, 0) to (w, w, top) as polynomials, which meet them to
    0.3 % of the speed of the ball."""
    g = np.cos((np.arange(24) + 0.5) / 24 * np.pi)
    across, z = (a.ravel() for a in np.meshgrid(g, (g + 1) / 2))
    u, text = ball.velocity(w + 0 * across, w * across, top * z), {}

    def fit(value, factor):
        powers = np.array([factor * across ** (2 * i) * z ** j for i in range(4) for j in range(8)]).T
        return np.linalg.lstsq(powers, value, rcond=None)[0].reshape(4, 8)

    fits = fit(u[0], z), fit(u[1], z * across), fit(u[2], z)
    for side, sign, t in ("right", "", "y"), ("left", "0-", "y"), ("top", "", "x"), ("bottom", "0-", "x"):
        polynomial = []
        for c in fits:
            inner = nested(c[-1], f"(z/{top})")
            for row in c[-2::-1]:
                inner = f"({nested(row, f'(z/{top})')}+({t}/{w})^2*{inner})"
            polynomial.append(f"z/{top}*{inner}")
        out, along = f"{sign}{polynomial[0]}", f"{t}/{w}*{polynomial[1]}"
        text[side] = ",".join((out, along, polynomial[2]) if t == "y" else (along, out, polynomial[2]))
    x, y = (w * a.ravel() for a in np.meshgrid(g, g))
    u, square = ball.velocity(x, y, top + 0 * x), (x * x + y * y) / w ** 2
    powers = np.array([square ** i for i in range(8)]).T
    radial, axial = (nested(np.linalg.lstsq(powers, value, rcond=None)[0], f"((x^2+y^2)/{w * w})") for value in (u[0] * w / x, u[2]))
    text["front"] = f"x/{w}*{radial},y/{w}*{radial},{axial}"
    return text


def oscillating(beta):
    """Returns the factor B of the dipole far from a cylinder of radius 1 with the velocity cos(2 pi t) in a fluid of
    beta = D^2 f/nu, and G of the force -pi rho a^2 dU/dt G: G. G. Stokes (1851). Both are complex."""
    from scipy.special import kv
    wave = np.sqrt(0.5j * np.pi * beta)
    return kv(2, wave) / kv(0, wave), 1 + 4 * kv(1, wave) / (wave * kv(0, wave))
