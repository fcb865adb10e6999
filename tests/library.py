#!/usr/bin/env python3
"""Runs plug-ins: the examples of docs/howto/own-*.md, built here, and the forms of studies/forms.c.

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


def example(page):
    """Returns the code in C of a how-to."""
    with open(f"{source}/docs/howto/{page}.md") as file:
        return re.search(r"```c\n(.*?)```", file.read(), re.DOTALL).group(1)


build("mps", example("own-laplacian"))
build("shear_wave", example("own-case"))
build("mine", example("own-rows"))
build("old", example("own-laplacian").replace("= PLUGIN(rows)", '= {ISPH_VERSION, {8, 8, 8}, rows, 1}'))
build("twice", example("own-rows").replace('"powell_eyring"', '"carreau"'))
build("none", "int nothing;\n")

patch = ["-options_file", f"{source}/options/patch.opts", "-n", "12", "-patch_field", "quadratic"]
error = run(*patch, "-jitter", "0", "-library", "mps.so", "-visc_laplacian", "mps")["laplacian_linf"]
assert error < 1e-9, error
for form, field in ("fatehi_manzari", "quadratic"), ("lsph", "linear"):
    error = run(*patch[:-1], field, "-jitter", "0.5", "-library", forms, "-visc_laplacian", form)["laplacian_linf"]
    assert error < 1e-9, (form, error)
default = run(*CAVITY)["kinetic_energy"]
for flow in (["-library", "mps.so", "-visc_laplacian", "mps"],
             ["-library", forms, "-visc_laplacian", "mls3", "-ppe_laplacian", "mls3"]):
    energy = run(*CAVITY, *flow)["kinetic_energy"]
    assert abs(energy - default) < 0.1 * default, (flow, energy, default)

refused("-library old.so: it was built for another isph", "-library", "old.so")
refused("-library none.so: it has no symbol IsphPlugin", "-library", "none.so")
refused("-library mps.c: no shared object", "-library", "mps.c")
refused("there is a row carreau among the Rheologies already", "-library", "twice.so")

# Plug-ins together: a case, and a fluid without shear thinning, which is Newtonian; a piston at rest is a body at rest.
error = run("-library", "shear_wave.so,mine.so", "-case", "shear_wave", "-n", "20")["velocity_l2"]
assert error < 0.02, error
law = "-dt 0.02 -max_steps 5 -rheology_viscosity_min 5e-3 -rheology_viscosity_max 0.02 -rheology_time 1e-9 -rheology".split()
energy = [run(*CAVITY, *words)["kinetic_energy"] for words in (["-library", "mine.so", *law, "powell_eyring"],
                                                               [*law, "carreau", "-rheology_exponent", "1"])]
assert abs(energy[0] - energy[1]) < 1e-6 * energy[1], energy
scene = ["-case", "scene", "-n", "20", "-t_end", "0.1", "-scene_body_1", "circle,0.4,0.5,0.1"]
moved = [run(*scene, *words)["kinetic_energy"]
         for words in (["-library", "mine.so", "-scene_body_1_position", "0.2 + crank(0.1, 0.1, t), 0.5"],
                       ["-scene_body_1_position", "0.2 + 0.2*cos(t), 0.5"])]
assert moved[0] > 0.0 and abs(moved[0] - moved[1]) < 1e-9 * moved[1], moved
listed = subprocess.run([isph, "-library", "mine.so", "-catalogue"], capture_output=True, text=True, check=True).stdout
assert "powell_eyring" in listed and "crank" in listed

refused("-visc_laplacian mpz: no such name", "-library", "mps.so", "-visc_laplacian", "mpz")
