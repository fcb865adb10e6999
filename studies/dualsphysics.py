"""Cases for DualSPHysics, weakly compressible: writes a case and reads its particles.

A case needs none of DualSPHysics's other programs: the particles are written in its binary format. Laminar viscosity,
Wendland kernel, h = 2^(1/2) dx, symplectic steps with two sums over neighbours, density diffusion of Fourtakas et al. Steps are
the shorter of 0.2 h/c and a share of h^2/nu. Walls have one layer of particles every dx, the first at dx/2 behind the surface.
"""
import csv
import glob
import math
import os
import re
import shutil
import struct
from typing import NamedTuple

import numpy as np

PROGRAM = "DualSPHysics5.4CPU_linux64"
RHO, GAMMA, CFL = 1000.0, 7.0, 0.2
FLUID = 3  # type of its particles in outputs
TYPES = {bool: (2, "i"), int: (8, "I"), float: (12, "d")}  # numbers of types, of JBinaryDataDef
ARRAYS = {"Idp": (8, "<u4"), "Posd": (23, "<f8"), "Vel": (22, "<f4"), "Rhop": (11, "<f4"), "BoundNor": (22, "<f4")}
CASE = """<?xml version="1.0" encoding="UTF-8" ?>
<case app="isph">
 <execution>
  <parameters>
{parameters}
{domain}
  </parameters>
  <particles np="{all}" nb="{bound}" nbf="{walls}" mkboundfirst="11" mkfluidfirst="1">
   <fixed mkbound="0" mk="11" begin="0" count="{walls}" />
{moving}
   <fluid mkfluid="0" mk="1" begin="{bound}" count="{fluid}" />
  </particles>
  <constants>
   <data2d value="true" /> <data2dposy value="0" /> <gravity x="{gx:g}" y="0" z="{gz:g}" /> <cflnumber value="{cfl}" />
   <gamma value="{gamma}" /> <rhop0 value="{rho}" /> <dp value="{dx}" /> <h value="{h}" /> <b value="{b}" />
   <massbound value="{mass}" /> <massfluid value="{mass}" />
  </constants>
{motion}
 </execution>
</case>
"""
DOMAIN = """   <simulationdomain>
    <posmin x="{}" y="default" z="{}" />
    <posmax x="{}" y="default" z="{}" />
   </simulationdomain>"""
MOVING = '   <moving mkbound="1" mk="12" begin="{}" count="{}" refmotion="0" />'
MOTION = """  <motion>
   <objreal ref="0"> <begin mov="1" start="0" /> <mvrect id="1" duration="{}"> <vel x="1" y="0" z="0" /> </mvrect> </objreal>
  </motion>"""
PARAMETERS = {"StepAlgorithm": 2, "Kernel": 2, "ViscoTreatment": 3, "ViscoBoundFactor": 1, "DensityDT": 2, "DensityDTvalue": 0.1,
              "RhopOutMin": 700, "RhopOutMax": 1300}


class Case(NamedTuple):
    dx: float
    walls: np.ndarray  # places of particles at rest: a row of x, 0, z each
    fluid: np.ndarray
    nu: float
    sound: float  # speed of sound
    times: tuple  # of the particles that are read; all are multiples of `interval`
    interval: float  # between outputs
    parameters: dict  # beside PARAMETERS
    gravity: tuple = (0, 0)  # along x and z
    share: float = math.inf  # longest step over h^2/nu
    domain: tuple = ()  # x and z of the lowest corner, x and z of the highest
    lid: np.ndarray = np.empty((0, 3))  # places of particles with the velocity 1 along x
    normals: np.ndarray = None  # from particles of walls and lid to the surface; needed by modified dynamic walls


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


def points(x, z):
    """Returns the places of a lattice with the coordinates x and z, row by row."""
    x, z = np.meshgrid(x, z)
    return np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)


def write_case(folder, case):
    """Writes run.xml and run.bi4."""
    h, b = math.sqrt(2) * case.dx, RHO * case.sound**2 / GAMMA
    counts = {"walls": len(case.walls), "bound": len(case.walls) + len(case.lid), "fluid": len(case.fluid)}
    parameters = {**PARAMETERS, "Visco": case.nu, **case.parameters, "TimeMax": case.times[-1], "TimeOut": case.interval}
    with open(os.path.join(folder, "run.xml"), "w") as file:
        file.write(CASE.format(
            **counts, all=counts["bound"] + counts["fluid"], gamma=GAMMA, rho=RHO, dx=case.dx, h=h, b=b, mass=RHO * case.dx**2,
            gx=case.gravity[0], gz=case.gravity[1], cfl=min(CFL, case.share * h * case.sound / case.nu),
            parameters="\n".join(f'   <parameter key="{key}" value="{number}" />' for key, number in parameters.items()),
            domain=DOMAIN.format(*case.domain) if case.domain else "",
            moving=MOVING.format(counts["walls"], len(case.lid)) if len(case.lid) else "",
            motion=MOTION.format(2 * case.times[-1]) if len(case.lid) else ""))
    with open(os.path.join(folder, "run.bi4"), "wb") as file:
        file.write(b"#FileJBD JPartDataBi4".ljust(58) + b"\n\0" + bytes(4))
        file.write(particles(case, h, b))


def particles(case, h, b):
    """Returns the item of all particles: walls, lid, fluid."""
    places = np.concatenate([case.walls, case.lid, case.fluid])
    velocities = np.zeros_like(places)
    velocities[len(case.walls):len(case.walls) + len(case.lid), 0] = 1
    low, high, none = (tuple(map(float, ends)) for ends in (places.min(0), places.max(0), (0, 0, 0)))
    mass = RHO * case.dx**2
    whole = {"Piece": 0, "Npiece": 1, "RunCode": "", "Date": "", "AppName": "isph", "CaseName": "run", "Data2d": True,
             "Data2dPosY": 0.0, "MapPosMin": none, "MapPosMax": none, "PeriXinc": none, "PeriYinc": none,
             "PeriZinc": none, "CaseNp": np.uint64(len(places)), "CaseNfixed": np.uint64(len(case.walls)),
             "CaseNmoving": np.uint64(len(case.lid)), "CaseNfloat": np.uint64(0), "CaseNfluid": np.uint64(len(case.fluid)),
             "CasePosMin": low, "CasePosMax": high, "NpDynamic": False, "ReuseIds": False, "Dp": case.dx, "H": h, "B": b,
             "Rhop0": RHO, "Gamma": GAMMA, "MassBound": mass, "MassFluid": mass, "Symmetry": False, "Splitting": False}
    part = {"Cpart": 0, "TimeStep": 0.0, "Npok": len(places), "Nout": 0, "Step": 0, "RunTime": 0.0, "DomainMin": low,
            "DomainMax": high}
    arrays = {"Idp": np.arange(len(places)), "Posd": places, "Vel": velocities, "Rhop": np.full(len(places), RHO)}
    if case.normals is not None:
        arrays["BoundNor"] = case.normals
    return item("JPartDataBi4", whole, {}, [item("PART_0000", part, arrays, [])])


def command():
    return [shutil.which(PROGRAM), "-cpu", "-ompthreads:1", "run", "out", "-sv:csv", "-csvsep:1"]


def read(folder, case):
    """Returns the number of steps, and the places and velocities of the fluid at the times of the case; raises ValueError if
    particles were lost."""
    with open(os.path.join(folder, "out", "Run.out"), errors="replace") as file:
        steps = int(re.search(r"Steps of simulation\.*: ([\d,]+)", file.read()).group(1).replace(",", ""))
    outputs = {name: [] for name in "xyuv"}
    for t in case.times:
        path, = glob.glob(os.path.join(folder, "out", "**", f"PartCsv_{round(t / case.interval):04d}.csv"), recursive=True)
        with open(path, newline="") as file:
            rows = [{name.split(" ")[0]: number for name, number in row.items() if name} for row in csv.DictReader(file)]
        fluid = [row for row in rows if int(row["Type"]) == FLUID]
        if len(fluid) < len(case.fluid):
            raise ValueError(f"{len(case.fluid) - len(fluid)} of {len(case.fluid)} particles were lost until t = {t:g}")
        for name, column in zip("xyuv", ("Pos.x", "Pos.z", "Vel.x", "Vel.z")):
            outputs[name].append([float(row[column]) for row in fluid])
    return steps, outputs
