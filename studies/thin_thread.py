"""Steady coiling of a thin viscous thread on a floor: a reference for threads that needs no particles.

The thread leaves a hole of radius a at the height h above the floor with the speed u, straight down. It resists stretching with the force
N.t = 3 nu A U' and bending and twisting with the moment M = nu I (3 w'_across + 2 w'_along), I = A^2/(4 pi), by density, where t is the tangent,
U the speed along it, A the section and w the rate at which sections turn; M' = -t x N, N' = A (g + acceleration). In the frame that turns with the
coil the shape is at rest. The thread has no velocity and does not turn at the height 0, on which its axis lands (Ribe, Proc. R. Soc. Lond. A 460 (2004)
3223-3239). Without weight and inertia, and for a/h to zero, the rate is 4.00 u/h and the radius 0.250 h.
"""
import numpy as np
from scipy.integrate import solve_bvp

UP = np.array([[0.0], [0.0], [1.0]])
NODES = 61  # of the first guess
PART = 0.2  # first part of the way from one thread to another


def across(a, b):
    return np.cross(np.broadcast_to(a, b.shape), b, axis=0)


class Thread:
    """A thread with the slenderness a/h, the weight g h^2/(nu u) and the inertia u h/nu; lengths in h, times in h/u."""

    def __init__(self, slenderness, weight, inertia):
        self.slenderness, self.weight, self.inertia = slenderness, weight, inertia
        self.moment = np.pi * slenderness**4 / 4  # unit of the moments and forces [nu u h, nu u h^2]

    def rates(self, _, y, p):
        """Returns the derivatives of place, velocity, turning rate, moment and force along the thread."""
        rate, length = p
        x, v, w, m, n = (y[3 * k:3 * k + 3] for k in range(5))
        along = v - rate * across(UP, x)
        speed = np.sqrt((along**2).sum(0))
        t = along / speed
        area = np.pi * self.slenderness**2 / speed
        stretch = (n * t).sum(0) * self.moment / (3 * area)
        turn, twist, beside = across(w, t), (m * t).sum(0) * t, across(UP, t)
        acceleration = speed * (stretch * t + turn + rate * beside) + rate**2 * across(UP, across(UP, x))
        return length * np.vstack([t, stretch * t + turn, ((m - twist) / 3 + twist / 2) * self.moment * 4 * np.pi / area**2, -across(t, n),
                                   area * (self.weight * UP + self.inertia * acceleration) / self.moment])

    @staticmethod
    def ends(above, below, _):
        """Returns the residuals of the conditions at the hole and on the floor."""
        return np.concatenate([above[0:3] - UP[:, 0], above[3:6] + UP[:, 0], above[6:9], below[3:9], below[1:3]])

    def solve(self, guess):
        return solve_bvp(self.rates, self.ends, *guess, tol=1e-4, max_nodes=4000)

    @staticmethod
    def guess(coil):
        """Returns places, functions and parameters of a curve that lands on a circle of the radius `coil`."""
        q = np.linspace(0, 1, 401)[:, None]
        top, foot = UP[:, 0], np.array([coil, 0, 0])
        curve = (1 - q)**3 * top + 3 * (1 - q)**2 * q * 0.45 * top + 3 * (1 - q) * q**2 * (foot + [0, 1.6 * coil, 0]) + q**3 * foot
        s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
        xi = np.linspace(0, 1, NODES)
        x = np.array([np.interp(xi * s[-1], s, curve[:, k]) for k in range(3)])

        def slope(f):
            return np.gradient(f, xi * s[-1], axis=1, edge_order=2)

        t = slope(x) / np.linalg.norm(slope(x), axis=0)
        w = across(t, slope(t) + across(UP, t) / coil)
        twist = (slope(w) * t).sum(0) * t
        m = 3 * slope(w) - twist
        turns = np.array([[0 * t[0], t[2], -t[1]], [-t[2], 0 * t[0], t[0]], [t[1], -t[0], 0 * t[0]]])  # -t x
        inner = slice(5, -5)
        n = np.linalg.lstsq(turns[:, :, inner].transpose(2, 0, 1).reshape(-1, 3), slope(m)[:, inner].T.ravel(), rcond=None)[0]
        return xi, np.vstack([x, t + across(UP, x) / coil, w, m, n[:, None] * np.ones_like(x)]), np.array([1 / coil, s[-1]])


def coiling(slenderness, weight=0.0, inertia=0.0):
    """Returns the rate [u/h] and the radius [h] of the coil, of the branch that begins without weight and inertia."""
    start, end = np.array([0.1, 0.0, 0.0]), np.array([slenderness, weight, inertia])
    found, done, part = Thread(*start).solve(Thread.guess(0.3)), 0.0, PART
    while done < 1:
        part = min(part, 1 - done)
        further = Thread(*(start + (done + part) * (end - start))).solve((found.x, found.y, found.p))
        if further.status or abs(further.p[0] / found.p[0] - 1) > 0.5:
            part /= 2
            if part < 1e-4:
                raise SystemExit("thin_thread: no steady coil found")
        else:
            found, done, part = further, done + part, 1.5 * part
    return found.p[0], found.y[0, -1]
