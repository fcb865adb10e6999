"""The channel of studies/peers by PySPH: width 1, length 2, from rest, driven to a parabola of largest velocity 1.

Schemes, sound speed, background pressure, kernel, walls and steps are those of PySPH's examples `poiseuille` and `cavity`.
"""
import numpy as np
from pysph.base.nnps import DomainManager
from pysph.base.utils import get_particle_array
from pysph.solver.application import Application
from pysph.sph.scheme import SchemeChooser, TVFScheme
from pysph.sph.wc.edac import EDACScheme

SOUND, LENGTH, WALL_ROWS = 10.0, 2, 5


class Channel(Application):
    """Options: --nx, particles across; --re, Reynolds number on the width."""

    def add_user_options(self, group):
        group.add_argument("--nx", type=int, default=20, help="particles across")
        group.add_argument("--re", type=float, default=15, help="Reynolds number")

    def consume_user_options(self):
        self.dx, self.nu = 1 / self.options.nx, 1 / self.options.re

    def create_scheme(self):
        both = {"fluids": ["fluid"], "solids": ["walls"], "dim": 2, "rho0": 1.0, "c0": SOUND, "nu": 0.0, "pb": SOUND**2}
        return SchemeChooser(default="tvf", tvf=TVFScheme(**both, p0=SOUND**2, h0=1.0), edac=EDACScheme(**both, h=1.0))

    def configure_scheme(self):
        h, force = self.dx, 8 * self.nu
        self.scheme.configure(**{"h" if self.options.scheme == "edac" else "h0": h}, nu=self.nu, gx=force)
        dt = min(0.25 * h / (SOUND + 1), 0.125 * h * h / self.nu, 0.25 * np.sqrt(h / force))
        self.scheme.configure_solver(dt=dt, pfreq=10**9)

    def create_domain(self):
        return DomainManager(xmin=0, xmax=LENGTH, periodic_in_x=True)

    def create_particles(self):
        n, dx = self.options.nx, self.dx
        along, across = (np.arange(LENGTH * n) + 0.5) * dx, (np.arange(n) + 0.5) * dx
        behind = -(np.arange(WALL_ROWS) + 0.5) * dx
        arrays = []
        for name, places in (("fluid", across), ("walls", np.concatenate([behind, 1 - behind]))):
            x, y = np.meshgrid(along, places)
            arrays.append(get_particle_array(name=name, x=x.ravel(), y=y.ravel(), m=dx * dx, rho=1.0, h=dx))
        self.scheme.setup_properties(arrays)
        for array in arrays:
            array.set(V=np.full(array.x.size, 1 / (dx * dx)))
        return arrays
