#!/usr/bin/env python3
"""freebodies.py NAME ISPH: bodies that move freely obey Newton's law at any density, reach the velocity at which drag and weight
balance, turn with half the vorticity, keep held components, and go on after a restart as if it had not been."""
import csv
import math
import os
import subprocess
import sys

RADIUS = 0.125
BOX = f"-case scene -scene_box 0,0,1,1 -n 16 -scene_body_1 circle,0.5,0.5,{RADIUS} -viscosity 0.05 -dt 0.01 "
FALL = BOX + "-body_force 0,-1 "


def report(isph, words):
    """Runs isph and returns the values of its report."""
    if os.path.exists("r.csv"):
        os.remove("r.csv")
    subprocess.run([isph, *words.split(), "-progress", "none", "-report", "r.csv"], check=True,
                   stdout=subprocess.DEVNULL)
    with open("r.csv", newline="") as file:
        return {row["quantity"]: float(row["value"]) for row in csv.DictReader(file)}


def newton(isph):
    """In the first step, of order 1, m v/dt = F - m g with the force of the report; a neutral body stays. A body without
    mass has the acceleration of the fluid that it displaces over that which moves with it, at least g rho V/(2 rho V)."""
    for scheme in ("projection", "coupled"):
        for density in (1e-3, 1.0, 1e3):
            mass = density * math.pi * RADIUS**2
            row = report(isph, f"{FALL}-scheme {scheme} -max_steps 1 -time_order 1 -scene_body_1_density {density}")
            v = row["body_1_v"]
            off = abs(mass * (v / 0.01 + 1.0) - row["body_1_fy"]) / max(mass, math.pi * RADIUS**2)
            print(scheme, density, v, "off", off, "solves", row["body_solves"])
            assert off < 2e-4, (scheme, density)
            assert abs(v) < 1e-9 if density == 1.0 else (v > 0.0) == (density < 1.0), (scheme, density)
            assert abs(v) < 1.0e-2, (scheme, density)
    row = report(isph, "-case scene -dim 3 -n 8 -scene_periodic z -scene_box 0,0,0,1,1,0.5 -scene_body_1 cylinder,0.5,0.5,0.2 "
                       "-scene_body_1_density 1 -body_force 0,-1,0 -viscosity 0.05 -dt 0.01 -max_steps 1 -time_order 1")
    assert abs(row["body_1_v"]) < 1e-9 and abs(row["body_1_fy"] / (0.02 * math.pi) - 1) < 1e-5, row  # its weight


def terminal(isph):
    """A cylinder between walls, d/W = 0.25, whose weight less buoyancy is its drag by Faxen (1946), 21.964 mu U. The drag
    of a fixed cylinder errs by 2 % at 8 particles along the diameter too."""
    row = report(isph, "-case scene -without convection -scene_box 0,0,1,4 -n 32 -scene_body_1 circle,0.5,2,0.125 "
                       "-scene_body_1_density 2 -viscosity 1 -body_force 0,-1 -dt 0.04 -t_end 1")
    ratio = row["body_1_v"] / (-math.pi * RADIUS**2 / 21.964)
    print("terminal velocity over Faxen's", ratio, "solves", row["body_solves"])
    assert abs(ratio - 1.0) < 0.025 and abs(row["body_1_spin"] * RADIUS) < 1e-3 * abs(row["body_1_v"])


def shear(isph):
    """Half the vorticity in a shear; walls at five radii take 2 % of it. A held rotation stays as given."""
    words = ("-case scene -without convection -scene_box 0,-0.5,1,0.5 -n 32 -scene_periodic x "
             "-scene_wall_top_velocity 0.5,0 -scene_wall_bottom_velocity -0.5,0 -scene_velocity y,0 "
             "-scene_body_1 circle,0.5,0,0.1 -scene_body_1_density 2 -viscosity 1 -dt 0.05 -t_end 1 ")
    spin = report(isph, words)["body_1_spin"]
    print("spin over the vorticity", -spin)
    assert 0.485 < -spin < 0.5
    held = report(isph, words + "-scene_body_1_hold rotation -scene_body_1_rotation 0.25 -max_steps 3")
    assert held["body_1_spin"] == 0.25


def contact(isph):
    """A heavy body comes to rest on the floor and a light one below the ceiling, pushed off by about dx, in steps of few
    solves."""
    words = ("-case scene -scene_box 0,0,1,1 -n 24 -scene_body_1 circle,0.3,0.31,0.125 -scene_body_1_density 3 -viscosity 0.05 "
             "-scene_body_2 circle,0.68,0.69,0.125 -scene_body_2_density 0.1 -body_force 0,-1 -t_end 6")
    row = report(isph, words)
    gaps = row["body_1_y"] - 0.125, 1 - row["body_2_y"] - 0.125
    print("gaps in dx", [24 * gap for gap in gaps], "contacts", row["body_contacts"], "solves", row["body_solves"])
    assert all(0.8 < 24 * gap < 1.05 for gap in gaps) and row["body_contacts"] > 0 and row["body_solves"] < 4
    assert max(abs(row["body_1_v"]), abs(row["body_2_v"])) < 0.05  # they tremble by a hundredth of dx in a step


def restart(isph):
    """The second half of a run from a checkpoint is that of the whole run, bit for bit, in contact with the ceiling."""
    words = FALL + "-scene_body_1 circle,0.5,0.82,0.125 -scene_body_1_density 0.5 -scene_body_1_force 0.01*sin(9*t),0 -scene_body_1_spring 0.1,0.2 "
    whole = report(isph, words + "-max_steps 8")
    assert whole["body_contacts"] > 0
    report(isph, words + "-max_steps 4 -checkpoint half.h5")
    half = report(isph, words + "-max_steps 8 -restart half.h5")
    for name, value in whole.items():
        if name.startswith("body_"):
            assert half[name] == value, (name, value, half[name])


{test.__name__: test for test in (newton, terminal, shear, contact, restart)}[sys.argv[1]](sys.argv[2])
