"""Inputs with other files: damaged bytes of any file, and other contents of checkpoints and of particles."""
import os
import shutil
import subprocess

from random_input.commands import EXCLUDED, Input
from random_input.expressions import mutated
from random_input.hdf5 import Contents, changed, checksum
from random_input.runs import environment

RESTART = ["-n", "8", "-progress", "none", "-report", "report.csv", "-max_steps"]
PROBES = ["-probe_point", "0.5,0.5", "-output", "s.h5", "-checkpoint", "c.h5"]
FLOWS = (  # whose checkpoints and snapshots get other contents
    ("-report_times", "0.01"),
    ("-scheme", "coupled", "-motion", "eulerian"),
    ("-case", "scene", "-scene_wall_top_velocity", "1,0", "-viscosity_field", "0.01+0.01*x"),
)
START = ("position", "velocity", "viscosity", "type")  # the data sets that -particles reads
OPTIONS_TEXT = """# a scene
-case scene
-scene_box 0,0,1,1   # its corners
-scene_body_1 "circle,0.5,0.5,0.2"
-scene_wall_top_velocity 'sin(t), 0'
-body_force "x*y, -1"
-viscosity 0.1
-visc_ksp_rtol 1e-8
-ppe_pc_type hypre
-n 8
-max_steps 1
"""

def written(isph, folder, options):
    """Runs isph with options; returns the contents of its files."""
    os.mkdir(folder)
    subprocess.run([isph, *RESTART, "2", *options], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                   env=environment(folder))
    found = {}
    for name in os.listdir(folder):
        path = os.path.join(folder, name)
        if os.path.isfile(path):
            with open(path, "rb") as file:
                found[name] = file.read()
    shutil.rmtree(folder)
    return found


def pristine(isph, folder):
    """Runs isph for the files that inputs change; returns the files, and the files of each of FLOWS."""
    flows = [written(isph, folder, (*flow, "-output", "s.h5", "-checkpoint", "c.h5")) for flow in FLOWS]
    for flow in flows:
        contents = Contents(flow["c.h5"])
        assert checksum(contents) == contents.number(contents.attributes["checksum"].at)
    return written(isph, folder, PROBES), flows


def damaged(rng, data):
    """Returns bytes with bits flipped, cut off, put in or at the end."""
    data = bytearray(data)
    draw = rng.random()
    near = rng.random() < 0.5  # the beginning of an HDF5 file describes the rest
    length = min(len(data), 4096) if near else len(data)
    if draw < 0.5:
        for _ in range(rng.choice((1, 1, 2, 8, 64))):
            data[rng.randrange(length)] ^= 1 << rng.randrange(8)
    elif draw < 0.65:
        del data[rng.randrange(length):]
    elif draw < 0.75:
        at = rng.randrange(length)
        data[at:at + rng.choice((1, 2, 4, 8, 100))] = bytes(rng.randrange(256) for _ in range(rng.choice((0, 1, 4, 8, 100))))
    elif draw < 0.9:
        at = rng.randrange(length)
        count = rng.choice((1, 2, 4, 8))
        data[at:at + count] = rng.choice((b"\x00", b"\xff", b"\x7f", b"\x80")) * count
    else:
        data += bytes(rng.randrange(256) for _ in range(rng.choice((1, 100, 5000)))) if rng.random() < 0.5 else bytes(data)
    return bytes(data)


def file_input(rng, files):
    kind = rng.choice(("checkpoint", "checkpoint", "particles", "options", "petscrc", "csv", "index"))
    if kind == "checkpoint":
        return Input(RESTART + ["3"], ["-restart", "c.h5"], {"c.h5": damaged(rng, files["c.h5"])})
    if kind == "particles":
        return Input(RESTART + ["1"], ["-particles", "p.h5"], {"p.h5": damaged(rng, files["s_0001.h5"])})
    if kind in ("options", "petscrc"):
        while True:
            data = damaged(rng, OPTIONS_TEXT.encode()) if rng.random() < 0.5 else mutated(rng, OPTIONS_TEXT).encode()
            if not EXCLUDED.search(data.decode("latin-1")):
                break
        name, words = {"options": ("o.opts", ["-options_file", "o.opts"]), "petscrc": (".petscrc", [])}[kind]
        return Input(words, ["-n", "8", "-max_steps", "1", "-progress", "none"], {name: data})
    some = {name: files[name] for name in files if name not in ("report.csv", "probe_point.csv", "s.xdmf")}
    other = {name: files[name] for name in files if name not in some}
    name = "s.xdmf" if kind == "index" else rng.choice(("report.csv", "probe_point.csv"))
    other[name] = damaged(rng, other[name])
    return Input(RESTART + ["3"], ["-restart", "c.h5", *PROBES], {**some, **other})


def contents_input(rng, flows):
    k = rng.randrange(len(FLOWS))
    if rng.random() < 0.75:
        return Input(RESTART + ["4", *FLOWS[k]], ["-restart", "c.h5"], {"c.h5": changed(rng, flows[k]["c.h5"])})
    return Input(RESTART + ["1", *FLOWS[k]], ["-particles", "p.h5"], {"p.h5": changed(rng, flows[k]["s_0001.h5"], START)})
