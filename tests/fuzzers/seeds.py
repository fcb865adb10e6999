#!/usr/bin/env python3
"""Writes seeds and words for the fuzzers of the parsers.

    seeds.py ISPH SOURCE FOLDER

The seeds come from the options files in SOURCE/options, from SOURCE/tests/refusals.list and from the reference data; the
words come from `isph -options_reference`. FOLDER gets seeds/NAME/ and words/NAME.dict for each fuzzer. A first byte
chooses a variant of the parser, as the file of each fuzzer tells.
"""
import glob
import os
import re
import shlex
import subprocess
import sys

FUNCTIONS = ("sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh log2 log10 log ln exp sqrt sign rint abs "
             "min max sum avg").split()
OPERATORS = "+ - * / ^ == != <= >= < > && || ? : = ( ) , ' ' . e".split(" ")
CONSTANTS = "x y z t pi nu rho L U _pi _e".split()
NUMBERS = "0 1 -1 0.5 1e300 1e-300 1e400 nan inf 0x10 2147483648 1e30".split()
VARIANTS = 4  # of expressions in the seeds: all variables, and each alone


def commands(source):
    """Yields the words of the options of each options file, of its tests, and of each refusal."""
    for path in sorted(glob.glob(os.path.join(source, "options", "*.opts"))):
        with open(path, encoding="utf-8") as file:
            lines = file.read().splitlines()
        yield [word for line in lines if not line.startswith("#") for word in shlex.split(line)]
        yield from (shlex.split(line)[2:] for line in lines if line.startswith("#TEST"))
    with open(os.path.join(source, "tests", "refusals.list"), encoding="utf-8") as file:
        for line in file:
            if not line.startswith("#") and line.count("|") > 1:
                yield shlex.split(line.split("|")[1])


def pairs(words):
    """Returns options with their values; a word after an option that begins with no letter behind a dash is its value."""
    found = []
    for word in words:
        if re.match(r"--?[A-Za-z]", word):
            found.append((word, []))
        elif found:
            found[-1][1].append(word)
    return [(option, " ".join(values)) for option, values in found]


def write(folder, name, seeds):
    """Writes seeds as files 000, 001, ... of seeds/NAME."""
    folder = os.path.join(folder, "seeds", name)
    os.makedirs(folder, exist_ok=True)
    for k, seed in enumerate(sorted(seeds)):
        with open(os.path.join(folder, f"{k:03d}"), "wb") as file:
            file.write(seed)


def write_words(folder, name, words):
    """Writes words in the form of libFuzzer's dictionaries."""
    os.makedirs(os.path.join(folder, "words"), exist_ok=True)
    with open(os.path.join(folder, "words", f"{name}.dict"), "w", encoding="ascii") as file:
        for word in sorted(set(words)):
            text = "".join(c if " " <= c <= "~" and c not in '"\\' else "".join(f"\\x{b:02x}" for b in c.encode()) for c in word)
            file.write(f'"{text}"\n')


def expressions(all_pairs):
    """Returns seeds of expressions: values of options with brackets, variables or functions."""
    texts = {value for option, value in all_pairs
             if re.search(r"velocity$|_exact$|_force$|_field$|_rotation$", option) and value}
    return {bytes([variant << 3 | 2]) + text.encode() for text in texts for variant in range(VARIANTS)}


def scenes(all_commands):
    """Returns seeds of typed scenes: the options of each command that describe a scene."""
    seeds = set()
    for words in all_commands:
        lines = [f"{option} {value}" for option, value in pairs(words) if re.match("-scene_|-viscosity_field", option)]
        seeds |= {bytes([n]) + "\n".join(lines).encode() for n in (1, 3) if lines}
    return seeds


def options_files(source, all_commands):
    """Returns seeds of options files and command lines."""
    seeds = set()
    for path in glob.glob(os.path.join(source, "options", "*.opts")) + glob.glob(
            os.path.join(source, "tests", "options_files", "*")):
        with open(path, "rb") as file:
            seeds.add(b"\x00" + file.read(4096))
    for words in all_commands:
        seeds.add(b"\x01" + "\n".join(words).encode())
    return seeds


def tables(source):
    """Returns seeds of reference data and of a file of a monitor."""
    seeds = {b"\x01t,step,u,v,p\n0,0,1,2,3\n0.25,1,1,2,3\n0.75,2,1,2,3\n"}
    for path in glob.glob(os.path.join(source, "cases", "reference", "*.csv")):
        with open(path, "rb") as file:
            seeds.add(b"\x00" + file.read(2048))
    return seeds


def checkpoints():
    """Returns seeds of changed checkpoints: each change of each of the first attributes and data sets."""
    return {bytes([corrects, 0, change, name, 1, 2, 3, 4, 5, 6, 7, 8]) for corrects in (0, 1) for change in range(8)
            for name in range(24)}


def main():
    isph, source, folder = sys.argv[1:]
    environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}  # MPI keeps memory
    out = subprocess.run([isph, "-options_reference"], stdout=subprocess.PIPE, check=True, encoding="utf-8", env=environment)
    names = re.findall(r"^\| `(-[^`]*)`", out.stdout, re.M)
    values = re.findall(r"(?:one|some) of ([^|]*) \|", out.stdout)
    table_words = [word.replace("\\", "") for value in values for word in re.split(", *", value.strip())]
    scene = [re.sub("<k>", "1", re.sub("<side>", "top", name)) for name in names if name.startswith("-scene_")]
    found = list(commands(source))
    write(folder, "expression", expressions([pair for words in found for pair in pairs(words)]))
    write(folder, "shapes", scenes(found))
    write(folder, "optionsfile", options_files(source, found))
    write(folder, "tables", tables(source))
    write(folder, "checkpoint", checkpoints())
    write_words(folder, "expression", FUNCTIONS + OPERATORS + CONSTANTS + NUMBERS)
    write_words(folder, "shapes", FUNCTIONS + OPERATORS + CONSTANTS + NUMBERS + scene
                + ["circle,", "box,", "polygon,", "left,right", "bottom,top", "x,y", "\n-scene_", "true", "false"])
    write_words(folder, "optionsfile", names + table_words
                + ["-prefix_push", "-options_file", "-options_file_yaml", "alias", "%YAML ", "---", "\n", '"', "#", "fuzzed.opts",
                   ":yaml", "${", "ascii:", ":ascii_xml"])
    write_words(folder, "tables", NUMBERS + ["\n", "\r\n", ",", "#", "\n\n"])
    write_words(folder, "checkpoint", [])


if __name__ == "__main__":
    main()
