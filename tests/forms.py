#!/usr/bin/env python3
"""Runs the cavity at Re = 100, n = 24, for 24 steps with every Laplacian of the catalogue, first as
viscous operator, then as pressure operator. A form that is not safe_implicit, or that couples components,
must be refused for the pressure by a single line.

    forms.py ISPH

The kinetic energy must be within 17 % of the reference at that time: resolution and walls cause errors
of 5 to 16 %, a wrong operator far larger errors. A form that does not declare null_constants damps uniform
velocities, and must be outside. Forms of two
passes are those of explicit steps, and refused. A form that declares varying_viscosity also runs a Couette
flow with nu = 1 + 9 y, which must be within 3 % of u = ln(1 + 9 y)/ln 10; without the term
grad nu.grad u the flow would be u = y, with an error of 25 %. Any other form must be refused there."""
import re
import subprocess
import sys


def catalogue(isph):
    """Returns the names of the Laplacians with their declared properties."""
    text = subprocess.run([isph, "-catalogue"], check=True, capture_output=True, text=True).stdout
    section = text.split("\nLaplacians (", 1)[1].split("\n\n", 1)[0]
    forms = {}
    for line in section.splitlines()[1:]:
        name = re.match(r"  (\w+) ", line)
        if name:
            last = name.group(1)
        elif "null_constants" in line or "couples_components" in line:
            forms[last] = line.split(";")[0].replace(",", " ").split()
    return forms


LAYERED = ("-case scene -without pressure,convection -scene_box 0,0,0.32,1 -scene_periodic x -n 25 -viscosity 1 "
           "-scene_wall_top_velocity 1,0 -t_end 1e6 -dt 2e5 -check_velocity_l2 0.03 -progress none").split()
LAYERED += ["-viscosity_field", "1 + 9*y", "-scene_exact", "log(1 + 9*y)/log(10), 0", "-scene_velocity", "0,0"]


def varying(isph, name, properties):
    """Returns true if a form runs with a varying viscosity if it declares this, and is refused otherwise."""
    done = subprocess.run([isph, *LAYERED, "-visc_laplacian", name], capture_output=True, text=True)
    declared = "varying_viscosity" in properties
    good = done.returncode == 0 if declared else "this form has no varying viscosity" in done.stderr
    print(f"{name}, varying viscosity: {'run' if declared else 'refused'}, {'good' if good else 'WRONG'}")
    if not good:
        print(done.stdout, done.stderr)
    return good


TWO_PASSES = "two_pass", "energy_sph", "energy_fpm", "energy_coupled"


def main():
    isph, wrong = sys.argv[1], 0
    forms = catalogue(isph)
    assert len(forms) >= 9, forms
    for name, properties in forms.items():
        wrong += not varying(isph, name, properties)
        for option in "-visc_laplacian", "-ppe_laplacian":
            done = subprocess.run(
                [isph, "-n", "24", "-max_steps", "24", option, name, "-progress", "none",
                 "-check_kinetic_energy", "0.17"], capture_output=True, text=True)
            refused = name in TWO_PASSES or option == "-ppe_laplacian" and ("safe_implicit" not in properties
                                                          or "couples_components" in properties)
            if refused:
                good = done.returncode != 0 and done.stderr.startswith(f"isph: {option} {name}: ")
            else:
                good = (done.returncode == 0) == ("null_constants" in properties)
            print(f"{option} {name}: {'refused' if refused else 'run'}, {'good' if good else 'WRONG'}")
            if not good:
                print(done.stdout, done.stderr)
                wrong += 1
    sys.exit(wrong > 0)


main()
