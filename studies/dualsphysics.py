"""The viscous column of studies/peers_free by DualSPHysics, weakly compressible: writes the case and reads its particles.

The case needs none of DualSPHysics's other programs: the particles are written in its binary format. Laminar viscosity,
Wendland kernel, h = 2^(1/2) dx, symplectic steps, density diffusion of Fourtakas et al., walls of its dynamic particles. The
speed of sound is ten times (2 g H)^(1/2); steps are the shorter of 0.2 h/c and SHARE h^2/nu.
"""
import csv
import glob
import math
import os
import re
import shutil
import struct

import numpy as np

PROGRAM = "DualSPHysics5.4CPU_linux64"
RHO, GAMMA, SOUND, CFL = 1000.0, 7.0, 10 * math.sqrt(2), 0.2
WALL_ROWS = 4
FLUID = 3  # type of its particles in outputs
TYPES = {bool: (2, "i"), int: (8, "I"), float: (12, "d")}  # numbers of types, of JBinaryDataDef
ARRAYS = {"Idp": (8, "<u4"), "Posd": (23, "<f8"), "Vel": (22, "<f4"), "Rhop": (11, "<f4")}
CASE = """<?xml version="1.0" encoding="UTF-8" ?>
<case app="isph">
 <execution>
  <parameters>
{parameters}
   <simulationdomain>
    <posmin x="-2" y="default" z="default" />
    <posmax x="2" y="default" z="1.5" />
   </simulationdomain>
  </parameters>
  <particles np="{all}" nb="{walls}" nbf="{walls}" mkboundfirst="11" mkfluidfirst="1">
   <fixed mkbound="0" mk="11" begin="0" count="{walls}" />
   <fluid mkfluid="0" mk="1" begin="{walls}" count="{fluid}" />
  </particles>
  <constants>
   <data2d value="true" /> <data2dposy value="0" /> <gravity x="0" y="0" z="-1" /> <cflnumber value="{cfl}" />
   <gamma value="{gamma}" /> <rhop0 value="{rho}" /> <dp value="{dx}" /> <h value="{h}" /> <b value="{b}" />
   <massbound value="{mass}" /> <massfluid value="{mass}" />
  </constants>
 </execution>
</case>
"""
PARAMETERS = {"StepAlgorithm": 2, "Kernel": 2, "ViscoTreatment": 3, "Visco": 1, "ViscoBoundFactor": 1, "DensityDT": 2,
              "DensityDTvalue": 0.1, "Shifting": 0, "RhopOutMin": 700, "RhopOutMax": 1300}


def absent():
    """Returns a sentence about the missing program, or None."""
    return None if shutil.which(PROGRAM) else f"no DualSPHysics ({PROGRAM} on the PATH)"


def text(word):
    return struct.pack("<I", len(word)) + word.encode()


def value(name, number):
    """Returns a value of a JBinaryData item; numbers of three components are tuples, 64-bit counts are np.uint64."""
    if isinstance(number, str):
        return text(name) + struct.pack("<i", 1) + text(number)
    if isinstance(number, tuple):
        return text(name) + struct.pack("<i3d", 23, *number)
    if isinstance(number, np.uint64):
        return text(name) + struct.pack("<iQ", 10, int(number))
    number_of_type, code = TYPES[type(number)]
    return text(name) + struct.pack("<i" + code, number_of_type, number)


def item(name, values, arrays, items):
    """Returns an item of JBinaryData with its values, arrays and inner items."""
    body = text("\nVALUES") + struct.pack("<I", len(values)) + b"".join(value(*pair) for pair in values.items())
    head = (text("\nITEM\n") + text(name) + struct.pack("<2i", 0, 0) + text("%15.7E") + text("%24.16E")
            + struct.pack("<3I", len(arrays), len(items), len(body)))
    for key, numbers in arrays.items():
        kind, form = ARRAYS[key]
        data = np.ascontiguousarray(numbers, form).tobytes()
        definition = text("\nARRAY") + text(key) + struct.pack("<2i2I", 0, kind, len(numbers), len(data))
        body += struct.pack("<I", len(definition)) + definition + data
    return struct.pack("<I", len(head)) + head + body + b"".join(items)


def particles(n):
    """Returns places of the floor, then of the fluid, and the number of the floor's."""
    dx = 1 / n
    floor = np.meshgrid((np.arange(-2 * n, 2 * n) + 0.5) * dx, -(np.arange(WALL_ROWS) + 0.5) * dx)
    column = np.meshgrid((np.arange(n) + 0.5) * dx - 0.5, (np.arange(n) + 0.5) * dx)
    places = [np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1) for x, z in (floor, column)]
    return np.concatenate(places), len(places[0])


def write_case(folder, n, share, times):
    """Writes run.xml and run.bi4 for n particles along the height; returns the number of particles of the fluid."""
    places, walls = particles(n)
    dx, h = 1 / n, math.sqrt(2) / n
    b = RHO * SOUND**2 / GAMMA
    parameters = {**PARAMETERS, "TimeMax": times[-1], "TimeOut": times[0] / 2}
    with open(os.path.join(folder, "run.xml"), "w") as file:
        file.write(CASE.format(parameters="\n".join(f'   <parameter key="{key}" value="{number}" />'
                                                    for key, number in parameters.items()),
                               all=len(places), walls=walls, fluid=len(places) - walls, gamma=GAMMA, rho=RHO, dx=dx, h=h, b=b,
                               cfl=min(CFL, share * h * SOUND), mass=RHO * dx * dx))
    low, high, count = (tuple(map(float, ends)) for ends in (places.min(0), places.max(0), (0, 0, 0)))
    whole = {"Piece": 0, "Npiece": 1, "RunCode": "", "Date": "", "AppName": "isph", "CaseName": "run", "Data2d": True,
             "Data2dPosY": 0.0, "MapPosMin": count, "MapPosMax": count, "PeriXinc": count, "PeriYinc": count,
             "PeriZinc": count, "CaseNp": np.uint64(len(places)), "CaseNfixed": np.uint64(walls),
             "CaseNmoving": np.uint64(0), "CaseNfloat": np.uint64(0), "CaseNfluid": np.uint64(len(places) - walls),
             "CasePosMin": low, "CasePosMax": high, "NpDynamic": False, "ReuseIds": False, "Dp": dx, "H": h, "B": b, "Rhop0": RHO,
             "Gamma": GAMMA, "MassBound": RHO * dx * dx, "MassFluid": RHO * dx * dx, "Symmetry": False, "Splitting": False}
    part = {"Cpart": 0, "TimeStep": 0.0, "Npok": len(places), "Nout": 0, "Step": 0, "RunTime": 0.0, "DomainMin": low,
            "DomainMax": high}
    arrays = {"Idp": np.arange(len(places)), "Posd": places, "Vel": np.zeros_like(places), "Rhop": np.full(len(places), RHO)}
    with open(os.path.join(folder, "run.bi4"), "wb") as file:
        file.write(b"#FileJBD JPartDataBi4".ljust(58) + b"\n\0" + bytes(4))
        file.write(item("JPartDataBi4", whole, {}, [item("PART_0000", part, arrays, [])]))
    return len(places) - walls


def command():
    return [shutil.which(PROGRAM), "-cpu", "-ompthreads:1", "run", "out", "-sv:csv", "-csvsep:1"]


def read(folder, times):
    """Returns the number of steps, and the places and velocities of the fluid at these times."""
    with open(os.path.join(folder, "out", "Run.out"), errors="replace") as file:
        steps = int(re.search(r"Steps of simulation\.*: ([\d,]+)", file.read()).group(1).replace(",", ""))
    outputs = {name: [] for name in "xyuv"}
    for t in times:
        path, = glob.glob(os.path.join(folder, "out", "**", f"PartCsv_{round(2 * t / times[0]):04d}.csv"), recursive=True)
        with open(path, newline="") as file:
            rows = [{name.split(" ")[0]: number for name, number in row.items() if name} for row in csv.DictReader(file)]
        fluid = [row for row in rows if int(row["Type"]) == FLUID]
        for name, column in zip("xyuv", ("Pos.x", "Pos.z", "Vel.x", "Vel.z")):
            outputs[name].append([float(row[column]) for row in fluid])
    return steps, outputs
