#!/usr/bin/env python3
"""Runs isph-study for two tiny scenes: its errors against those of the runs, its statistics, failures, resumption and
lines for unsuitable input.

    study.py ISPH_STUDY ISPH OPTIONS"""
import csv
import glob
import json
import math
import os
import signal
import statistics
import subprocess
import sys
import time

study, isph, options = sys.argv[1:]
WALLS = os.path.join(options, "stokes_walls.opts")
BODY = ("-case scene\n-scene_wall_top_velocity 1,0\n-reynolds 10\n-scene_body_1 circle,0.5,0.5,0.2\n-motion eulerian\n"
        "-max_steps 2\n-probe_point 0.1,0.9\n-output flow.h5  # each run has its own\n")
STEP = 1e-5  # difference of the jitters of two starts [dx]


def command(*words):
    return [sys.executable, study, *words, "--isph", isph]


def call(*words):
    return subprocess.run(command(*words), capture_output=True, text=True, check=False)


def succeed(*words):
    done = call(*words)
    assert done.returncode == 0, (words, done.returncode, done.stderr)
    return done


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def check_error():
    """Orders and errors are those of the reports; a longer list adds runs, and the same makes none."""
    words = ["error", WALLS, "--swap", "-visc_laplacian morris", "--swap=-visc_laplacian mls", "--out", "e", "-dt", "1"]
    assert succeed(*words, "--n", "6,8").stderr.count("\n") == 4
    done = succeed(*words, "--n", "6,8,12")
    assert done.stderr.count("\n") == 2, done.stderr
    assert "velocity_l2: error by exact" in done.stdout and ("drew" in done.stdout or "no picture" in done.stdout), done.stdout
    table = rows("e/error.csv")
    assert [(row["setting"], row["n"]) for row in table] == [
        (f"-visc_laplacian {form}", n) for form in ("morris", "mls") for n in ("6", "8", "12")], table
    for row in table:
        report = rows(f"e/runs/{row['folder']}/report.csv")
        assert float(row["error"]) == [float(r["error"]) for r in report if r["quantity"] == "velocity_l2"][0], row
        assert float(row["cpu_s"]) == float(report[0]["cpu_s"]) > 0.0, row
    one, two = (float(row["error"]) for row in table[-2:])
    shown = [line.split(" | ")[-2] for line in done.stdout.splitlines() if "| -visc_laplacian mls | 12 |" in line]
    assert shown == [f"{math.log(one / two) / math.log(12 / 8):.2f}"], (shown, one, two)
    cut = glob.glob("e/runs/*/record.json")[0]
    with open(cut, "w") as file:
        file.write('{"kind": "holds"')
    assert succeed(*words, "--n", "6,8,12").stderr.startswith("[1/1]"), "a run that was cut is no run"
    done = succeed(*words, "--n", "6,8,12", "--by", "estimate", "--quantity", "velocity")
    assert not done.stderr and "the program's own estimate" in done.stdout, done


def check_reference():
    """Numbers, forces and probes against a finer run, and against the limit of three runs."""
    with open("body.opts", "w") as file:
        file.write(BODY)
    words = ["error", "body.opts", "--out", "r", "--jobs", "2", "--quantity"]
    succeed(*words, "body_1_fy,point_0_u", "--n", "20,26", "--reference", "32")
    found = {(row["quantity"], row["n"]): row for row in rows("r/error.csv")}
    with open(glob.glob("r/runs/n_32_*/record.json")[0]) as file:
        finer = json.load(file)["numbers"]
    own = rows(f"r/runs/{found['body_1_fy', '20']['folder']}/report.csv")
    force = [float(row["value"]) for row in own if row["quantity"] == "body_1_fy"][0]
    expected = abs(force - finer["body_1_fy"]) / math.hypot(finer["body_1_fx"], finer["body_1_fy"])
    assert abs(float(found["body_1_fy", "20"]["error"]) - expected) < 1e-12, found
    probe = rows(f"r/runs/{found['point_0_u', '26']['folder']}/probe_point.csv")[-1]
    assert float(found["point_0_u", "26"]["value"]) == float(probe["u"]) != 0.0, probe
    field = call(*words, "velocity", "--n", "20,26", "--reference", "32")
    if "no h5py" not in field.stderr:
        errors = [float(row["error"]) for row in rows("r/error.csv")]
        assert field.returncode == 0 and not field.stderr and 0.2 > errors[0] > errors[1] > 0.0, (field, errors)
    limit = succeed(*words, "kinetic_energy", "--n", "20,26,32")
    assert not limit.stderr and "no error is known" in limit.stdout or "the limit" in limit.stdout, limit.stdout


def check_stability():
    """Failures have their time, step and sentence; starts of a setting have mean and spread."""
    words = ["stability", "-case", "cavity", "-reynolds", "1000", "-max_steps", "4", "-jitter", "0.1", "--vary", "n=8,10",
             "--vary", "start=1..2", "--out", "s"]
    done = succeed(*words, "--jobs", "2")
    assert done.stderr.count("\n") == 4 and succeed(*words).stderr == "", done.stderr
    jitters = []
    for of in rows("s/numbers.csv"):
        values = [float(row[of["number"]]) for row in rows("s/stability.csv") if row["n"] == of["n"]]
        assert [float(of[key]) for key in ("mean", "spread", "min", "max")] == [
            statistics.fmean(values), statistics.stdev(values), min(values), max(values)] and len(values) == 2, (of, values)
    for row in rows("s/stability.csv"):
        with open(f"s/runs/{row['folder']}/command") as file:
            run = file.read().split()
        jitters.append(float(run[run.index("-jitter", run.index("-jitter") + 1) + 1]))
    assert all(abs(jitter - 0.1 - STEP * k) < 1e-12 for jitter, k in zip(jitters, (1, 2, 1, 2))), jitters

    done = succeed("stability", "-case", "cavity", "-n", "24", "-max_steps", "20", "--swap", "", "--swap", "-visc_ts_type euler",
                   "--vary", "dt=0.3,0.001", "--bound", "kinetic_energy<1e-9", "--out", "f")
    found = {(row["dt"], row["setting"]): row for row in rows("f/stability.csv")}
    lost = found["0.3", "-visc_ts_type euler"]
    assert lost["run"] == "fails" and float(lost["t_failed"]) > 0 and int(lost["step"]) > 0, lost
    assert lost["reason"].startswith("step") and lost["reason"].replace("|", "/") in done.stdout, lost
    assert found["0.001", "as typed"]["run"] == "doubtful" and "bound < 1e-09" in done.stdout, found
    done = succeed("stability", "-case", "cavity", "-n", "8", "--vary", "visc_laplacian=morris,moris", "--out", "f", "-max_steps", "1")
    assert "1 of 2 runs are refused" in done.stdout and "no such name" in done.stdout, done.stdout
    done = succeed("stability", "-case", "cavity", "-n", "40", "--vary", "seed=1..2", "--timeout", "0.3", "--out", "f", "-t_end", "1e6")
    assert "2 of 2 runs take too long" in done.stdout, done.stdout


def check_need():
    """The parts of a step are those of the banner, and what words add is told."""
    done = succeed("need", "body.opts", "-n", "20", "--steps", "2", "--out", "need", "--swap=-motion lagrangian")
    for word in ("| predict |", "| project |", "Left out: momentum", "stages: adds move, rebuild", "kB a particle"):
        assert word in done.stdout, (word, done.stdout)


def check_interrupt():
    """SIGINT ends the runs too, with one line; the same command goes on."""
    words = ["stability", "-case", "cavity", "-n", "8", "--vary", "t_end=0.1,1e6", "--out", "i", "--jobs", "2"]
    with subprocess.Popen(command(*words), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        first = process.stderr.readline()
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        text, told = process.communicate(timeout=60)
    assert process.returncode == 130 and first.startswith("[1/2]") and not text, (process.returncode, first, text)
    assert told == "isph-study: interrupted; the same command goes on from here\n", told
    assert len(glob.glob("i/runs/*/record.json")) == 1, "a run that was interrupted has a record"
    assert [row["run"] for row in rows("i/stability.csv")] != [], "no row of the run that ended"


def check_refusals():
    """Unsuitable input gets one line."""
    with open("file", "w") as file:
        file.write("")
    for words, sentence in ((["error", "none.opts"], "none.opts: No such file"),
                            (["error", WALLS, "--n", "6", "--out", "file"], "file: "),
                            (["error", WALLS, "--n", "6", "--out", "/proc/study"], "/proc/study: "),
                            (["error", WALLS, "--n", "6,x"], "numbers above 0"), (["error", WALLS, "--n", "0"], "numbers above 0"),
                            (["error", WALLS, "--n", "6", "--quantity", "drag", "--out", "q"], "no such number"),
                            (["error", WALLS, "--n", "6", "--swap=-walll x", "--out", "q"], "no run reached its end"),
                            (["error", WALLS, "--n", "6", "--swap", "-wall 'x"], "--swap -wall 'x: No closing"),
                            (["error", WALLS, "--n", "6", "--reference", "7 -wall x", "--out", "q"], "--reference 7 -wall x: "),
                            (["stability", WALLS], "needs --vary"), (["stability", WALLS, "--vary", "n"], "NAME=V1,V2"),
                            (["stability", WALLS, "--vary", "n=6", "--bound", "u"], "--bound u: "),
                            (["stability", WALLS, "--vary", "ranks=x"], "whole number"),
                            (["stability", WALLS, "--vary", "isph=file"], "is no program"),
                            (["error", WALLS, "--jobs", "x"], "--jobs"), (["error"], "a scene is required"),
                            (["need", WALLS, "-n", "x", "--out", "q"], "-n")):
        done = call(*words)
        assert done.returncode and sentence in done.stderr and "Traceback" not in done.stderr, (words, done.stderr)
        assert [line for line in done.stderr.splitlines() if not line.startswith("[")][0].startswith("isph-study: "), done.stderr


for check in (check_error, check_reference, check_stability, check_need, check_interrupt, check_refusals):
    check()
