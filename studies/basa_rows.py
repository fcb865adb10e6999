"""Model B of Basa, Quinlan & Lastiwka (2009), Eq. (29), in start-up of Poiseuille flow on a lattice that keeps its rows: a
linear system of as many velocities as rows, for readings of the walls that studies/basa_poiseuille does not run. nu = 1,
the width is 1, and the force is 8, so that the final velocity is 1."""
import numpy as np

H_DX = 1.56986  # h/dx of section 6
REACH = 4  # rows that the kernel reaches [-]
FORCE = 8.0
READINGS = {  # name: velocities behind walls, stress behind walls, share of (wcsph:wall) along the wall
    "line through wall and each particle; stress continued by its slope": ("each", "slope", 0.0),
    "the same, and the wall pressure balances the force too (before)": ("each", "slope", 1.0),
    "line through wall and each particle; stress of the particle": ("each", "own", 0.0),
    "line through wall and nearest row; stress by the first pass": ("line", "pass", 0.0),
    "parabola through wall and two nearest rows; stress by the first pass": ("parabola", "pass", 0.0),
    "mirror images; stress by the first pass": ("mirror", "pass", 0.0),
}


def slope(q):
    """Returns -W' h^3 of the cubic spline in two dimensions."""
    return 10 / (7 * np.pi) * (3 * q - 2.25 * q * q if q < 1 else 0.75 * max(2 - q, 0)**2)


def weights(dx):
    """Returns by row the sums of V grad_i W across the rows, and of V |W'|/r X^2 along them."""
    across, along = {}, {}
    for j in range(-REACH, REACH + 1):
        pairs = [(i * dx, np.hypot(i, j) * dx) for i in range(-REACH, REACH + 1) if i or j]
        over = [(x, dx**2 * slope(r / (H_DX * dx)) / (H_DX * dx)**3 / r) for x, r in pairs]
        across[j], along[j] = sum(w for _, w in over) * j * dx, sum(w * x * x for x, w in over)
    return across, along


def exact(y, t):
    """Returns Eq. (36) with the series not multiplied by (y/d)^2."""
    k = 2 * np.arange(200) + 1
    series = (-1.0)**np.arange(200) / k**3 * np.cos(np.outer(y, k) * np.pi) * np.exp(-(k * np.pi)**2 * t)
    return 1 - 4 * y**2 - 32 / np.pi**3 * series.sum(axis=1)


def behind(u, kind, deep, dx):
    """Returns the velocity of row `deep` behind the wall at the start of u; the first row is dx/2 from it."""
    d = (deep + 0.5) * dx
    if kind == "mirror":
        return -u[deep]
    if kind == "line":
        return -u[0] * d / (0.5 * dx)
    a, b = np.linalg.solve(dx * np.array([[0.5, 0.25 * dx], [1.5, 2.25 * dx]]), u[:2])
    return -a * d + b * d * d


def each(u, across, dx):
    """Returns the stresses of the rows, with dummies on the line through the wall and the particle, Morris et al. (1997)."""
    n, stress = len(u), np.zeros(len(u))
    for i in range(n):
        for j, w in across.items():
            if 0 <= i + j < n:
                stress[i] += w * (u[i + j] - u[i])
            else:
                near, deep = (i + 0.5, -(i + j) - 0.5) if j < 0 else (n - i - 0.5, i + j - n + 0.5)
                stress[i] -= w * min(1 + deep / near, 10) * u[i]
    return stress


def second(stress, across, kind, dx):
    """Returns the forces of stresses, which continue behind the walls by their slope or as they are."""
    n, force = len(stress), np.zeros(len(stress))
    for i in range(n):
        inside = {j: w for j, w in across.items() if 0 <= i + j < n}
        rise = sum(w * (stress[i + j] - stress[i]) for j, w in inside.items())
        force[i] = rise
        if kind == "slope":
            moment = sum(w * j * dx for j, w in inside.items())
            force[i] += rise / moment * sum(w * j * dx for j, w in across.items() if j not in inside)
    return force


def rate(u, reading, across, along, dx):
    """Returns du/dt of the rows."""
    kind, stresses, share = READINGS[reading]
    n, lost = len(u), np.zeros(len(u))
    for i in range(n):
        lost[i] = share * FORCE * sum(w for j, w in along.items() if not 0 <= i + j < n)
    if kind == "each":
        return FORCE - lost + second(each(u, across, dx), across, stresses, dx)
    m = 2 * REACH
    full = np.concatenate([[behind(u, kind, k, dx) for k in reversed(range(m))], u,
                           [behind(u[::-1], kind, k, dx) for k in range(m)]])

    def gradient(f):
        return sum(w * np.roll(f, -j) for j, w in across.items())  # wrong at the ends, which the rows do not reach

    return FORCE - lost + gradient(gradient(full))[m:m + n]


def errors(reading, stars, n=20):
    """Returns the RMS errors, Eq. (38), of a reading at times t*."""
    dx = 1 / n
    y, (across, along) = (np.arange(n) + 0.5) * dx - 0.5, weights(dx)
    push = rate(np.zeros(n), reading, across, along, dx)
    matrix = np.array([rate(row, reading, across, along, dx) - push for row in np.eye(n)]).T
    growth, modes = np.linalg.eig(matrix)
    parts = np.linalg.solve(modes, push.astype(complex))
    for star in stars:
        t = star / np.pi**2
        small = np.abs(growth * t) < 1e-9
        grown = np.where(small, t, np.expm1(growth * t) / np.where(small, 1, growth))
        u = np.real(modes @ (grown * parts))
        yield float(np.sqrt(np.mean((u / exact(y, t) - 1)**2)))
