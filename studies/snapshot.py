"""Reads snapshots of isph as fields for drawing: particles, and the part of the plane that is fluid."""
import functools
import sys

import h5py
import numpy as np
from matplotlib import patches, tri


class Body:
    """A body of the plane, or the section of a body in space across z."""

    def __init__(self, shape, numbers, around):
        self.around = around
        self.round = shape in ("circle", "cylinder", "ball", "ring")
        if self.round:
            self.centre, self.outer = numbers[:2], numbers[-1]
            self.inner = numbers[2] if shape == "ring" else -self.outer
        else:
            corners = numbers.reshape(-1, 2)
            self.corners = corners[(corners != np.roll(corners, 1, axis=0)).any(axis=1)]  # edges have a length

    def distance(self, x):
        """Returns the distance of points from the surface, positive in the fluid, and the nearest points of it."""
        if self.round:
            arm = x - self.centre
            r = np.maximum(np.linalg.norm(arm, axis=1), 1e-300)
            middle = (self.inner + self.outer) / 2
            distance = abs(r - middle) - (self.outer - middle)
            nearest = self.centre + arm * (np.where(r > middle, self.outer, self.inner) / r)[:, None]
        else:
            (across, up), nearest = np.ascontiguousarray(x.T), np.zeros_like(x.T)
            distance, inside = np.full(len(x), np.inf), np.zeros(len(x), bool)
            for a, b in zip(self.corners, np.roll(self.corners, -1, axis=0)):
                edge = b - a
                along = np.clip(((across - a[0]) * edge[0] + (up - a[1]) * edge[1]) / (edge @ edge), 0, 1)
                foot = a[0] + along * edge[0], a[1] + along * edge[1]
                square = (across - foot[0]) ** 2 + (up - foot[1]) ** 2
                np.copyto(nearest, foot, where=square < distance)
                distance = np.minimum(square, distance)
                if edge[1]:
                    inside ^= ((a[1] > up) != (b[1] > up)) & (across < a[0] + (up - a[1]) / edge[1] * edge[0])
            distance, nearest = distance**0.5, nearest.T
            distance = np.where(inside, -distance, distance)
        return (-distance if self.around else distance), nearest

    def patch(self, **style):
        if not self.round:
            return patches.Polygon(self.corners, **style)
        if self.inner > 0:
            return patches.Annulus(self.centre, self.outer, self.outer - self.inner, **style)
        return patches.Circle(self.centre, self.outer, **style)


SHORT = {"p": "pressure", "nu": "viscosity", "rho": "density"}  # names of fields in expressions of isph


class Snapshot:
    """Particles of a plane at a time, with an interpolant of their velocity and of a field: the speed, or a scalar."""

    def __init__(self, path, box=None, length="[m]", speed="[m/s]", field="speed"):
        try:
            with h5py.File(path, "r") as file:
                x, u = file["position"][:], file["velocity"][:]
                self.fluid = file["type"][:] == 0
                self.attributes = {name: plain(value) for name, value in file.attrs.items()}
                dx = float(self.attributes["dx"])
                size = file["volume"][:] ** (1 / x.shape[1]) if "volume" in file else np.full(len(x), dx)
                self.room_lo, self.room_hi = file.attrs["box"][:].reshape(2, -1)
                self.lo, self.hi = self.room_lo[:2].copy(), self.room_hi[:2].copy()
                self.free = bool(self.attributes["free_surface"])
                self.place, self.fluid_speed = x[self.fluid], np.linalg.norm(u[self.fluid], axis=1)
                self.label, values = f"speed |u| {speed}", None
                if field != "speed":
                    self.label, values = read_scalar(file, field, self.fluid, path)
                self.bodies, cut = self.read_bodies(file, x)
        except (OSError, KeyError) as error:
            sys.exit(f"plot: {path} is not a readable snapshot: {error}")
        self.path, self.length, self.speed = path, length, speed  # units on the axes
        self.time = float(self.attributes.get("time", 0))
        self.dim, self.dx = x.shape[1], dx
        self.radius = size[self.fluid] * (0.75 / np.pi) ** (1 / 3)  # of balls with the volume of the particles
        fluid = self.fluid
        if self.dim == 3:
            cut = cut if cut[fluid].any() else np.ones(len(x), bool)  # fluid that has not come to the middle
            fluid, x, u, size = fluid[cut], x[cut, :2], u[cut], size[cut]
        self.x, self.size = x[fluid], size[fluid]
        self.kinds = self.attributes["boundary_kinds"].split(",")[:4]
        for k in (k for k, kind in enumerate(self.kinds) if kind == "free"):  # a film leaves the box there
            axis = k // 2
            if k % 2:
                self.hi[axis] = max(self.hi[axis], self.x[:, axis].max() + 4 * dx)
            else:
                self.lo[axis] = min(self.lo[axis], self.x[:, axis].min() - 4 * dx)
        self.box = box or self.window()  # left, right, bottom, top

        # Wall particles count if they touch the fluid: layers behind them hold extrapolated values.
        margin = 0.75 * dx if box is None else 0.1 * dx
        lo, hi = (np.array(self.box[k::2]) for k in range(2)) if box else (self.lo, self.hi)
        inside = fluid | (self.room(x) > -margin) if box is None else np.all(
            (x >= lo - margin) & (x <= hi + margin), axis=1)
        x, u = x[inside], u[inside, :2]
        _, distinct = np.unique(np.round(x / (1e-6 * dx)), axis=0, return_index=True)
        self.corners, self.velocity = x[distinct], u[distinct].T
        self.fluid_values, self.values = self.fluid_speed, None
        if values is not None:  # walls have none: they take that of the nearest fluid
            self.fluid_values = values[self.fluid]
            own, at_fluid = values if self.dim == 2 else values[cut], fluid[inside][distinct]
            self.values = own[inside][distinct]
            for k in np.flatnonzero(~at_fluid):
                self.values[k] = self.values[at_fluid][np.argmin(((self.corners[at_fluid] - self.corners[k]) ** 2).sum(axis=1))]

    @functools.cached_property
    def triangles(self):
        """Returns the triangles between the particles; pictures of space need none, and a layer may have too few for one."""
        return tri.Triangulation(*self.corners.T)

    @functools.cached_property
    def inside(self):
        """Returns the function of the free surface, or None."""
        return self.surface() if self.free else None

    def read_bodies(self, file, x):
        """Returns the sections of all bodies at the middle of z, and which particles are in the layer there."""
        middle, cut = 0, np.ones(len(x), bool)
        if x.shape[1] == 3:
            low, high = file.attrs["box"][[2, 5]]
            middle = (low + high) / 2
            above = (x[:, 2] - middle) / float(self.attributes["dx"])
            cut = (above > -0.01) & (above < 0.99)
        self.solids = []  # shape, numbers, ends along z, and if the fluid is inside
        for k, shape in enumerate(filter(None, self.attributes["body_shapes"].split(",")), 1):
            ends = file.attrs[f"body_{k}_ends"][:] if f"body_{k}_ends" in file.attrs else (-np.inf, np.inf)
            self.solids.append((shape, file.attrs[f"body_{k}"][:], ends, bool(plain(file.attrs[f"body_{k}_around"]))))
        return [Body(*section, around) for shape, numbers, ends, around in self.solids
                for section in sections(shape, numbers, ends, middle)], cut

    def window(self):
        """Returns the part of the box that the fluid and its neighbourhood take."""
        margin = np.maximum(4 * self.dx, 0.1 * np.ptp(self.x, axis=0))
        low = np.maximum(self.lo, self.x.min(axis=0) - margin)
        high = np.minimum(self.hi, self.x.max(axis=0) + margin)
        return low[0], high[0], low[1], high[1]

    def walls(self):
        """Returns functions of points: their distances from a side of the box or from a body, and the nearest points."""
        def side(axis, at, sign):
            def distance(x):
                nearest = x.copy()
                nearest[:, axis] = at
                return sign * (x[:, axis] - at), nearest
            return distance

        sides = [(k // 2, self.hi[k // 2] if k % 2 else self.lo[k // 2], -1 if k % 2 else 1) for k in range(4)]
        closed = [side(*s) for s, kind in zip(sides, self.kinds) if kind not in ("periodic", "free")]
        return closed + [body.distance for body in self.bodies]

    def room(self, x):
        """Returns the distance of points from the nearest side or body, negative outside the fluid's domain."""
        nearest = np.minimum((x - self.lo).min(axis=1), (self.hi - x).min(axis=1))
        return np.min([nearest, *(body.distance(x)[0] for body in self.bodies)], axis=0)

    def surface(self):
        """Returns a function that tells which points are fluid: where the concentration of particles is above 1/2.

        C(x) = sum_j V_j W(|x - x_j|), wendland_c2 of radius 3 dx. Images of particles beyond walls and periodic sides continue the fluid to
        them."""
        reach = 3 * self.size.max()
        x, size = self.x, self.size
        for axis, kind in enumerate(self.kinds[::2]):
            period = self.hi[axis] - self.lo[axis]
            for end, sign in ((self.lo, 1), (self.hi, -1)):
                near = (kind == "periodic") & (abs(self.x[:, axis] - end[axis]) < reach)
                x = np.vstack([x, self.x[near] + sign * period * np.eye(2)[axis]])
                size = np.append(size, self.size[near])
        for wall in self.walls():
            distance, nearest = wall(x)
            near = (distance < reach) & (distance > 0)
            image = 2 * nearest[near] - x[near]
            solid = self.room(image) < 0
            x, size = np.vstack([x, image[solid]]), np.append(size, size[near][solid])

        def inside(points):
            low = points.min(axis=0)
            width = int((points[:, 0].max() - low[0]) / reach) + 1
            bins = ((points - low) // reach).astype(int)
            key = bins[:, 1] * width + bins[:, 0]
            order = np.argsort(key, kind="stable")
            key, concentration = key[order], np.zeros(len(points))
            for place, own in zip(x, size):
                column, row = ((place - low) // reach).astype(int)
                for k in range(row - 1, row + 2):
                    first, last = max(column - 1, 0), min(column + 1, width - 1)
                    if first > last:
                        continue
                    a, b = np.searchsorted(key, [k * width + first, k * width + last + 1])
                    q = np.linalg.norm(points[order[a:b]] - place, axis=1) / (3 * own)
                    concentration[a:b] += np.where(q < 1, 7 / np.pi / 9 * (1 - np.minimum(q, 1))**4 * (1 + 4 * q), 0)
            fluid = np.zeros(len(points), bool)
            fluid[order] = concentration > 0.5
            return fluid
        return inside

    def is_fluid(self, x, y):
        """Tells which points of a grid are fluid."""
        points = np.column_stack([x.ravel(), y.ravel()])
        fluid = self.room(points) >= 0
        if self.inside is not None:
            fluid &= self.inside(points)
        return fluid.reshape(x.shape)

    def on_grid(self, box, points=600):
        """Returns x and y of the centres of a grid of squares, `points` along the longer side, and where is fluid u, v, and
        the field if it is not the speed."""
        left, right, bottom, top = box
        cell = max(right - left, top - bottom) / points
        x, y = ((np.arange(n) + 0.5) * length / n + low for low, length in ((left, right - left), (bottom, top - bottom))
                for n in [max(2, round(length / cell))])
        grid = np.meshgrid(x, y)
        fluid = self.is_fluid(*grid)
        if not fluid.any():
            sys.exit(f"plot: {self.path}: nothing to draw, for no point of its box is fluid outside the bodies")
        fields = [*self.velocity] if self.values is None else [*self.velocity, self.values]
        values = [tri.LinearTriInterpolator(self.triangles, c)(*grid) for c in fields]
        gap = fluid & np.ma.getmaskarray(values[0])  # corners, where no particle is: the nearest has the value
        particles = np.column_stack([self.triangles.x, self.triangles.y])
        nearest = [np.argmin(((particles - p) ** 2).sum(axis=1)) for p in np.column_stack([c[gap] for c in grid])]
        for value, component in zip(values, fields):
            value[gap] = component[nearest]
        return x, y, *(np.ma.array(value, mask=~fluid) for value in values)

    def field_on_grid(self, box):
        """Returns x, y, u, v and the field on a grid."""
        x, y, u, v, *field = self.on_grid(box)
        return x, y, u, v, *(field or [np.ma.hypot(u, v)])

    def draw_bodies(self, axes):
        """Draws the bodies, and the solid around bodies that have the fluid inside."""
        style = {"facecolor": "0.75", "edgecolor": "0.3", "linewidth": 1}
        for body in self.bodies:
            if body.around:
                axes.add_patch(patches.Rectangle(self.lo, *(self.hi - self.lo), zorder=-2, **style))
                axes.add_patch(body.patch(zorder=-1, **{**style, "facecolor": "white"}))
        for body in self.bodies:
            if not body.around:
                axes.add_patch(body.patch(zorder=2.5, **style))

    def title(self):
        parts = [str(self.attributes[name]) for name in ["case"] if name in self.attributes]
        if "reynolds" in self.attributes:
            parts.append(f"Re = {float(self.attributes['reynolds']):g}")
        return ", ".join(parts + [f"t = {self.time:g}"])


def read_scalar(file, name, fluid, path):
    """Returns the label and the values of a data set with a number a particle."""
    key = name if name in file else SHORT.get(name, name)
    scalars = [key for key, data in file.items() if getattr(data, "shape", None) == fluid.shape and key not in ("id", "type", "boundary")]
    if key not in scalars:
        sys.exit(f"plot: {path} has no field {name}; it has speed, {', '.join(scalars)}")
    units = plain(file[key].attrs.get("units", b"1"))
    return key if units == "1" else f"{key} [{units}]", file[key][:]


def sections(shape, numbers, ends, z):
    """Returns shapes and numbers of the sections of a body of space at z; those of a body of the plane are its own."""
    if shape == "ball":
        squared = numbers[3] ** 2 - (z - numbers[2]) ** 2
        return [(shape, np.array([*numbers[:2], squared ** 0.5]))] if squared > 0 else []
    if shape == "revolved":
        corners = numbers.reshape(-1, 2)
        r = sorted(a[0] + (z - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
                   for a, b in zip(corners, np.roll(corners, -1, axis=0)) if (a[1] > z) != (b[1] > z))
        return [("ring", np.array([0, 0, *pair])) for pair in zip(r[::2], r[1::2]) if pair[1] > 0]
    if shape in ("ellipsoid", "capsule", "cone", "compound", "file"):
        return []  # of space, and drawn by their wall particles alone
    return [(shape, numbers)] if ends[0] <= z <= ends[1] else []


def plain(value):
    """Returns an HDF5 attribute as a Python number or string."""
    value = np.asarray(value).reshape(-1)[0]
    return value.decode() if isinstance(value, bytes) else value
