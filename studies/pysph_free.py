"""Flows of studies/peers_free by PySPH: mode 2 of a viscous drop, and a viscous column on a floor without slip.

Schemes: `wcsph` and `delta` are PySPH's WCSPHScheme without and with the terms of delta-SPH, `edac` its EDACScheme, `adami` its
AdamiHuAdamsScheme, each with its own kernel and integrator and without artificial viscosity. Steps are the shorter of
0.25 h/c and --share h^2/nu. The speed of sound is ten times the rate of the drop, or ten times (2 g H)^(1/2) of the column.
"""
import drop_mode
import numpy as np
from pysph.base.utils import get_particle_array
from pysph.solver.application import Application
from pysph.sph.scheme import AdamiHuAdamsScheme, SchemeChooser, WCSPHScheme
from pysph.sph.wc.edac import EDACScheme

WALL_ROWS = 4  # of particles below the floor
H_OVER_DX = {"wcsph": 1.3, "delta": 1.3, "edac": 1.0, "adami": 1.0}
COLUMN_TIMES = (1, 2.5, 5)


class FreeFlow(Application):
    """Options: --nx, particles along the radius or the height; --share, of h^2/nu in a step; --layout, of the drop."""
    fluids, solids, gravity, sound, times = ["fluid"], [], 0.0, 0.0, ()

    def add_user_options(self, group):
        group.add_argument("--nx", type=int, default=16, help="particles along the radius or the height")
        group.add_argument("--share", type=float, default=0.125, help="step over h^2/nu")
        group.add_argument("--layout", choices=("lattice", "rings"), default="lattice", help="particles of a drop")

    def consume_user_options(self):
        self.dx = 1 / self.options.nx

    def create_scheme(self):
        weak = {"fluids": self.fluids, "solids": self.solids, "dim": 2, "rho0": 1.0, "c0": self.sound, "nu": 1.0,
                "gy": -self.gravity}
        classic = {**weak, "h0": 0.1, "hdx": H_OVER_DX["wcsph"], "alpha": 0.0, "gamma": 7.0}
        return SchemeChooser(default="wcsph", wcsph=WCSPHScheme(**classic), delta=WCSPHScheme(**classic, delta_sph=True),
                             edac=EDACScheme(**weak, h=0.1), adami=AdamiHuAdamsScheme(**weak, h0=0.1, gamma=1.0))

    def h(self):
        return H_OVER_DX[self.options.scheme] * self.dx

    def configure_scheme(self):
        h = self.h()
        self.scheme.configure(**{"h" if self.options.scheme == "edac" else "h0": h})
        self.scheme.configure_solver(dt=min(0.25 * h / self.sound, self.options.share * h * h), tf=self.times[-1],
                                     output_at_times=list(self.times[:-1]), pfreq=10**9)

    def arrays(self, **places):
        """Returns the particles of each name, given their places, velocities and masses."""
        made = [get_particle_array(name=name, rho=1.0, h=self.h(), **values) for name, values in places.items()]
        self.scheme.setup_properties(made)
        for array in made:
            if "V" in array.properties:
                array.V[:] = 1 / array.m
        return made


class Drop(FreeFlow):
    """A disc of radius 1 with the velocity of mode 2."""
    sound, times = 10 * drop_mode.RATE, drop_mode.TIMES

    def create_particles(self):
        x, y = rings(self.options.nx) if self.options.layout == "rings" else lattice(self.options.nx)
        u, v = drop_mode.velocity(x, y, 0)
        return self.arrays(fluid={"x": x, "y": y, "u": u, "v": v, "m": np.full(x.size, np.pi / x.size)})


class Column(FreeFlow):
    """A column 1 wide and 1 high on a floor."""
    solids, gravity, sound, times = ["floor"], 1.0, 10 * np.sqrt(2), COLUMN_TIMES

    def create_particles(self):
        n, dx = self.options.nx, self.dx
        column = np.meshgrid((np.arange(n) + 0.5) * dx - 0.5, (np.arange(n) + 0.5) * dx)
        floor = np.meshgrid((np.arange(-2 * n, 2 * n) + 0.5) * dx, -(np.arange(WALL_ROWS) + 0.5) * dx)
        return self.arrays(**{name: {"x": x.ravel(), "y": y.ravel(), "m": dx * dx}
                              for name, (x, y) in (("fluid", column), ("floor", floor))})


def lattice(n):
    """Returns the points of a square lattice in the unit disc."""
    x, y = (grid.ravel() for grid in np.meshgrid(*2 * ((np.arange(-n, n) + 0.5) / n,)))
    inside = x * x + y * y < 1
    return x[inside], y[inside]


def rings(n):
    """Returns points of equal areas on n rings in the unit disc, 6 k - 3 on ring k."""
    angles = [2 * np.pi * (np.arange(6 * k - 3) + 0.5 * (k % 2)) / (6 * k - 3) for k in range(1, n + 1)]
    radii = np.concatenate([np.full(angle.size, (k + 0.5) / n) for k, angle in enumerate(angles)])
    angles = np.concatenate(angles)
    return radii * np.cos(angles), radii * np.sin(angles)
