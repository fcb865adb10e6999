#!/usr/bin/env python3
"""Tests the iteration for fluids whose viscosity follows the strain rate.

    rheology.py ISPH

Newton's method converges in a few solves from rest, also for plastics of Bingham numbers near 100 in both schemes, whose
velocities agree, and for exponents from 0.3 to 4; its last steps are quadratic. A sheared layer of less than two particles is
said, one of three is not, one between the particles and the wall is said, and a velocity that errs by more than 10 % is not trusted. With strains of cells channels at Bn = 97 are right."""
import re
import subprocess
import sys

SOLVES = 15  # of a flow from rest; 7 to 12
YIELD = 0.0914281628567  # distance of the yield surface from the walls of the channel, whose exact velocity follows
EXACT = (f"min(y,1-y)<{YIELD}?2.45*(0.5*min(y,1-y)-min(y,1-y)^2/2)-min(y,1-y):0.0103314281627,0")
LARGE = ("min(y,1-y)<0.03063858403?2.130554336*(0.5*min(y,1-y)-min(y,1-y)^2/2)-min(y,1-y):0.001,0")  # Bn = 1000
PLASTIC = "-viscosity 1 -without convection -rheology papanastasiou"
CHANNEL = f"-case scene -scene_box 0,0,0.5,1 -scene_periodic x -body_force 2.45,0 -speed 0.01 {PLASTIC} -rheology_yield 1"
CAVITY = f"-case scene -scene_wall_top_velocity 1,0 {PLASTIC} -rheology_yield 100"
COUPLED = "-scheme coupled -steady -coupled_ksp_converged_reason"
PROJECTION = "-visc_snes_monitor -dt 10 -t_end 40"
POWER = "-case poiseuille -reynolds 0.5 -rheology power_law -n 16 -dt 100 -max_steps 1 -visc_snes_monitor"


def run(words):
    """Returns the output of a run and the numbers of its report."""
    done = subprocess.run([sys.argv[1], *words.split(), "-progress", "none"], capture_output=True, text=True, check=True,
                          timeout=60)
    return done.stdout, {name: float(value) for name, value in re.findall(r"^(\w+) +([-+.\de]+) +-? ", done.stdout, re.M)}


def norms(text):
    """Returns the residuals of the first step's iterations."""
    found = [(int(k), float(norm)) for k, norm in re.findall(r"(\d+) SNES Function norm (\S+)", text)]
    last = next((k for k in range(1, len(found)) if found[k][0] == 0), len(found))
    return [norm for _, norm in found[:last]]


for n in (16, 24):
    text, steady = run(f"{CHANNEL} -n {n} {COUPLED}")
    solves = len(re.findall("Linear coupled_ solve", text))
    assert 3 < solves <= SOLVES, (n, solves)
    text, late = run(f"{CHANNEL} -n {n} {PROJECTION}")
    first = norms(text)
    assert len(first) <= SOLVES + 1 and first[-1] < 0.02 * first[-2] < 1e-3 * first[-3], first
    error = abs(late["kinetic_energy"] / steady["kinetic_energy"] - 1)
    assert error < 0.01, (n, error)
for scheme in ("-dt 10 -t_end 40", COUPLED):  # a typed law is that of the table
    law = [run(f"-case scene -scene_box 0,0,0.5,1 -scene_periodic x -body_force 1,0 -viscosity 1 -without convection -n 16 {scheme} {words}")[1]
           for words in ("-rheology power_law -rheology_exponent 0.6", "-viscosity_field g^(-0.4)")]
    error = abs(law[0]["kinetic_energy"] / law[1]["kinetic_energy"] - 1)
    assert error < 1e-6, (scheme, error)  # the tolerance of the iteration
text, _ = run(f"{CAVITY} -n 20 {COUPLED}")
assert 3 < len(re.findall("Linear coupled_ solve", text)) <= SOLVES, text
for exponent in (0.3, 4):
    assert len(norms(run(f"{POWER} -rheology_exponent {exponent}")[0])) <= SOLVES + 1, exponent
for flow, exact, n in ((CHANNEL, EXACT, 16), (CHANNEL.replace("2.45", "2.130554336").replace("0.01", "0.001"), LARGE, 28)):
    text, report = run(f"{flow} -n {n} -scheme coupled -steady -scene_exact {exact}")
    assert report["velocity_l2"] < 0.1 or report["trust"] == 0, (n, report)
_, still = run("-case scene -scene_box 0,0,0.25,1 -scene_periodic x -body_force 2016.24532,0 -viscosity 1 -without convection -rheology "
               "herschel_bulkley -rheology_exponent 0.3 -rheology_consistency 1 -rheology_yield 1000 -n 20 -scheme coupled -steady")
assert still["trust"] == 0 and still["sheared_layer"] == 0.5, still  # its mean velocity should be 1: layers of 0.004 yield
for n, most in ((16, 0.06), (20, 0.025)):
    text, report = run(f"{CHANNEL} -n {n} {COUPLED} -scene_exact {EXACT} -visc_laplacian weak_stress")
    assert report["velocity_l2"] < most and len(re.findall("Linear coupled_ solve", text)) <= SOLVES, (n, report)
for n, thin in ((16, True), (32, False)):
    text, report = run(f"{CHANNEL} -n {n} -scene_velocity {EXACT} -dt 1e-12 -max_steps 1")
    assert abs(report["sheared_layer"] / (YIELD * n) - 1) < 0.1, (n, report["sheared_layer"])
    assert ("sheared layers beside rigid parts are 1.4 particles thick" in text) == thin, text
