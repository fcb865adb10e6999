#!/usr/bin/env python3
"""Checks the layers of the program: layers.py OBJECTS [ROOT]

OBJECTS is a file with the paths of all objects of the library, a line each. `nm` lists their symbols. The test fails
if a file calls a function, or reads an object, of a folder above its own in LAYERS, or includes a header of one; if
files call each other in a circle that CIRCLES does not name; or if a folder has more than MOST_FILES files. With
names of folders or files instead of ROOT it prints their arrows.
"""

import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

# Folders of src/ from bottom to top, and cases/; "top" is src/ itself.
LAYERS = """base options quantities geometry mesh scene particles fits rows walls strain operators time flow forces balance solvers splines
motion start schemes/stages schemes/diffusion schemes/scalars schemes/projection schemes/coupled schemes/wcsph schemes io measures
cases run patch library top""".split()
RANK = {folder: k for k, folder in enumerate(LAYERS)}

# Files that call each other: the parts of one object, which stand in one folder.
CIRCLES = {
    "scene": """bodies boundaries typedchecks scenecreate distances fluids free freebodies grading openings regime spacing symmetry
        typed typedbodies""".split(),
    "splines": """splineextend splinefits splineintegrals splines splinestep splinestiffness
        splinewindow""".split(),
}
# Headers of isph/ that are not named by their folder.
HEADERS = {"petsc": "base", "regime": "scene", "catalogue": "library", "plugin": "library"}
MOST_FILES = 18  # of a folder, headers included


def place(path):
    """Returns (folder, name) of a file of the source tree by its path in it."""
    parts = path.with_suffix("").parts
    folder = "/".join(parts[:-1])
    folder = folder[4:] if folder.startswith("src/") else folder
    return ("top" if folder == "src" else folder), parts[-1]


def read_symbols(objects):
    """Returns {file: undefined symbols} and {symbol: its file}; files are (folder, name)."""
    used, defined = {}, {}
    lines = [line for line in Path(objects).read_text().split() if "cmake_pch" not in line]  # parsed headers
    listed = subprocess.run(["nm", "-A", *lines], capture_output=True, text=True, check=True).stdout
    for line in lines + listed.splitlines():
        path = re.match(r"[^:]*\.dir/((?:src|cases)/[^:]*)\.c\.o(?:bj)?(?:$|:)", line)
        if not path:
            sys.exit(f"layers: {line} is no object of src/ or cases/")
        file, words = place(Path(path[1])), line.split()
        used.setdefault(file, set())
        if len(words) > 1 and words[-2].endswith("U"):
            used[file].add(words[-1])
        elif len(words) > 1 and words[-2] in "TDBRCGSi":
            defined[words[-1]] = file
    return used, defined


def read_arrows(objects):
    """Returns {file: {other file: symbols}}."""
    used, defined = read_symbols(objects)
    arrows = {file: defaultdict(list) for file in used}
    for file, symbols in used.items():
        for symbol in sorted(symbols):
            other = defined.get(symbol, file)
            if other != file:
                arrows[file][other].append(symbol)
    return arrows


def circles(arrows):
    """Yields the sets of files that call each other (Tarjan's algorithm, without recursion)."""
    index, low, stack, held = {}, {}, [], set()
    for root in arrows:
        if root in index:
            continue
        work = [(root, iter(arrows[root]))]
        index[root] = low[root] = len(index)
        stack.append(root)
        held.add(root)
        while work:
            file, rest = work[-1]
            other = next((o for o in rest if o not in index or o in held), None)
            if other is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[file])
                if low[file] == index[file]:
                    ring = set()
                    while file not in ring:
                        ring.add(stack.pop())
                    held -= ring
                    if len(ring) > 1:
                        yield ring
            elif other in index:
                low[file] = min(low[file], index[other])
            else:
                index[other] = low[other] = len(index)
                stack.append(other)
                held.add(other)
                work.append((other, iter(arrows[other])))


def text(file):
    """Returns the name of a file."""
    return f"{file[0]}/{file[1]}.c"


def check_arrows(arrows):
    """Yields a sentence for each arrow to a folder above."""
    for file, others in arrows.items():
        for other, symbols in others.items():
            if RANK[other[0]] > RANK[file[0]]:
                yield f"{text(file)} calls {', '.join(symbols)} of {text(other)}, a folder above it"


def check_circles(arrows):
    """Yields a sentence for each circle of files that CIRCLES does not allow, and for each file of it without one."""
    found = defaultdict(set)
    for ring in circles(arrows):
        folders = {folder for folder, _ in ring}
        names = {name for _, name in ring}
        folder = folders.pop()
        if folders or not names <= set(CIRCLES.get(folder, ())):
            yield f"a circle of files: {', '.join(sorted(map(text, ring)))}"
        found[folder] |= names
    for folder, names in CIRCLES.items():
        rest = set(names) - found[folder]
        if rest:
            yield f"CIRCLES names {', '.join(sorted(rest))} of {folder}, which are in no circle any more: take them out"


def header_layer(name, path, root):
    """Returns the folder of an included header, or None for those of libraries."""
    if name.startswith("isph/"):
        folder = HEADERS.get(name[5:-2], name[5:-2])
        return next(f for f in LAYERS if f.split("/")[-1] == folder)
    for base in (path.parent, root / "src"):
        if (base / name).is_file():
            return place((base / name).resolve().relative_to(root.resolve()))[0]
    return None


def check_files(root):
    """Yields a sentence for each unknown or crowded folder and for each header of a folder above."""
    folders = defaultdict(list)
    for path in sorted([*root.glob("src/**/*.[ch]"), *root.glob("cases/*.[ch]")]):
        folders[place(path.relative_to(root))[0]].append(path)
    for folder, paths in folders.items():
        if folder not in RANK:
            yield f"{folder} is no folder of LAYERS"
            continue
        if len(paths) > MOST_FILES and folder != "cases":
            yield f"{folder} has {len(paths)} files, {MOST_FILES} are allowed"
        for path in paths:
            for name in re.findall(r'^#include "([^"]+)"', path.read_text(), re.M):
                layer = header_layer(name, path, root)
                if layer and RANK[layer] > RANK[folder]:
                    yield f"{path.relative_to(root)} includes {name}, of a folder above it"


def main():
    """Checks the layers, or prints arrows."""
    arrows = read_arrows(sys.argv[1])
    root = Path(sys.argv[2] if len(sys.argv) > 2 else Path(__file__).parent.parent)
    if not root.is_dir():
        for file, others in sorted(arrows.items()):
            for other, symbols in sorted(others.items()):
                if any(word in text(file) for word in sys.argv[2:]):
                    print(f"{text(file)} -> {text(other)}: {', '.join(symbols)}")
        return
    faults = [*check_files(root), *check_arrows(arrows), *check_circles(arrows)]
    print("\n".join(faults) or f"{len(arrows)} files in {len(LAYERS)} layers: no arrow upwards")
    sys.exit(1 if faults else 0)


main()
