"""The folding of a thin viscous sheet on a belt: a reference for jets that needs no particles. Lengths and times in D and D/U.

The sheet is a chain of material segments with the width h. It resists stretching with the force 4 nu h dv/ds and bending with the moment
nu h^3/3 d^2(theta)/ds dt (Ribe, Phys. Rev. E 68 (2003) 036305). Each step is implicit in the velocities of the nodes. A node that comes
within D/2 of the belt has its speed from then on; parts of the sheet do not touch each other.
"""
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu


class Sheet:
    """A sheet that leaves a slit at a height with the speed 1."""

    def __init__(self, height, nu, force, belt, segment=0.25, step=0.02):
        self.height, self.nu, self.force, self.belt, self.segment, self.step = height, nu, force, belt, segment, step
        n = round(1 / segment)
        y = height - segment * np.arange(n, -1.0, -1.0)
        self.x = np.stack([1e-3 * np.linspace(1, 0, n + 1), y], 1)  # slightly off the axis
        self.u = np.tile([0.0, -1.0], (n + 1, 1))
        self.area, self.held = np.full(n, segment), np.arange(n + 1) == n

    def forms(self):
        """Yields indices, vectors c and strengths of the terms strength (c.u)^2/2 of the dissipation: of stretching, of bending at
        inner nodes, and of bending at the slit, whose direction is fixed."""
        edge = np.diff(self.x, axis=0)
        length = np.linalg.norm(edge, axis=1)
        along = edge / length[:, None]
        turn = np.stack([-along[:, 1], along[:, 0]], 1) / length[:, None]  # rate of the angle of a segment
        width, first = self.area / length, 2 * np.arange(len(self.x))
        yield first[:-1, None] + np.arange(4), np.hstack([-along, along]), 4 * self.nu * width / length
        stiff = self.nu * (0.5 * (width[1:] + width[:-1])) ** 3 / 3 / (0.5 * (length[1:] + length[:-1]))
        yield first[:-2, None] + np.arange(6), np.hstack([turn[:-1], -turn[:-1] - turn[1:], turn[1:]]), stiff
        yield first[-2:-1, None] + np.arange(4), np.hstack([-turn[-1:], turn[-1:]]), self.nu * width[-1:] ** 3 / 3 / (length[-1:] / 2)

    def velocity(self):
        """Returns the velocities after a step."""
        n = len(self.x)
        mass = np.zeros(n)
        mass[:-1] += self.area / 2
        mass[1:] += self.area / 2
        inertia = np.repeat(mass, 2) / self.step
        row, column, value = [np.arange(2 * n)], [np.arange(2 * n)], [inertia]
        for index, c, strength in self.forms():
            row.append(np.repeat(index, index.shape[1], 1).ravel())
            column.append(np.tile(index, (1, index.shape[1])).ravel())
            value.append((strength[:, None, None] * c[:, :, None] * c[:, None, :]).ravel())
        matrix = coo_matrix((np.concatenate(value), (np.concatenate(row), np.concatenate(column)))).tocsr()
        right = inertia * self.u.ravel()
        right[1::2] -= self.force * mass
        u = np.where(self.held[:, None], [self.belt, 0.0], 0.0)
        u[-1] = [0.0, -1.0]
        free = np.repeat(~self.held, 2)
        right -= matrix @ u.ravel()
        u = u.ravel()
        u[free] = splu(matrix[free][:, free].tocsc()).solve(right[free])
        return u.reshape(n, 2)

    def advance(self):
        """Advances by a step, lets nodes land and enter, and forgets most landed ones."""
        self.u = self.velocity()
        self.x = self.x + self.step * self.u
        landed = np.flatnonzero(~self.held & (self.x[:, 1] <= 0.5))
        if len(landed):
            self.held[: landed[-1] + 1] = True
        if self.x[-1, 1] <= self.height - self.segment:
            self.held[-1] = False
            self.x = np.vstack([self.x, [0.0, self.x[-1, 1] + self.segment]])
            self.u = np.vstack([self.u, [0.0, -1.0]])
            self.area, self.held = np.append(self.area, self.segment), np.append(self.held, True)
        drop = max(np.count_nonzero(self.held[:-1]) - 40, 0)
        self.x, self.u, self.area, self.held = self.x[drop:], self.u[drop:], self.area[drop:], self.held[drop:]

    def place(self, level):
        """Returns the mean place at which the sheet crosses a level, NaN if it does not."""
        y = self.x[:, 1]
        k = np.flatnonzero((y[:-1] < level) != (y[1:] < level))
        return np.mean(self.x[k, 0] + (level - y[k]) / (y[k + 1] - y[k]) * (self.x[k + 1, 0] - self.x[k, 0])) if len(k) else np.nan


def places(height, nu, force, belt, level, end):
    """Returns times and places of a sheet at a level, every half time unit, once it has landed."""
    sheet, found, every = Sheet(height, nu, force, belt), [], 25
    for k in range(1, round(end / sheet.step) + 1):
        sheet.advance()
        if k % every == 0 and k * sheet.step > height + 2:
            found.append((k * sheet.step, sheet.place(level)))
    return np.array(found)
