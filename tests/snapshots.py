#!/usr/bin/env python3
"""Tests snapshots: their times, fields and attributes, and the data that VTK reads from them.

    snapshots.py times COMMAND...      tests the times of snapshots
    snapshots.py fields COMMAND...     tests fields of steady Couette flow, and attributes; needs h5py
    snapshots.py surfaces COMMAND...   tests the surfaces of a body that moves, and those of -scene_view
    snapshots.py vtk COMMAND...        tests the arrays that VTK reads; needs VTK's Python modules

COMMAND starts the program, on some ranks. The status is 77 if a Python module is missing."""
import glob
import math
import os
import re
import subprocess
import sys
from xml.etree import ElementTree

from interpreter import python_with



def run(*options):
    """Runs the program without its output."""
    subprocess.run([*sys.argv[2:], "-progress", "none", *options], check=True, stdout=subprocess.DEVNULL)


def index_times(path):
    """Returns the times of the snapshots in an XDMF index."""
    with open(path) as file:
        return [float(t) for t in re.findall(r'<Time Value="([^"]*)"', file.read())]


def times():
    """Snapshots lie at multiples of -output_every, for any length of the steps."""
    for motion in "lagrangian", "eulerian":
        run("-case", "cavity", "-n", "12", "-t_end", "1", "-motion", motion, "-output", "s.h5", "-output_every", "0.15",
            "-report_times", "0.2,0.3", "-cfl", "0.7")
        wanted = [*(0.15 * k for k in range(7)), 1]
        found = index_times("s.xdmf")
        assert len(found) == len(wanted), found
        for a, b in zip(found, wanted):
            assert abs(a - b) < 1e-12, (a, b)


def fields():
    """In u = y vorticity, strain rate and density are -1, 1 and rho; attributes name the run."""
    python_with("h5py")
    import h5py

    # 20 steps of nu dt/L^2 = 1; gradients of linear fields are exact up to the solver.
    run("-case", "couette", "-n", "16", "-dt", "1", "-t_end", "20", "-visc_ksp_rtol", "1e-12", "-output", "c.h5")
    with h5py.File("c_0001.h5") as file:
        fluid = file["type"][:] == 0
        assert abs(file["vorticity"][:][fluid] + 1).max() < 1e-7, file["vorticity"][:]
        assert abs(file["strain_rate"][:][fluid] - 1).max() < 1e-7
        assert (file["vorticity"][:][~fluid] == 0).all() and (file["boundary"][:][fluid] == -1).all()
        assert abs(file["density"][:][fluid] - 1).max() < 0.05  # a lattice, wendland_c2, h/dx = 1.3
        bottom = file["boundary"][:] == 2
        assert bottom.any() and (file["position"][:][bottom, 1] <= 0).all()
        attributes = dict(file.attrs)
        assert attributes["boundary_names"] == b"left,right,bottom,top", attributes
        assert attributes["boundary_kinds"] == b"periodic,periodic,wall,wall", attributes
        assert list(attributes["boundary_ids"]) == [0, 1, 2, 3]
        assert "volume" not in file
    # Volumes of a graded lattice fill the box, 0.5 x 1 (8 dx wide); gradients and density as before.
    run("-case", "couette", "-n", "16", "-dt", "1", "-t_end", "20", "-visc_ksp_rtol", "1e-12", "-spacing_wall", "0.5",
        "-output", "g.h5")
    with h5py.File("g_0001.h5") as file:
        fluid = file["type"][:] == 0
        assert abs(file["volume"][:].sum() - 0.5) < 1e-12 and (file["volume"][:][~fluid] == 0).all()
        assert abs(file["vorticity"][:][fluid] + 1).max() < 1e-7, file["vorticity"][:]
        assert abs(file["density"][:][fluid] - 1).max() < 0.05
        assert [attributes[k] for k in ("dx", "rho", "nu")] == [1 / 16, 1, 1] and attributes["h"] > attributes["dx"]
        assert "commit" in attributes
        # virtual data sets of the group VTKHDF
        assert (file["VTKHDF/Points"][:, :2] == file["position"][:]).all()
        assert (file["VTKHDF/PointData/velocity"][:, 2] == 0).all()
    run("-case", "cavity_cylinder", "-n", "16", "-max_steps", "1", "-output", "b.h5", "-checkpoint", "k.h5")
    for path in "b_0001.h5", "k.h5":
        with h5py.File(path) as file:
            assert file.attrs["boundary_names"] == b"left,right,bottom,top,body_1", path
    with h5py.File("b_0001.h5") as file:
        known = {name: value.tolist() for name, value in file.attrs.items() if name[:3] in ("box", "bod", "fre")}
        assert known == {"box": [0, 0, 1, 1], "free_surface": 0, "body_shapes": b"circle", "body_1": [0.5, 0.5, 0.25],
                         "body_1_around": 0}, known
    run("-case", "cavity", "-dim", "3", "-n", "8", "-max_steps", "1", "-output", "d.h5")
    with h5py.File("d_0001.h5") as file:
        assert file["vorticity"].shape == (len(file["id"]), 3)
        assert file["VTKHDF/Points"] == file["position"]  # one data set, two names


def read_surfaces(path):
    """Returns the time, the names and {name: ends of its segments} of a file of surfaces in the plane."""
    root = ElementTree.parse(path).getroot()
    number = {array.get("Name"): array.text.split() for array in root.iter() if array.tag in ("Array", "DataArray")}
    names = bytes(map(int, number["boundary_names"])).decode().split("\0")[:-1]
    x = list(map(float, number["points"]))
    segments = {name: [] for name in names}
    for k, boundary in enumerate(number["boundary"]):
        segments[names[int(boundary)]].append((x[6 * k:6 * k + 2], x[6 * k + 3:6 * k + 5]))
    return float(number["TimeValue"][0]), segments


def surfaces():
    """Corners of a box that moves and turns are where its motion puts them; lengths of surfaces are right."""
    box = "-case", "scene", "-n", "20", "-scene_body_1", "box,0.4,0.35,0.6,0.65"
    run(*box, "-scene_view", "view.vtp")
    run(*box, "-scene_body_1_velocity", "0.2,0", "-scene_body_1_rotation", "1", "-viscosity", "1", "-t_end", "0.2",
        "-output", "m.h5")
    for path, t in ("view.vtp", 0), ("m_0000.vtp", 0), ("m_0001.vtp", 0.2):
        time, segments = read_surfaces(path)
        assert time == t and list(segments) == ["left", "right", "bottom", "top", "body_1"], (time, list(segments))
        length = {name: sum(math.dist(a, b) for a, b in pairs) for name, pairs in segments.items()}
        for name, wanted in ("left", 1), ("top", 1), ("body_1", 1):
            assert abs(length[name] - wanted) < 1e-6, (path, length)
        ends = [end for pair in segments["body_1"] for end in pair]
        for x, y in ((0.1, 0.15), (-0.1, 0.15), (-0.1, -0.15), (0.1, -0.15)):
            corner = (0.5 + 0.2 * t + x * math.cos(t) - y * math.sin(t), 0.5 + x * math.sin(t) + y * math.cos(t))
            assert min(math.dist(corner, end) for end in ends) < 1e-6, (path, corner)


def vtk():
    """VTK reads each file as points with all fields; the index has the times."""
    python_with("vtkmodules.vtkIOHDF")
    from vtkmodules.vtkIOHDF import vtkHDFReader

    for dim, planar in (("2", True), ("3", False)):
        for old in glob.glob("v_*.h5"):
            os.remove(old)
        run("-case", "cavity", "-dim", dim, "-n", "8", "-t_end", "0.2", "-output", "v.h5", "-output_every", "0.1")
        assert index_times("v.xdmf") == [0, 0.1, 0.2]
        for path in sorted(glob.glob("v_*.h5")):
            reader = vtkHDFReader()
            assert reader.CanReadFile(path), path
            reader.SetFileName(path)
            reader.Update()
            grid = reader.GetOutputDataObject(0)
            data = grid.GetPointData()
            arrays = {data.GetArrayName(k): data.GetArray(k) for k in range(data.GetNumberOfArrays())}
            columns = {name: array.GetNumberOfComponents() for name, array in arrays.items()}
            assert columns == {"velocity": 3, "pressure": 1, "density": 1, "vorticity": 1 if planar else 3,
                               "strain_rate": 1, "type": 1, "boundary": 1, "id": 1}, columns
            walls = sum(int(arrays["type"].GetTuple1(k)) for k in range(grid.GetNumberOfPoints()))
            assert grid.GetNumberOfPoints() - walls == 8 ** int(dim)
            assert grid.GetNumberOfCells() == 1 and grid.GetCell(0).GetNumberOfPoints() == grid.GetNumberOfPoints()
            assert grid.GetBounds() == (0, 1, 0, 1, 0, 0 if planar else 1), grid.GetBounds()
            assert arrays["velocity"].GetRange(0)[1] == 1  # the lid


{"times": times, "fields": fields, "surfaces": surfaces, "vtk": vtk}[sys.argv[1]]()
