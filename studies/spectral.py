"""Pseudo-spectral solution of the Navier-Stokes equations in the periodic unit square, for references.

The vorticity w = dv/dx - du/dy obeys dw/dt + u.grad w = nu lap w. The viscous term is integrated exactly (factor
exp(-nu k^2 t)), the rest by the classical Runge-Kutta method, with the convolution dealiased by the 2/3 rule. The mean
velocity does not change.
"""
import math

import numpy as np


class Grid:
    """Holds wave numbers of n x n points, y along the first axis and x along the second."""

    def __init__(self, n):
        self.n = n
        x = np.arange(n) / n
        self.x, self.y = np.meshgrid(x, x)
        self.kx = 2 * np.pi * np.fft.rfftfreq(n, 1 / n)[None, :]
        self.ky = 2 * np.pi * np.fft.fftfreq(n, 1 / n)[:, None]
        self.square = self.kx**2 + self.ky**2
        self.inverse = 1 / np.where(self.square == 0, 1, self.square)
        most = 2 * np.pi * (n // 3)
        self.kept = (np.abs(self.kx) <= most) & (np.abs(self.ky) <= most)

    def velocity(self, vorticity, mean):
        """Returns the transform of the velocity of a vorticity: lap psi = -w, u = (d psi/dy, -d psi/dx) + mean."""
        stream = vorticity * self.inverse
        u, v = 1j * self.ky * stream, -1j * self.kx * stream
        u[0, 0], v[0, 0] = (component * self.n**2 for component in mean)
        return u, v

    def convection(self, vorticity, mean):
        """Returns the transform of -u.grad w."""
        u, v, along, across = (np.fft.irfft2(part, (self.n, self.n)) for part in
                               (*self.velocity(vorticity, mean), 1j * self.kx * vorticity, 1j * self.ky * vorticity))
        return np.where(self.kept, -np.fft.rfft2(u * along + v * across), 0)


class Field:
    """Velocity at the end of solve(), as a Fourier series."""

    def __init__(self, grid, u, v):
        self.grid, self.u, self.v = grid, u, v

    def at(self, x, y, chunk=4096):
        """Returns the velocity at points, by summation of the whole series."""
        x, y = np.ravel(x), np.ravel(y)
        weight = np.full(self.grid.kx.shape, 2.0)  # a wave along x and its conjugate
        weight[0, 0] = 1
        if self.grid.n % 2 == 0:
            weight[0, -1] = 1
        found = np.empty((2, len(x)))
        for first in range(0, len(x), chunk):
            part = slice(first, first + chunk)
            east = np.exp(1j * x[part, None] * self.grid.kx) * weight
            north = np.exp(1j * y[part, None] * self.grid.ky.T)
            for row, series in zip(found, (self.u, self.v)):
                row[part] = np.sum((north @ series) * east, axis=1).real / self.grid.n**2
        return found


def solve(velocity, nu, t_end, n, courant=0.4):
    """Advances velocity(x, y) to t_end on n x n points and returns the Field."""
    grid = Grid(n)
    start = [np.broadcast_to(component, (n, n)) for component in velocity(grid.x, grid.y)]
    mean = [component.mean() for component in start]
    steps = max(1, math.ceil(t_end * n * max(np.hypot(*start).max(), 1e-30) / courant))
    dt = t_end / steps
    u, v = (np.fft.rfft2(component) for component in start)
    w = np.where(grid.kept, 1j * grid.kx * v - 1j * grid.ky * u, 0)
    half = np.exp(-0.5 * dt * nu * grid.square)
    for _ in range(steps):
        a = dt * grid.convection(w, mean)
        b = dt * grid.convection(half * (w + 0.5 * a), mean)
        c = dt * grid.convection(half * w + 0.5 * b, mean)
        d = dt * grid.convection(half * (half * w + c), mean)
        w = half * (half * (w + a / 6) + (b + c) / 3) + d / 6
    return Field(grid, *grid.velocity(w, mean))


def taylor_green(x, y):
    """Returns the velocity of the vortices of Taylor & Green at the start, as in cases/taylor_green.c."""
    return np.sin(2 * np.pi * x) * np.cos(2 * np.pi * y), -np.cos(2 * np.pi * x) * np.sin(2 * np.pi * y)


def double_shear(x, y, steepness=30):
    """Returns the velocity of two shear layers at the start (Brown & Minion, J. Comput. Phys. 122 (1995) 165-183)."""
    return np.tanh(steepness * np.where(y < 0.5, y - 0.25, 0.75 - y)), 0.05 * np.sin(2 * np.pi * (x + 0.25))
