#!/usr/bin/env python3
"""Installs a build to a prefix in the current directory, runs a case from there, and builds a
program with the installed library by CMake's find_package and by pkg-config.

    install.py CMAKE BUILD USER_PROGRAM [PKGCONFIG_PATH]

The installed program must read the reference data of the prefix, or of ISPH_DATA; without them a run
warns once and leaves out the comparison. The man page and the bash completion must hold the options
that -help lists."""
import csv
import os
import re
import subprocess
import sys

FLOW = ["-case", "cavity", "-reynolds", "1", "-n", "16", "-motion", "eulerian", "-t_end", "0.25",
        "-report_times", "0.22", "-report"]


def run(command, succeeds=True, **environment):
    """Runs a command, without ISPH_DATA in the environment unless it is given; returns all output."""
    settings = {key: value for key, value in os.environ.items() if key != "ISPH_DATA"}
    done = subprocess.run(command, env={**settings, **environment}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert (done.returncode == 0) == succeeds, (command, done.returncode, done.stdout)
    return done.stdout


def errors(path, quantity):
    with open(path, newline="") as file:
        return [row["error"] for row in csv.DictReader(file) if row["quantity"] == quantity]


def find(name):
    found = [os.path.join(folder, name) for folder, _, files in os.walk("prefix") if name in files]
    assert len(found) == 1, f"{name}: installed as {found}"
    return os.path.abspath(found[0])


def complete(isph, *words):
    """Returns the completions of a command line that ends in the last word."""
    script = "source prefix/share/bash-completion/completions/isph; COMP_WORDS=(\"$@\"); " \
             "COMP_CWORD=$(($# - 1)); _isph; echo ${COMPREPLY[*]}"
    return run(["bash", "-c", script, "bash", isph, *words]).split()


def check_options(isph):
    """Asserts that the man page and the completion hold the options of -help."""
    text = run([isph, "-help"])
    listed = re.findall(r"^  (-\S+)", text[text.index("All options"):], re.M)
    with open(find("isph.1")) as file:
        page = file.read()
    assert "@" not in page and "; ;" not in page, page
    in_page = re.findall(r'^\.TP\n\.BI "([^"]+)"', page, re.M)
    assert [name.replace("\\-", "-") for name in in_page] == listed, (in_page, listed)
    completed = complete(isph, "-")
    for option in listed:
        assert "<" in option or option in completed, option
    for words, expected in ((["-ppe_f"], "-ppe_filter"), (["-visc_ts_m"], "-visc_ts_monitor"),
                            (["-scene_body_12_v"], "-scene_body_12_velocity"),
                            (["-case", "pat"], "patch"), (["-output", "prefix/b"], "prefix/bin")):
        assert complete(isph, *words) == [expected], (words, complete(isph, *words))


def main():
    cmake, build, user = sys.argv[1:4]
    prefix = os.path.abspath("prefix")
    run([cmake, "--install", build, "--prefix", prefix])
    isph = os.path.join(prefix, "bin", "isph")
    for name in ["LICENSE", "theory.md", "isph.1", "cavity.opts", "plot"]:
        find(name)
    for tool in "isph-plot", "isph-study":
        assert os.path.exists(os.path.join(prefix, "bin", tool)), f"{tool} leads nowhere"
    told = run([sys.executable, os.path.join(prefix, "bin", "isph-study"), "need", "-case", "cavity", "-n", "8", "--steps", "1"])
    assert "| predict |" in told, told

    check_options(isph)

    print(run([isph, *FLOW, "a.csv"]))
    assert all(float(error) < 0.1 for error in errors("a.csv", "u_profile_l2")), "profile far off"
    os.mkdir("empty")
    told = run([isph, *FLOW, "b.csv"], ISPH_DATA=os.path.abspath("empty"))
    assert told.count("reference data not found") == 1, told
    assert set(errors("b.csv", "u_profile_l2")) == {""}, "an error without a reference"
    with open(find("cavity_re1_u.csv"), "a") as file:
        file.write("no number\n")
    told = run([isph, *FLOW, "c.csv"], succeeds=False)
    assert "not two numbers" in told, "the data beside the program were not read"

    run([cmake, "-S", user, "-B", "user", f"-DCMAKE_PREFIX_PATH={prefix}"])
    run([cmake, "--build", "user"])
    assert "force on the lid" in run(["user/user", "-n", "8", "-max_steps", "1"])
    path = os.pathsep.join([os.path.dirname(find("isph.pc")), *sys.argv[4:],
                            os.environ.get("PKG_CONFIG_PATH", "")])
    flags = run(["pkg-config", "--cflags", "--libs", "isph"], PKG_CONFIG_PATH=path).split()
    libraries = [f"-Wl,-rpath,{flag[2:]}" for flag in flags if flag.startswith("-L")]
    run(["cc", os.path.join(user, "user.c"), "-o", "other", *flags, *libraries])
    assert "force on the lid" in run(["./other", "-n", "8", "-max_steps", "1"])


main()
