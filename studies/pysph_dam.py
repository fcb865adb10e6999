"""The viscous dam of studies/dam_viscous by PySPH: 2 wide and 2 high, g = density = 1, viscosity 1, on a floor without slip.

The scheme is Adami, Hu & Adams, J. Comput. Phys. 231 (2012), weakly compressible, with wall particles that extrapolate the
velocity; the speed of sound is ten times (2 g H)^(1/2). Steps are the shorter of 0.25 h/c and 0.125 h^2/nu.
"""
import numpy as np
from pysph.base.kernels import QuinticSpline
from pysph.base.utils import get_particle_array
from pysph.solver.application import Application
from pysph.sph.scheme import AdamiHuAdamsScheme

SOUND, NU, TIMES = 20.0, 1.0, (2, 4, 6)


class ViscousDam(Application):
    """Option: --nx, particles along half of the width."""

    def add_user_options(self, group):
        group.add_argument("--nx", type=int, dest="nx", default=16, help="particles along half of the width of the dam")

    def consume_user_options(self):
        self.dx = 1 / self.options.nx

    def create_scheme(self):
        return AdamiHuAdamsScheme(fluids=["fluid"], solids=["floor"], dim=2, rho0=1.0, c0=SOUND, nu=NU, h0=0.1, p0=0.0,
                                  gy=-1.0, gamma=1.0, tdamp=0.0, alpha=0.0)

    def configure_scheme(self):
        h = self.dx
        self.scheme.configure(h0=h)
        self.scheme.configure_solver(kernel=QuinticSpline(dim=2), dt=min(0.25 * h / SOUND, 0.125 * h * h / NU), tf=TIMES[-1],
                                     output_at_times=list(TIMES[:-1]), pfreq=10**9)

    def create_particles(self):
        dx, half = self.dx, self.options.nx
        places = (np.arange(-half, half) + 0.5) * dx
        x, y = (grid.ravel() for grid in np.meshgrid(places, (np.arange(2 * half) + 0.5) * dx))
        floor = (np.arange(-4 * half, 4 * half) + 0.5) * dx
        wall_x, wall_y = (grid.ravel() for grid in np.meshgrid(floor, -(np.arange(4) + 0.5) * dx))
        arrays = [get_particle_array(name=name, x=a, y=b, m=dx * dx, rho=1.0, h=dx)
                  for name, a, b in (("fluid", x, y), ("floor", wall_x, wall_y))]
        self.scheme.setup_properties(arrays)
        for array in arrays:
            array.set(V=np.full(array.x.size, 1 / (dx * dx)))
        return arrays
