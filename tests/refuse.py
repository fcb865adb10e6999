#!/usr/bin/env python3
"""refuse.py EVERY LIST SOURCE TEST STARTER COMMAND... - tries bad input, lines of a test in refusals.list: the first of EVERY.

A run is refused as a user should see it if it ends with an exit status other than 0, without a crash, and prints a
single line that begins with "isph: " and matches the expression. Runs on one rank are children of STARTER and print
nothing else on standard error. COMMAND makes runs on several ranks.
"""
import os
import re
import shlex
import subprocess
import sys

from starter import Starter

TITLE = re.compile(r"# ---- (\w+): .* ----$")
LINE = re.compile(r"(\w+)\s*\|([^|]*)\|\s*(.+)$")
SECONDS = 300  # of a run


def lines(path, test):
    """Yields name, words and expression of each line of a test, TITLE or TITLE_npK."""
    title = None
    with open(path, encoding="utf-8") as file:
        for line in map(str.strip, file):
            found = TITLE.match(line)
            title = found[1] if found else title
            if not line or line.startswith("#"):
                continue
            found = LINE.match(line)
            assert found and title, f"not 'name | args | regular expression': {line}"
            words = shlex.split(found[2])
            ranks = words.pop(0)[3:] if words and words[0].startswith("np=") else ""
            if test == (f"{title}_np{ranks}" if ranks else title):
                yield found[1], words, re.compile(found[3])


def mistake(status, out, err, expected, alone):
    """Returns the reason why a run was not refused as it should be, or None."""
    errors = re.findall(r"^isph: .*$", f"{out}\n{err}", re.M)
    if status is None:
        return "no end"
    if status < 0 or status > 128:
        return f"crashed instead of refusing: {status}"
    if status == 0:
        return "was not refused: exit status 0"
    if len(errors) != 1:
        return f"{len(errors)} lines begin with 'isph: '; exactly one is allowed"
    if not expected.search(errors[0]):
        return f"the error line does not match '{expected.pattern}'"
    if re.search("PETSC ERROR|Sanitizer|runtime error:", out + err):
        return "a traceback stands beside the error line"
    if alone and err.strip() != errors[0]:
        return "stderr holds more than the error line"
    return None


def execute(command, words, folder):
    """Runs a command; returns its status, standard output and standard error."""
    try:
        done = subprocess.run([*command, *words], cwd=folder, capture_output=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired as error:
        return None, error.stdout or b"", error.stderr or b""
    return done.returncode, done.stdout, done.stderr


def main():
    every, path, source, test, program, *command = sys.argv[1:]
    alone = "_np" not in test
    tried, failed = 0, 0
    starter = Starter(program)
    for name, words, expected in list(lines(path, test))[:: int(every)]:
        for k, word in enumerate(words):
            file = re.match("(file,)?([^/,-][^,]*/[^,]*)", word)
            if file and os.path.exists(os.path.join(source, file[2])):
                words[k] = word.replace(file[2], os.path.join(source, file[2]), 1)
        os.mkdir(name)
        status, *texts = starter.run(words, name, seconds=SECONDS) if alone else execute(command, words, name)
        out, err = (text.decode(errors="replace") for text in texts)
        wrong = mistake(status, out, err, expected, alone)
        tried += 1
        if wrong:
            failed += 1
            print(f"{name}: {wrong}\n    isph {shlex.join(words)}\n{out}{err}")
    print(f"{tried} refusals, {failed} of them wrong")
    sys.exit(failed > 0 or tried == 0)


if __name__ == "__main__":
    main()
