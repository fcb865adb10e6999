# The recipe of Spack: `spack repo create REPO`, copy this file to REPO/packages/isph/package.py, `spack repo add REPO`.
# `spack dev-build isph@0.2.0` builds the source tree in which it is called.
from spack.package import *


class Isph(CMakePackage):
    """Incompressible viscous SPH with sparse viscosity and pressure operators, on PETSc."""

    license("BSD-2-Clause")

    # url and sha256 belong to a tarball that is published: `spack checksum isph`
    version("0.2.0")

    variant("native", default=False, description="Compile for this machine's processor only")

    depends_on("c", type="build")
    depends_on("cmake@3.18:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("hdf5+mpi")
    depends_on("lapack")
    depends_on("petsc@3.18:+mpi+hdf5+hypre~complex")
    depends_on("muparser@2.3:")
    depends_on("python@3.9:", type="run")
    depends_on("py-h5py", type="run")
    depends_on("py-matplotlib", type="run")
    depends_on("py-numpy", type="run")

    def cmake_args(self):
        return [
            self.define("ISPH_TESTS", False),
            self.define_from_variant("ISPH_NATIVE", "native"),
            self.define("PETSC_DIR", self.spec["petsc"].prefix),
            self.define("CMAKE_C_COMPILER", self.spec["mpi"].mpicc),
        ]

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_cavity(self):
        Executable(join_path(self.prefix.bin, "isph"))("-case", "cavity", "-n", "16", "-max_steps", "2")
