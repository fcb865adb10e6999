"""Exact solutions of flows whose viscosity varies, for studies/viscosity: each returns a Solution with nu = 1 outside
inclusions, L = 1 and the plane stress divided by the density.

A flow whose stress is known from balance alone needs the rate g(tau, s) of the fluid there only: between cylinders
tau = T/(2 pi r^2), r d omega/dr = -g; between plates tau = f (1/2 - y), du/dy = g."""
import functools
import math

import numpy as np

INNER, OUTER, RATE = 0.25, 0.5, 1.0  # of the turning cylinders: radii, rate of the inner one
RADIUS = 0.2  # of the drop in a strain
FINE = 4001  # points of a quadrature
BETWEEN = 0.375  # radius of the interface of two turning fluids


class Solution:
    """`fields(x, y)`: velocity (2, N) and pressure (N), or None where it is not compared; `depth(x, y)`: distance from the interface, positive inside the
    inclusion; `values`: forces, torques and other numbers; `arguments`: options of isph that belong to the
    parameters; flows with a thin fluid, which are long on their way, start from the solution."""

    def __init__(self, fields, arguments="", depth=None, values=None):
        self.fields, self.arguments, self.depth, self.values = fields, arguments, depth, values or {}


def rate_power(n):
    """Returns the strain rate of a power law with K = 1 at a stress."""
    return lambda tau, _: np.sign(tau) * np.abs(tau)**(1 / n)


def rate_bingham(stress):
    return lambda tau, _: np.sign(tau) * np.maximum(np.abs(tau) - stress, 0.0)


def rate_carreau(n, time):
    """Returns the rate by bisection; the stress increases with the rate if n > 0."""
    def rate(tau, _):
        size = np.abs(tau)
        low, high = np.zeros_like(size), np.maximum(size, size**(1 / n) * time**((1 - n) / n)) * 2 + 1e-30
        for _ in range(80):
            middle = 0.5 * (low + high)
            above = (1 + (time * middle)**2)**((n - 1) / 2) * middle > size
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return np.sign(tau) * middle
    return rate


def rate_field(k):
    """Returns the rate where nu = (r/INNER)^k."""
    return lambda tau, r: tau / (r / INNER)**k


def rate_layers(ratio, border):
    """Returns the rate of a fluid with the viscosity `ratio` below `border`, and 1 above."""
    return lambda tau, s: np.where(s < border, tau / ratio, tau)


def cumulated(values, s):
    """Returns the integral of values from the first point of s to each, by the trapezium rule."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(s))])


def bisect(function, low, high):
    """Returns the root of an increasing function of a positive argument, by bisection of its logarithm."""
    for _ in range(100):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if function(middle) < 0 else (low, middle)
    return math.sqrt(low * high)


def turning(rate, arguments="", border=None):
    """Flow between cylinders whose inner one turns. Pressure is not compared: with inertia it has the centrifugal part."""
    parts = [INNER, border, OUTER] if border else [INNER, OUTER]
    r = np.concatenate([np.linspace(a, b, FINE)[(1 if k else 0):] for k, (a, b) in enumerate(zip(parts, parts[1:]))])

    def spin(torque):
        """Returns omega(r) - omega(OUTER); integrals of two fluids meet at the interface."""
        total, whole = 0.0, np.empty(0)
        for k, (a, b) in reversed(list(enumerate(zip(parts, parts[1:])))):
            s = np.linspace(a, b, FINE)
            inner = s.copy()
            inner[0], inner[-1] = a + 1e-12, b - 1e-12  # on its own side of an interface
            slope = rate(torque / (2 * np.pi * s**2), inner) / s
            part = total + cumulated(slope[::-1], -s[::-1])[::-1]
            total, whole = part[0], np.concatenate([part[(1 if k else 0):], whole])
        return whole

    torque = bisect(lambda value: spin(value)[0] - RATE, 1e-8, 1e8)
    omega = spin(torque)

    def fields(x, y):
        turn = np.interp(np.hypot(x, y), r, omega)
        return np.array([-turn * y, turn * x]), None

    return Solution(fields, arguments, (lambda x, y: border - np.hypot(x, y)) if border else None,
                    {"domain_torque": torque, "body_1_torque": -torque})


def channel(rate, arguments=""):
    """Flow between plates at rest, its mean velocity 1; adds the force that drives it and the thickness of the sheared layers."""
    y = np.linspace(0, 0.5, FINE)

    def profile(force):
        return cumulated(rate(force * (0.5 - y), y), y)

    force = bisect(lambda value: 2 * cumulated(profile(value), y)[-1] - 1, 1e-6, 1e8)
    u = profile(force)

    def fields(x, at):
        return np.array([np.interp(np.minimum(at, 1 - at), y, u), 0 * x]), None

    solution = Solution(fields, f"{arguments} -body_force {force:.12g},0", None, {})
    sheared = y[rate(force * (0.5 - y), y) <= 0]
    solution.sheared = float(sheared[0]) if len(sheared) else 0.5
    return solution


def couette(ratio, border=0.5):
    """Two layers between plates, the lower one `ratio` times as viscous; the upper plate moves."""
    stress = 1 / (border / ratio + (1 - border))

    def fields(x, y):
        return np.array([np.where(y < border, stress * y / ratio, 1 - stress * (1 - y)), 0 * x]), 0 * x

    start = f"y<{border:g}?{stress / ratio:.12g}*y:1-{stress:.12g}*(1-y),0"
    return Solution(fields, f"-scene_fluid_1 box,-1,-1,2,{border:g} -scene_fluid_1_viscosity {ratio:g} -scene_velocity \"{start}\"",
                    lambda x, y: border - y)


def drop(ratio, nu=1.0, radius=RADIUS):
    """A round drop in a strain of rate 1, u = (x, -y) far away, without inertia (G. I. Taylor, Proc. R. Soc. Lond. A 138 (1932)
    41-48, in a plane): psi = (r^2/2 + A + B/r^2) sin 2 theta outside, r^2/(ratio + 1) sin 2 theta inside,
    B = a^4 (ratio - 1)/(2 (ratio + 1)), A = -2 B/a^2: velocity and tangential stress are continuous, and the drop remains round
    for a moment only. p = 4 nu A cos 2 theta/r^2 outside and 0 inside. The sides of the box have this velocity."""
    b = (ratio - 1) / (2 * (ratio + 1))
    inner = 2 / (ratio + 1)
    two, four = 4 * b * radius**2, 2 * b * radius**4
    outside = (f"x*(1-{two:.12g}*(x^2-y^2)/(x^2+y^2)^2+{four:.12g}*(x^2-3*y^2)/(x^2+y^2)^3)",
               f"(-y)*(1-{two:.12g}*(y^2-x^2)/(x^2+y^2)^2+{four:.12g}*(y^2-3*x^2)/(x^2+y^2)^3)")
    start = f"x^2+y^2<{radius**2:g}?{inner:.12g}*x:{outside[0]},x^2+y^2<{radius**2:g}?{-inner:.12g}*y:{outside[1]}"
    sides = " ".join(f"-scene_wall_{side}_velocity \"{','.join(outside)}\"" for side in ("left", "right", "bottom", "top"))

    def fields(x, y):
        s, difference = x**2 + y**2, x**2 - y**2
        inside = s < radius**2
        s = np.maximum(s, 1e-12)
        u = np.where(inside, inner * x, x * (1 - two * difference / s**2 + four * (x**2 - 3 * y**2) / s**3))
        v = np.where(inside, -inner * y, -y * (1 + two * difference / s**2 + four * (y**2 - 3 * x**2) / s**3))
        return np.array([u, v]), np.where(inside, 0.0, -2 * nu * two * difference / s**2)

    return Solution(fields, f"-viscosity {nu:g} -scene_fluid_1 circle,0,0,{radius} -scene_fluid_1_viscosity {nu * ratio:g} {sides} "
                    f"-scene_velocity \"{start}\"", lambda x, y: radius - np.hypot(x, y))


@functools.lru_cache(maxsize=None)
def turning_named(kind, value):
    """Returns the flow between cylinders of a kind of fluid."""
    value = float(value)
    if kind == "newtonian":
        return turning(rate_power(1.0))
    if kind == "power":
        return turning(rate_power(value), f"-rheology power_law -rheology_exponent {value:g}")
    if kind == "bingham":
        return turning(rate_bingham(value), f"-rheology papanastasiou -rheology_yield {value:g}")
    if kind == "carreau":
        return turning(rate_carreau(value, 5), f"-rheology carreau -rheology_exponent {value:g} -rheology_time 5")
    if kind == "field":
        return turning(rate_field(value), f"-viscosity_field \"((x^2+y^2)/{INNER**2})^{value / 2:g}\"")
    solution = turning(rate_layers(value, BETWEEN), border=BETWEEN)
    own = solution.values["domain_torque"] / (4 * math.pi)  # omega is 1 - own/value (1/INNER^2 - 1/r^2) inside
    omega = f"(x^2+y^2<{BETWEEN**2}?{RATE - own / value / INNER**2:.12g}+{own / value:.12g}/(x^2+y^2):{own:.12g}*(1/(x^2+y^2)-{1 / OUTER**2:g}))"
    solution.arguments = (f"-scene_fluid_1 circle,0,0,{BETWEEN} -scene_fluid_1_viscosity {value:g} -scene_velocity \"(-y)*{omega},x*{omega}\"")
    return solution


@functools.lru_cache(maxsize=None)
def channel_named(kind, value):
    """Returns the flow between plates of a kind of fluid."""
    value = float(value)
    if kind == "power":
        return channel(rate_power(value), f"-rheology power_law -rheology_exponent {value:g}")
    if kind == "carreau":
        return channel(rate_carreau(value, 5), f"-rheology carreau -rheology_exponent {value:g} -rheology_time 5")
    return channel(rate_bingham(value), f"-rheology papanastasiou -rheology_yield {value:g}")


NAMED = {"turning": turning_named, "channel": channel_named, "couette": lambda ratio: couette(float(ratio)),
         "drop": lambda ratio, nu="1": drop(float(ratio), float(nu))}
