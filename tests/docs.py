#!/usr/bin/env python3
"""Tests the manual against the program: README.md, CHANGELOG.md, CONTRIBUTING.md, STYLE.md and the pages under docs/.

    docs.py links                     every link and anchor resolves, every quoted option exists
    docs.py run ISPH PAGE...          every command of the pages runs, in short variants
    docs.py shown ISPH PAGE...        every command of the pages runs in full and prints the output that is shown
    docs.py quoted ISPH PAGE...       the same, but runs only the commands of `console` blocks
    docs.py remake ISPH PAGE...       writes the output of the commands into the pages
    docs.py words                     users' pages are short: all together, and limits.md
    docs.py limits                    writes the table of docs/limits.md from docs/limits.csv and the #TEST lines of options/
    docs.py code                      prints the C code of the how-tos as a single file, to be compiled

A fenced block marked `sh` holds commands. A block marked `console` holds commands after `$ ` and, below each command,
its output; a line `...` stands for output that is left out. The commands of a page run in the order of the page in an
empty directory, which has options/, studies/ and cases/ of the source tree, and in which `isph` is the program under
test.

Short variants: with `run` each flow ends after two steps (four if it is a restart), no progress is printed,
tolerances (-check_...) are not tested, studies vary two values, and pictures in 3D are small. Programs that build, install or take hours (cmake, quickstart, check, and all
studies except `plot` and `isph-study`) only have to exist. If no Python can draw, commands that draw are skipped with a
message.

Output that is shown is compared word by word. Numbers may differ by 2 %, by two units of the last digit or by 1e-6, and
by any amount in lines with times of the computer or about a flow that diverged.
"""
import csv
import functools
import glob
import os
import re
import shutil
import stat
import subprocess
import sys
import tempfile

WORDS = 60000  # of the pages that users read; docs/developers/ and the three files for developers do not count
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LOOSE = re.compile(r"wall time|us/particle|^isph: step |^memory ")  # numbers that depend on the computer, or of a flow that diverged
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

# Options of other programs; beginnings of PETSc's options.
FOREIGN = {"-o", "-n", "-c", "-g", "-S", "-B", "-D", "-L", "-R", "-j", "-j2", "-k", "-e", "-f", "-np", "-i", "-m", "-x",
           "-s", "-F", "-p", "-C", "-h", "-V"}
PETSC = ("log_", "options_", "malloc_", "info", "on_error", "help", "version", "fp_trap",
         "sub_", "start_in_debugger", "ksp_", "pc_", "snes_", "ts_")


def pages():
    """Returns the pages of the manual, as paths from the root of the source tree."""
    found = ["CHANGELOG.md", "README.md", "CONTRIBUTING.md", "STYLE.md"]
    for path in glob.glob(os.path.join(ROOT, "docs", "**", "*.md"), recursive=True):
        found.append(os.path.relpath(path, ROOT))
    return sorted(found)


def read(page):
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        return file.read()


def blocks(text):
    """Yields the fenced blocks of a text: mark, body, begin and end of the body in the text."""
    for match in re.finditer(r"^```([^\n`]*)\n(.*?)^```[ \t]*$", text, re.M | re.S):
        yield match.group(1).strip(), match.group(2), match.start(2), match.end(2)


# ---- links and options ----


def anchors(text):
    """Returns the anchors of a page: its ids, and the names that GitHub derives from its headings."""
    names, seen = set(re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text)), {}
    for heading in re.findall(r"^#{1,6}[ \t]+(.*)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
        name = re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")
        count = seen[name] = seen.get(name, -1) + 1
        names.add(f"{name}-{count}" if count else name)
    return names


def link_faults(page):
    text = re.sub(r"^```.*?^```", "", read(page), flags=re.M | re.S)
    text = re.sub(r"`[^`\n]*`", "", text)
    given = re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text)
    for name in sorted({name for name in given if given.count(name) > 1}):
        yield f"{page}: #{name}: {given.count(name)} places have this anchor"
    for target in re.findall(r"\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if not os.path.exists(os.path.join(ROOT, there)):
            yield f"{page}: {target}: no such file"
        elif anchor and there.endswith(".md") and anchor not in anchors(read(there)):
            yield f"{page}: {target}: no such heading"


def known_options():
    """Returns possible names of options in the sources: words after a dash or at the beginning of a string literal."""
    names = set()
    for folder in "src", "cases", "include":
        for path in glob.glob(os.path.join(ROOT, folder, "**", "*.[ch]"), recursive=True):
            with open(path, encoding="utf-8") as file:
                text = file.read()
            names.update(re.findall(r"\"-?([a-z][a-z0-9_]*)", text))
            names.update(re.findall(r"[\s(\"]-([a-z][a-z0-9_]*)", text))
    return {name.rstrip("_") for name in names}


def exists(option, names):
    """Returns True if an option, quoted without its dash, is an option of isph or of PETSc's solvers."""
    stem = re.split(r"[<.]", option)[0].rstrip("_")
    if option.startswith(("visc_", "ppe_", "coupled_", "check_")) or option.startswith(PETSC) or stem in names:
        return True
    numbered = re.sub(r"_\d+(_|$)", r"_", stem).rstrip("_")
    sides = re.sub(r"_(left|right|bottom|top|back|front|side)(_|$)", "_", numbered).rstrip("_")
    return any(name in names for name in (numbered, sides)) or any(
        stem.startswith(known) for known in ("scene_body", "scene_fluid", "scene_wall") if known in names)


def option_faults(page, names):
    for quoted in re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```", "", read(page), flags=re.M | re.S)):
        for option in re.findall(r"(?:^|[\s|])-([a-z][A-Za-z0-9_]*(?:<[a-z]+>[a-z_]*)?)", quoted):
            if "-" + option not in FOREIGN and not exists(option, names):
                yield f"{page}: `-{option}` is no option of isph"


def sources():
    """Returns the text of all sources; adjacent string literals are joined, as a compiler joins them."""
    text = ""
    for folder in "src", "cases", "include":
        for path in sorted(glob.glob(os.path.join(ROOT, folder, "**", "*.[ch]"), recursive=True)):
            with open(path, encoding="utf-8") as file:
                text += file.read()
    text = re.sub(r"\"\s*(?:PetscInt(?:64)?_FMT|SNES[A-Z]+)\b", 'd"', text)
    return re.sub(r"\"\s*\"", "", text)


def formats(text):
    """Yields the format of each message that a user can get."""
    call = r"\b(?:UserCheck|FailureSet|SayLine|PetscCheck(?=\((?:[^;\"](?!;))*PETSC_ERR_FILE_))\("
    for start in re.finditer(call, text):
        end = text.index(";\n", start.end())
        literals = re.findall(r'"((?:[^"\\]|\\.)*)"', text[start.end() : end])
        if literals:
            yield max(literals, key=len)


def unanswered():
    """Yields the messages of the program that docs/faq.md does not explain."""
    page = read("docs/faq.md")
    parts = re.findall(r"`([^`]+)`", "".join(row.split(" | ")[0] for row in re.findall(r"^\|.*\n", page, re.M)))
    printed = re.findall(r"^isph: .*", page, re.M)
    for message in formats(sources()):
        fixed = [re.escape(part) for part in re.split(r"%%|%[-0-9.*]*l*[a-zA-Z]", message)]
        known = any(part in message for part in parts) or any(re.search(".*".join(fixed), line) for line in printed)
        if max(map(len, fixed)) > 8 and not known:
            yield f"docs/faq.md: no answer to the message '{message}'"


def message_faults(page):
    """Yields the parts of messages in a page's table of messages that no source prints."""
    table = re.search(r"^\| message contains .*\n((?:\|.*\n)+)", read(page) + "\n", re.M)
    if not table:
        return
    text = sources()
    for row in table.group(1).splitlines():
        for part in re.findall(r"`([^`]+)`", row.split(" | ")[0]):
            if part not in text:
                yield f"{page}: no message contains '{part}'"


def formula_faults():
    """Yields the formulas that sources and pages cite by name, as in "theory.md, (rows:gradient)", and that the theory does not have, and
    those of the theory that nobody cites."""
    there = set(re.findall(r'<a id="([a-z]+:[a-z0-9-]+)"', "".join(map(read, pages()))))
    pages_of_formulas, cited = {name.split(":")[0] for name in there}, set()
    paths = [path for folder in ("src", "include", "cases", "tests", "options", "studies")
             for path in sorted(glob.glob(os.path.join(ROOT, folder, "**", "*"), recursive=True))]
    for path in paths + [os.path.join(ROOT, page) for page in pages()]:
        if os.path.isdir(path) or path.endswith((".png", ".h5", ".pyc", ".csv")):
            continue
        with open(path, encoding="utf-8", errors="replace") as file:
            names = set(re.findall(r"[(#]([a-z]+:[a-z0-9-]+)\)", file.read()))
        cited |= names
        for name in sorted(names - there):
            if name.split(":")[0] in pages_of_formulas:
                yield f"{os.path.relpath(path, ROOT)}: the theory has no formula ({name})"
    for name in sorted(there - cited):
        yield f"docs/developers/theory: nobody cites ({name}): it needs no tag"


def cited_faults():
    """Yields the pages and files of the manual that sources name and that are not there."""
    for folder in "src", "include", "cases", "tests", "options", "studies", "packaging":
        for path in sorted(glob.glob(os.path.join(ROOT, folder, "**", "*"), recursive=True)):
            if os.path.isfile(path) and not path.endswith((".png", ".h5", ".pyc")):
                with open(path, encoding="utf-8", errors="replace") as file:
                    for name in sorted(set(re.findall(r"\bdocs/[a-z_/-]+\.(?:md|csv|png)\b", file.read()))):
                        if not os.path.exists(os.path.join(ROOT, name)):
                            yield f"{os.path.relpath(path, ROOT)}: {name}: no such file"


def python_faults(page):
    for mark, body, _, _ in blocks(read(page)):
        if mark == "python":
            try:
                compile(body, page, "exec")
            except SyntaxError as error:
                yield f"{page}: Python: {error}"


def links():
    names = known_options()
    faults = [fault for page in pages() for kind in (link_faults, python_faults, message_faults) for fault in kind(page)]
    faults += [fault for page in pages() if not page.startswith(("CHANGELOG", "docs/developers/results/"))  # they name options that are gone
               for fault in option_faults(page, names)]
    faults += unanswered()
    faults += formula_faults()
    faults += cited_faults()
    faults += ["docs/limits.md is not that of docs/limits.csv"] if limits(False) else []
    print("\n".join(faults) or f"{len(pages())} pages: links, anchors and options are there")
    return bool(faults)


def words():
    """Compares the words of users' pages, split at blanks, with their bounds."""
    found = {page: len(read(page).split()) for page in pages()}
    users = {page: count for page, count in found.items() if page == "README.md" or
             page.startswith("docs/") and not page.startswith("docs/developers/")}
    for page, count in sorted(users.items(), key=lambda pair: pair[1]):
        print(f"{count:6} {page}")
    total, limits = sum(users.values()), users["docs/limits.md"]
    print(f"{total} words in {len(users)} pages of users, of at most {WORDS}; limits.md has {limits}, of at most 1500")
    return total > WORDS or limits > 1500


# ---- limits ----


def held(test):
    """Returns the tolerance and n of the first -check_ of a #TEST line, NAME_TEST of options/NAME.opts."""
    for path in glob.glob(os.path.join(ROOT, "options", "*.opts")):
        name = os.path.basename(path)[: -len(".opts")]
        if not test.startswith(name + "_"):
            continue
        with open(path, encoding="utf-8") as file:
            text = file.read()
        line = re.search(rf"^#TEST {re.escape(test[len(name) + 1:])}( .*)$", text, re.M)
        if line:
            quantity, tolerance = re.search(r" -check_(\w+) (\S+)", line.group(1)).groups()
            n = re.search(r" -n (\d+)", line.group(1)) or re.search(r"^-n (\d+)", text, re.M)
            return f"`{quantity}` {100 * float(tolerance):g} %" + (f" ({n.group(1)})" if n else "")
    raise SystemExit(f"docs/limits.csv: no test {test} with a tolerance in options/")


def limits_table():
    """Returns the table of docs/limits.md."""
    lines, group = ["| flow | trust | error | n | test | what to do |", "| --- | --- | --- | --- | --- | --- |"], None
    with open(os.path.join(ROOT, "docs", "limits.csv"), newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if row["group"] != group:
                group = row["group"]
                lines.append(f"| **{group}** | | | | | |")
            page, _, anchor = row["details"].partition("#")
            page = ("" if page.startswith("howto") else "developers/") + page + ".md" + ("#" + anchor if anchor else "")
            test = held(row["test"]) if row["test"] else ""
            lines.append(f"| [{row['flow']}]({page}) | {row['trust']} | {row['error']} | {row['n']} | {test} | {row['advice']} |")
    return "\n".join(lines) + "\n"


def limits(write):
    """Writes the table of docs/limits.md, or returns True if the page has another one."""
    page = read("docs/limits.md")
    begin, end = page.index("<!-- table -->") + len("<!-- table -->\n"), page.index("<!-- end -->")
    if write:
        with open(os.path.join(ROOT, "docs", "limits.md"), "w", encoding="utf-8") as file:
            file.write(page[:begin] + limits_table() + page[end:])
    elif page[begin:end] != limits_table():
        print("docs/limits.md: its table is not that of docs/limits.csv; docs.py limits writes it")
        return True
    return False


# ---- commands ----

SHORT = """#!/usr/bin/env bash
# isph for a short variant: a step, two after a restart; half of -n above 23; no progress, no tolerances; a small patch.
last=1 keep=() skip= small= before=
for word in "$@"; do
  if [ "$skip" ]; then skip=; continue; fi
  if [[ $before == -n && $word =~ ^[0-9]+$ && $word -gt 23 ]]; then word=$((word / 2)); fi
  before=$word
  case $word in
    -check_*) skip=1; continue ;;
    -restart) last=2 ;;
    -catalogue|-help|--help|-h|-version|--version|-options_reference|patch|options/patch.opts) last= ;;
  esac
  [ "$word" != options/patch.opts ] || small="-n 16"
  keep+=("$word")
done
[ $# -gt 0 ] || last=
exec @ISPH@ "${keep[@]}" ${last:+-max_steps $last -progress none} $small
"""

FULL = """#!/bin/sh
exec @ISPH@ "$@"
"""

STUDY = """#!/usr/bin/env bash
# isph-study; for a short variant with the first two values of each --vary, half of the first two of --n, and half of --reference.
words=() last=
for word in "$@"; do
  if [ @SHORT@ ] && [[ $last == --reference ]]; then word=$((word / 2)); fi
  if [ @SHORT@ ] && [[ $last =~ ^--(vary|n)$ ]]; then
    word=$(sed -E 's/^([a-z_]+=[0-9]+)[.][.][0-9]+$/\\1..2/; s/^([^,]*,[^,]*),.*/\\1/' <<<"$word")
  fi
  if [ @SHORT@ ] && [[ $last == --n && $word =~ ^([0-9]+),([0-9]+)$ ]]; then
    word=$((BASH_REMATCH[1] / 2)),$((BASH_REMATCH[2] / 2))
  fi
  last=$word
  words+=("$word")
done
exec python3 studies/isph-study "${words[@]}" --isph .bin/isph
"""

EXISTS = """#!/bin/sh
exit 0
"""


@functools.cache
def drawing_python():
    """Returns the first Python that can draw, or None."""
    for python in (sys.executable, "/usr/bin/python3"):
        if subprocess.run([python, "-c", "import h5py, matplotlib"], capture_output=True, check=False).returncode == 0:
            return python
    return None


def script(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)


class Place:
    """An empty directory that looks like the root of the source tree."""

    def __init__(self, isph, full):
        self.path = tempfile.mkdtemp(prefix="docs_", dir=os.getcwd())
        wrapper = (FULL if full else SHORT).replace("@ISPH@", os.path.abspath(isph))
        script(os.path.join(self.path, "build", "isph"), wrapper)
        script(os.path.join(self.path, ".bin", "isph"), wrapper)
        for name in "options", "cases":
            os.symlink(os.path.join(ROOT, name), os.path.join(self.path, name))
        os.makedirs(os.path.join(self.path, "studies"))
        for path in glob.glob(os.path.join(ROOT, "studies", "*")):
            name = os.path.basename(path)
            there = os.path.join(self.path, "studies", name)
            if os.access(path, os.X_OK) and os.path.isfile(path) and name not in ("plot", "isph-study"):
                script(there, EXISTS)
            elif os.path.isfile(path):
                shutil.copy2(path, there)
                if name == "plot" and not full:
                    small = read("studies/plot").replace("400 if movie else 800", "100")
                    assert small != read("studies/plot"), "studies/plot: no sizes of pictures in 3D"
                    script(there, small)
        script(os.path.join(self.path, ".bin", "isph-study"), STUDY.replace("@SHORT@", "" if full else "short"))
        for name in "quickstart", "check":
            if os.path.exists(os.path.join(ROOT, name)):
                script(os.path.join(self.path, name), EXISTS)
        for name in "cmake", "cpack", "ctest", "git", "apt-get", "sudo", "paraview", "sbatch":
            script(os.path.join(self.path, ".bin", name), EXISTS)
        self.python = drawing_python()
        if self.python:
            os.symlink(self.python, os.path.join(self.path, ".bin", "python3"))
        self.environment = dict(os.environ, PATH=os.path.join(self.path, ".bin") + ":" + os.environ["PATH"])

    def draws(self, command):
        return re.search(r"studies/plot|python3|\.png", command) is not None

    def run(self, command):
        """Runs a command; returns its status and its output (both streams), None if it draws but no Python can."""
        if self.draws(command) and not self.python:
            print(f"passed over, no Python can draw: {command.splitlines()[0]}")
            return None
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=self.path, env=self.environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        return done.returncode, done.stdout

    def remove(self):
        shutil.rmtree(self.path, ignore_errors=True)


def shown(body):
    """Returns the commands of a console block, each with the lines shown below it."""
    found, lines = [], body.split("\n")[:-1]
    for line in lines:
        if line.startswith("$ "):
            found.append([line[2:], []])
        elif line.startswith("> ") and found and not found[-1][1]:
            found[-1][0] += "\n" + line[2:]
        elif found:
            found[-1][1].append(line)
    return found


def commands(text):
    """Yields the commands of a page in order, each with the lines shown below it; None for a block marked `sh`."""
    for mark, body, _, _ in blocks(text):
        if mark == "sh":
            yield body, None
        elif mark == "console":
            yield from shown(body)


def last_lines(output):
    return "\n".join(output.rstrip().split("\n")[-12:])


def run(isph, names):
    """Runs the commands of the pages in short variants."""
    bad = 0
    for page in names:
        place = Place(isph, False)
        count = 0
        for command, _ in commands(read(page)):
            result = place.run(command)
            count += 1
            if result and result[0]:
                bad += 1
                print(f"{page}: status {result[0]} of\n{command}\n...\n{last_lines(result[1])}")
        print(f"{page}: {count} commands or blocks of them")
        place.remove()
    return bool(bad)


def last_digit(number):
    """Returns the unit of the last digit of a number as it is written; 0 for a whole number."""
    mantissa, _, exponent = number.lower().partition("e")
    _, point, decimals = mantissa.partition(".")
    return 10.0 ** (int(exponent or 0) - len(decimals)) if point else 0.0


def same_words(a, b):
    """Returns True if two lines have the same words, and numbers that differ no more than between builds."""
    if NUMBER.sub("#", a).split() != NUMBER.sub("#", b).split():
        return False
    if LOOSE.search(a):
        return True
    return all(abs(float(x) - float(y)) <= max(0.02 * abs(float(y)), 2.0 * last_digit(x), 1e-6)
               for x, y in zip(NUMBER.findall(a), NUMBER.findall(b)))


def mismatch(lines, printed):
    """Returns the first difference of the lines shown and the lines printed, or None; `...` stands for any lines."""
    at, loose = 0, False
    for line in lines:
        if line.strip() == "...":
            loose = True
            continue
        while loose and at < len(printed) and not same_words(line, printed[at]):
            at += 1
        if at >= len(printed) or not same_words(line, printed[at]):
            return f"shown:   {line}\nprinted: {printed[at] if at < len(printed) else '(nothing more)'}"
        at, loose = at + 1, False
    if at < len(printed) and not loose:
        return f"printed, and not shown: {printed[at]}"
    return None


def tidy(output):
    """Returns the lines of an output without empty lines at both ends and without blanks at the ends of lines."""
    return [line.rstrip() for line in output.strip("\n").split("\n")] if output.strip() else []


def check_quoted(isph, names):
    """Runs only the commands whose output is shown, and compares it with the page."""
    return check_shown(isph, names, alone=True)


def check_shown(isph, names, alone=False):
    """Runs the commands in full and compares the output with the page."""
    bad = 0
    for page in names:
        asked = [(command, lines) for command, lines in commands(read(page)) if not alone or lines is not None]
        place = Place(isph, True)
        for command, lines in asked:
            result = place.run(command)
            if result is None:
                continue
            fault = None if lines is None else mismatch(lines, tidy(result[1]))
            refused = lines and any(line.startswith("isph: ") for line in lines)
            if fault or bool(result[0]) != bool(refused):
                bad += 1
                print(f"{page}: status {result[0]} of\n{command}\n{fault or result[1]}\n")
        place.remove()
        print(f"{page}: read to its end")
    return bool(bad)


def shortened(lines, printed):
    """Returns the output with a line `...` that leaves as many lines before and after it as in the page."""
    if not any(line.strip() == "..." for line in lines):
        return printed
    first = next(k for k, line in enumerate(lines) if line.strip() == "...")
    last = len(lines) - 1 - next(k for k, line in enumerate(reversed(lines)) if line.strip() == "...")
    tail = len(lines) - 1 - last
    return printed[:first] + ["..."] + (printed[-tail:] if tail else [])


def remake(isph, names):
    """Writes what the commands print into the pages."""
    for page in names:
        place, text, pieces, at = Place(isph, True), read(page), [], 0
        for mark, body, begin, end in blocks(text):
            if mark == "sh":
                place.run(body)
            if mark != "console":
                continue
            made = []
            for command, lines in shown(body):
                result = place.run(command)
                made.append("$ " + command.replace("\n", "\n> "))
                kept = result is None or (lines and not mismatch(lines, tidy(result[1])))
                made += lines if kept else shortened(lines, tidy(result[1]))
            pieces += [text[at:begin], "\n".join(made) + "\n"]
            at = end
        with open(os.path.join(ROOT, page), "w", encoding="utf-8") as file:
            file.write("".join(pieces) + text[at:])
        place.remove()
    return False


def code():
    """Prints the C code of the how-to of a case; tests/library.py builds that of a Laplacian."""
    case, = (body for mark, body, _, _ in blocks(read("docs/howto/own-case.md")) if mark == "c")
    print(case)


def main():
    if sys.argv[1:] == ["links"]:
        sys.exit(links())
    if sys.argv[1:] == ["limits"]:
        sys.exit(limits(True))
    if sys.argv[1:] == ["words"]:
        sys.exit(words())
    if sys.argv[1:] == ["code"]:
        sys.exit(code())
    kinds = {"run": run, "shown": check_shown, "quoted": check_quoted, "remake": remake}
    if len(sys.argv) < 4 or sys.argv[1] not in kinds:
        sys.exit(__doc__)
    sys.exit(kinds[sys.argv[1]](sys.argv[2], sys.argv[3:]))


main()
