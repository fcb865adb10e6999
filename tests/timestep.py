#!/usr/bin/env python3
"""Checks the steps of -dt_adapt error.

    timestep.py third ISPH    with -time_order 3 errors in time are of order 3, and moving vortices profit
    timestep.py order ISPH    the steps grow as the cube root of the tolerance, errors in time fall with its power 2/3
    timestep.py limits ISPH   short periods, -dt_max and small tolerances bound the step; jumps of walls end no run
    timestep.py steady ISPH   steady flows take as many steps as with -dt_adapt cfl, but for the start"""
import csv
import os
import subprocess
import sys


def run(isph, *words):
    """Runs isph and returns the first row of its report with its quantities added."""
    if os.path.exists("r.csv"):
        os.remove("r.csv")
    subprocess.run([isph, *words, "-progress", "none", "-report", "r.csv"], check=True, stdout=subprocess.DEVNULL)
    with open("r.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return {**rows[0], **{row["quantity"]: float(row["value"]) for row in rows}}


CHANNEL = ("-case scene -scene_periodic x -scene_box 0,0,0.5,1 -viscosity 0.05 -without pressure,convection -n 16 "
           "-t_end 0.45 -body_force 10*pi*cos(10*pi*t),0").split()


def order(isph):
    """The error of a step is of order 3, and the error of the flow at a given time of order 2."""
    exact = run(isph, *CHANNEL, "-dt", "5e-5")["kinetic_energy"]
    runs = [run(isph, *CHANNEL, "-dt_rtol", str(5e-5 / 8**k)) for k in range(3)]
    steps = [int(r["steps"]) for r in runs]
    errors = [abs(r["kinetic_energy"] / exact - 1) for r in runs]
    print(steps, errors)
    for k in 0, 1:
        assert 1.7 < steps[k + 1] / steps[k] < 2.2, steps
        assert 3.3 < errors[k] / errors[k + 1] < 5, errors


def third(isph):
    """Halved steps: a fourth of the error with BDF2, an eighth with BDF3. Moving particles turn with the flow, so that their
    error in time is most of the error of quartic fits. The first step of backward Euler is no reason to end a run: at
    dt = 0.01 it makes the velocity larger than the force alone."""
    run(isph, *CHANNEL, "-dt", "1e-2", "-time_order", "2")
    exact = run(isph, *CHANNEL, "-dt", "5e-5")["kinetic_energy"]
    ratios = []
    for number, low, high in (2, 3.8, 4.3), (3, 6.2, 8.3):
        errors = [abs(run(isph, *CHANNEL, "-dt", str(dt), "-time_order", str(number))["kinetic_energy"] / exact - 1)
                  for dt in (5e-3, 2.5e-3)]
        ratios.append(errors[0] / errors[1])
        assert low < ratios[-1] < high, (number, errors)
    vortices = "-case taylor_green -reynolds 100 -n 40 -mls_degree 4".split()
    second, best = (run(isph, *vortices, "-time_order", number)["velocity_l2"] for number in "23")
    print(ratios, second, best)
    assert best < second / 2, (second, best)


def limits(isph):
    # The CFL number allows dt = 15; the wall has the period 1, of which at least 20 steps are made.
    slow = ("-case scene -scene_periodic x -without pressure,convection -speed 1e-3 -viscosity 0.1 -n 32 -t_end 2 "
            "-scene_wall_top_velocity 1e-3*cos(2*pi*t),0").split()
    loose = run(isph, *slow, "-dt_rtol", "0.1")
    assert int(loose["steps"]) >= 38, loose["steps"]
    tight = run(isph, *slow, "-dt_rtol", "1e-5")
    assert int(tight["steps"]) > 4 * int(loose["steps"]), (loose["steps"], tight["steps"])
    bounded = run(isph, *slow, "-dt_rtol", "0.1", "-dt_max", "0.01")
    assert 200 <= int(bounded["steps"]) < 215, bounded["steps"]
    # The lid starts and stops at once: some steps are repeated, none fails, and dt recovers.
    jump = run(isph, "-case", "scene", "-n", "16", "-t_end", "2", "-scene_wall_top_velocity", "t>1?1:0,0")
    print(loose["steps"], tight["steps"], bounded["steps"], jump["steps"], jump["rejected"])
    assert 0 < jump["rejected"] < 20 and jump["retries"] == 0 and int(jump["steps"]) < 200, jump


def steady(isph):
    """The start takes at most 60 steps more, and no step is repeated after it."""
    for flow in ("-case cavity -n 25 -t_end 4", "-case cavity -n 25 -t_end 4 -motion eulerian",
                 "-case taylor_green -n 24"):
        cfl, error = (run(isph, *flow.split(), "-reynolds", "100", "-dt_adapt", name) for name in ("cfl", "error"))
        print(flow, cfl["steps"], error["steps"], error["rejected"])
        assert int(error["steps"]) <= int(cfl["steps"]) + 60, (flow, cfl["steps"], error["steps"])
        assert abs(error["kinetic_energy"] / cfl["kinetic_energy"] - 1) < 0.02, flow


{"third": third, "order": order, "limits": limits, "steady": steady}[sys.argv[1]](sys.argv[2])
