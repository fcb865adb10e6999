"""The exact flow of mode 2 of a viscous drop without surface tension (docs/developers/theory.md, (surface:mode)), for the drivers of other codes.

Radius, density and kinematic viscosity are 1. The drop is round, and the largest radial velocity of its border at t = 0 is SPEED.
"""
import numpy as np

RATE = 5.54079  # nu/R^2, of the velocity
SPEED = 0.01  # nu/R: the border moves by 0.0018 R
TIMES = (0.05, 0.1)  # R^2/nu


def series(order, z):
    """Returns J_order(k)/(k/2)^order for z = k^2, an array."""
    term = np.full_like(z, 1 / np.prod(np.arange(1, order + 1)))
    total = term.copy()
    for i in range(1, 30):
        term = -0.25 * z * term / (i * (i + order))
        total += term
    return total


def velocity(x, y, t):
    """Returns both components at places in the disc: psi = F sin(2 theta) exp(-RATE t), F = r^2 (a + b g(RATE r^2))."""
    r2 = x * x + y * y
    border = np.array([RATE])
    g, both_slopes = series(2, border), series(2, border) - series(3, border)  # g and g + 4 dg/dz at r = 1
    b = 2 * SPEED / (RATE * both_slopes)
    a = b * (0.25 * RATE * both_slopes - g)  # no tangential stress at r = 1
    both = a + b * series(2, RATE * r2)  # F/r^2
    rest = -0.25 * b * RATE * r2 * series(3, RATE * r2)  # r/2 times the slope of F/r^2
    ratio = np.divide(x * x - y * y, r2, out=np.zeros_like(r2), where=r2 > 0)  # cos(2 theta)
    decay = 2 * np.exp(-RATE * t)
    return decay * x * (both + rest * (1 - ratio)), -decay * y * (both + rest * (1 + ratio))
