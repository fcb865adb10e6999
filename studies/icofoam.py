"""Lid-driven cavity by OpenFOAM's icoFoam: writes the case and reads the velocity.

Second order in space and time: linear interpolation everywhere, backward differences; PISO with two corrections, the
pressure by GAMG, which takes a third of PCG's time on 100^2 cells. Square cells, unit cavity, lid u = 1 at y = 1, from
rest.
"""
import math
import os
import re
import shutil

import numpy as np

HEAD = "FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"
FILES = {  # path: (class, text with fields of str.format in single braces)
    "system/blockMeshDict": ("dictionary", """
scale 1;
vertices ((0 0 0) (1 0 0) (1 1 0) (0 1 0) (0 0 {dx}) (1 0 {dx}) (1 1 {dx}) (0 1 {dx}));
blocks (hex (0 1 2 3 4 5 6 7) ({n} {n} 1) simpleGrading ({grading} {grading} 1));
boundary
(
  lid {{ type wall; faces ((3 7 6 2)); }}
  walls {{ type wall; faces ((0 4 7 3) (2 6 5 1) (1 5 4 0)); }}
  sides {{ type empty; faces ((0 3 2 1) (4 5 6 7)); }}
);
"""),
    "system/controlDict": ("dictionary", """
application icoFoam; startFrom startTime; startTime 0; stopAt endTime; endTime {t_end}; deltaT {dt};
writeControl timeStep; writeInterval {interval}; writeFormat ascii; writePrecision 12; timePrecision 12;
runTimeModifiable false;
"""),
    "system/fvSchemes": ("dictionary", """
ddtSchemes {{ default backward; }}
gradSchemes {{ default Gauss linear; }}
divSchemes {{ default none; div(phi,U) Gauss linear; }}
laplacianSchemes {{ default Gauss linear orthogonal; }}
interpolationSchemes {{ default linear; }}
snGradSchemes {{ default orthogonal; }}
"""),
    "system/fvSolution": ("dictionary", """
solvers
{{
  p {{ solver GAMG; smoother GaussSeidel; tolerance {tolerance}; relTol 0.05; }}
  pFinal {{ $p; relTol 0; }}
  U {{ solver smoothSolver; smoother symGaussSeidel; tolerance {tolerance}; relTol 0; }}
}}
PISO {{ nCorrectors 2; nNonOrthogonalCorrectors 0; pRefCell 0; pRefValue 0; }}
"""),
    "constant/transportProperties": ("dictionary", "nu [0 2 -1 0 0 0 0] {nu};\n"),
    "0/U": ("volVectorField", """
dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0);
boundaryField
{{
  lid {{ type fixedValue; value uniform (1 0 0); }}
  walls {{ type noSlip; }}
  sides {{ type empty; }}
}}
"""),
    "0/p": ("volScalarField", """
dimensions [0 2 -2 0 0 0 0]; internalField uniform 0;
boundaryField
{{
  lid {{ type zeroGradient; }}
  walls {{ type zeroGradient; }}
  sides {{ type empty; }}
}}
"""),
}
MESH, SOLVE = ["blockMesh"], ["icoFoam"]


def absent():
    """Returns a sentence about missing programs, or None."""
    missing = [command[0] for command in (MESH, SOLVE) if not shutil.which(command[0])]
    return f"no {' and no '.join(missing)} (Debian package openfoam)" if missing else None


def environment():
    return {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ}


def write_files(folder, files, **values):
    """Writes the files of a case with these values in their fields."""
    for path, (kind, text) in files.items():
        path = os.path.join(folder, path)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w") as file:
            file.write((HEAD + text).format(kind=kind, name=os.path.basename(path), **values))


def write_case(folder, reynolds, n, t_end, courant, tolerance="1e-6", writes=1, ratio=1):
    """Writes the case for steps of at most courant dx/U and linear solvers that stop at a residual. The velocity is
    written `writes` times, and cells grow by a ratio from walls to the middle. Returns (dt, steps)."""
    steps = math.ceil(t_end * n / courant / writes - 1e-9) * writes
    write_files(folder, FILES, n=n, dx=1 / n, nu=1 / reynolds, t_end=f"{t_end:g}", interval=steps // writes,
                dt=f"{t_end / steps:.15g}", tolerance=tolerance,
                grading=1 if ratio == 1 else f"((0.5 0.5 {ratio})(0.5 0.5 {1 / ratio}))")
    return t_end / steps, steps


def cell_sizes(n, ratio):
    """Returns the sizes of cells of write_case() along an axis."""
    half = float(ratio) ** (np.arange(n // 2) / (n // 2 - 1))
    half *= 0.5 / half.sum()
    return np.concatenate([half, half[::-1]])


def times(folder):
    """Returns the names of the times with a written velocity, ascending, without the start."""
    return sorted((name for name in os.listdir(folder) if re.fullmatch(r"[0-9.e+-]+", name) and name != "0"), key=float)


def read_velocity(folder, n, time=None):
    """Returns u[k, j, i] and v[k, j, i] of the cell in column i, row j and layer k at a time, by default the end."""
    with open(os.path.join(folder, time or times(folder)[-1], "U")) as file:
        block = re.search(r"nonuniform List<vector>\s*(\d+)\s*\((.*?)\n\)", file.read(), re.DOTALL)
    if not block or int(block[1]) % (n * n):
        raise ValueError(f"no velocity of layers of {n * n} cells")
    values = np.array(block[2].replace("(", " ").replace(")", " ").split(), dtype=float).reshape(-1, n, n, 3)
    return values[..., 0], values[..., 1]
