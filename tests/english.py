#!/usr/bin/env python3
"""Checks the style of comments and docstrings: english.py [-v] [ROOT or FILE ...]

Counts the words of LIMITS, which often hide the noun of a sentence, and fails if there are too many in
1000 words of comments. Refuses a sentence that begins with a word of HEADLESS, and in the whole tree a
comment of the C sources that names a file or a function which is not there. Reads C, Python, shell and
CMake sources, option files and lists of tests. Option -v prints each counted comment.
"""

import ast
import io
import re
import sys
import tokenize
from pathlib import Path

# Pattern and largest number in 1000 words of comments
LIMITS = {
    "what": (re.compile(r"\bwhat\b", re.I), 0.5),
    "that of, those of": (re.compile(r"\b(that|those) of\b", re.I), 2.0),
    "one, ones": (re.compile(r"\bones?\b", re.I), 3.0),
}
HEADLESS = re.compile(r"(?:^|[.:!?]\s+)(What|Whether|Where)\b")
NAME = re.compile(r"^[\w, ]+ - ")  # "Name - " at the beginning of a docstring
WORD = re.compile(r"[A-Za-z][A-Za-z'-]*")

FOLDERS = (".ci", "cases", "cmake", "include", "options", "src", "studies", "tests")
C_TOKEN = re.compile(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|/\*.*?\*/|//[^\n]*', re.S)


def c_comments(text):
    """Yields line and text of each comment; consecutive lines of // make a single comment."""
    line, block, last = 0, [], -2
    for match in C_TOKEN.finditer(text):
        token = match.group()
        if token[0] != "/":
            continue
        at = text.count("\n", 0, match.start())
        alone = not text[text.rfind("\n", 0, match.start()) + 1 : match.start()].strip()
        if token.startswith("/*"):
            yield at, re.sub(r"\n[ \t]*\*?", "\n", token[2:-2])
            continue
        if block and not (alone and at == last + 1):
            yield line, "\n".join(block)
            block = []
        if not block:
            line = at
        block.append(token[2:])
        last = at
    if block:
        yield line, "\n".join(block)


def hash_comments(lines):
    """Joins the (line, text, alone) of comments after # that follow each other."""
    line, block, last = 0, [], -2
    for at, text, alone in lines:
        if block and not (alone and at == last + 1):
            yield line, "\n".join(block)
            block = []
        if not block:
            line = at
        block.append(text)
        last = at
    if block:
        yield line, "\n".join(block)


def python_comments(text):
    """Yields the docstrings and the comments of a Python file."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            doc = ast.get_docstring(node)
            if doc:
                yield node.body[0].lineno - 1, doc
    found = []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and not token.string.startswith("#!"):
            alone = not token.line[: token.start[1]].strip()
            found.append((token.start[0] - 1, token.string[1:], alone))
    yield from hash_comments(found)


def script_comments(text):
    """Yields the comments of a shell script, a CMake file, an option file or a list of tests."""
    found = []
    for at, line in enumerate(text.splitlines()):
        match = re.match(r"^((?:[^#]*\s)?)#(?![!#])(?!TEST\b)(.*)$", line)
        if match and match.group(1).count('"') % 2 == 0 and match.group(1).count("'") % 2 == 0:
            found.append((at, match.group(2), not match.group(1).strip()))
    yield from hash_comments(found)


def reader(path):
    """Returns the function that finds the comments of a file, or None."""
    if path.suffix in (".c", ".h"):
        return c_comments
    if path.suffix == ".py":
        return python_comments
    if path.suffix in (".sh", ".opts", ".list", ".cmake") or path.name == "CMakeLists.txt":
        return script_comments
    if path.suffix == "":
        with path.open("rb") as file:
            first = file.readline()
        if first.startswith(b"#!"):
            return python_comments if b"python" in first else script_comments
    return None


def files(root):
    """Lists the files of the source tree or of a folder."""
    if not (root / "src").is_dir():
        yield from sorted(path for path in root.rglob("*") if path.is_file())
        return
    inside = (path for folder in FOLDERS for path in (root / folder).rglob("*"))
    for path in sorted([*root.iterdir(), *inside]):
        if path.is_file() and "__pycache__" not in path.parts:
            yield path


def stale(root, comments):
    """Yields a sentence for each C comment that names a file or a function which the tree does not have."""
    text = "\n".join(path.read_text(encoding="utf-8") for path in root.rglob("*.[ch]") if "build" not in str(path))
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
    functions = set(re.findall(r"\b(\w+)\(", text)) | set(re.findall(r"\(\*(\w+)\)", text))
    sources = {path.name for path in root.rglob("*.[ch]")}
    for path, line, comment in comments:
        for name in re.findall(r"(?<![<\w./*-])((?:[a-z_]+/)*[a-z_]+\.[ch])\b", comment):
            there = (root / name).is_file() or (root / "src" / name).is_file() if "/" in name else name in sources
            if not there and not name.startswith("isph/"):
                yield f"{path}:{line + 1}: {name} is not there"
        for name in re.findall(r"\b([A-Z][a-z]\w*)\(\)", comment):
            if name not in functions and not name.startswith("Petsc"):
                yield f"{path}:{line + 1}: {name}() is not there"


def main():
    arguments = [word for word in sys.argv[1:] if word != "-v"]
    verbose = "-v" in sys.argv
    paths = []
    for word in arguments or [Path(__file__).resolve().parent.parent]:
        path = Path(word)
        paths += files(path) if path.is_dir() else [path]

    words, refused, in_c = 0, 0, []
    counts = dict.fromkeys(LIMITS, 0)
    for path in paths:
        comments = reader(path)
        if not comments:
            continue
        for line, text in comments(path.read_text(encoding="utf-8")):
            if comments is c_comments:
                in_c.append((path, line, text))
            text = text.strip()
            words += len(WORD.findall(text))
            place = f"{path}:{line + 1}"
            body = NAME.sub("", text, count=1)
            begins = HEADLESS.search(body[:1].upper() + body[1:])
            if begins:
                refused += 1
                print(f"{place}: a comment does not begin with {begins.group(1)}: {text[:60]!r}")
            for habit, (pattern, _) in LIMITS.items():
                found = pattern.findall(text)
                counts[habit] += len(found)
                if found and verbose:
                    print(f"{place}: {habit}: {' '.join(text.split())[:100]!r}")

    if not arguments:
        for sentence in stale(Path(__file__).resolve().parent.parent, in_c):
            refused += 1
            print(sentence)
    failed = refused > 0
    print(f"{words} words of comments; {refused} comments refused")
    for habit, (_, limit) in LIMITS.items():
        rate = 1000.0 * counts[habit] / max(words, 1)
        high = rate > limit
        failed = failed or high
        print(f"{habit:18} {rate:6.2f} in 1000 words, at most {limit}{'  TOO MANY' if high else ''}")
    return failed


if __name__ == "__main__":
    sys.exit(main())
