#!/usr/bin/env python3
"""Runs isph with random input: options, files, their contents, expressions and scenes that a seed determines.

    fuzz.py [--count N] [--seed S] [--start K] [--jobs J] [--only KIND] [--patience X] [--starter PROGRAM] ISPH

Input k of seed S is the same on every computer and with any --count, so `--seed S --start K --count 1` repeats it
(with the same --only). The options, their kinds and ranges come from `isph -options_reference`. Each input runs in a
folder fuzz_S_K of its own below the present folder. The folder stays if the input is a finding; the file `command` in
it holds the whole command line. Paths are names inside that folder, and options that run other programs, draw or wait
do not occur. With isph_starter as PROGRAM the runs are its children, and take a third of the time.

A finding is one of these:

    crash        a signal, or the statuses 59 and above 128, which stand for one
    hang         no end within 20 s times --patience, and within three times as long in a second run
    sanitizer    a report of AddressSanitizer or UndefinedBehaviorSanitizer
    not finite   the status 0 with nan or inf in the report file or in the printed table
    refusal      another status without exactly one line on standard error, which begins with "isph: "; a traceback.
                 Lines of Open MPI's own, which begin with "mca_" when it reads a damaged file, do not count
    balance      the status 0 with a `balance` above 1 in the report, and no line that something is not kept, or with
                 `trust` 1 and a line about more than forces and torques

Exits with status 1 if there is a finding.
"""
import argparse
import concurrent.futures
import os
import random
import shutil
import sys
import threading

from random_input.commands import Input, base, expression_input, options, scene_input
from random_input.files import contents_input, file_input, pristine
from random_input.runs import FINDINGS, execute, judge, quoted, sanitized, starter
from random_input.table import reference

SECONDS = 20
KINDS = ("option", "combination", "file", "expression", "scene", "contents")
SHARES = (35, 20, 15, 15, 10, 5)  # of the kinds
THREAD = threading.local()  # start: the starter of a thread, or None


def generate(rng, only, rows, cases, files, flows):
    kind = only or rng.choices(KINDS, SHARES)[0]
    if kind == "file":
        return file_input(rng, files)
    if kind == "contents":
        return contents_input(rng, flows)
    if kind == "expression":
        return expression_input(rng)
    if kind == "scene":
        return scene_input(rng)
    words, setting = options(rng, rows, 1 if kind == "option" else rng.randint(2, 4))
    return Input(base(rng, cases, setting), words)


def try_input(isph, settings, index, known, memory):
    """Runs one input; returns the kind of its finding and a line about it, or None."""
    rng = random.Random(f"{settings.seed}:{index}:{settings.only}")
    made = generate(rng, settings.only, *known)
    folder = os.path.abspath(f"fuzz_{settings.seed}_{index}")
    seconds = SECONDS * settings.patience
    words = [os.fsencode(word) for word in made.arguments()]
    for attempt in 1, 3:  # a computer at work on other things is slow
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(os.path.join(folder, "sub"))
        for name, data in {"text.h5": b"no HDF5\n", "empty.h5": b"", **made.files}.items():
            with open(os.path.join(folder, name), "wb") as file:
                file.write(data)
        status, out, err = execute([isph, *words], folder, attempt * seconds, memory, THREAD.start)
        if status is not None:
            break
    finding = judge(status, out, err, folder, reported="report.csv" in made.files)
    if not finding:
        shutil.rmtree(folder)
        return None
    line = " ".join([quoted(isph)] + [quoted(word) for word in made.arguments()])
    with open(os.path.join(folder, "command"), "w", encoding="utf-8") as file:
        file.write(f"{line}\n")
    for name, text in ("stdout", out), ("stderr", err):
        with open(os.path.join(folder, name), "w", encoding="utf-8", errors="replace") as file:
            file.write(text)
    if len(line) > 1000:
        line = f"sh {folder}/command"
    only = f" --only {settings.only}" if settings.only else ""
    return finding[0], (f"{finding[0]}: --seed {settings.seed} --start {index} --count 1{only}: {finding[1]}\n"
                        f"    cd {os.path.basename(folder)} && {line}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", choices=KINDS)
    parser.add_argument("--patience", type=float, default=1)
    parser.add_argument("--starter")
    parser.add_argument("isph")
    settings = parser.parse_args()
    isph = os.path.abspath(settings.isph)
    memory = not sanitized(isph)
    known = *reference(isph), *pristine(isph, os.path.abspath(f"fuzz_{settings.seed}_files"))
    counts = dict.fromkeys(FINDINGS, 0)

    def begin():
        THREAD.start = starter(settings.starter, memory) if settings.starter else None

    with concurrent.futures.ThreadPoolExecutor(settings.jobs, initializer=begin) as pool:
        tries = [pool.submit(try_input, isph, settings, index, known, memory)
                 for index in range(settings.start, settings.start + settings.count)]
        for done in tries:
            if done.result():
                counts[done.result()[0]] += 1
                print(done.result()[1], flush=True)
    print("{} inputs, {} crashes, {} hangs, {} sanitizer reports, {} not finite, "
          "{} refusals of more than one line, {} balances out of their bound".format(settings.count, *counts.values()))
    sys.exit(any(counts.values()))


if __name__ == "__main__":
    main()
