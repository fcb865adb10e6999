#!/usr/bin/env python3
"""Runs forms of shared objects: the example of docs/howto/own-laplacian.md, built here, and those of studies/forms.c.

    library.py SOURCE FORMS COMPILER ISPH

The Laplacian of the example is exact for |x - x_i|^2, so that a patch test of a quadratic field on a lattice has rounding
errors only; in a flow its energy is within 10 % of that of the default form. Objects that do not fit are refused."""
import csv
import os
import re
import shlex
import subprocess
import sys

source, forms, compiler, isph = sys.argv[1:]
CAVITY = "-case cavity -n 20 -t_end 0.5 -reynolds 100".split()


def build(name, text):
    """Builds a shared object from a text in C."""
    flags = shlex.split(subprocess.run(["pkg-config", "--cflags", "PETSc", "hdf5"], check=True, capture_output=True,
                                       text=True).stdout)
    with open(f"{name}.c", "w") as file:
        file.write(text)
    subprocess.run([compiler, "-shared", "-fPIC", f"-I{source}/include", *flags, f"{name}.c", "-o", f"{name}.so"],
                   check=True)


def run(*words):
    """Returns the quantities of a run."""
    subprocess.run([isph, *words, "-report", "run.csv"], check=True, stdout=subprocess.DEVNULL)
    with open("run.csv", newline="") as file:
        rows = {row["quantity"]: float(row["value"]) for row in csv.DictReader(file)}
    os.remove("run.csv")
    return rows


def refused(sentence, *words):
    done = subprocess.run([isph, *CAVITY, *words], capture_output=True, text=True)
    lines = done.stderr.splitlines()
    assert done.returncode and len(lines) == 1 and re.search(sentence, lines[0]), (words, done.stderr)


with open(f"{source}/docs/howto/own-laplacian.md") as file:
    example = re.search(r"```c\n(/\* mps.c.*?)```", file.read(), re.DOTALL).group(1)
build("mps", example)
build("old", example.replace("FORMS_BUILD", "FORMS_VERSION, sizeof(Stencil) + 8, sizeof(LaplacianRow), "
                             "sizeof(GradientRow)"))
build("none", "int nothing;\n")

patch = ["-options_file", f"{source}/options/patch.opts", "-n", "20", "-patch_field", "quadratic"]
error = run(*patch, "-jitter", "0", "-forms_library", "mps.so", "-visc_laplacian", "mps")["laplacian_linf"]
assert error < 1e-9, error
for form, field in ("fatehi_manzari", "quadratic"), ("lsph", "linear"):
    error = run(*patch[:-1], field, "-jitter", "0.5", "-forms_library", forms, "-visc_laplacian", form)["laplacian_linf"]
    assert error < 1e-9, (form, error)
default = run(*CAVITY)["kinetic_energy"]
for flow in (["-forms_library", "mps.so", "-visc_laplacian", "mps"],
             ["-forms_library", forms, "-visc_laplacian", "mls3", "-ppe_laplacian", "mls3"]):
    energy = run(*CAVITY, *flow)["kinetic_energy"]
    assert abs(energy - default) < 0.1 * default, (flow, energy, default)

refused("-forms_library old.so: it was built for another isph", "-forms_library", "old.so")
refused("-forms_library none.so: it has no symbol IsphForms", "-forms_library", "none.so")
refused("-forms_library mps.c: no shared object", "-forms_library", "mps.c")
refused("-visc_laplacian mpz: no such name", "-forms_library", "mps.so", "-visc_laplacian", "mpz")
