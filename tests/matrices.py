#!/usr/bin/env python3
"""Compares the matrices of -visc_ksp_view_mat and -ppe_ksp_view_mat on different numbers of ranks, and checks that
row k belongs to fluid particle k of a snapshot. The viscous matrix must be I/dt - nu L, and the pressure matrix
-dx^2 L, with a Laplacian L that is exact for linear fields.

    matrices.py N DT NU COMMAND_1 --and COMMAND_2

Both commands run the same flow of N x N fixed particles in the unit square, the first with the files a.bin and
p.txt, the second with b.txt and q.bin."""
import struct
import subprocess
import sys

from interpreter import python_with

python_with("h5py")

import h5py  # noqa: E402 (after the interpreter)


def binary(path):
    """Reads a matrix in PETSc's binary format: big-endian class id, rows, columns, entries, row lengths, columns,
    values. Integers have 64 bits if PETSc has indices of 64 bits; then the first four bytes are zero, because the
    class id is small."""
    with open(path, "rb") as file:
        data = file.read()
    letter, width = ("i", 4) if any(data[:4]) else ("q", 8)
    kind, rows, cols, nnz = struct.unpack(f">4{letter}", data[:4 * width])
    assert kind == 1211216 and rows == cols, path
    at = (4 + rows) * width
    lengths = struct.unpack(f">{rows}{letter}", data[4 * width:at])
    columns = struct.unpack(f">{nnz}{letter}", data[at:at + width * nnz])
    at += width * nnz
    values = struct.unpack(f">{nnz}d", data[at:at + 8 * nnz])
    matrix, first = [], 0
    for length in lengths:
        matrix.append(dict(zip(columns[first:first + length], values[first:first + length])))
        first += length
    return matrix


def ascii_(path):
    matrix = []
    with open(path) as file:
        for line in file:
            line = line.strip()  # PETSc may print blanks before the entries of several ranks
            if not line.startswith("row "):
                continue
            head, entries = line.split(":", 1)
            assert int(head[4:]) == len(matrix), line
            pairs = entries.replace("(", " ").split(")")
            matrix.append({int(c): float(v) for c, v in (p.split(",") for p in pairs if "," in p)})
    return matrix


def places(path, ids=False):
    """Returns the places of the fluid of a snapshot, which are those of the rows of matrices, and their ids."""
    with h5py.File(path) as file:
        fluid = file["type"][...] == 0
        x = file["position"][...][fluid]
        return (x, file["id"][...][fluid]) if ids else x


def by_id(matrix, ids):
    """Sorts rows and columns of a matrix by ids, which are 0, 1, ..."""
    rows = [None] * len(ids)
    for k, row in enumerate(matrix):
        rows[ids[k]] = {int(ids[column]): value for column, value in row.items()}
    return rows


def difference(a, b):
    assert len(a) == len(b) and all(set(r) == set(s) for r, s in zip(a, b)), "other entries"
    largest = max(abs(v) for row in a for v in row.values())
    return max(abs(r[c] - s[c]) for r, s in zip(a, b) for c in r) / largest


def apply(matrix, f, row):
    return sum(value * f[column] for column, value in matrix[row].items())


def main():
    n, dt, nu = int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
    cut = sys.argv.index("--and")
    commands = sys.argv[4:cut] + ["-output", "one.h5"], sys.argv[cut + 1:] + ["-output", "two.h5"]
    for command in commands:
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    (x, ids), (_, others) = (places(f"{name}_0000.h5", True) for name in ("one", "two"))
    visc, ppe = by_id(binary("a.bin"), ids), by_id(ascii_("p.txt"), ids)
    assert len(visc) == len(ppe) == len(x) == n * n
    # ASCII files have six digits.
    assert difference(visc, by_id(ascii_("b.txt"), others)) < 1e-5
    assert difference(ppe, by_id(binary("q.bin"), others)) < 1e-5
    x = [tuple(x[k]) for k in sorted(range(len(ids)), key=lambda k: ids[k])]
    # The first step is one of backward Euler, with the shift 1/dt.
    shift, one, dx = 1 / dt, [1.0] * (n * n), 1.0 / n
    inner = [k for k, p in enumerate(x) if all(4.2 * dx < c < 1 - 4.2 * dx for c in p)]
    assert inner
    for k in inner:
        assert abs(apply(visc, one, k) / shift - 1) < 1e-9
        assert abs(apply(ppe, one, k)) < 1e-4
        for a in range(2):
            f = [p[a] - x[k][a] for p in x]
            assert abs(apply(visc, f, k)) < 1e-9 * nu / dx
            assert abs(apply(ppe, f, k)) < 1e-4 * dx


if __name__ == "__main__":
    main()
