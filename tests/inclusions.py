"""Tests inclusions of other viscosities against finite elements, and that their interfaces hold in time: inclusions.py ISPH OPTIONS"""
import re
import subprocess
import sys

# Velocity at the centre by finite elements: studies/viscosity_references.py.
CENTRE = {"1e-4": -0.2347, "1e-3": -0.2346, "1": -0.1970, "1e3": -0.1606, "1e6": -0.1606}


def run(words):
    """Returns the report of a run by name, and the last row of its probe."""
    done = subprocess.run([sys.argv[1], *words.split(), "-progress", "none"], capture_output=True, text=True, check=True, timeout=100)
    report = {name: float(value) for name, value in re.findall(r"^(\w+) +([-+.\de]+) +-? ", done.stdout, re.M)}
    with open("probe_point.csv", encoding="utf-8") as file:
        return report, [float(value) for value in file.read().split("\n")[-2].split(",")]


for ratio, exact in CENTRE.items():
    _, row = run(f"-options_file {sys.argv[2]} -scene_fluid_1_viscosity {ratio}")
    assert abs(row[6] / exact - 1) < 0.015, (ratio, row)
    assert abs(row[7]) < 0.005 and abs(row[9]) < 0.05, (ratio, row)  # the flow is symmetric
# The long run of each scheme is the steady flow.
for ratio in ("1e-2", "1e6"):
    steady, _ = run(f"-options_file {sys.argv[2]} -scene_fluid_1_viscosity {ratio} -n 24")
    for scheme in ("projection", "coupled"):
        late, _ = run(f"-case scene -without convection -viscosity 1 -scene_wall_top_velocity 1,0 -scene_fluid_1 circle,0.5,0.6,0.15 "
                      f"-scene_fluid_1_viscosity {ratio} -n 24 -scheme {scheme} -dt 0.1 -t_end 3 -probe_point 0.5,0.6")
        assert abs(late["kinetic_energy"] / steady["kinetic_energy"] - 1) < 0.01, (ratio, scheme, late, steady)
