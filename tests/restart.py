#!/usr/bin/env python3
"""Stops runs and restarts them.

    restart.py kill ISPH           a run killed 12 times at random moments has the same report, snapshots and probes
    restart.py bitwise ISPH...     continued and restarted runs, and the fields of their particles, are equal to the last
                                   bit, also if steps follow the error in time; on 2 ranks one flow of each kind of state
    restart.py ranks ISPH...       a checkpoint of 2 ranks restarts on 1, 2 and 3 ranks with the same flow to 1e-10
    restart.py term ISPH           a run that gets SIGTERM leaves a checkpoint and the status interrupted; the
                                   restarted run has the same flow to 1e-4
    restart.py status ISPH...      runs that get SIGINT, or SIGXCPU on 1 and 2 ranks, end with 128 plus its number
    restart.py damage ISPH         corrupted, truncated and foreign checkpoints are refused by a single line
    restart.py other ISPH          a run restarts with other -report_times and another -output
    restart.py probes ISPH         a probe file that cannot be continued ends the run and stays unchanged
    restart.py particles ISPH      a run started from the particles of a snapshot equals the original run
    restart.py finished ISPH       the restart of a finished run writes new outputs; locks of other programs hold nobody up
    restart.py scene ISPH          a restart with another box, other sides, bodies or viscosities is refused
    restart.py disk ISPH           a run on a full disk prints a single line of error, and all its files are complete

ISPH... is the program, followed by the words that start it on several ranks, with {} for their number."""
import csv
import ctypes
import glob
import os
import random
import re
import resource
import signal
import struct
import subprocess
import sys
import xml.dom.minidom
import time

from random_input.hdf5 import Contents

BASE = ["-n", "24", "-t_end", "3", "-progress", "none", "-skin", "1"]
FORCED = ["-case", "scene", "-scene_body_1", "circle,0.5,0.5,0.2", "-body_force", "sin(9*t),x*cos(7*t)",
          "-scene_wall_top_velocity", "cos(5*t),0"]  # force and wall velocity depend on time
SAME = ["-pressure_points", "same"]
SAME_FIELDS = [*SAME, "-velocity_filter", "4"]  # the particles have the fields of coarse points
CLOUD = ["-spacing_wall", "0.5", "-spacing_growth", "0.15"]
COMPRESSIBLE = ["-scheme", "wcsph"]
GAS = ["-equation_of_state", "ideal_gas", "-density_form", "summation"]
FLUIDS = ["-case", "scene", "-scene_wall_top_velocity", "1,0", "-scene_fluid_1", "circle,0.5,0.7,0.2", "-scene_fluid_1_viscosity", "1"]
BODIES = ["-case", "scene", "-scene_body_1", "box,0.3,0.4,0.7,0.6", "-scene_body_1_rotation", "1", "-scene_body_1_velocity",
          "0,0.3*sin(t)"]
OPENINGS = ["-case", "scene", "-scene_inflow", "left", "-scene_outflow", "right", "-scene_wall_left_velocity", "6*y*(1-y),0",
            "-scene_velocity", "6*y*(1-y),0", "-viscosity", "0.1"]  # particles enter and leave
JET = ["-case", "scene", "-scene_box", "0,0,2,1.5", "-scene_inflow", "top", "-scene_opening_top", "0.5,1.5", "-scene_outflow",
       "left,right", "-scene_filled_1", "box,0,0,2,0.5", "-scene_filled_2", "box,0.5,0.5,1.5,1.5", "-scene_wall_top_velocity",
       "0,-6*(x-0.5)*(1.5-x)", "-scene_velocity", "0,y > 0.5 ? -6*(x-0.5)*(1.5-x) : 0", "-viscosity", "5", "-jitter", "0.1"]  # lands and crowds; particles enter and leave
HEAT = ["-case", "scene", "-scene_wall_top_velocity", "1,0", "-viscosity", "1", "-viscosity_field", "exp(-T)", "-scene_scalar_1_name", "T",
        "-scene_scalar_1_diffusivity", "1+T*T", "-scene_scalar_1_source", "5*exp(-T)*g^2", "-scene_scalar_1_value", "bottom: t; left: 0",
        "-scene_scalar_1_exchange", "top: 2,1", "-scene_scalar_2_name", "dye", "-scene_scalar_2_start", "x", "-body_force", "0,50*T"]
MIXTURE = ["-case", "scene", "-scene_symmetry", "left,right", "-viscosity", "0.1", "-body_force", "0,-1",
           "-scene_fluid_1", "circle,0.5,0.4,0.2", "-scene_fluid_1_density", "0.1", "-scene_fluid_1_tension", "0.1"]
SINKING = ["-case", "scene", "-scene_box", "0,0,1,1.5", "-scene_filled_1", "box,0,0,1,1", "-viscosity", "0.02", "-body_force", "0,-1",
           "-scene_fluid_1", "circle,0.5,0.6,0.2", "-scene_fluid_1_density", "2", "-surface_tension", "0.02", "-speed", "0.2"]
SURFACE = ["-case", "drop_mode", "-with", "convection", "-speed", "1e-3", "-viscosity", "1"]
IMPACT = ["-n", "16", "-case", "scene", "-scene_box", "0,0,2,1", "-scene_filled_1", "circle,0.62,0.5,0.35", "-scene_velocity", "-1,0",
          "-viscosity", "10", "-scheme", "coupled"]  # the velocity jumps in step 10
FILES = ["-checkpoint", "c.h5", "-checkpoint_every", "0.1", "-output", "flow.h5", "-output_every", "0.5",
         "-report_times", "1,2", "-probe_point", "0.5,0.5", "-probe_every", "0.25", "-probe_forces"]


def start(command, folder="."):
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                            text=True)


def run(command, folder=".", good=True, timeout=None):
    """Runs a command to its end, asserts that it succeeds or fails as expected, and returns its stderr."""
    done = start(command, folder)
    error = done.communicate(timeout=timeout)[1]
    assert (done.returncode == 0) == good, (command, done.returncode, error)
    return error


def report(path):
    """Returns what a restart must repeat: all rows but the set-ups of this program's solvers."""
    with open(path, newline="") as file:
        return [(row["status"], row["quantity"], row["t"], row["value"]) for row in csv.DictReader(file)
                if not row["quantity"].endswith("_setups")]


def number(rows, quantity):
    return [float(value) for _, name, _, value in rows if name == quantity][-1]


def complete(folder):
    """Checks that each snapshot of the index exists and is an HDF5 file; returns their names."""
    with open(f"{folder}/flow.xdmf") as file:
        named = sorted(set(re.findall(r"flow_\d+\.h5", file.read())))
    assert named, folder
    for name in named:
        with open(f"{folder}/{name}", "rb") as file:
            assert file.read(8) == b"\x89HDF\r\n\x1a\n", name
    return named


def kill(isph):
    random.seed(1)
    os.mkdir("calm")
    begun = time.time()
    run([isph, *BASE, *FILES, "-report", "r.csv"], "calm")
    length = time.time() - begun
    os.mkdir("killed")
    kills = 0
    while True:
        again = ["-restart", "c.h5"] if os.path.exists("killed/c.h5") else []
        process = start([isph, *BASE, *FILES, *again, "-report", "r.csv"], "killed")
        try:
            error = process.communicate(timeout=None if kills == 6 else random.uniform(0, 0.6 * length))[1]
            assert process.returncode == 0, error
            if kills == 6:
                break
            for path in glob.glob("killed/*"):  # the run finished: start again
                os.remove(path)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            kills += 1
            if os.path.exists("killed/flow.xdmf"):
                complete("killed")
            if os.path.exists("killed/r.csv"):  # killed after the report: the run had finished
                for path in glob.glob("killed/*"):
                    os.remove(path)
    assert report("calm/r.csv") == report("killed/r.csv")
    assert complete("calm") == complete("killed"), (complete("calm"), complete("killed"))
    for name in "probe_point.csv", "probe_forces.csv":
        with open(f"calm/{name}") as a, open(f"killed/{name}") as b:
            assert a.read() == b.read(), name
    assert len(complete("calm")) == 7
    print(f"{kills} kills, a run of {length:.2f} s")


def ranked(command, n):
    isph, *mpi = command
    return [word.replace("{}", str(n)) for word in mpi] + [isph] if n > 1 else [isph]


ON_RANKS = "lagrangian", "coupled", "graded_moving", "error", "impact", "compressible", "jet", "bodies", "sinking"


def checksum(path):
    """Returns the checksum of a checkpoint, over the fields of all particles and all other numbers of its run."""
    with open(path, "rb") as file:
        contents = Contents(file.read())
    at = contents.attributes["checksum"].at
    return contents.data[at:at + 8]


def bitwise(*command):
    n = 2 if len(command) > 1 else 1
    for name, flow in (("lagrangian", []), ("eulerian", ["-motion", "eulerian"]),
                       ("coupled", ["-scheme", "coupled"]), ("same", SAME),
                       ("falls", ["-scheme", "coupled", "-coupled_ksp_max_it", "3", "-coupled_ksp_rtol", "1e-9"]),
                       ("implicit", ["-motion", "eulerian", "-convection", "implicit"]),
                       ("graded", ["-motion", "eulerian", "-spacing_wall", "0.7"]),
                       ("graded_same", [*SAME, "-motion", "eulerian", "-spacing_wall", "0.7"]),
                       ("graded_moving", ["-spacing_wall", "0.7"]),
                       ("cloud", ["-motion", "eulerian", *CLOUD]),
                       ("same_body", [*FORCED, *SAME]), ("third", ["-time_order", "3"]),
                       ("third_eulerian", ["-time_order", "3", "-motion", "eulerian"]), ("error", FORCED),
                       ("error_eulerian", [*FORCED, "-motion", "eulerian"]),
                       ("error_coupled", [*FORCED, "-motion", "eulerian", "-scheme", "coupled"]),
                       ("compressible", COMPRESSIBLE), ("gas", [*COMPRESSIBLE, *GAS]),
                       ("dynamic", [*COMPRESSIBLE, "-density_form", "summation", "-wall", "dynamic"]),
                       ("impact", IMPACT), ("openings", OPENINGS), ("jet", JET),
                       ("fluids", FLUIDS), ("mixture", MIXTURE), ("sinking", SINKING), ("bodies", BODIES), ("heat", HEAT),
                       ("heat_eulerian", [*HEAT, "-motion", "eulerian"]),
                       ("tension", [*SURFACE, "-surface_tension", "1"])):
        if n > 1 and name not in ON_RANKS:
            continue
        folder = f"{name}{n}"
        os.mkdir(folder)
        dt, last = 0.01, 6  # the run is stopped at half of its steps, with a checkpoint
        if name.startswith(("error", "third")):  # lengths of steps vary, and the history is longer
            last = 10
        if "-scheme wcsph" in " ".join(flow):  # sound limits steps
            dt = 0.004
        if name == "impact":  # its velocity jumps in step 10
            last = 20
        steps = ["-dt", f"{dt}", "-checkpoint_every", f"{last // 2 * dt:g}", "-report_times",
                 f"{last // 2 * dt:g},{(last // 2 + 2) * dt:g}"]
        if name.startswith(("error", "third")):  # a checkpoint each step, because lengths of steps vary
            steps = [*(steps[:2] if name.startswith("third") else ["-dt_adapt", "error"]), "-checkpoint_every", "1e-6",
                     "-report_times", "0.1,0.15"]
        start_ = [*ranked(command, n), "-n", "12", *steps, "-skin", "0.5", *flow, "-progress", "none"]
        run([*start_, "-max_steps", str(last), "-checkpoint", "a.h5", "-report", "a.csv"], folder)
        run([*start_, "-max_steps", str(last // 2), "-checkpoint", "b.h5"], folder)
        run([*start_, "-max_steps", str(last), "-checkpoint", "c.h5", "-restart", "b.h5", "-report", "c.csv"],
            folder)
        assert report(f"{folder}/a.csv") == report(f"{folder}/c.csv"), folder
        assert checksum(f"{folder}/a.h5") == checksum(f"{folder}/c.h5"), folder


def ranks(*command):
    tight = ["-n", "16", "-progress", "none", "-visc_ksp_rtol", "1e-13", "-ppe_ksp_rtol", "1e-13"]
    for name, flow in (("lagrangian", []), ("eulerian", ["-motion", "eulerian"]), ("same", SAME),
                       ("cloud", ["-motion", "eulerian", *CLOUD]), ("body", ["-case", "cavity_cylinder"])):
        file = f"{name}.h5"
        run([*ranked(command, 2), *tight, *flow, "-max_steps", "6", "-checkpoint", file])
        flows = []
        for n in 1, 2, 3:
            run([*ranked(command, n), *tight, *flow, "-max_steps", "12", "-restart", file, "-report",
                 f"{name}{n}.csv"])
            flows.append(report(f"{name}{n}.csv"))
        for quantity in "u_min", "v_max", "v_min", "kinetic_energy":
            values = [number(flow, quantity) for flow in flows]
            print(name, quantity, values)
            assert max(values) - min(values) < 1e-10, (name, quantity, values)  # U = 1


def term(isph):
    run([isph, *BASE, "-report", "calm.csv"])
    process = start([isph, *BASE, "-t_end", "30", "-checkpoint", "c.h5", "-checkpoint_every", "0.5", "-report",
                     "r.csv"])
    while not os.path.exists("c.h5"):
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    error = process.communicate()[1]
    assert process.returncode == 128 + signal.SIGTERM and error.startswith("isph: interrupted by SIGTERM"), error
    assert {row[0] for row in report("r.csv")} == {"interrupted"}
    run([isph, *BASE, "-restart", "c.h5", "-report", "rest.csv"])
    for quantity in "u_min", "v_max", "v_min", "kinetic_energy":
        a, b = (number(report(path), quantity) for path in ("calm.csv", "rest.csv"))
        print(quantity, a, b)  # the epoch at the checkpoint changes the order of sums: differences of 1e-6 occur
        assert abs(a - b) < 1e-4 * abs(a)


def status(*command):
    """The status is the one that a shell gives to a program that the signal ends: POSIX, exit status of commands."""
    flow = [*BASE, "-t_end", "3000", "-report", "r.csv", "-checkpoint", "c.h5"]
    process = start([command[0], *flow, "-checkpoint_every", "0.1"])
    while not os.path.exists("c.h5"):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    assert process.communicate()[1].startswith("isph: interrupted by SIGINT"), "SIGINT"
    assert process.returncode == 130, process.returncode
    steady = ["-case", "cavity", "-n", "40", "-motion", "eulerian", "-scheme", "coupled", "-steady", "-report", "s.csv"]
    process = subprocess.Popen([command[0], *steady], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    next(line for line in process.stdout if line.startswith("solver"))  # of the banner
    process.send_signal(signal.SIGINT)  # between two solves of the iteration, the one step of this run
    error = process.communicate()[1]
    assert error.startswith("isph: interrupted by SIGINT in iteration"), error
    assert process.returncode == 130 and {row[0] for row in report("s.csv")} == {"interrupted"}, process.returncode
    for n in 1, 2:
        limited = ["sh", "-c", "ulimit -S -t 1; exec \"$0\" \"$@\"", command[0], *flow]
        done = subprocess.run([*ranked(command, n)[:-1], *limited], capture_output=True, text=True, check=False)
        assert "isph: interrupted by SIGXCPU" in done.stderr, done.stderr
        assert done.returncode == 152, (n, done.returncode)
        assert {row[0] for row in report("r.csv")} == {"interrupted"}


def damage(isph):
    run([isph, "-n", "16", "-max_steps", "3", "-dt", "0.01", "-t_end", "1", "-checkpoint", "c.h5", "-output", "s.h5"])
    with open("c.h5", "rb") as file:
        data = file.read()

    def refused(name, content, words, *options):
        with open(name, "wb") as file:
            file.write(content)
        error = run([isph, "-n", "16", "-max_steps", "6", "-restart", name, *options], good=False)
        print(error.strip())
        assert error.count("\n") == 1 and error.startswith(f"isph: -restart {name}: ") and words in error, error

    clock = struct.pack("<d", 0.01)
    assert clock in data
    for k, place in enumerate((len(data) * 3 // 4, data.index(clock))):  # in the particles, then in the clock
        refused(f"bit{k}.h5", data[:place] + bytes([data[place] ^ 1]) + data[place + 1:], "checksum")
    for share in 2, 4, 40:
        refused(f"cut{share}.h5", data[:len(data) - len(data) // share], "truncated")
    refused("text.h5", b"no HDF5 at all\n" * 100, "no HDF5 file")
    refused("case.h5", data, "is of case cavity, this run is of case hydrostatic", "-case", "hydrostatic")
    refused("size.h5", data, "particles in 2D", "-wall", "dummy_linear")
    refused("density.h5", data, "the file has another density", "-density", "5")
    refused("start.h5", data, "started from other places", "-jitter", "0.2")
    refused("given.h5", data, "started from other places", "-particles", "s_0000.h5")
    refused("motion.h5", data, "other quantities", "-motion", "eulerian")
    contents = Contents(bytearray(data))
    for begin, end in contents.sealed:  # HDF5's metadata, which have checksums
        place = (begin + end) // 2
        refused("header.h5", data[:place] + bytes([data[place] ^ 1]) + data[place + 1:], "is damaged")
    place = contents.attributes["version"].at
    contents.data[place:place + 5] = b"9.9.9"
    refused("unsealed.h5", contents.data, "is no checkpoint of isph, or is damaged")
    contents.seal()
    refused("version.h5", contents.data, "the file is of isph 9.9.9")


def other(isph):
    flow = [isph, "-n", "16", "-progress", "none", "-output_every", "0.5"]
    run([*flow, "-t_end", "1", "-report_times", "0.5", "-checkpoint", "c.h5", "-output", "one.h5"])
    run([*flow, "-t_end", "2", "-report_times", "1,1.25,1.75", "-restart", "c.h5", "-output", "flow.h5", "-report",
         "r.csv"])
    times = sorted({float(row[2]) for row in report("r.csv")})
    assert times == [0.5, 1.0, 1.25, 1.75, 2.0], times  # reports of the first run are kept
    named = complete(".")
    assert named == sorted(glob.glob("flow_*.h5")) and len(named) == 3, named  # at the start, at 1.5 and at the end


def probes(isph):
    flow = [isph, "-n", "16", "-progress", "none", "-probe_point", "0.5,0.5"]
    run([*flow, "-t_end", "0.5", "-checkpoint", "c.h5"])
    with open("probe_point.csv") as file:
        written = file.read()
    os.mkdir("probe_point.csv.part")
    error = run([*flow, "-t_end", "1", "-restart", "c.h5"], good=False)
    assert error.startswith("isph: -probe_output: cannot write probe_point.csv"), error
    with open("probe_point.csv") as file:
        assert file.read() == written


def particles(isph):
    """Checks that the viscosities of a snapshot are the first guess of a rheology and do not bound it later."""
    flow = [isph, "-case", "poiseuille", "-rheology", "power_law", "-rheology_exponent", "0.5", "-n", "16", "-dt", "100",
            "-t_end", "500", "-progress", "none"]
    run([*flow, "-output", "s.h5", "-report", "lattice.csv"])
    run([*flow, "-particles", "s_0000.h5", "-report", "given.csv"])
    energies = [number(report(path), "kinetic_energy") for path in ("lattice.csv", "given.csv")]
    assert abs(energies[0] - energies[1]) < 1e-6 * energies[0], energies
    for options, words in ((["-n", "24", "-rheology", "power_law", "-rheology_exponent", "0.5"], "times the volume of the fluid"),
                           (["-n", "16", "-rheology", "newtonian"], "a data set 'viscosity'")):
        error = run([isph, "-case", "poiseuille", "-particles", "s_0000.h5", *options], good=False)
        assert error.startswith("isph: -particles s_0000.h5: ") and words in error, error


def finished(isph):
    """Checks that the restart of a finished run writes the outputs that its first run did not, and that a lock which another
    program has left on the name of a file holds nobody up."""
    flow = [isph, "-n", "12", "-max_steps", "3", "-progress", "none"]
    lock = ctypes.CDLL(None)
    lock.sem_open.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.c_uint, ctypes.c_uint]
    lock.sem_open(b"/OMPIO_locked.h5.part", os.O_CREAT, 0o644, 0)
    try:
        run([*flow, "-checkpoint", "locked.h5"], timeout=60)
    finally:
        lock.sem_unlink(b"/OMPIO_locked.h5.part")
    run([*flow, "-restart", "locked.h5", "-output", "o&p.h5", "-probe_line", "0.5,0,0.5,1,11"])
    with open("probe_line.csv") as file:
        assert len(file.readlines()) == 12
    assert os.path.exists("o&p_0000.h5")
    xml.dom.minidom.parse("o&p.xdmf")


def refused(flow, options, words):
    error = run([*flow, *options, "-restart", "c.h5"], good=False)
    assert error.startswith("isph: -restart c.h5: ") and words in error, error


def scene(isph):
    """Checks that a restart refuses options which would change the scene of its checkpoint."""
    flow = [isph, "-case", "scene", "-n", "16", "-max_steps", "2", "-progress", "none", "-scene_fluid_1",
            "circle,0.5,0.5,0.2", "-scene_fluid_1_viscosity"]
    run([*flow, "1", "-checkpoint", "c.h5"])
    run([*flow, "1", "-restart", "c.h5"])
    for options, words in ((["2"], "viscosities"), (["1", "-reynolds", "7"], "viscosities"),
                           (["1", "-scene_box", "0,0,1,1.001"], "box")):
        refused(flow, options, words)
    flow = [isph, "-case", "scene", "-n", "16", "-max_steps", "2", "-progress", "none", "-scene_body_1"]
    run([*flow, "circle,0.5,0.5,0.15", "-checkpoint", "c.h5"])
    run([*flow, "circle,0.5,0.5,0.15", "-restart", "c.h5"])
    refused(flow, ["circle,0.4375,0.5,0.15"], "bodies")  # moved by dx: the same number of particles
    refused(flow, ["circle,0.5,0.5,0.15", "-t_end", "0.01"], "after -t_end")
    refused(flow[:-1], ["-scene_domain", "circle,0.5,0.5,0.45", "-scene_box", "0,0,1,1"], "left is of kind wall in the file and none in this run")
    flow = [isph, "-case", "scene", "-n", "16", "-max_steps", "2", "-progress", "none"]
    run([*flow, "-checkpoint", "c.h5"])
    for options in SAME_FIELDS, ["-pressure_spacing", "1.5"]:
        refused(flow, options, "pressure on other points")
    run([*flow, *SAME_FIELDS, "-checkpoint", "c.h5"])
    refused(flow, [], "pressure on other points")
    cloud = ["-motion", "eulerian", "-spacing"]
    run([*flow, *cloud, "0.9 + 0.1*x", "-checkpoint", "c.h5"])
    run([*flow, *cloud, "0.9 + 0.1*x", "-restart", "c.h5"])
    refused(flow, [*cloud, "1.0 - 0.1*x"], "another spacing")
    mirrored = ["-scene_symmetry", "bottom,top"]  # as many wall particles as walls have
    run([*flow, *mirrored, "-checkpoint", "c.h5"])
    run([*flow, *mirrored, "-restart", "c.h5"])
    for options, words in (([], "bottom is of kind symmetry in the file and wall in this run"),
                           (["-scene_symmetry", "bottom"], "top is of kind symmetry in the file and wall in this run"),
                           (["-scene_periodic", "x", *mirrored], "left is of kind wall in the file and periodic in this run")):
        refused(flow, options, words + "; use the same -scene_ options")
    with open("c.h5", "rb") as file:  # a kind that this version does not know is a word like others
        contents = Contents(bytearray(file.read().replace(b"wall,wall,symmetry,symmetry", b"wall,wall,symmetry,mangrove")))
    contents.seal()
    with open("c.h5", "wb") as file:
        file.write(contents.data)
    refused(flow, mirrored, "top is of kind mangrove in the file and symmetry in this run")


def disk(isph):
    """Fills a file system of 1 MB if it can be mounted; otherwise reaches a limit on file sizes."""
    os.mkdir("small")
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "isph_test", "small"], check=False,
                             capture_output=True).returncode == 0
    limit = None if mounted else lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_IGN),
                                          resource.setrlimit(resource.RLIMIT_FSIZE, (150000, 150000)))
    try:
        for files in (["-output", "flow.h5", "-output_every", "0.02"],
                      ["-probe_line", "0,0.5,1,0.5,200"],
                      ["-n", "60", "-checkpoint", "c.h5", "-checkpoint_every", "0.01", "-output", "flow.h5",
                       "-output_every", "0.05"]):
            done = subprocess.run([isph, *BASE, *files], cwd="small", capture_output=True, text=True,
                                  preexec_fn=limit, check=False)
            print(mounted, done.stderr.strip())
            assert done.returncode > 0 and done.stderr.count("\n") == 1, done.stderr
            assert "cannot" in done.stderr and "disk is full" in done.stderr, done.stderr
            if "-output" in files:
                assert complete("small")
            for path in glob.glob("small/*"):
                os.remove(path)
    finally:
        if mounted:
            subprocess.run(["umount", "small"], check=True)


def main():
    tests = {"kill": kill, "bitwise": bitwise, "ranks": ranks, "term": term, "status": status, "damage": damage,
             "other": other, "probes": probes, "particles": particles, "finished": finished, "scene": scene,
             "disk": disk}
    tests[sys.argv[1]](*sys.argv[2:])


main()
