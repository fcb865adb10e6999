#!/usr/bin/env python3
"""momentum.py ISPH: the momentum of periodic boxes without forces stays what it was; a force f changes it by f t."""
import csv
import os
import subprocess
import sys

ROUNDING = 1e-12  # of the flow's momentum
LAYER = ("-case scene -scene_box 0,0,1,1 -scene_periodic x,y -reynolds 1000 -t_end 0.2 "
         "-scene_velocity 0.3+tanh(20*(y<0.5?y-0.25:0.75-y)),0.05*sin(2*pi*x)")


def run(isph, words):
    """Runs isph and returns linear_momentum over the momentum of all fluid at the root mean square of the speed."""
    if os.path.exists("r.csv"):
        os.remove("r.csv")
    subprocess.run([isph, *words.split(), "-progress", "none", "-report", "r.csv"], check=True,
                   stdout=subprocess.DEVNULL)
    with open("r.csv", newline="") as file:
        row = {row["quantity"]: float(row["value"]) for row in csv.DictReader(file)}
    return row["linear_momentum"] / (2 * row["kinetic_energy"])**0.5, row["linear_momentum"]


def main(isph):
    for more in ("", " -pressure_points same", " -velocity_filter 4", " -motion eulerian", " -visc_ts_type cn",
                 " -visc_laplacian pairwise_stress"):
        share, _ = run(isph, "-case taylor_green -n 24 -jitter 0 -t_end 0.2" + more)
        print("vortices", more, share)
        assert share < ROUNDING, more
    for more in ("", " -pressure_points same"):
        start, drift = (run(isph, f"{LAYER} -n 32{more}{end}")[1] for end in (" -max_steps 1", ""))
        print("layer", more, start, drift - start)
        assert abs(start - 0.3) < 1e-6 and abs(drift - start) < ROUNDING, more
    # Momentum of fluid that a force accelerates from rest: density 1, volume 1, f = 0.5, t = 0.2.
    _, forced = run(isph, "-case scene -scene_box 0,0,1,1 -scene_periodic x,y -body_force 0.5,0 -n 16 -t_end 0.2 -dt 0.02")
    print("forced", forced)
    assert abs(forced - 0.1) < 1e-4, forced


main(sys.argv[1])
