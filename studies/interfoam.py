"""A dam on a floor without slip by OpenFOAM's interFoam, two fluids in one mesh: writes the case and reads the front.

The dam is 1 wide and 2 high, beside a plane of symmetry at x = 0; its density is 1 and g = 1. The fluid above has a
thousandth of its density and of its dynamic viscosity. Square cells; steps by a Courant number, with three outer
corrections, because viscosity couples velocity and pressure where nu dt/dx^2 is large.
"""
import os
import re
import shutil

import icofoam
import numpy as np

LENGTH, HEIGHT = 4, 3  # of the box
FIELD = """
dimensions {dimensions}; internalField {start};
boundaryField
{{
  middle {{ type symmetryPlane; }}
  walls {{ {walls} }}
  top {{ {top} }}
  sides {{ type empty; }}
}}
"""
FILES = {  # path: (class, text with fields of str.format in single braces)
    "system/blockMeshDict": ("dictionary", f"""
scale 1;
vertices ((0 0 0) ({LENGTH} 0 0) ({LENGTH} {HEIGHT} 0) (0 {HEIGHT} 0)
          (0 0 {{dx}}) ({LENGTH} 0 {{dx}}) ({LENGTH} {HEIGHT} {{dx}}) (0 {HEIGHT} {{dx}}));
blocks (hex (0 1 2 3 4 5 6 7) ({{nx}} {{ny}} 1) simpleGrading (1 1 1));
boundary
(
  middle {{{{ type symmetryPlane; faces ((0 4 7 3)); }}}}
  walls {{{{ type wall; faces ((2 6 5 1) (1 5 4 0)); }}}}
  top {{{{ type patch; faces ((3 7 6 2)); }}}}
  sides {{{{ type empty; faces ((0 3 2 1) (4 5 6 7)); }}}}
);
"""),
    "system/controlDict": ("dictionary", """
application interFoam; startFrom startTime; startTime 0; stopAt endTime; endTime {t_end}; deltaT 1e-4;
writeControl adjustable; writeInterval {interval}; writeFormat ascii; writePrecision 8; timePrecision 8;
runTimeModifiable false; adjustTimeStep yes; maxCo {courant}; maxAlphaCo {courant}; maxDeltaT {dt_max};
"""),
    "system/fvSchemes": ("dictionary", """
ddtSchemes {{ default Euler; }}
gradSchemes {{ default Gauss linear; }}
divSchemes
{{
  div(rhoPhi,U) Gauss linearUpwind grad(U); div(phi,alpha) Gauss vanLeer; div(phirb,alpha) Gauss linear;
  div(((rho*nuEff)*dev2(T(grad(U))))) Gauss linear;
}}
laplacianSchemes {{ default Gauss linear orthogonal; }}
interpolationSchemes {{ default linear; }}
snGradSchemes {{ default orthogonal; }}
"""),
    "system/fvSolution": ("dictionary", """
solvers
{{
  "alpha.water.*"
  {{
    nAlphaCorr 2; nAlphaSubCycles 1; cAlpha 1; MULESCorr yes; nLimiterIter 5; solver smoothSolver;
    smoother symGaussSeidel; tolerance 1e-8; relTol 0;
  }}
  "pcorr.*" {{ solver PCG; preconditioner DIC; tolerance 1e-6; relTol 0; }}
  p_rgh {{ solver PCG; preconditioner DIC; tolerance 1e-8; relTol 0.01; }}
  p_rghFinal {{ $p_rgh; relTol 0; }}
  U {{ solver smoothSolver; smoother symGaussSeidel; tolerance 1e-9; relTol 0.01; }}
  UFinal {{ $U; relTol 0; }}
}}
PIMPLE {{ momentumPredictor yes; nOuterCorrectors 3; nCorrectors 3; nNonOrthogonalCorrectors 0; }}
relaxationFactors {{ equations {{ ".*" 1; }} }}
"""),
    "constant/g": ("uniformDimensionedVectorField", "dimensions [0 1 -2 0 0 0 0]; value (0 -1 0);\n"),
    "constant/transportProperties": ("dictionary", """
phases (water air);
water {{ transportModel Newtonian; nu {nu}; rho 1; }}
air {{ transportModel Newtonian; nu {nu}; rho 1e-3; }}
sigma 0;
"""),
    "constant/turbulenceProperties": ("dictionary", "simulationType laminar;\n"),
    "0/U": ("volVectorField", FIELD.replace("{start}", "uniform (0 0 0)").replace("{dimensions}", "[0 1 -1 0 0 0 0]")
            .replace("{walls}", "type noSlip;")
            .replace("{top}", "type pressureInletOutletVelocity; value uniform (0 0 0);")),
    "0/p_rgh": ("volScalarField", FIELD.replace("{start}", "uniform 0").replace("{dimensions}", "[1 -1 -2 0 0 0 0]")
                .replace("{walls}", "type fixedFluxPressure; value uniform 0;")
                .replace("{top}", "type totalPressure; p0 uniform 0;")),
    "0/alpha.water": ("volScalarField", FIELD.replace("{start}", "nonuniform List<scalar> {alpha}")
                      .replace("{dimensions}", "[0 0 0 0 0 0 0]").replace("{walls}", "type zeroGradient;")
                      .replace("{top}", "type inletOutlet; inletValue uniform 0; value uniform 0;")),
}
MESH, SOLVE = ["blockMesh"], ["interFoam"]


def absent():
    """Returns a sentence about missing programs, or None."""
    missing = [command[0] for command in (MESH, SOLVE) if not shutil.which(command[0])]
    return f"no {' and no '.join(missing)} (Debian package openfoam)" if missing else None


def write_case(folder, nu, n, t_end, interval, courant):
    """Writes the case with n cells along the width of the dam; fields are written at multiples of the interval."""
    nx, ny = LENGTH * n, HEIGHT * n
    filled = np.zeros((ny, nx), dtype=int)
    filled[:2 * n, :n] = 1
    alpha = f"{filled.size} ({' '.join(map(str, filled.ravel()))})"
    icofoam.write_files(folder, FILES, nu=f"{nu:g}", nx=nx, ny=ny, dx=1 / n, t_end=f"{t_end:g}", interval=f"{interval:g}",
                        courant=f"{courant:g}", dt_max=f"{interval:g}", alpha=alpha)


def read_share(folder, n, time):
    """Returns the share of the dam's fluid at [row, column] at a time."""
    with open(os.path.join(folder, time, "alpha.water")) as file:
        block = re.search(r"nonuniform List<scalar>\s*(\d+)\s*\((.*?)\n\)", file.read(), re.DOTALL)
    if not block:
        raise ValueError(f"no share of the fluid in {folder}")
    return np.array(block[2].split(), dtype=float).reshape(HEIGHT * n, LENGTH * n)


def crossing(share, n):
    """Returns the last place at which a line of cells, or each of several lines, crosses the share 1/2."""
    best = 0.0
    for line in np.atleast_2d(share):
        inside = np.flatnonzero(line >= 0.5)
        if inside.size and inside[-1] + 1 < line.size:
            k = inside[-1]
            best = max(best, (k + 0.5 + (line[k] - 0.5) / (line[k] - line[k + 1])) / n)
    return best


def shape(folder, n, time):
    """Returns front, highest place and volume of the half of the dam at a time."""
    share = read_share(folder, n, time)
    return crossing(share, n), crossing(share.T, n), share.sum() / n**2
