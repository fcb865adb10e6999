#!/usr/bin/env python3
"""Tests studies/bodies with cheap flows: bodies at rest, a cylinder beside a wall, and one whose surface oscillates, beside exact
forces; its exact flows beside published tables; its page.

    bodies.py STUDY ISPH"""
import csv
import importlib.machinery
import importlib.util
import os
import subprocess
import sys

from interpreter import python_with

python_with("numpy, scipy")
study, isph = sys.argv[1:3]
sys.path.insert(0, os.path.dirname(study))
import bodies_exact  # noqa: E402 (after the path)

# D. J. Jeffrey & Y. Onishi (1981); H. Brenner (1961), as tabulated by A. Ghigo (Basilisk's sandbox)
for h, kind, load in ((1.1, "along", 28.330185), (1.1, "towards", 465.930829), (1.1, "turning", 30.164276), (2, "along", 9.541968)):
    _, _, error, found = bodies_exact.cylinder(h, kind)
    assert error < 1e-11 and abs(found / load - 1) < 1e-7, (h, kind, error, found)
for h, drag in ((1.4, 3.73562), (1.2, 6.34089)):
    found = bodies_exact.Ball(h, 16, 40).drag
    assert abs(found / drag - 1) < 1e-5, (h, found)

subprocess.run([sys.executable, study, "--isph", isph, "--out", os.getcwd(), "--only",
                r"rest (circle|triangle)[^-]*, n|cylinder .* 0.5, n = 16"],
               check=True, stdout=subprocess.DEVNULL)
with open("bodies.csv", newline="", encoding="utf-8") as file:
    rows = list(csv.DictReader(file))
assert len(rows) == 7, len(rows)
for row in rows:  # a tenth of a per cent at rest; three to ten times the errors measured elsewhere
    bound = 1e-3 if row["section"] == "rest" else 5e-3
    exact, force = float(row["exact"]), float(row["force"])
    assert abs(force - exact) < bound * abs(exact), row
    assert float(row["bar"]) < 1e-2 * abs(exact), row
    if row["section"] == "rest":
        assert float(row["traction"]) < 1e-3 * abs(exact), row
with open("bodies.md", encoding="utf-8") as file:
    assert "| cylinder | towards, 0.5 | 16 |" in file.read()

# The page has 200 steps a period, 0.2 %; half of them err by 0.3 %.
loader = importlib.machinery.SourceFileLoader("bodies_study", study)
module = importlib.util.module_from_spec(importlib.util.spec_from_loader("bodies_study", loader))
loader.exec_module(module)
exact, force, _, bar, _, _ = module.oscillating(isph, 35, 16, 100)
assert abs(force - exact) < 5e-3 * exact and bar < 1e-2 * exact, (exact, force, bar)
