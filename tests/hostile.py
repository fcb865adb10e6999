#!/usr/bin/env python3
"""Hostile files: what an option may lead to, and disks and limits that are full. Each run ends with one line.

    hostile.py files COMMAND...      devices, links, pipes and folders in the place of files; paths that are too long
    hostile.py options COMMAND...    options files that are no files of options
    hostile.py full COMMAND...       a full disk, and a limit on the size of files
    hostile.py damaged COMMAND...    checkpoints with attributes of other shapes; needs h5py (else status 77)

Writes in the present folder only.
"""
import os
import resource
import stat
import subprocess
import sys

SKIPPED = 77
SMALL = ("-n", "8", "-max_steps", "1", "-progress", "none")


def run(*options, **how):
    """Runs a small flow; returns the status and the lines of isph on standard error."""
    done = subprocess.run([*sys.argv[2:], *SMALL, *options], stderr=subprocess.PIPE, text=True, timeout=120, check=False,
                          **{"stdout": subprocess.DEVNULL, **how})
    assert "PETSC ERROR" not in done.stderr, done.stderr
    return done.returncode, [line for line in done.stderr.splitlines() if line.startswith("isph: ")]


def refused(words, *options, **how):
    """Asserts that a run ends with one line that holds the words."""
    status, lines = run(*options, **how)
    assert status != 0 and len(lines) == 1 and words in lines[0], (options, status, lines)


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
                        (b"-prefix_pop\n", "line 1: -prefix_pop: there is no -prefix_push before it"),
                        (b'"-prefix_pop"\n', "line 1: -prefix_pop: there is no -prefix_push before it"),
                        (b"-prefix_push\n", "line 1: -prefix_push: a prefix is required"),
                        (b"-reynolds 1\n-dt \x001\n", "line 2: it has a null byte"),
                        (b"-log_view :f:g\n", "line 1: -log_view :f:g: unknown format g; allowed are :file, "),
                        (b"--options_left 7\n", "line 1: -options_left 7: allowed are true and false"),
                        (b"-options_file o.opts\n", "does one include itself?")):
        with open("o.opts", "wb") as file:
            file.write(text)
        refused(words, "-options_file", "o.opts")
    refused("-options_file a\\nb: No such file", "-options_file", "a\nb")  # a line break is printed as \n
    refused("-reynolds a\\nb\\x07: a number is required", "-reynolds", "a\nb\x07")
    for text in b"-reynolds 10\r\n-density 2\r\n", b"-prefix_push visc_\n-ksp_rtol 1e-8\n-prefix_pop\n":
        with open("o.opts", "wb") as file:
            file.write(text)
        assert run("-options_file", "o.opts") == (0, [])


def full():
    refused("-visc_mat_view: the file cannot be written", "-visc_mat_view", "ascii:/dev/full")
    refused("-log_view: the file cannot be written", "-log_view", ":/dev/full")
    refused("the file cannot be written", "-ppe_ksp_view", "ascii:/dev/full")
    with open("/dev/full", "w", encoding="utf-8") as disk:
        refused("standard output cannot be written", stdout=disk)
    # 250,000 particles take 16 MB in a checkpoint; Open MPI needs files of 4 MB
    limit = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (12000000, 12000000))}
    refused("cannot be written, or the disk is full", "-n", "500", "-checkpoint", "c.h5", **limit)
    refused("cannot write", "-n", "500", "-output", "s.h5", **limit)


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


if __name__ == "__main__":
    {"files": files, "options": options, "full": full, "damaged": damaged}[sys.argv[1]]()
