#!/usr/bin/env python3
"""Compares the viscous matrices of the forms of Basa et al. (2009) and Fang et al. (2009) with those of a code of
its own, which writes the published sums as dense matrices.

    viscousforms.py ISPH

The matrix of -visc_ksp_view_mat is s I - nu L on a disordered periodic box, with a shift s. So nu L plus this matrix
must be a multiple of the unit matrix. All sums are those of the papers, with differences of velocities in the
gradients of two passes, and without the term eta^2 added to r^2."""
import math
import subprocess
import sys

from interpreter import python_with

python_with("numpy")

import numpy as np  # noqa: E402 (after the interpreter)

from matrices import binary, places  # noqa: E402

NU, RATIO = 0.01, 1.3


class Cloud:
    """Kernel sums over all particles of a periodic box of unit length, for the kernel wendland_c2: W[i, j],
    slope[i, j, a] = V_j dW/dx_a at i, second[i, j, a, b], each with the particle itself."""

    def __init__(self, x, n):
        count, self.d = x.shape
        h, self.V = RATIO / n, 1.0 / n**self.d
        sigma = {2: 7 / (4 * math.pi), 3: 21 / (16 * math.pi)}[self.d] / h**self.d
        self.X = x[None, :, :] - x[:, None, :]
        self.X -= np.round(self.X)
        self.r = np.sqrt((self.X**2).sum(2))
        q = np.minimum(self.r / h, 2.0)
        far = 1 - q / 2
        self.r[np.arange(count), np.arange(count)] = 1.0  # the entries of the particle itself have X = 0
        self.W = self.V * sigma * far**4 * (2 * q + 1)
        first = self.V * sigma / h * -5 * q * far**3
        last = self.V * sigma / h**2 * -5 * far**2 * (1 - 2 * q)
        unit = np.eye(self.d)
        self.first = first
        self.slope = -self.X / self.r[..., None] * first[..., None]
        self.second = np.einsum("ij,ija,ijb->ijab", (last - first / self.r) / self.r**2, self.X, self.X)
        self.second += (first / self.r)[..., None, None] * unit
        self.second[np.arange(count), np.arange(count)] = last[0, 0] * unit

    def gradients(self, correction):
        """Returns the corrected gradients, Eqs (2), (22), (24) to (26) of Basa et al."""
        c = self.slope.copy()
        if correction in ("shepard", "mixed"):
            one, slope = self.W.sum(1)[:, None, None], self.slope.sum(1)[:, None, :]
            c = (self.slope * one - self.W[..., None] * slope) / one**2
        if correction in ("first_order", "mixed"):
            moment = np.einsum("ija,ijb->iab", c, self.X)
            c = np.einsum("iab,ijb->ija", np.linalg.inv(moment), c)
        return c

    def differences(self, weights):
        """Subtracts from the particle's own weight the sum of all weights."""
        out = weights.copy()
        for i in range(len(out)):
            out[i, i] -= weights[i].sum(0)
        return out

    def seconds(self, correction):
        """Returns second derivatives, Eqs (27) and (23) of Basa et al."""
        if correction == "none":
            return self.second
        one = self.W.sum(1)[:, None, None, None]
        slope, second = self.slope.sum(1)[:, None, :], self.second.sum(1)[:, None, :, :]
        mixed = np.einsum("ija,ikb->ijab", self.slope, slope)
        out = (self.second * one - mixed - mixed.swapaxes(2, 3) - self.W[..., None, None] * second) / one**2
        return out + 2 * self.W[..., None, None] * np.einsum("ika,ikb->ikab", slope, slope) / one**3


def of_hessian(second):
    """Returns lap u + 1/3 grad div u, Eq. (6) of Basa et al., as blocks [i, j, a, b]."""
    return np.einsum("ijcc,ab->ijab", second, np.eye(second.shape[2])) + second / 3


def radial(cloud, correction, factor):
    """Eqs (33) and (34) of Basa et al."""
    blocks = np.einsum("ija,ijb->ijab", cloud.gradients(correction), cloud.X) / cloud.r[..., None, None]**2
    return cloud.differences(factor * blocks)


def morris(cloud, correction):
    """Eq. (35) of Basa et al."""
    weight = 2 * np.einsum("ija,ija->ij", cloud.gradients(correction), cloud.X) / cloud.r**2
    return cloud.differences(weight[..., None, None] * np.eye(cloud.d))


def expected(cloud, form, correction):
    if form in ("violeau", "cleary"):
        return radial(cloud, correction, 2 * 4.24 if form == "cleary" else 2 * (cloud.d + 2))
    if form == "morris":
        return morris(cloud, correction)
    return of_hessian(cloud.seconds(correction))


def measured(isph, n, dim, form, correction):
    """Returns the positions, and the blocks [i, j, a, b] of the matrix of a run, rows and columns as in the snapshot."""
    command = [isph, "-case", "taylor_green", "-dim", str(dim), "-n", str(n), "-jitter", "0.25", "-motion", "eulerian",
               "-max_steps", "1", "-dt", "0.01", "-reynolds", "100", "-h_over_dx", str(RATIO), "-visc_laplacian", form,
               "-visc_ksp_view_mat", "binary:a.bin", "-output", "a.h5", "-progress", "none", "-visc_ts_type", "beuler"]
    command += ["-correction", correction] if correction != "none" else []
    command += ["-cleary_xi", "4.24"] if form == "cleary" else []
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    x = places("a_0000.h5")
    rows = binary("a.bin")
    blocks = np.zeros((len(rows), len(rows)))
    for k, row in enumerate(rows):
        blocks[k, list(row)] = list(row.values())
    if len(rows) == len(x):
        return x, blocks[:, :, None, None] * np.eye(dim)
    return x, blocks.reshape(len(x), dim, len(x), dim).swapaxes(1, 2)


def main():
    isph, wrong = sys.argv[1], 0
    every = "none", "shepard", "first_order", "mixed"
    forms = {"morris": every, "violeau": every, "cleary": every[:1], "direct": every[:2]}
    runs = [(dim, form, correction) for dim in (2, 3) for form in forms for correction in forms[form]
            if dim == 2 or form in ("violeau", "direct") and correction in every[:2]]
    for dim, form, correction in runs:
        n = 9 if dim == 2 else 6
        x, matrix = measured(isph, n, dim, form, correction)
        term = NU * expected(Cloud(x, n), form, correction)
        rest = (matrix + term).swapaxes(1, 2).reshape(len(x) * dim, -1)
        error = np.abs(rest - np.eye(len(rest)) * rest[0, 0]).max() / np.abs(term).max()
        good = error < 1e-12
        print(f"{dim}D {form} {correction}: {error:.1e}{'' if good else ' WRONG'}")
        wrong += not good
    sys.exit(wrong > 0)


main()
