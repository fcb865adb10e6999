#!/usr/bin/env python3
"""Checks that studies/same.entered has a row for each source file: entered.py ROOT

Each .c file of src/ and cases/ that defines a function has a row, which names a line of studies/same.list that enters
it, but for those of the library, which tests/test_library.c enters. Rows name files without their folders, so that a file that moves needs no new row. Nothing is run."""
import collections
import os
import re
import sys
from pathlib import Path

ROOT = Path(sys.argv[1])
REMEDY = ("add a line to studies/same.list if none runs it, then remake the table: cmake -S . -B build-cover "
          "-DISPH_COVERAGE=ON -DISPH_TESTS=OFF && cmake --build build-cover && studies/same --entered build-cover")
DEFINITION = re.compile(r"^[A-Za-z_][^;={}#]*\)\s*\{", re.M)
COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)

sys.path.insert(0, str(ROOT / "studies"))
from same_runs import read_list  # noqa: E402 (after the path)


def fail(sentence):
    """Ends the test with a sentence."""
    sys.exit(f"{sentence}; {REMEDY}")


def main():
    """Compares files, rows and labels."""
    files = collections.Counter(path.name for folder in ("src", "cases") for path in (ROOT / folder).rglob("*.c")
                                if path.parent.name != "library" and DEFINITION.search(COMMENT.sub("", path.read_text(encoding="utf-8"))))
    table = ROOT / "studies" / "same.entered"
    rows = [re.split(r" \| |/", line) for line in table.read_text(encoding="utf-8").splitlines() if line[:1] != "#"]
    names = collections.Counter(row[0] for row in rows)
    labels = {line.label for line in read_list()}
    for name in sorted(files - names):
        fail(f"studies/same.entered has no row for the source file {name}, or one too few of this name")
    for name in sorted(names - files):
        fail(f"studies/same.entered names {name}, but src/ and cases/ have no such file with functions, or one too few")
    for name, label, entered, _ in rows:
        if int(entered) == 0:
            fail(f"No line of studies/same.list enters {name}")
        if label not in labels:
            fail(f"studies/same.entered names the line {label} for {name}, but studies/same.list has no such line")


if os.path.exists(ROOT / "studies" / "same.entered"):
    main()
else:
    fail("studies/same.entered is absent")
