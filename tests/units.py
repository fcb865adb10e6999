#!/usr/bin/env python3
"""Runs the cavity in other units of length, time and mass, scaled by 2^30 and 2^-30. Every dimensionless
quantity must be equal to the last bit, because multiplication by a power of two is exact. A tolerance that
is wrongly a fixed length, time or mass would change the result.

    units.py ISPH"""
import csv
import os
import subprocess
import sys

POWER = {  # powers of length, time and mass in the reported quantities
    "u_min": (1, -1, 0), "v_max": (1, -1, 0), "v_min": (1, -1, 0), "kinetic_energy": (2, -2, 1),
    "divergence_max": (0, -1, 0), "linear_momentum": (1, -1, 1),
    "velocity_l2_estimate": (0, 0, 0), "error_space": (0, 0, 0), "error_operator": (0, 0, 0),
    "error_time": (0, 0, 0), "trust": (0, 0, 0), "mach": (0, 0, 0), "density_variation": (0, 0, 0),
    "sound_passage": (0, 0, 0), "force_balance": (0, 0, 0), "torque_balance": (0, 0, 0), "balance": (0, 0, 0)}
DEPTH = 1  # in 2D energies and momenta are per length of depth, and the density is mass / length^3


def run(isph, name, length, time, mass, words=()):
    path = f"{name}.csv"
    subprocess.run(
        [isph, "-n", "16", "-max_steps", "12", "-progress", "none", "-report", path,
         "-length", repr(length), "-speed", repr(length / time), "-density", repr(mass / length ** 3),
         "-body_force", f"{0.1 * length / time ** 2!r},0", *words], check=True, stdout=subprocess.DEVNULL)
    with open(path, newline="") as file:
        rows = {row["quantity"]: float(row["value"]) for row in csv.DictReader(file)}
    os.remove(path)
    scaled = {}
    for quantity, value in rows.items():
        l, t, m = POWER[quantity]
        if m:
            l -= DEPTH
        scaled[quantity] = value / (length ** l * time ** t * mass ** m)
    return scaled


def compare(words, steps):
    """Returns the number of units in which a flow with further words differs."""
    big, small, wrong = 2.0 ** 30, 2.0 ** -30, 0
    base = run(sys.argv[1], "base", 1.0, 1.0, 1.0, words)
    assert len(base) >= 8, base
    for length, time, mass in steps:
        length, time, mass = (big if x > 0 else small if x < 0 else 1.0 for x in (length, time, mass))
        other = run(sys.argv[1], "other", length, time, mass, words)
        same = other == base
        print(f"{' '.join(words)} length {length:g}, time {time:g}, mass {mass:g}: {'same' if same else 'DIFFERENT'}")
        if not same:
            print(base, other, sep="\n")
            wrong += 1
    return wrong


def main():
    wrong = compare((), ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1, -1, -1), (-1, 1, 1)))
    wrong += compare(("-scheme", "wcsph", "-equation_of_state", "ideal_gas"), ((1, -1, -1), (-1, 1, 1)))
    sys.exit(wrong > 0)


main()
