#!/usr/bin/env python3
"""Hostile files: what an option may lead to, and disks and limits that are full. Each run ends with one line.

    hostile.py files ISPH [STARTER]      devices, links, pipes and folders in the place of files; paths that are too long
    hostile.py options ISPH [STARTER]    options files that are no files of options
    hostile.py full ISPH [STARTER]       a full disk, and limits on the size of files and on memory
    hostile.py quit ISPH [STARTER]       SIGQUIT
    hostile.py numbers ISPH [STARTER]    numbers beyond the range of the computer
    hostile.py contents ISPH [STARTER]   checkpoints and particle files with other numbers, and the right checksum
    hostile.py damaged ISPH [STARTER]    checkpoints with attributes of other shapes, a particle file without particles;
                                     needs h5py (else status 77)

Writes in the present folder only.
"""
import math
import os
import resource
import signal
import stat
import struct
import subprocess
import sys
import time

from random_input.hdf5 import Contents, checksum
from random_input.runs import sanitized
from starter import Starter

SKIPPED = 77
ISPH = sys.argv[2]
START = Starter(sys.argv[3]) if len(sys.argv) > 3 else None
SMALL = ("-n", "8", "-max_steps", "1", "-progress", "none")


def run(*options, **how):
    """Runs a small flow; returns the status and the lines of isph on standard error. Runs without limits are children of
    the starter."""
    if START and not how:
        status, _, err = START.run([*SMALL, *options], seconds=120)
        err = err.decode(errors="replace")
        assert status is not None, "no end"
    else:
        done = subprocess.run([ISPH, *SMALL, *options], stderr=subprocess.PIPE, text=True, timeout=120, check=False,
                              **{"stdout": subprocess.DEVNULL, **how})
        status, err = done.returncode, done.stderr
    assert "PETSC ERROR" not in err, err
    return status, [line for line in err.splitlines() if line.startswith("isph: ")]


def refused(words, *options, **how):
    """Asserts that a run ends with one line that holds the words; returns the status."""
    status, lines = run(*options, **how)
    assert status != 0 and len(lines) == 1 and words in lines[0], (options, status, lines)
    return status


def files():
    with open("target", "w", encoding="utf-8") as file:
        file.write("kept\n")
    os.symlink("target", "link")
    os.symlink("nowhere", "dangling")
    os.mkfifo("pipe")
    os.mkdir("folder")
    for option in "-checkpoint", "-report":
        for name in "link", "dangling", "pipe", "folder":
            refused(f"{option} {name}: it exists and is no regular file", option, name)
    for option in "-restart", "-particles":
        for name in "pipe", "folder":
            refused(f"{option} {name}: it exists and is no regular file", option, name)
    for name, options in (("s_0000.h5", ("-output", "s.h5")), ("s.xdmf", ("-output", "s.h5")),
                          ("s_0000.h5.part", ("-output", "s.h5")), ("k.part", ("-checkpoint", "k")),
                          ("p_point.csv", ("-probe_point", ".5,.5", "-probe_output", "p"))):
        os.symlink("target", name)
        refused("cannot write", *options)
        assert os.path.islink(name)
        os.remove(name)
    with open("target", encoding="utf-8") as file:
        assert file.read() == "kept\n"
    assert os.path.islink("link") and stat.S_ISFIFO(os.stat("pipe").st_mode)
    for option in "-checkpoint", "-output", "-report", "-restart", "-particles":
        refused("characters, and at most 200", option, "x" * 201 + ".h5")
        refused("the path has a line break", option, "a\nb.h5")
    longest = "y" * 197 + ".h5"
    assert run("-checkpoint", longest) == (0, []) and run("-output", longest) == (0, [])
    for one, other in ((("-checkpoint", "w_0003.h5"), ("-output", "w.h5")),
                       (("-checkpoint", "w.xdmf"), ("-output", "./w.h5")),
                       (("-checkpoint", "w.csv"), ("-report", "../" + os.path.basename(os.getcwd()) + "/w.csv")),
                       (("-report", "p_point.csv"), ("-probe_point", ".5,.5", "-probe_output", "p"))):
        refused("lead to the same file", *one, *other)


def options():
    os.mkfifo("pipe")
    for name in "pipe", "/dev/null":
        refused(f"-options_file {name}: it is no regular file", "-options_file", name)
    for text, words in ((b"\xef\xbb\xbf-reynolds 10\n", "line 1: it begins with a byte order mark"),
                        (b'"-prefix_pop"\n', "line 1: -prefix_pop: there are no prefixes; write whole names"),
                        (b"--- # options\n", "o.opts: YAML is not read; write each option with its value in a line"),
                        (b"-reynolds 1\n-dt \x001\n", "line 2: it has a null byte"),
                        (b"-log_view :f:g\n", "line 1: -log_view :f:g: unknown format g; allowed are :file, "),
                        (b"--options_left 7\n", "line 1: -options_left 7: allowed are true and false"),
                        (b"-options_file o.opts\n", "does one include itself?")):
        with open("o.opts", "wb") as file:
            file.write(text)
        refused(words, "-options_file", "o.opts")
    refused("-options_file a\\nb: No such file", "-options_file", "a\nb")  # a line break is printed as \n
    refused("-reynolds a\\nb\\x07: a number is required", "-reynolds", "a\nb\x07")
    with open("o.opts", "wb") as file:
        file.write(b"-reynolds 10\r\n-density 2\r\n")
    assert run("-options_file", "o.opts") == (0, [])


def full():
    refused("-log_view: the file cannot be written", "-log_view", ":/dev/full")
    refused("the file cannot be written", "-ppe_ksp_view", "ascii:/dev/full")
    with open("/dev/full", "w", encoding="utf-8") as disk:
        refused("standard output cannot be written", stdout=disk)
    # 78,400 particles take 5 MB in a checkpoint; Open MPI needs files of 4 MB
    limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4500000, 4500000))}
    refused("cannot be written, or the disk is full", "-n", "280", "-checkpoint", "c.h5", **limit)
    refused("-n 1000000: allowed is 4 to 100000", "-n", "1000000")
    if not sanitized(ISPH):
        refused("cannot write", "-n", "280", "-output", "s.h5", **limit)
        # a million particles take 2 GB, which the machine has and the process may not take
        limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_AS, (700 << 20, 700 << 20))}
        assert refused("there is too little memory: use a smaller -n, or more nodes", "-n", "1000", **limit) == 55


def quitted():
    """SIGQUIT ends a run at once and without a message; the last checkpoint remains."""
    command = [ISPH, "-n", "16", "-t_end", "1e6", "-progress", "none", "-checkpoint", "c.h5",
               "-checkpoint_every", "0.1"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0))) as process:
        for _ in range(600):
            if os.path.exists("c.h5") or process.poll() is not None:
                break
            time.sleep(0.1)
        process.send_signal(signal.SIGQUIT)
        message = process.communicate(timeout=60)[1]
    assert process.returncode == -signal.SIGQUIT and not message, (process.returncode, message)
    refused("-restart c.h5: the file is at t = ", "-n", "16", "-t_end", "1e-6", "-restart", "c.h5")


def numbers():
    """Units in which a quantity overflows end the run with status 72, with all quantities in the report."""
    huge = "-length", "1e50", "-speed", "1e50", "-density", "1e50"
    for options in (), ("-case", "taylor_couette"), ("-dim", "3"):
        status = refused("linear_momentum is not finite: numbers of this run leave the range of the computer; choose "
                         "units", *huge, *options, "-report", "r.csv")
        assert status == 72, status
        with open("r.csv", encoding="utf-8") as file:
            assert "linear_momentum" in file.read()


def contents():
    assert run("-checkpoint", "c.h5", "-output", "s.h5", "-report_times", "0.01", "-max_steps", "2") == (0, [])
    with open("c.h5", "rb") as file:
        checkpoint = file.read()
    with open("s_0000.h5", "rb") as file:
        snapshot = file.read()

    def changed(path, original, name, *numbers):
        """Writes a file in which a data set begins with other numbers."""
        contents = Contents(bytearray(original))
        struct.pack_into(f"<{len(numbers)}d", contents.data, contents.sets[name].at, *numbers)
        if "checksum" in contents.attributes:
            struct.pack_into("<Q", contents.data, contents.attributes["checksum"].at, checksum(contents))
            contents.seal()
        with open(path, "wb") as file:
            file.write(contents.data)

    changed("c.h5", checkpoint, "particles", 0.0)
    assert run("-max_steps", "3", "-restart", "c.h5") == (0, [])  # the checksum is right
    # of the first particle: id, kind, x and y, u, x and y at the start of the epoch, dx, volume
    first = 0, 0, 0.1, 0.1, 0, 0, 0.1, 0.1
    for record in ((-1,), (0.5,), (1e9,), (math.nan,), (0, 2), (0, -1), (0, math.inf), (0, 0, math.nan),
                   (*first[:4], math.inf), (*first, 1), (*first, 0.125, -1)):
        changed("c.h5", checkpoint, "particles", *record)
        assert refused("-restart c.h5: the file is damaged: 1 of its particles", "-max_steps", "3", "-restart",
                       "c.h5") == 79
    changed("c.h5", checkpoint, "particles", 1)
    assert refused("-restart c.h5: the file is damaged: 1 of its particles have the number of another", "-max_steps",
                   "3", "-restart", "c.h5") == 79
    for memory in ((math.nan,), (-0.1,), (0.1, -3e9), (0.1, 0.01, -1), (0.1, 0.01, 0.01, 1.5),
                   (0.1, 0.01, 0.01, math.inf), (0.1, 0.01, 0.01, 1, 0, 0, 0, 10, 0, math.nan)):
        # t, dt, dt before, step; counts; the step before the last
        changed("c.h5", checkpoint, "memory", *memory)
        assert refused("-restart c.h5: the file is damaged", "-max_steps", "3", "-restart", "c.h5") == 79
    for row in (1e300,), (-1,), (math.nan,), (0, 0, 1e10):  # number, time, particles
        changed("c.h5", checkpoint, "snapshots", *row)
        assert refused("-restart c.h5: the file is damaged", "-max_steps", "3", "-restart", "c.h5") == 79
    for row in (math.nan,), (-0.01,), (math.inf,):  # time
        changed("c.h5", checkpoint, "report", *row)
        assert refused("-restart c.h5: the file is damaged", "-max_steps", "3", "-restart", "c.h5") == 79
    for row in (0.01, -math.inf), (0.01, 1, math.inf), (0.01, 1, 1, math.inf):
        changed("c.h5", checkpoint, "report", *row)
        assert refused("is not finite", "-max_steps", "3", "-restart", "c.h5") == 72
    changed("p.h5", snapshot, "velocity", 1e160)
    refused("-particles: the square of a speed at the start is not finite", "-particles", "p.h5")
    contents = Contents(bytearray(checkpoint))
    struct.pack_into("<I", contents.data, contents.sets["memory"].type_at + 4, 0)  # numbers of no bytes
    contents.seal()
    with open("c.h5", "wb") as file:
        file.write(contents.data)
    assert refused("parts of it cannot be read", "-max_steps", "3", "-restart", "c.h5") == 79
    for rows in 2**27 + 1, 2**31, 2**32 + 64, 2**63, 2**64 - 1:
        contents = Contents(bytearray(snapshot))
        struct.pack_into("<Q", contents.data, contents.sets["position"].sizes_at, rows)
        with open("p.h5", "wb") as file:
            file.write(contents.data)
        refused("-particles p.h5: ", "-particles", "p.h5")


def damaged():
    for python in sys.executable, "/usr/bin/python3":
        if subprocess.run([python, "-c", "import h5py, numpy"], capture_output=True, check=False).returncode == 0:
            break
    else:
        sys.exit(SKIPPED)
    if python != sys.executable:
        os.execv(python, [python, *sys.argv])
    import h5py
    import numpy

    for name, value in (("format", numpy.zeros(10000, dtype="i4")), ("dim", "two"), ("dim", numpy.zeros((3, 3))),
                        ("version", 3), ("case", numpy.array(["cavity"] * 900, dtype="S64")), ("next_id", "x" * 5000),
                        ("record", numpy.zeros(7)), ("memory_names", 1.5), ("checksum", numpy.zeros(9, dtype="u8")),
                        ("n_report", numpy.zeros(2, dtype="i4")), ("report_names", 5)):
        assert run("-checkpoint", "c.h5") == (0, [])
        with h5py.File("c.h5", "r+") as file:
            assert name in file.attrs, name
            del file.attrs[name]
            file.attrs[name] = value
        refused("-restart c.h5: ", "-max_steps", "2", "-restart", "c.h5")
    for name, columns in ("report", 4), ("snapshots", 3), ("particles", 0):  # gigabytes that the file does not hold
        assert run("-checkpoint", "c.h5") == (0, [])
        with h5py.File("c.h5", "r+") as file:
            columns = columns or file[name].shape[1]
            if name in file:
                del file[name]
            file.create_dataset(name, (10**8, columns), dtype="f8")
            if f"n_{name}" in file.attrs:
                file.attrs[f"n_{name}"] = numpy.int32(10**8)
        refused("parts of it cannot be read", "-max_steps", "2", "-restart", "c.h5")
    for rows in 2**27, 2**31 + 5, 2**60:  # the fill value of absent chunks, so that the file is small
        with h5py.File("p.h5", "w") as file:
            file.create_dataset("position", (rows, 2), "f8", chunks=(1024, 2), fillvalue=0.5)
        assert os.path.getsize("p.h5") < 100000
        refused("-particles p.h5: ", "-particles", "p.h5")


if __name__ == "__main__":
    {"files": files, "options": options, "full": full, "quit": quitted, "numbers": numbers, "contents": contents,
     "damaged": damaged}[sys.argv[1]]()
