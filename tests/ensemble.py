"""Runs studies/ensemble for tiny cavities, and checks its statistics, its failures, and that a second call makes no run.

    ensemble.py ENSEMBLE ISPH"""
import csv
import json
import statistics
import subprocess
import sys

ensemble, isph = sys.argv[1:]
FLOW = ["--vary", "n=8,10", "-case", "cavity", "-reynolds", "1000", "-max_steps", "4", "-jitter", "0.1",
        "-probe_point", "0.5,0.5"]
WRONG = ["-case", "cavity", "-n", "24", "-visc_ts_type", "euler", "-dt", "0.3", "-max_steps", "200"]  # refusals.list
STEP = 1e-5  # difference of the jitters of two starts [dx]


def call(*words):
    return subprocess.run([sys.executable, ensemble, "--isph", isph, "--seeds", "2", "--out", "runs", *words],
                          capture_output=True, text=True, check=False)


def succeed(*words):
    done = call(*words)
    assert done.returncode == 0, f"studies/ensemble ended with status {done.returncode}: {done.stderr}"
    with open("runs/ensemble.json") as file:
        return done, json.load(file)["ensembles"]


def check_flow(first, ensembles):
    """Compares each mean and spread with the rows of the runs."""
    assert first.stderr.count(": done") == 8, first.stderr
    assert [(e["vary"]["n"], e["ranks"]) for e in ensembles] == [("8", 1), ("8", 2), ("10", 1), ("10", 2)], ensembles
    for e in ensembles:
        with open(f"runs/{e['build']}_np{e['ranks']}.csv", newline="") as file:
            rows = [row for row in csv.DictReader(file) if f"-n {e['vary']['n']} " in row["run"]]
        words = [row["run"].split() for row in rows]
        jitters = sorted(float(word[word.index("-jitter") + 1]) for word in words)
        assert all(abs(jitter - 0.1 - STEP * k) < 1e-12 for k, jitter in enumerate(jitters, 1)), jitters
        for name in "kinetic_energy", "u_min", "point_0_p":
            values, found = [float(row[name]) for row in rows], e["numbers"][name]
            assert found["runs"] == 2 and found["min"] == min(values) < max(values) == found["max"], (name, found)
            assert abs(found["mean"] - statistics.fmean(values)) <= 1e-15 * abs(found["mean"]), (name, found)
            assert abs(found["spread"] - statistics.stdev(values)) <= 1e-9 * found["spread"], (name, found)
        energy = e["numbers"]["kinetic_energy"]
        assert energy["spread"] < 1e-3 * energy["mean"], f"no small disturbance: {energy}"
        assert not e["failures"], e["failures"]


done, found = succeed("--ranks", "1,2", *FLOW)
check_flow(done, found)
again, same = succeed("--ranks", "1,2", *FLOW)
assert not again.stderr and same == found, f"runs that are in the folder were made again: {again.stderr}"
with open("runs/ensemble.md") as page:
    assert page.read() == done.stdout, "the page is not the text on the screen"

done, found = succeed("--jobs", "2", "--draw", "seed", *WRONG)
failures = found[0]["failures"]
assert [failure["start"] for failure in failures] == [1, 2] and not found[0]["numbers"], found
assert all(failure["t"] > 0 and "step" in failure["reason"] for failure in failures), failures
assert "2 of 2 runs failed" in done.stdout, done.stdout

for words, sentence in ((["-case", "cavty"], "no such name"), (["-n", "8", "-output", "a.h5"], "same file"),
                        (["--vary", "n", "-case", "cavity"], "NAME=V1,V2")):
    done = call(*words)
    assert done.returncode and sentence in done.stderr, f"{words}: {done.stderr}"
