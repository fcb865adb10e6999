#!/usr/bin/env python3
"""Tests that a run says how far its velocity can be trusted, and why not.

    estimates.py ISPH...

ISPH... is the program, followed by the words that start it on several ranks, with {} for their number. Exact solutions
of the flows are typed, so that the report has the true error beside the estimate. Flows that the operators represent
exactly are trusted; errors by the form, by the step and by the start are found and named. Contact lines that move on walls without
slip are told, and those at rest are not."""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
CHANNEL = ("-case scene -scene_periodic x -scene_box 0,0,0.5,1 -viscosity 1 -without convection -body_force 8,0 "
           "-scene_exact 4*y*(1-y),0 -n 16")
EXACT = {  # flows whose fits are exact: estimate below 1e-6, whatever their particles
    "channel": CHANNEL + " -t_end 1",
    "channel, coupled": CHANNEL + " -scheme coupled -steady",
    "shear, jitter": "-case scene -scene_periodic x -scene_wall_top_velocity 1,0 -scene_exact y,0 -viscosity 1 "
                     "-without convection -scheme coupled -steady -n 12 -jitter 0.2",
    "at rest": "-case hydrostatic -n 12",
}
CLOSE = {  # flow: (cause of the error, options); the estimate within a factor of 4
    "inconsistent form": ("operator", CHANNEL + " -visc_laplacian cleary -t_end 1"),
    "vortices": ("space", "-case taylor_green -n 24 -t_end 0.5"),
    "fixed vortices": ("space", "-case taylor_green -n 24 -t_end 0.5 -motion eulerian"),
    "sheet of four particles": ("operator", f"-options_file {ROOT}/options/sheet.opts -n 4 -max_steps 1"),
    "long steps": ("time", f"-options_file {ROOT}/options/womersley.opts -n 16 -dt 0.015 -motion eulerian"),
}
VIOLATED = {  # not trusted: the reason is the same in all of them
    "drop in a cavity": "-case scene -without convection -viscosity 1 -scene_wall_top_velocity 1,0 -scene_fluid_1 "
                        "circle,0.5,0.6,0.15 -scene_fluid_1_viscosity 1e-3 -n 24 -scheme coupled -steady",
    "Bingham between cylinders": "-case scene -scene_box -0.65,-0.65,0.65,0.65 -scene_domain circle,0,0,0.5 "
                                 "-scene_body_1 circle,0,0,0.25 -scene_body_1_rotation 1 "
                                 "-viscosity 1 -without convection -rheology papanastasiou -rheology_yield 4 -n 20 "
                                 "-scheme coupled -steady",
    "anti-diffusive form": CHANNEL + " -visc_laplacian direct -t_end 1",
}
DROP = f"-options_file {ROOT}/options/drop_angle.opts"
COLUMN = ("-case scene -scene_box 0,0,2,1.5 -scene_filled_1 box,0,0,0.5,1 -scene_symmetry left -body_force 0,-1 "
          "-viscosity 1 -n 10 -t_end 4")
LINES = {  # flow: (walls along which a contact line moves that they do not resolve, options)
    "drop at rest": ([], DROP),
    "drop that spreads": (["bottom"], DROP + " -scene_filled_1 circle,0,0,0.49975 -t_end 20"),
    "column": (["bottom"], COLUMN),
    "column on a wall that slips": ([], COLUMN + " -scene_wall_bottom_slip 0.2"),
    "jet that leaves": ([], f"-options_file {ROOT}/options/jet_free.opts"),
    "roll": (["body_1"], f"-options_file {ROOT}/options/roll.opts -n 12 -t_end 0.3"),
}
JET = ("-case scene -dim 3 -scene_box 0,0,0,1,1,1 -scene_inflow left -scene_outflow right -scene_wall_left_velocity 1,0,0 "
       "-scene_velocity 1,0,0 -viscosity 1 -surface_tension 1 -n 8 -dt 0.02 -t_end 0.02 ")
LEAVES = {  # flow: (an outflow lacks the pressure of the tension, options)
    "round jet": (True, JET + "-scene_opening_left circle,0.5,0.5,0.3 -scene_filled_1 cylinder,-1,0.5,0.5,2,0.5,0.5,0.3"),
    "curtain": (False, JET + "-scene_opening_left box,0.25,-1,0.75,2 -scene_symmetry back,front "
                             "-scene_filled_1 box,-1,0.25,-1,2,0.75,2"),
}
SHEET = f"-options_file {ROOT}/options/sheet.opts -n 6 -t_end 120 -jitter 0.1"
PARTS = ("error_space", "error_operator", "error_time")


def run(command, options, ranks=1):
    isph, *mpi = command
    start = [word.replace("{}", str(ranks)) for word in mpi] + [isph] if ranks > 1 else [isph]
    done = subprocess.run([*start, *options.split(), "-progress", "none"], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{options}: status {done.returncode}: {done.stderr.strip()}")
    rows = [line.split() for line in done.stdout.partition("\nquantity ")[2].partition("\n\n")[0].splitlines()[1:]]
    return {row[0]: float(row[1]) for row in rows if len(row) == 4 and row[1] not in ("-", "value")}, done.stdout


def check(holds, sentence):
    if not holds:
        sys.exit(sentence)


def main():
    command = sys.argv[1:]
    for name, options in EXACT.items():
        report, text = run(command, options)
        estimate = report["velocity_l2_estimate"]
        check(estimate < 1e-6 and report["trust"] == 1.0 and "not trusted" not in text, f"{name}: estimate {estimate}")
    for name, (cause, options) in CLOSE.items():
        report, text = run(command, options)
        error, estimate = report["velocity_l2"], report["velocity_l2_estimate"]
        check(error / 4 < estimate < 4 * error, f"{name}: error {error}, estimate {estimate}")
        if report["trust"] == 0.0:
            check(f"most of it by {cause}" in text, f"{name}: the cause is not {cause}: {text}")
        else:
            check(max(PARTS, key=report.get) == f"error_{cause}" or cause == "space", f"{name}: {report}")
    for name, options in VIOLATED.items():
        report, text = run(command, options)
        check(report["trust"] == 0.0 and "not trusted: " in text, f"{name}: trusted, {report}")
    for name, (walls, options) in LINES.items():
        told = re.findall(r"^contact line: .* the (\w+) wall", run(command, options)[1], re.M)
        check(told == walls, f"{name}: contact lines on {told}")
    for name, (lacks, options) in LEAVES.items():
        check(("outflow not trusted" in run(command, options)[1]) == lacks, f"{name}: pressure of the outflow")
    for options in ("-case taylor_green -n 16 -t_end 0.2", SHEET):
        one, three = (run(command, options, ranks)[0] for ranks in (1, 3))
        for part in PARTS:
            check(abs(one[part] - three[part]) <= 0.02 * one["velocity_l2_estimate"], f"{part}: {one[part]}, {three[part]}")
    ends = [re.findall(r"^kinetic_energy .*?(\S+) +- +-$", run(command, SHEET + more)[1], re.M)[-1]
            for more in ("", " -report_times 60")]
    check(ends[0] == ends[1], f"a report changes the run: {ends}")


if __name__ == "__main__":
    os.environ.setdefault("OMPI_MCA_rmaps_base_oversubscribe", "1")
    main()
