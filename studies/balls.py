"""Draws particles of space as balls of their volume, and bodies by their shapes, with light and shadows.

Numpy alone: each ball writes its depth into a buffer of pixels, bodies are found by sphere tracing of their signed
distance (J. C. Hart, Vis. Comput. 12 (1996) 527-545), and a second buffer, seen from the light, has the shadows. Gravity
points down. Bodies end at the box; where they hide fluid, their halves towards the camera are cut away. The VTK of Debian 12 draws to an X display only, which a machine without one has not."""
import re

import numpy as np
from snapshot import Body

GREY, FLOOR, EDGE = (0.62, 0.62, 0.64), (0.93, 0.93, 0.92), (0.45, 0.45, 0.45)
BALL, SOLID, GROUND, LINE = 0, 1, 2, 3  # contents of a pixel
LIGHT = np.array([-0.55, 1.2, 0.75])  # to the right of the camera, up, towards it
SHADE, AMBIENT = 0.35, 0.5  # of light in a shadow; of light that has no direction
PART = 16384  # points whose distances are computed together
BLOCKS = 16, 4, 1  # sides of the blocks that seek bodies together [pixels]
HIDDEN = 0.2  # share of the fluid's pixels behind bodies that is too much
FLAT = "ellipsoid", "capsule", "cone", "compound", "file"  # shapes of space whose numbers are no outline


def view(azimuth, elevation):
    """Returns the directions right, up and towards the camera as rows; angles in degrees, y is up."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)])
    return frame(towards)


def frame(towards):
    """Returns three normal directions, the last along `towards`."""
    towards = towards / np.linalg.norm(towards)
    right = np.cross([0, 1, 0] if abs(towards[1]) < 0.99 else [0, 0, -1], towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])


def solid_distance(solids, x):
    """Returns the signed distance of points from bodies, positive outside; parts of the points fit into the cache."""
    if len(x) > PART:
        return np.concatenate([solid_distance(solids, x[k : k + PART]) for k in range(0, len(x), PART)])
    nearest = np.full(len(x), np.inf)
    for shape, numbers, ends, around in solids:
        if around or shape in FLAT:
            continue
        if shape == "ball":
            distance = np.linalg.norm(x - numbers[:3], axis=1) - numbers[3]
        elif shape == "revolved":
            section = np.column_stack([np.hypot(x[:, 0], x[:, 1]), x[:, 2]])
            distance = Body("polygon", numbers, False).distance(section)[0]
        else:
            outline = Body(shape, numbers, False).distance(x[:, :2])[0]
            distance = np.maximum(outline, abs(x[:, 2] - np.mean(ends)) - (ends[1] - ends[0]) / 2)
        nearest = np.minimum(nearest, distance)
    return nearest


def part(lo, hi, towards=None):
    """Returns the signed distance from the box, or from its half away from the camera."""
    def distance(x):
        outside = np.maximum(lo - x, x - hi).max(axis=1)
        return outside if towards is None else np.maximum(outside, (x - (lo + hi) / 2) @ towards)
    return distance


def upright(snapshot):
    """Returns the axis that is up, against the body force if it is along one, and directions right, up and to the front."""
    force = re.search(r"-body_force (\S+,\S+,\S+) -", str(snapshot.attributes.get("options", "")) + " -")
    try:
        force = [float(word) for word in force[1].split(",")]
    except (TypeError, ValueError):
        force = [0, -1, 0]
    up = int(np.argmin(force)) if min(force) < 0 else 1
    return up, np.roll(np.eye(3), up - 1, axis=1)


class Buffer:
    """Depths and surfaces in the pixels of a view along the last direction of `axes`."""

    def __init__(self, axes, corners, pixels):
        seen = corners @ axes.T
        self.axes, self.low, high = axes, seen.min(axis=0), seen.max(axis=0)
        margin = 0.02 * (high - self.low).max()
        self.low, high = self.low - margin, high + margin
        self.pixel = (high - self.low)[:2].max() / pixels
        self.shape = tuple(np.ceil((high - self.low)[1::-1] / self.pixel).astype(int))
        self.nearest, self.far = high[2], self.low[2]
        self.depth = np.full(self.shape, -np.inf)
        self.what = np.full(self.shape, -1)
        self.ball = np.zeros(self.shape, int)
        self.normal = np.zeros((*self.shape, 3))

    def balls(self, x, radius):
        """Draws balls at x."""
        place = x @ self.axes.T
        first = np.ceil((place[:, :2] - radius[:, None] - self.low[:2]) / self.pixel - 0.5).astype(int)
        last = np.floor((place[:, :2] + radius[:, None] - self.low[:2]) / self.pixel - 0.5).astype(int)
        first, last = np.maximum(first, 0), np.minimum(last + 1, self.shape[::-1])
        for k in np.flatnonzero((last > first).all(axis=1)):
            part = slice(first[k, 1], last[k, 1]), slice(first[k, 0], last[k, 0])
            across, up = (self.low[a] + (np.arange(first[k, a], last[k, a]) + 0.5) * self.pixel - place[k, a]
                          for a in range(2))
            rise = radius[k] ** 2 - across**2 - up[:, None] ** 2
            depth = place[k, 2] + np.sqrt(np.maximum(rise, 0))
            nearer = (rise > 0) & (depth > self.depth[part])
            self.depth[part][nearer], self.ball[part][nearer] = depth[nearer], k
        cell = np.nonzero(self.depth > -np.inf)
        self.what[cell] = BALL
        self.normal[cell] = self.points(self.depth)[cell] - x[self.ball[cell]]
        self.normal[cell] /= radius[self.ball[cell], None]

    def points(self, depth, block=1):
        """Returns the points of space of all pixels, or of the middles of blocks of pixels, at a depth."""
        row, column = np.indices([-(-n // block) for n in self.shape])
        depth = np.where(np.isfinite(depth), depth, self.far)
        place = np.stack([self.low[0] + (column + 0.5) * block * self.pixel, self.low[1] + (row + 0.5) * block * self.pixel,
                          np.broadcast_to(depth, row.shape)], axis=-1)
        return place @ self.axes

    def put(self, pixels, depth, what, normal):
        """Draws a surface in the pixels in which it is nearer than what is there."""
        nearer = pixels & (depth > self.depth)
        self.depth[nearer], self.what[nearer], self.normal[nearer] = depth[nearer], what, normal[nearer]

    def bodies(self, solids, room):
        """Draws the parts of bodies in a room. Blocks of pixels advance together as long as no body is within reach of their corners."""
        def to_solid(x):
            return np.maximum(solid_distance(solids, x), room(x))

        depth = np.full([-(-n // BLOCKS[0]) for n in self.shape], self.nearest)
        for coarse, block in zip((BLOCKS[0], *BLOCKS), BLOCKS):
            x = self.points(self.nearest, block)
            depth = depth.repeat(coarse // block, 0).repeat(coarse // block, 1)[: len(x), : x.shape[1]].ravel()
            corner = (block - 1) * self.pixel / 2**0.5
            shape, x, hit = x.shape[:2], x.reshape(-1, 3), np.zeros(len(depth), bool)
            left = np.flatnonzero(depth > self.far)
            while len(left):
                distance = to_solid(x[left] - (self.nearest - depth[left])[:, None] * self.axes[2]) - corner
                ends = distance < max(corner, 0.5 * self.pixel)
                hit[left[ends]] = True
                left, distance = left[~ends], distance[~ends]
                depth[left] -= distance
                left = left[depth[left] > self.far]
            depth = depth.reshape(shape)
        x -= (self.nearest - depth).reshape(-1, 1) * self.axes[2]
        normal = np.zeros_like(x)
        step = 1.5 * self.pixel
        for a, e in enumerate(np.eye(3)):
            normal[hit, a] = to_solid(x[hit] + step * e) - to_solid(x[hit] - step * e)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        self.put(hit.reshape(self.shape), depth, SOLID, normal.reshape(*self.shape, 3))

    def floor(self, lo, hi, up):
        """Draws the floor of the box, across the axis `up`."""
        if self.axes[2, up] < 0.01:
            return
        start = self.points(0.0)
        depth = (lo[up] - start[..., up]) / self.axes[2, up]
        x = start + depth[..., None] * self.axes[2]
        inside = np.all((x >= lo) & (x <= hi), axis=-1, where=np.arange(3) != up)
        self.put(inside, depth, GROUND, np.broadcast_to(np.eye(3)[up], x.shape))

    def edges(self, lo, hi):
        """Draws the edges of the box."""
        for axis in range(3):
            for k in range(4):
                x = np.repeat([[(lo, hi)[bool(k & (1 << (b - (b > axis))))][b] for b in range(3)]], 4000, axis=0)
                x[:, axis] = np.linspace(lo[axis], hi[axis], 4000)
                place = x @ self.axes.T
                column, row = np.floor((place[:, :2] - self.low[:2]) / self.pixel).astype(int).T
                good = (column >= 0) & (row >= 0) & (column < self.shape[1]) & (row < self.shape[0])
                cell = row[good], column[good]
                seen = place[good, 2] >= self.depth[cell] - 1e-3 * (self.nearest - self.far)
                self.what[cell[0][seen], cell[1][seen]] = LINE

    def lit(self, light):
        """Returns the share of the light that reaches each pixel, from the depths that the light sees."""
        place = self.points(self.depth) @ light.axes.T
        share = np.zeros(self.shape)
        for i, j in ((-1, -1), (-1, 1), (1, -1), (1, 1), (0, 0)):
            column = np.clip((place[..., 0] - light.low[0]) / light.pixel + i, 0, light.shape[1] - 1)
            row = np.clip((place[..., 1] - light.low[1]) / light.pixel + j, 0, light.shape[0] - 1)
            share += place[..., 2] > light.depth[row.astype(int), column.astype(int)] - 4 * light.pixel
        return share / 5


def picture(snapshot, colours, azimuth=30, elevation=20, pixels=800):
    """Returns a picture of the fluid of a snapshot in space as rows of RGB, from the top; colours: RGB of each particle."""
    x, radius = snapshot.place, snapshot.radius
    lo, hi = snapshot.room_lo, snapshot.room_hi
    corners = np.array([[(lo, hi)[k >> a & 1][a] for a in range(3)] for k in range(8)])
    up, turn = upright(snapshot)
    seen = view(azimuth, elevation)
    axes = seen @ turn
    solids = [solid for solid in snapshot.solids if not solid[3] and solid[0] not in FLAT]
    room = part(lo, hi)
    if solids:
        coarse = Buffer(axes, corners, pixels // 8)
        coarse.balls(x, radius)
        fluid = coarse.what == BALL
        coarse.bodies(solids, room)
        if (coarse.what[fluid] == SOLID).mean() > HIDDEN:
            room = part(lo, hi, seen[2] * [1, 0, 1] @ turn / np.linalg.norm(seen[2, ::2]))
    camera = Buffer(axes, corners, 2 * pixels)
    light = Buffer(frame((LIGHT @ seen * [1, 0, 1] + [0, LIGHT[1], 0]) @ turn), corners, pixels)
    for buffer in camera, light:
        buffer.balls(x, radius)
        if solids:
            buffer.bodies(solids, room)
    if snapshot.attributes["boundary_kinds"].split(",")[2 * up] == "wall":
        camera.floor(lo, hi, up)
    facing = np.clip(camera.normal @ light.axes[2], 0, 1)
    bright = AMBIENT + (1 - AMBIENT) * facing * (SHADE + (1 - SHADE) * camera.lit(light))
    image = np.ones((*camera.shape, 3))
    for what, colour in ((BALL, None), (SOLID, GREY), (GROUND, FLOOR)):
        here = camera.what == what
        image[here] = (colours[camera.ball[here]] if colour is None else colour) * bright[here][:, None]
    camera.edges(lo, hi)
    image[camera.what == LINE] = EDGE
    rows, columns = (n // 2 for n in camera.shape)
    return image[:2 * rows, :2 * columns].reshape(rows, 2, columns, 2, 3).mean(axis=(1, 3))[::-1]
