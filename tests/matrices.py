#!/usr/bin/env python3
"""Compares the matrices of -visc_mat_view and -ppe_mat_view on different numbers of ranks, and checks that
row k belongs to the particle of id k. The viscous matrix must be I/k - nu L, with the step k of an equivalent
backward Euler step, and the pressure matrix -dx^2 L, with a Laplacian L that is exact for linear fields.

    matrices.py N DT NU COMMAND_1 --and COMMAND_2

Both commands run the same flow of N x N particles in the unit square, the first with the files a.bin and
p.txt, the second with b.txt and q.bin."""
import csv
import struct
import subprocess
import sys


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


def particles(path):
    with open(path) as file:
        rows = list(csv.DictReader(file))
    assert [int(row["id"]) for row in rows] == list(range(len(rows))), path
    return [(float(row["x"]), float(row["y"])) for row in rows]


def difference(a, b):
    assert len(a) == len(b) and all(set(r) == set(s) for r, s in zip(a, b)), "other entries"
    largest = max(abs(v) for row in a for v in row.values())
    return max(abs(r[c] - s[c]) for r, s in zip(a, b) for c in r) / largest


def apply(matrix, f, row):
    return sum(value * f[column] for column, value in matrix[row].items())


def main():
    n, dt, nu = int(sys.argv[1]), float(sys.argv[2]), float(sys.argv[3])
    cut = sys.argv.index("--and")
    for command in sys.argv[4:cut], sys.argv[cut + 1:]:
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    visc, ppe, x = binary("a.bin"), ascii_("p.txt"), particles("a.bin.particles.csv")
    assert len(visc) == len(ppe) == len(x) == n * n
    # The number of ranks changes the rounding of 10 steps, and ASCII files have six digits.
    assert difference(visc, ascii_("b.txt")) < 1e-5
    assert difference(ppe, binary("q.bin")) < 1e-5
    for here, there in zip(x, particles("b.txt.particles.csv")):
        assert max(abs(a - b) for a, b in zip(here, there)) < 1e-8
    # A step of BDF2 has the matrix of a backward Euler step over k = 2 dt/3, with the shift 1/k = 3/(2 dt).
    shift, one, dx = 1.5 / dt, [1.0] * (n * n), 1.0 / n
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
