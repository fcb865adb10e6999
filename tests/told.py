#!/usr/bin/env python3
"""told.py ISPH - tests lines on runs that end with status 0 though something is wrong: of -scheme wcsph if the flow is far
from an incompressible one, of moving particles that are unevenly spread, and of balances out of their bounds

Each line is there for a run that needs it, and not for a run beside it that does not."""
import re
import subprocess
import sys

VORTICES = "-case taylor_green -reynolds 100 -n 8 -max_steps 2"
CAVITY = "-case cavity -reynolds 100 -n 8 -dt 0.01"
DROP = "-case scene -scene_box -1.5,-1.5,1.5,1.5 -scene_filled_1 circle,0,0,1 -viscosity 5 -n 6 -max_steps 1"
WCSPH = [  # line, run that has it, run that has it not
    # alpha h c0/(16 nu) = 1.6 for alpha = 0.2 and 0.08 for 0.01: h/dx = 1.3, c0 = 10
    (r"artificial_over_nu \S+, should be at most 1: ", f"{VORTICES} -artificial_viscosity 0.2",
     f"{VORTICES} -artificial_viscosity 0.01"),
    (r"sound_passage 2, should be at most 1: ", f"{CAVITY} -t_end 0.05", f"{CAVITY} -t_end 0.2"),  # L/c0 = 0.1
    (r"velocity not kept: -visc_laplacian direct ", f"{VORTICES} -visc_laplacian direct", VORTICES),
    (r"rotation not kept: -visc_laplacian morris ", f"{DROP} -visc_laplacian morris", DROP),
    (r"rotation not kept: ", f"{DROP} -visc_laplacian energy_sph", f"{DROP} -visc_laplacian energy_fpm"),
    (r"mach \S+, should be at most 0.2: ", f"{VORTICES} -sound_speed 3", VORTICES),
]
STRAINED = "-case taylor_green -reynolds 100 -n 24 -t_end 0.5"
RUNS = [*((line, f"-scheme wcsph {wrong}", f"-scheme wcsph {right}") for line, wrong, right in WCSPH),
        (r"unevenness \S+, should be at most 0.15: ", f"{STRAINED} -cfl 3", STRAINED)]
# Balances. The torques on two cylinders are opposite, which stiff plastics miss.
RINGS = ("-case scene -scene_box -0.65,-0.65,0.65,0.65 -scene_domain circle,0,0,0.5 -scene_body_1 "
         "circle,0,0,0.25 -scene_body_1_rotation 1 -viscosity 1 -without convection -n 20 -scheme coupled -steady")
DUCT = ("-case scene -scene_box 0,0,2,1 -scene_inflow left -scene_outflow right -scene_wall_left_velocity 6*y*(1-y),0 "
        "-viscosity 0.1 -motion eulerian -t_end 1")
RUNS += [
    (r"rotation not kept: torques on boundaries ", f"{RINGS} -rheology papanastasiou -rheology_yield 1 -visc_laplacian stress_mls", RINGS),
    (r"momentum not kept: forces on boundaries ", "-case cavity -motion eulerian -reynolds 400 -n 10 -t_end 3 -pressure_points same", f"{DUCT} -n 12"),
]


def lines(words):
    done = subprocess.run([sys.argv[1], *words.split(), "-progress", "none"], capture_output=True, text=True, check=True,
                          timeout=60)
    return done.stdout


for line, wrong, right in RUNS:
    assert re.search("^" + line, lines(wrong), re.M), (line, lines(wrong))
    assert not re.search("^" + line, lines(right), re.M), (line, lines(right))
