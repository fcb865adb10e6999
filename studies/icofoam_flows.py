"""Other flows by OpenFOAM's icoFoam than the cavity of icofoam.py, with the same schemes: a flow between two lids with a
cylinder, on a mesh that follows its surface, and flows in the periodic unit square.

The mesh of the cylinder has square cells of edge 1/n outside a square of half side REACH about its centre. Four blocks
lead from the sides of this square to arcs of the surface. Their cells are not orthogonal, so the Laplacians and the
normal gradients have corrections, and the pressure is solved once more in each PISO step.
"""
import math
import os
import re

import icofoam
import numpy as np

REACH = 0.25
PERIODIC_MESH = """
scale 1;
vertices ((0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 {dx}) (1 0 {dx}) (1 1 {dx}) (0 1 {dx}));
blocks (hex (0 1 2 3 4 5 6 7) ({n} {n} 1) simpleGrading (1 1 1));
boundary
(
  left {{ type cyclic; neighbourPatch right; faces ((0 4 7 3)); }}
  right {{ type cyclic; neighbourPatch left; faces ((2 6 5 1)); }}
  bottom {{ type cyclic; neighbourPatch top; faces ((1 5 4 0)); }}
  top {{ type cyclic; neighbourPatch bottom; faces ((3 7 6 2)); }}
  sides {{ type empty; faces ((0 3 2 1) (4 5 6 7)); }}
);
"""
PERIODIC_FIELD = """
dimensions {dimensions}; internalField {start};
boundaryField
{{
  left {{ type cyclic; }}
  right {{ type cyclic; }}
  bottom {{ type cyclic; }}
  top {{ type cyclic; }}
  sides {{ type empty; }}
}}
"""
BODY_FIELD = """
dimensions {dimensions}; internalField {start};
boundaryField
{{
  lids {{ {lids} }}
  walls {{ {walls} }}
  sides {{ type empty; }}
}}
"""
U_UNIT, P_UNIT = "[0 1 -1 0 0 0 0]", "[0 2 -2 0 0 0 0]"


def with_files(**texts):
    """Returns the files of icofoam.py with other texts; a name is the last word of a path."""
    return {path: (kind, texts.get(os.path.basename(path), text)) for path, (kind, text) in icofoam.FILES.items()}


def steps_of(n, t_end, courant):
    """Returns the number of steps of at most courant / n."""
    return math.ceil(t_end * n / courant - 1e-9)


def write(folder, files, reynolds, n, t_end, courant):
    """Writes a case with steps of at most courant / n; returns (dt, steps)."""
    steps = steps_of(n, t_end, courant)
    icofoam.write_files(folder, files, n=n, dx=1 / n, nu=1 / reynolds, t_end=f"{t_end:g}", interval=steps,
                        dt=f"{t_end / steps:.15g}", tolerance="1e-6")
    return t_end / steps, steps


def write_periodic(folder, velocity, reynolds, n, t_end, courant):
    """Writes a flow that starts from velocity(x, y), on n x n square cells."""
    x, y = cell_centres(n)
    vectors = " ".join(f"({u:.12g} {v:.12g} 0)" for u, v in zip(*(np.broadcast_to(part, n * n) for part in velocity(x, y))))
    u = PERIODIC_FIELD.format(dimensions=U_UNIT, start=f"nonuniform List<vector> {n * n} ({vectors})")
    p = PERIODIC_FIELD.format(dimensions=P_UNIT, start="uniform 0")
    return write(folder, with_files(blockMeshDict=PERIODIC_MESH, U=braced(u), p=braced(p)), reynolds, n, t_end, courant)


def braced(text):
    """Returns a text that str.format leaves as it is."""
    return text.replace("{", "{{").replace("}", "}}")


def cell_centres(n):
    """Returns x and y of n x n square cells, row after row."""
    middle = (np.arange(n) + 0.5) / n
    return np.tile(middle, n), np.repeat(middle, n)


def write_cylinder(folder, centre, radius, reynolds, n, t_end, courant):
    """Writes the flow between two lids, both with u = 1, with a cylinder; sides of its square lie on edges of cells."""
    u = BODY_FIELD.format(dimensions=U_UNIT, start="uniform (0 0 0)", lids="type fixedValue; value uniform (1 0 0);",
                          walls="type noSlip;")
    p = BODY_FIELD.format(dimensions=P_UNIT, start="uniform 0", lids="type zeroGradient;", walls="type zeroGradient;")
    files = with_files(blockMeshDict=braced(cylinder_mesh(centre, radius, n)), U=braced(u), p=braced(p))
    files = {path: (kind, text.replace("linear orthogonal", "linear corrected").replace("default orthogonal",
                    "default corrected").replace("nNonOrthogonalCorrectors 0", "nNonOrthogonalCorrectors 1"))
             for path, (kind, text) in files.items()}
    return write(folder, files, reynolds, n, t_end, courant)


def cylinder_mesh(centre, radius, n):
    """Returns the text of blockMeshDict: eight blocks of square cells about four blocks from a square to the circle."""
    edges = [[0, c - REACH, c + REACH, 1] for c in centre]
    counts = [[round((b - a) * n) for a, b in zip(edge, edge[1:])] for edge in edges]
    for edge, count in zip(edges, counts):
        if any(k < 1 or abs(k - (b - a) * n) > 1e-6 for k, a, b in zip(count, edge, edge[1:])):
            raise ValueError(f"n = {n}: the edges {edge} do not lie on edges of cells")
    plane = [(x, y) for y in edges[1] for x in edges[0]]  # numbers 0 to 15, row after row
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    plane += [(centre[0] + a * radius / math.sqrt(2), centre[1] + b * radius / math.sqrt(2)) for a, b in corners]
    layer = len(plane)
    blocks, radial = [], max(2, round((1.14 * REACH - radius) * n))  # 1.14: mean distance of the square over REACH

    def block(a, b, c, d, along, across):
        blocks.append(f"hex ({a} {b} {c} {d} {a + layer} {b + layer} {c + layer} {d + layer}) "
                      f"({along} {across} 1) simpleGrading (1 1 1)")

    for j in range(3):
        for i in range(3):
            if (i, j) != (1, 1):
                a = 4 * j + i
                block(a, a + 1, a + 5, a + 4, counts[0][i], counts[1][j])
    square = [5, 6, 10, 9]  # corners of the square about the circle, counted as those of the circle
    for k in range(4):
        after = (k + 1) % 4
        block(square[k], square[after], 16 + after, 16 + k, counts[k % 2][1], radial)
    arcs, walls = [], []
    for k in range(4):
        after, angle = (k + 1) % 4, math.pi / 2 * (k - 1)
        middle = centre[0] + radius * math.cos(angle), centre[1] + radius * math.sin(angle)
        for z, shift in ((0, 0), (1 / n, layer)):
            arcs.append(f"arc {16 + k + shift} {16 + after + shift} ({middle[0]:.15g} {middle[1]:.15g} {z:.15g})")
        walls.append(face(16 + k, 16 + after, layer))
    lids = [face(a, a + 1, layer) for a in (0, 1, 2, 12, 13, 14)]
    walls += [face(a, a + 4, layer) for a in (0, 4, 8, 3, 7, 11)]
    flat = [re.findall(r"\d+", text)[:4] for text in blocks]
    sides = [f"({' '.join(str(int(a) + shift) for a in four)})" for four in flat for shift in (0, layer)]
    points = " ".join(f"({x:.15g} {y:.15g} {z:.15g})" for z in (0, 1 / n) for x, y in plane)
    return (f"scale 1;\nvertices ({points});\nblocks ({' '.join(blocks)});\nedges ({' '.join(arcs)});\n"
            f"boundary ( lids {{ type wall; faces ({' '.join(lids)}); }} walls {{ type wall; faces ({' '.join(walls)}); }} "
            f"sides {{ type empty; faces ({' '.join(sides)}); }} );\n")


def face(a, b, layer):
    """Returns the face above the edge from vertex a to vertex b."""
    return f"({a} {b} {b + layer} {a + layer})"


def read_vectors(folder, name, time=None):
    """Returns the first two components of a vector of each cell at a time, by default the end."""
    with open(os.path.join(folder, time or icofoam.times(folder)[-1], name)) as file:
        block = re.search(r"nonuniform List<vector>\s*\d+\s*\((.*?)\n\)", file.read(), re.DOTALL)
    if not block:
        raise ValueError(f"no vectors in {name}")
    return np.array(block[1].replace("(", " ").replace(")", " ").split(), dtype=float).reshape(-1, 3).T[:2]


def profile(x, y, field, points, spacing):
    """Returns a field of cells at points, by quadratic least-squares fits with the weight of isph's probes."""
    found = []
    for px, py in points:
        reach = 2.6 * spacing
        while True:
            q = np.hypot(x - px, y - py) / reach
            near = q < 1
            if near.sum() >= 12:
                break
            reach *= 1.2
        X, Y, q = (x[near] - px) / reach, (y[near] - py) / reach, q[near]
        root = np.sqrt((1 - q) ** 4 * (1 + 4 * q))
        basis = np.array([np.ones_like(X), X, Y, X * X, X * Y, Y * Y])
        found.append(np.linalg.lstsq((basis * root).T, (field[:, near] * root).T, rcond=None)[0][0])
    return np.array(found).T
