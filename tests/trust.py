"""Tests studies/trust with four tiny flows: exact linear flows have no error, a coarse flow that is measured by a reference has
the error of docs/developers/results/trust.csv, and the page is written; each class of the list has flows in both halves.

    trust.py STUDY ISPH"""
import csv
import importlib.machinery
import importlib.util
import os
import subprocess
import sys

from interpreter import python_with

python_with("numpy, matplotlib, scipy")
study, isph = sys.argv[1:3]
ONLY = "linear (wheels_n12|rigid_cleary)|bodies bearing_n|form_channel morris_steady"

sys.path.insert(0, os.path.dirname(study))
loader = importlib.machinery.SourceFileLoader("trust_study", study)
module = importlib.util.module_from_spec(importlib.util.spec_from_loader("trust_study", loader))
loader.exec_module(module)
flows, references = module.read_list()
assert len(flows) >= 220 and len({flow.arguments for flow in flows.values()}) == len(flows), "flows are few or the same"
for class_ in {flow.class_ for flow in flows.values()}:
    halves = [flow.half for flow in flows.values() if flow.class_ == class_]
    assert abs(halves.count("open") - halves.count("sealed")) <= 1, f"the halves of {class_} differ in size"
assert all(reference.sides[1] > reference.sides[0] for reference in references.values())


def truths(path):
    """Returns the true errors of a file by the arguments of the runs."""
    with open(path, newline="", encoding="utf-8") as file:
        return {row["run"]: float(row["truth"]) for row in csv.DictReader(file) if row["truth"]}


subprocess.run([sys.executable, study, "--isph", isph, "--out", ".", "--only", ONLY], check=True, stdout=subprocess.DEVNULL)
found, known = truths("trust.csv"), truths(os.path.join(module.RESULTS, "trust.csv"))
assert len(found) == 5, found
for name in ("linear wheels_n12", "linear rigid_cleary"):
    assert found[flows[name].arguments] < 1e-5, name  # the tolerances of the solvers, 1e-5 and 1e-7
# The same flows on another machine: rounding and the last iterations of solvers differ.
for name in ("bodies bearing_n12", "bodies bearing_n20", "form_channel morris_steady_n20"):
    assert abs(found[flows[name].arguments] / known[flows[name].arguments] - 1) < 0.02, name
with open("trust.md", encoding="utf-8") as file:
    page = file.read()
assert "The open half" in page and "bearing_n20" in page and os.path.getsize("trust.png") > 10000, page
