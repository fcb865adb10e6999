#!/usr/bin/env python3
"""Tests the views and monitors of solvers, the stages of -log_view, and the reductions of a step.

    views.py COMMAND...         COMMAND starts the program, on some ranks"""
import csv
import re
import struct
import subprocess
import sys


def output(*options):
    """Returns the lines that a run of three steps prints."""
    command = [*sys.argv[1:], "-case", "cavity", "-n", "12", "-max_steps", "3", "-progress", "none",
               *options]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def count(lines, beginning, number):
    """Asserts that exactly `number` lines begin with these words."""
    found = [line for line in lines if line.strip().startswith(beginning)]
    assert len(found) == number, (beginning, len(found), number)


def reductions(steps, *options):
    """Returns reductions in the stages of some steps, and Krylov iterations."""
    output(*options, "-max_steps", str(steps), "-log_view", ":log.py:ascii_info_detail", "-report", "r.csv")
    names = {}
    with open("log.py", encoding="utf-8") as file:  # a program, in Python
        exec(re.sub(r":\s*-?nan", ": 0", file.read()), names)
    with open("r.csv", encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    return (sum(stage["summary"][0]["numReductions"] for name, stage in names["Stages"].items()
                if name not in ("Main Stage", "Set-up", "Output")),
            steps * sum(float(last[name] or 0) for name in ("visc_its", "ppe_its", "coupled_its") if name in last))


def bounded(most, *options):
    """Asserts that a step has at most `most` reductions, besides two for each Krylov iteration."""
    (few, few_its), (many, many_its) = reductions(4, *options), reductions(8, *options)
    each = (many - few - 2 * (many_its - few_its)) / 4
    assert each <= most, (options, each, most)


def main():
    for motion in "lagrangian", "eulerian":  # a KSP is reset when particles are numbered anew
        lines = output("-motion", motion, "-visc_ksp_view", "-ppe_ksp_view", "-visc_ts_monitor",
                       "-ppe_ksp_converged_reason")
        count(lines, "KSP Object: (visc_)", 1)
        count(lines, "KSP Object: (ppe_)", 1)
        count(lines, "Linear ppe_ solve converged due to", 3)
        for step in 1, 2, 3:
            count(lines, f"{step} TS dt", 2)  # one integrator a component
        unknowns = 64  # splines on 6 x 6 cells
        lines = output("-motion", motion, "-ppe_ksp_view_mat", "::ascii_info",
                       "-ppe_ksp_view_pmat", "::ascii_info", "-ppe_ksp_view_rhs", "ascii:b.txt",
                       "-ppe_ksp_view_solution", "binary:x.dat", "-visc_ksp_view_mat",
                       "-visc_ksp_view_rhs", "-visc_ksp_view_solution")
        count(lines, "Mat Object:", 3)
        count(lines, "row 143:", 1)
        count(lines, "Vec Object:", 2)
        with open("b.txt", encoding="utf-8") as file:
            assert sum(line[:1] in "-0123456789" for line in file) == unknowns
        with open("x.dat", "rb") as file:  # class and size, in PETSc's integers, then the numbers
            head = file.read()[:-8 * unknowns]
        assert head in (struct.pack(">ii", 1211214, unknowns), struct.pack(">qq", 1211214, unknowns)), head
    lines = output("-visc_ts_view", "-ppe_ksp_monitor", "-log_view", "-visc_ts_type", "arkimex")
    for component in "u", "v":
        count(lines, f"TS Object: {component} (visc_)", 1)
    count(lines, "0 KSP Residual norm", 3)
    for stage in "Main Stage", "Set-up", "Steps", "Output", "move", "rebuild", "predict", "project", "check":
        assert any(f": {stage:>15}: " in line for line in lines), stage
    for event in "PairRates", "TSRHSFunction":  # of the weakly compressible scheme
        count(lines, event, 0)
    lines = output("-scheme", "wcsph", "-log_view", "-wcsph_ts_view")
    count(lines, "TS Object: flow (wcsph_)", 1)
    count(lines, "PairRates", 2)  # in the steps, and in the estimate of the error
    integrate = next(k for k, line in enumerate(lines) if re.match("--- Event Stage .*: integrate", line))
    steps = lines[integrate:next(k for k in range(integrate, len(lines)) if lines[k].startswith("Object Type"))]
    for event in "KSP", "PC", "SNES", "Mat", "Pressure", "Viscosity":  # the estimate of the error has solves, steps none
        count([line for line in steps if " 1.0 " in line], event, 0)  # events, not headings
    lines = output("-scheme", "coupled", "-motion", "eulerian", "-coupled_ksp_view",
                   "-coupled_schur_ksp_view", "-coupled_ksp_view_rhs", "ascii:c.txt", "-coupled_schur_ksp_view_mat",
                   "ascii:s.txt::append")
    count(lines, "KSP Object: (coupled_)", 1)
    count(lines, "KSP Object: (coupled_schur_)", 1)
    with open("c.txt", encoding="utf-8") as file:
        assert sum(line[:1] in "-0123456789" for line in file) == 2 * 144 + unknowns
    with open("s.txt", encoding="utf-8") as file:
        assert sum(line.strip().startswith("row ") for line in file) == unknowns
    bounded(30, "-motion", "lagrangian")
    bounded(30, "-motion", "eulerian")
    bounded(420, "-scheme", "coupled")
    bounded(150, "-scheme", "coupled", "-motion", "eulerian")


main()
