"""commandline.py SOURCE COMMAND... - tests requests that need no run, valid options files, and mistakes in
PETSc's own files and in the environment

Usage, help, versions and the reference page are printed once on any number of ranks, with exit status 0.
The reference page in docs/ equals the printed page, and no file reads an option that the tables do not hold.
"""
import glob
import os
import re
import subprocess
import sys
import tempfile

source, command = sys.argv[1], sys.argv[2:]
parallel = len(command) > 1  # the first rank reads files and tells the others


def isph(*arguments):
    """Returns the output of isph; asserts that its exit status is 0 and stderr is empty."""
    done = subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, (arguments, done.returncode, done.stdout, done.stderr)
    assert not done.stderr, (arguments, done.stderr)
    return done.stdout


usage = isph()
assert usage.count("usage: isph") == 1, usage
assert 10 <= len(usage.splitlines()) <= 16, usage
for option in ("-help", "-catalogue", "-version"):
    assert option in usage, option

for words in (["-version"],) if parallel else (["-version"], ["--version"], ["-n", "abc", "-version"]):
    version = isph(*words)
    for line in (r"isph \d+\.\d+\.\d+", r"PETSc \d+\.\d+\.\d+", r"hypre ", r"HDF5 \d+\.\d+\.\d+"):
        assert len(re.findall("^" + line, version, re.M)) == 1, (line, version)

# The reference page in docs/ equals the page that the program prints.
reference = isph("-options_reference")
with open(f"{source}/docs/reference/options.md", encoding="utf-8") as file:
    assert file.read() == reference, "write docs/reference/options.md anew: isph -options_reference"
options = re.findall(r"^\| `(-[^`]+)` \|", reference, re.M)
assert len(options) == len(set(options)) and len(options) > 100, options

# All options are listed for any case, even if other words of the command are invalid.
for words in (["-help"],) if parallel else (["-help"], ["-h"], ["--help"], ["-case", "patch", "-n", "abc", "-help"]):
    text = isph(*words)
    listed = re.findall(r"^  (-\S+)", text[text.index("All options"):], re.M)
    assert listed == options, set(options) ^ set(listed)
    most = re.findall(r"^  (-\S+)", text[text.index("most runs need:"):text.index("All options")], re.M)
    assert 10 <= len(most) <= 20 and set(most) <= set(options), most
    assert max(len(line) for line in text.splitlines()) <= 100
    assert re.search(r"^  <side> stands for +left, right, bottom, top, back, front$", text, re.M), text
found = isph("-help", "VISCOSITY")
assert "  -viscosity " in found and "  -rheology_viscosity_min " in found and "  -case " not in found, found
for word, option in (("drag", "-probe_forces"), ("temperature", "-scene_scalar_<k>_name"), ("outlet", "-scene_outflow"), ("mu", "-viscosity")):
    assert isph("-help", word).startswith(f"  {option} "), word
assert "  -body_force " in isph("-help", "gravity") and "no option has" in isph("-help", "nonsense")
# Steps of two hundred diffusion times reach a steady pressure slowly by the incremental projection, at once by the coupled scheme.
slow = ("-case", "cavity", "-reynolds", "1", "-motion", "eulerian", "-n", "12", "-dt", "200", "-t_end", "2000")
if not parallel:
    assert "not steady: steps are 2e+02 times" in isph(*slow, "-projection", "incremental")
    assert "not steady" not in isph(*slow, "-scheme", "coupled")
petsc = isph("-n", "12", "-help", "petsc")
assert petsc.startswith(isph("-help")), petsc[:2000]
for option in ("-ppe_ksp_gmres_restart", "-visc_ts_max_snes_failures", "-log_view"):
    assert option in petsc, option

# Options are read through rows of tables only. Options of PETSc, which have the prefix of a solver, are the exception.
for path in glob.glob(f"{source}/src/**/*.c", recursive=True) + glob.glob(f"{source}/cases/*.c"):
    with open(path, encoding="utf-8") as file:
        calls = re.findall(r"PetscOptions(?:Get|Has|Find|Begin)\w*\(\s*\w+,\s*NULL", file.read())
    assert not calls or "/src/options/" in path, (path, calls)

banner = isph("-options_file", f"{source}/tests/options_files/good.opts")
assert re.search(r"^case +scene", banner, re.M) and re.search(r"^particles +256 fluid", banner, re.M), banner

# Solvers are chosen by the usual step, though -time_order 3 begins with shorter ones, and implicit convection has its own CFL number.
for flow, name in (("-reynolds 0.1 -dt 0.1 -time_order 3", "hypre"), ("-reynolds 8 -motion eulerian -convection implicit", "bjacobi")):
    banner = isph("-case", "cavity", "-n", "16", "-max_steps", "0", *flow.split())
    assert re.search(rf"^visc solver .* PC {name}$", banner, re.M), banner

# The banner of a restarted run has the step of this run.
with tempfile.TemporaryDirectory() as folder:
    flow = ["-case", "cavity", "-n", "16", "-progress", "none"]
    isph(*flow, "-dt", "0.02", "-max_steps", "1", "-checkpoint", f"{folder}/c.h5")
    banner = isph(*flow, "-dt", "0.01", "-max_steps", "2", "-restart", f"{folder}/c.h5")
    assert ", dt = 0.01 s," in banner, banner

# A mistake in the environment or in PETSc's own files ends the run with a line that names its place.


def refused(expected, *arguments, **environment):
    """Asserts that isph prints the line expected, and no traceback, and ends with an exit status other than 0."""
    done = subprocess.run([*command, "-n", "16", "-max_steps", "0", *arguments], capture_output=True, text=True,
                          timeout=60, env={**os.environ, **environment})
    lines = [line for line in done.stderr.splitlines() if line.startswith("isph: ")]
    assert done.returncode != 0 and lines == ["isph: " + expected], (arguments, environment, done)
    assert "PETSC ERROR" not in done.stderr, done.stderr


stray = "a stray word; options begin with a dash, e.g. -case cavity"
refused(f"PETSC_OPTIONS: case: {stray}", PETSC_OPTIONS="case cavity")
refused(f"PETSC_OPTIONS: 2: {stray}", PETSC_OPTIONS='-scene_velocity "1, 0" -dt 1 2')
refused("PETSC_OPTIONS: -options_file: a file name is required", PETSC_OPTIONS="-options_file")
refused("-options_file nowhere: No such file or directory", PETSC_OPTIONS="-options_file nowhere")
refused("PETSC_OPTIONS_YAML: YAML is not read; write each option with its value in a line, as -n 16", PETSC_OPTIONS_YAML="dt: 1")
os.mkdir("home")
for name in (".petscrc",) if parallel else (".petscrc", "petscrc", "home/.petscrc"):
    for text, expected in (
            ("case cavity", "line 1: case: a stray word; options begin with a dash, and a value stands in the line of "
                            "its option"),
            ("\n-dt 1 -case cavity", "line 2: -dt and -case: each option has a line of its own, with its value")):
        with open(name, "w", encoding="utf-8") as file:
            file.write(text)
        refused(f"{name}, {expected}", HOME="home")
        assert re.search(r"^particles +256 fluid", isph("-n", "16", "-max_steps", "0", "-skip_petscrc"), re.M)
    os.remove(name)

# Without a launcher and with no settings of MPI, isph has a folder of MPI of its own, and removes it.
if not parallel:
    os.mkdir("temporary")
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_MCA_", "HWLOC_"))}
    plain["TMPDIR"] = os.path.abspath("temporary")
    runs = [subprocess.Popen([*command, "-n", "16", "-max_steps", "2", "-output", f"run{k}.h5"], env=plain,
                             stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) for k in range(4)]
    for k, run in enumerate(runs):
        error = run.communicate(timeout=60)[1]
        assert run.returncode == 0 and not error and os.path.exists(f"run{k}_0001.h5"), (k, run.returncode, error)
    assert not os.listdir("temporary"), os.listdir("temporary")
