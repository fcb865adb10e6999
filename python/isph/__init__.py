"""Incompressible viscous flow by smoothed particles: flows of isph from Python.

    import isph
    flow = isph.Flow(case="cavity", n=32, reynolds=100)
    flow.run(until=0.5)
    u, v = flow["velocity"]

Options are those of the program, without the dash. A tuple has components, and a function of x, y, z, t, a scalar or g
may stand for an expression or a component of one: scene_wall_top_velocity=(lambda x, t: x*(1 - x)*t, 0).
"""
import atexit
import ctypes
import inspect
import itertools
import pathlib
import runpy
import tempfile
import warnings
import weakref
from collections import namedtuple

import numpy

from ._library import FUNCTION, MONITOR, Error, Int, Real, byref, c_bool, c_char_p, c_int64, call, lib
from ._library import POINTER, c_void_p

__all__ = ["Error", "Flow", "study"]
Force = namedtuple("Force", "force torque error")  # [N], [N m]; how far two measures of each differ
Pose = namedtuple("Pose", "x attitude velocity spin")  # [m]; a quaternion; [m/s], [rad/s]
_flows = weakref.WeakSet()  # that are open


def _real(values):
    """Returns values as an array, and its address."""
    array = numpy.ascontiguousarray(values, dtype=float)
    return array, array.ctypes.data_as(POINTER(Real))


class Flow:
    """A flow. Arrays of it are those of the flow itself: they are valid until it makes a step, so copy what is kept.
    On several ranks (mpiexec, mpi4py) every rank makes the same calls, and has its own particles."""

    def __init__(self, *words, **options):
        """words: of a command line, as in Flow("-options_file", "kneader.opts", n=30)."""
        self._handle, self._functions, self._raised, self._each = c_void_p(), [], [], None
        lib.IsphFlowCreate(byref(self._handle))
        _flows.add(self)
        try:
            words = list(words) + [word for name, value in options.items() for word in self._option(name, value)]
            call(self._handle, "SetOptions", len(words), (c_char_p * (len(words) + 1))(*(w.encode() for w in words)))
            me = weakref.ref(self)  # a flow without circles ends where it is given up, on all ranks alike
            self._monitor = MONITOR(lambda *_: me()._after_step())
            call(self._handle, "SetMonitor", self._monitor, None)
            self._call("SetUp")
        except BaseException:
            self.close()
            raise

    def close(self):
        """Frees the flow."""
        if self._handle:
            lib.IsphFlowDestroy(byref(self._handle))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        self.close()

    def _call(self, name, *arguments):
        """Calls the library; an exception in a function of the user takes precedence over the error that follows."""
        if not self._handle:
            raise ValueError("the flow is closed")
        try:
            call(self._handle, name, *arguments)
        except Error:
            if not self._raised:
                raise
        if self._raised:
            raised = self._raised[0]
            self._raised.clear()
            raise raised

    def _option(self, name, value):
        """Returns the words of an option."""
        if value is None or value is False:
            return [f"-{name}", "false"] if value is False else []
        if value is True:
            return [f"-{name}"]
        parts = value if isinstance(value, tuple) else (value,)
        text = ",".join(self._function(part) if callable(part) else str(part) for part in parts)
        is_word = text[:1] == "-" and text[1:2].isalpha()
        return [f"-{name}", f"({text})" if is_word and len(parts) == 1 else f"0{text}" if is_word else text]

    def _function(self, function):
        """Registers a function; returns its call in an expression, with its arguments by their names."""
        raised = self._raised

        def value(n, argument, _):
            try:
                return float(function(*argument[:n]))
            except BaseException as fault:  # the flow ends with NaN, and _call() raises this
                raised.append(fault)
                return numpy.nan
        name, self._functions = f"python_{len(self._functions)}", self._functions + [FUNCTION(value)]
        call(self._handle, "SetFunction", name.encode(), self._functions[-1], None)
        return f"{name}({','.join(inspect.signature(function).parameters)})"

    def _after_step(self):
        """Called after each step; stops a run after an exception, as a KeyboardInterrupt."""
        try:
            return 1 if self._each and self._each(self) else 0
        except BaseException as fault:
            self._raised.append(fault)
            return 1

    def step(self):
        """Makes a step."""
        self._each = None
        self._call("Step")

    def run(self, until=numpy.inf, each=None, progress=False):
        """Runs to a time, at which a step ends, or to the end of the run; returns the flow. each: called with the flow
        after each step; if it returns true, the run stops. progress: a line that is written anew."""
        def after(flow):
            if progress:
                print(f"\rt = {flow.t:.6g}, step {flow.steps} ", end="", flush=True)
            return each(flow) if each else None
        self._each = after
        try:
            self._call("Run", until)
            if self.t < until * (1.0 - 1e-9) < numpy.inf:
                warnings.warn(f"the run ended at t = {self.t:.6g}, before {until:.6g}; give a later t_end, or a looser end",
                              stacklevel=2)
        except Error as fault:
            if fault.code != 1:  # the monitor stops
                raise
        finally:
            self._each = None
            if progress:
                print()
        return self

    def _time(self):
        t, dt, step = Real(), Real(), Int()
        self._call("GetTime", byref(t), byref(dt), byref(step))
        return t.value, dt.value, step.value

    t = property(lambda self: self._time()[0], doc="Time [s].")
    dt = property(lambda self: self._time()[1], doc="Length of the last step [s].")
    steps = property(lambda self: self._time()[2], doc="Number of steps.")
    dim = property(lambda self: self._sizes()[0], doc="Dimension of space.")
    n = property(lambda self: self._sizes()[1], doc="Number of fluid particles of this rank.")

    @property
    def over(self):
        """True at the end of the run."""
        over = c_bool()
        self._call("IsOver", byref(over))
        return over.value

    def _sizes(self):
        sizes = Int(), Int(), Int()
        self._call("GetSizes", *map(byref, sizes))
        return [size.value for size in sizes]

    def _view(self, pointer, n, kind=Real):
        """Returns an array of the flow without a copy; it keeps the flow alive."""
        numbers = (kind * n).from_address(ctypes.addressof(pointer.contents)) if n else (kind * 0)()
        numbers.flow = self
        return numpy.frombuffer(numbers, dtype=numpy.dtype(kind)) if n else numpy.empty(0, numpy.dtype(kind))

    @property
    def ids(self):
        """Ids of the fluid particles, which they keep."""
        pointer = POINTER(c_int64)()
        self._call("GetIds", byref(pointer))
        return self._view(pointer, self.n, c_int64)

    def __getitem__(self, name):
        """A field of the fluid: an array, or a tuple of the arrays of its components. Position, velocity, pressure,
        viscosity, spacing, volume and scalars are those of the flow; others, as vorticity, are computed."""
        n, component = Int(), (POINTER(Real) * 3)()
        try:
            self._call("GetField", name.encode(), byref(n), component)
        except Error:
            rows, place = _real(numpy.empty(3 * sum(self._sizes()[1:])))
            self._call("ComputeField", name.encode(), byref(n), place)
            values = rows[:n.value * self.n].reshape(self.n, n.value).T
            return values[0] if n.value == 1 else tuple(values)
        arrays = tuple(self._view(component[c], self.n) for c in range(n.value))
        return arrays if n.value > 1 else arrays[0]

    def vec(self, name, component=0):
        """A field as a Vec of petsc4py, on the same numbers."""
        from petsc4py import PETSc
        field = self[name]
        return PETSc.Vec().createWithArray(field[component] if isinstance(field, tuple) else field)

    def changed(self):
        """Tells that velocities, pressures or scalars have been changed."""
        self._call("Changed")

    def insert(self, x, velocity=None):
        """Inserts fluid particles at rows of x, with the velocity of the fluid around them, or rows of their own."""
        x, place = _real(numpy.atleast_2d(x))
        u, given = _real(numpy.broadcast_to(velocity, x.shape)) if velocity is not None else (None, None)
        self._call("Insert", len(x), place, given)

    def remove(self, ids):
        """Removes fluid particles by their ids."""
        ids = numpy.ascontiguousarray(numpy.atleast_1d(ids), dtype=numpy.int64)
        self._call("Remove", len(ids), ids.ctypes.data_as(POINTER(c_int64)))

    @property
    def boundaries(self):
        """The names of the boundaries with the names of their kinds: the sides of the box, then bodies."""
        names, name, kind = {}, c_char_p(), c_char_p()
        while True:
            self._call("GetBoundary", len(names), byref(name), byref(kind))
            if not name.value:
                return names
            names[name.value.decode()] = kind.value.decode()

    def _number(self, boundary):
        names = list(self.boundaries)
        if boundary not in names:
            raise KeyError(f"{boundary}: the boundaries are {', '.join(names)}")
        return names.index(boundary)

    def force(self, boundary):
        """Force and torque of the fluid on a boundary, and how far two measures of each differ.

        That is a lower bound of the error, NaN with a free surface; the report has error bars."""
        parts = [numpy.zeros(3), numpy.zeros(3), numpy.zeros(2)]
        self._call("GetForce", self._number(boundary), *(_real(part)[1] for part in parts))
        return Force(*parts)

    def pose(self, body):
        """Place, attitude, velocity and spin of a body."""
        parts = [numpy.zeros(3), numpy.zeros(4), numpy.zeros(3), numpy.zeros(3)]
        self._call("GetPose", self._number(body), *(_real(part)[1] for part in parts))
        return Pose(*parts)

    def probe(self, x):
        """Velocities and pressures at rows of x; NaN outside the fluid."""
        x, place = _real(numpy.atleast_2d(x))
        u, p = numpy.empty_like(x), numpy.empty(len(x))
        self._call("Probe", len(x), place, _real(u)[1], _real(p)[1])
        return u, p

    def measure(self):
        """Measures the flow; returns the quantities of the report by their names: (value, reference, relative error)."""
        self._call("Measure")
        return {row["quantity"]: (row["value"], row["reference"], row["error"]) for row in self.report()}

    def report(self):
        """The quantities measured so far, as rows: time, quantity, value, reference, relative error."""
        rows, name, t, value = [], c_char_p(), Real(), (Real * 3)()
        while True:
            self._call("GetQuantity", len(rows), byref(name), byref(t), value)
            if not name.value:
                return rows
            rows.append({"t": t.value, "quantity": name.value.decode(), "value": value[0], "reference": value[1],
                         "error": value[2]})

    def write(self, path):
        """Writes a snapshot for ParaView; the path ends in .h5."""
        self._call("WriteSnapshot", str(path).encode())

    def checkpoint(self, path):
        """Writes a checkpoint, for restart=path."""
        self._call("WriteCheckpoint", str(path).encode())

    def picture(self, field="speed", path=None, **style):
        """Draws a field of this rank over x and y by matplotlib, and with one rank the bodies, which needs h5py; returns the
        axes. path: of a file."""
        from matplotlib import pyplot
        x, y = self["position"][:2]
        values = numpy.sqrt(sum(u * u for u in self["velocity"])) if field == "speed" else self[field]
        if isinstance(values, tuple):
            values = values[0]
        _, axes = pyplot.subplots()
        points = axes.scatter(x.copy(), y.copy(), c=values.copy(), **{"s": 30000.0 / max(len(x), 1), "lw": 0, **style})
        axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"{field}, t = {self.t:.4g} s")
        axes.figure.colorbar(points, label=field)
        if len(self.boundaries) > 2 * self.dim and ctypes.c_int.in_dll(lib, "PetscGlobalSize").value == 1:
            self._draw_bodies(axes)
        if path:
            axes.figure.savefig(path, dpi=150)
        return axes

    def _draw_bodies(self, axes):
        """Draws the bodies as studies/plot does, from a snapshot."""
        paths = [parent / folder / "snapshot.py" for parent in pathlib.Path(__file__).resolve().parents
                 for folder in ("studies", "share/isph/studies")]
        try:
            module = runpy.run_path(next((str(path) for path in paths if path.is_file()), "snapshot.py"))
        except (ImportError, OSError) as error:
            warnings.warn(f"no bodies are drawn: {error}", stacklevel=3)
            return
        with tempfile.TemporaryDirectory() as folder:
            self.write(f"{folder}/bodies.h5")
            snapshot = module["Snapshot"](f"{folder}/bodies.h5")
        axes.set(xlim=snapshot.box[:2], ylim=snapshot.box[2:])
        snapshot.draw_bodies(axes)


@atexit.register
def _close():
    """Frees the flows that are left, before PETSc ends."""
    for flow in list(_flows):
        flow.close()


def study(*words, measure=None, **options):
    """Runs a flow for each combination of the options that are lists, one after the other. A row has these options and
    what measure(flow) returns by names, by default the values of the report; a flow that ends with an error has its text
    in the column `error`. Returns a frame of pandas where there is pandas, else a list of rows.

        isph.study(case="cavity", n=[16, 24, 32], reynolds=[10, 100])"""
    swept = {name: values for name, values in options.items() if isinstance(values, list)}
    rows = []
    for values in itertools.product(*swept.values()):
        row = dict(zip(swept, values))
        try:
            with Flow(*words, **{**options, **row}) as flow:
                flow.run()
                row.update(measure(flow) if measure else {k: v[0] for k, v in flow.measure().items()})
        except Error as fault:
            row["error"] = str(fault)
        rows.append(row)
    try:
        import pandas
        return pandas.DataFrame(rows)
    except ImportError:
        return rows
