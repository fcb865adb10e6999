#!/usr/bin/env python3
"""Installs a build to a prefix in the current directory, runs a case from there, and builds a program with the installed
library by CMake's find_package and by pkg-config.

    install.py CMAKE BUILD USER_PROGRAM [PKGCONFIG_PATH]

The reference data must be those of the prefix, or of ISPH_DATA; without them a run warns once and leaves out the
comparison."""
import csv
import os
import subprocess
import sys

FLOW = ["-case", "cavity", "-reynolds", "1", "-n", "16", "-motion", "eulerian", "-t_end", "0.25",
        "-report_times", "0.22", "-report"]


def run(command, succeeds=True, **environment):
    """Runs a command in an environment without ISPH_DATA, unless it is given; returns all it printed."""
    settings = {key: value for key, value in os.environ.items() if key != "ISPH_DATA"}
    done = subprocess.run(command, env={**settings, **environment}, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    assert (done.returncode == 0) == succeeds, f"{' '.join(command)}: status {done.returncode}\n{done.stdout}"
    return done.stdout


def errors(path, quantity):
    with open(path, newline="") as file:
        return [row["error"] for row in csv.DictReader(file) if row["quantity"] == quantity]


def find(name):
    found = [os.path.join(folder, name) for folder, _, files in os.walk("prefix") if name in files]
    assert len(found) == 1, f"{name}: installed as {found}"
    return os.path.abspath(found[0])


def main():
    cmake, build, user = sys.argv[1:4]
    prefix = os.path.abspath("prefix")
    run([cmake, "--install", build, "--prefix", prefix])
    isph = os.path.join(prefix, "bin", "isph")
    for name in ["LICENSE", "theory.md", "isph.1", "cavity.opts", "plot"]:
        find(name)
    assert os.path.exists(os.path.join(prefix, "bin", "isph-plot")), "isph-plot leads nowhere"

    print(run([isph, *FLOW, "a.csv"]))
    assert all(float(error) < 0.1 for error in errors("a.csv", "u_profile_l2")), "the profile is far off"
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
    assert "Re = 50" in run(["user/user", "-n", "8", "-max_steps", "1", "-reynolds", "50"])
    path = os.pathsep.join([os.path.dirname(find("isph.pc")), *sys.argv[4:], os.environ.get("PKG_CONFIG_PATH", "")])
    flags = run(["pkg-config", "--cflags", "--libs", "isph"], PKG_CONFIG_PATH=path).split()
    libraries = [f"-Wl,-rpath,{flag[2:]}" for flag in flags if flag.startswith("-L")]
    run(["cc", os.path.join(user, "user.c"), "-o", "other", *flags, *libraries])
    assert "Re = 50" in run(["./other", "-n", "8", "-max_steps", "1", "-reynolds", "50"])


main()
