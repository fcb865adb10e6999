"""Meshes of triangles with curved sides, for studies/elements.py. A domain is bounded by closed loops of smooth pieces; it
is the set of points within an odd number of loops. Nodes lie on the pieces, with a spacing that gaps and curvature lower.
Nodes within come from a tree of squares of the wanted size, and springs move them (Persson and Strang 2004)."""
import numpy as np
from scipy.spatial import Delaunay, cKDTree


def line(a, b):
    """Returns a straight piece from a to b."""
    a, b = np.array(a, float), np.array(b, float)
    return lambda t: a + np.multiply.outer(t, b - a)


def arc(centre, radius, start, end):
    """Returns a piece of a circle between two angles [rad]; radius may be a pair, of an ellipse."""
    centre, radius = np.array(centre, float), np.array(radius, float) * np.ones(2)
    return lambda t: centre + radius * np.stack([np.cos(start + (end - start) * t), np.sin(start + (end - start) * t)], -1)


def circle(centre, radius, start=0.0):
    """Returns the pieces of a circle or, with a pair of radii, of an ellipse."""
    return [arc(centre, radius, start + k * np.pi / 2, start + (k + 1) * np.pi / 2) for k in range(4)]


def polygon(*corners):
    """Returns the pieces of a polygon."""
    return [line(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]


def rounded(corners, radius):
    """Returns the pieces of a polygon, counter-clockwise and convex at its corners, whose corners are arcs of a radius."""
    pieces, n = [], len(corners)
    points = np.array(corners, float)
    for k in range(n):
        a, b, c = points[k - 1], points[k], points[(k + 1) % n]
        before, after = (b - a) / np.hypot(*(b - a)), (c - b) / np.hypot(*(c - b))
        turn = np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)
        start = b - before * radius * np.tan(turn / 2)
        angle = np.arctan2(-before[0], before[1])
        centre = start + radius * np.array([-before[1], before[0]])
        pieces.append((arc(centre, radius, angle, angle + turn), start, b + after * radius * np.tan(turn / 2)))
    return [q for k in range(n) for q in (pieces[k][0], line(pieces[k][2], pieces[(k + 1) % n][1]))]


def turned(pieces, angle, place=(0.0, 0.0)):
    """Returns pieces that are turned about the origin and then moved to a place."""
    c, s = np.cos(angle), np.sin(angle)
    turn, place = np.array([[c, s], [-s, c]]), np.array(place, float)
    return [lambda t, piece=piece: piece(t) @ turn + place for piece in pieces]


def table(piece, n=400):
    """Returns parameters of a piece, its points and the length up to each."""
    t = np.linspace(0, 1, n)
    x = piece(t)
    return t, x, np.concatenate([[0], np.cumsum(np.hypot(*np.diff(x, axis=0).T))])


class Sizes:
    """Wanted length of edges: `h` at most, a share of the gap between two loops (or two strands of one), of the radius of
    curvature, the `near` of named points, and growth with the distance from the border."""

    def __init__(self, loops, h, across=3.0, growth=0.25, points=(), grading=0.05, bend=0.35, least=0.0):
        tables = [table(piece) for loop in loops for piece in loop]
        loop_of = np.concatenate([np.full(400, k) for k, loop in enumerate(loops) for _ in loop])
        self.x = np.concatenate([x for _, x, _ in tables])
        bound = np.full(len(self.x), float(h))
        start = 0
        for _, x, s in tables:
            turn = np.unwrap(np.arctan2(*np.diff(x, axis=0).T[::-1]))
            curvature = np.abs(np.gradient(turn, (s[1:] + s[:-1]) / 2)) if s[-1] > 0 else np.zeros(399)
            bound[start:start + 400] = np.minimum(h, bend / np.maximum(np.append(curvature, curvature[-1]), 1e-30))
            start += 400
        if across:
            for k in range(len(loops)):
                if np.any(loop_of != k):
                    gap, _ = cKDTree(self.x[loop_of != k]).query(self.x[loop_of == k])
                    bound[loop_of == k] = np.minimum(bound[loop_of == k], gap / across)
        for x in points:
            bound = np.minimum(bound, grading * h + growth * np.hypot(*(self.x - x).T))
        self.bound, self.growth, self.h = np.maximum(bound, least), growth, h
        self.tree = cKDTree(self.x)
        distance, near = self.tree.query(self.x, k=100)
        for _ in range(30):  # the bound grows no faster along the border either, so that of the nearest point holds
            before, self.bound = self.bound, np.min(self.bound[near] + growth * distance, axis=1)
            if np.all(self.bound > 0.999 * before):
                break

    def __call__(self, x):
        distance, near = self.tree.query(x)
        return np.minimum(self.h, self.bound[near] + self.growth * distance)


def nodes_of(piece, sizes):
    """Returns corner nodes of a piece, without its end, and a node between each and the next, both on the piece."""
    t, x, s = table(piece)
    density = 1 / sizes(x)
    along = np.concatenate([[0], np.cumsum(np.diff(s) * (density[1:] + density[:-1]) / 2)])
    n = max(2, int(np.ceil(along[-1])))
    at = np.interp(np.arange(2 * n) * along[-1] / (2 * n), along, t)
    return piece(at[0::2]), piece(at[1::2])


def inside(points, loops):
    """Returns True for points within an odd number of closed polygons."""
    crossings = np.zeros(len(points), int)
    for loop in loops:
        for a, b in zip(loop, np.roll(loop, -1, axis=0)):
            cut = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
            if np.any(cut):
                x = a[0] + (points[cut, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
                crossings[np.flatnonzero(cut)[points[cut, 0] < x]] += 1
    return crossings % 2 == 1


def tree_points(low, high, sizes):
    """Returns centres of squares that are divided until each is about as wide as the wanted length at its centre."""
    width = max(high - low)
    cells, found = np.array([(low + high) / 2]), []
    while len(cells):
        fine = sizes(cells) < 0.95 * width
        found.append(cells[~fine])
        width /= 2
        cells = (cells[fine][:, None] + width / 2 * np.array([[-1, -1], [1, -1], [-1, 1], [1, 1]])).reshape(-1, 2)
    return np.concatenate(found)


class Mesh:
    """Nodes `x`, triangles `elements` of six nodes (corners, then the middle of the side after each corner), `corners`, the
    number of nodes that are corners, which come first, and `border`, pairs (loop, piece) with the nodes of each piece."""

    def __init__(self, loops, h, rounds=40, periodic=(), **sizes):
        """Makes a mesh of a domain. `periodic` has pairs of pieces of the first loop, the second of which, taken backwards,
        is the first one moved."""
        wanted = Sizes(loops, h, **sizes)
        ends, middles, owner = [], [], []
        for k, loop in enumerate(loops):
            parts = [nodes_of(piece, wanted) for piece in loop]
            for a, b in periodic if k == 0 else ():
                shift = loop[b](np.array([1.0]))[0] - loop[a](np.array([0.0]))[0]
                end = loop[a](np.array([1.0]))
                parts[b] = (np.concatenate([parts[a][0][1:], end])[::-1] + shift, parts[a][1][::-1] + shift)
            for j, (end, middle) in enumerate(parts):
                ends.append(end), middles.append(middle), owner.append(np.full(len(end), j))
        counts = np.cumsum([0] + [len(e) for e in ends])
        first = np.cumsum([0] + [len(loop) for loop in loops])
        spans = [np.arange(counts[first[k]], counts[first[k + 1]]) for k in range(len(loops))]
        border, middle, owner = np.concatenate(ends), np.concatenate(middles), np.concatenate(owner)
        follower = np.concatenate([np.roll(span, -1) for span in spans])
        points, triangles = self.fill(border, spans, wanted, rounds)
        self.corners = len(points)
        self.number(points, triangles, np.stack([np.arange(len(border)), follower], 1), middle)
        self.border, self.loops = {}, len(loops)
        for k, span in enumerate(spans):
            for j in range(len(loops[k])):
                mine = span[owner[span] == j]
                nodes = np.concatenate([mine, follower[mine[-1:]], self.middle_of[mine]])
                self.border[k, j] = nodes

    def fill(self, border, spans, wanted, rounds):
        """Returns the points and the triangles between the nodes of the border."""
        polygons = [border[span] for span in spans]
        points = tree_points(border.min(axis=0), border.max(axis=0), wanted)
        points = points[inside(points, polygons)]
        tree = cKDTree(border)
        points = points[tree.query(points)[0] > 0.6 * wanted(points)]
        n = len(border)
        points = np.concatenate([border, points])
        for turn in range(rounds):
            triangles = self.kept(points, polygons, n)
            edges = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
            between = points[edges[:, 0]] - points[edges[:, 1]]
            length = np.hypot(*between.T)
            want = wanted((points[edges[:, 0]] + points[edges[:, 1]]) / 2)
            want *= 1.15 * np.sqrt(np.sum(length**2) / np.sum(want**2))
            push = (np.maximum(want - length, 0) / length)[:, None] * between
            force = np.zeros_like(points)
            for axis in (0, 1):
                force[:, axis] = np.bincount(edges[:, 0], push[:, axis], len(points)) - np.bincount(
                    edges[:, 1], push[:, axis], len(points))
            moved = points[n:] + 0.2 * force[n:]
            distance, near = tree.query(moved)
            close = np.maximum(0.55 * wanted(moved) - distance, 0) / distance
            points[n:] = moved + close[:, None] * (moved - border[near])
            if turn % 10 == 5:  # crowded points leave
                pairs = cKDTree(points).query_pairs(0.6 * wanted.h, output_type="ndarray")
                pairs = pairs[pairs[:, 1] >= n]
                apart = np.hypot(*(points[pairs[:, 0]] - points[pairs[:, 1]]).T)
                out = np.unique(pairs[apart < 0.5 * wanted(points[pairs[:, 1]]), 1])
                points = np.delete(points, out, axis=0)
        centre = np.concatenate([(p + np.roll(p, -1, axis=0)) / 2 for p in polygons])  # points in circles over sides hide them
        radius = np.concatenate([np.hypot(*(p - np.roll(p, -1, axis=0)).T) / 2 for p in polygons])
        distance, near = cKDTree(centre).query(points[n:], k=4)
        out = np.any(distance < radius[near], axis=1) | ~inside(points[n:], polygons)
        points = np.delete(points, n + np.flatnonzero(out), axis=0)
        return points, self.kept(points, polygons, n)

    @staticmethod
    def kept(points, polygons, n):
        """Returns the triangles of Delaunay within the domain; only those of nodes of the border can lie outside."""
        triangles = Delaunay(points).simplices
        doubtful = np.all(triangles < n, axis=1)
        keep = ~doubtful
        centres = points[triangles[doubtful]].mean(axis=1)
        keep[np.flatnonzero(doubtful)] = inside(centres, polygons)
        triangles = triangles[keep]
        a, b, c = (points[triangles[:, k]] for k in range(3))
        area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        flat = np.abs(area) < 1e-9 * np.sum((b - a) ** 2, axis=1)
        return triangles[~flat]

    def number(self, points, triangles, sides, middle):
        """Numbers the nodes between corners, and demands that the border of the triangles is the border of the domain."""
        a, b, c = (points[triangles[:, k]] for k in range(3))
        area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        triangles[area < 0] = triangles[area < 0][:, ::-1]
        every = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, index, count = np.unique(every, axis=0, return_inverse=True, return_counts=True)
        index = index.reshape(-1)
        key = edges[:, 0] * len(points) + edges[:, 1]
        wanted = np.sort(sides, axis=1) @ [len(points), 1]
        if set(key[count == 1]) != set(wanted) or np.any(count > 2):
            raise ValueError(f"{len(set(wanted) ^ set(key[count == 1]))} sides of the mesh are not the border: take finer sides")
        x = (points[edges[:, 0]] + points[edges[:, 1]]) / 2
        at = np.searchsorted(key, wanted)
        x[at] = middle
        self.middle_of = at + len(points)
        self.x = np.concatenate([points, x])
        self.elements = np.concatenate([triangles, index.reshape(-1, 3) + len(points)], axis=1)

    def least_angle(self):
        """Returns the least angle of the triangles [degrees]."""
        p = self.x[self.elements[:, :3]]
        least = 180.0
        for k in range(3):
            a, b = p[:, (k + 1) % 3] - p[:, k], p[:, (k + 2) % 3] - p[:, k]
            cosine = np.sum(a * b, axis=1) / np.hypot(*a.T) / np.hypot(*b.T)
            least = min(least, np.degrees(np.arccos(cosine.max())))
        return least
