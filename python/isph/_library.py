"""The functions of libisph by ctypes: include/isph.h describes them."""
import atexit
import ctypes
import ctypes.util
import os
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int, c_int64, c_size_t, c_void_p
from pathlib import Path


def _load():
    """Loads the library of ISPH_LIBRARY, of the prefix or build tree of this package, or of the system."""
    here = Path(__file__).resolve().parent
    places = [os.environ.get("ISPH_LIBRARY"), here / "libisph.so", here.parents[1] / "build" / "libisph.so",
              *sorted(parent / "libisph.so" for parent in here.parents), ctypes.util.find_library("isph"), "libisph.so"]
    last = "there is none"
    for place in places:
        if place and (os.path.exists(place) or os.sep not in str(place)):
            try:  # plug-ins and those of MPI look for functions among global ones
                return ctypes.CDLL(str(place), mode=ctypes.RTLD_GLOBAL)
            except OSError as fault:
                last = fault
    raise ImportError(f"libisph.so is not found, or does not load ({last}); ISPH_LIBRARY names it")


lib = _load()
MONITOR = ctypes.CFUNCTYPE(c_int, c_void_p, c_void_p)


def _whole():
    """Returns the type of PetscInt."""
    kind, found, size = c_int(), c_int(), c_size_t()
    lib.PetscDataTypeFromString(b"int", byref(kind), byref(found))
    lib.PetscDataTypeGetSize(kind, byref(size))
    return c_int64 if found.value and size.value == 8 else c_int


class Error(RuntimeError):
    """A refused option, a flow that diverged, or another error of a flow; `code` is that of PETSc."""

    def __init__(self, text, code):
        super().__init__(text)
        self.code = code


_mine = c_int()
lib.PetscInitialized(byref(_mine))
if lib.IsphInitialize():
    raise ImportError("MPI or PETSc does not start")
if not _mine.value:  # petsc4py ends what it has begun
    atexit.register(lib.IsphFinalize)
Int, Real = _whole(), c_double
FUNCTION = ctypes.CFUNCTYPE(c_double, Int, POINTER(c_double), c_void_p)
_SIGNATURES = {
    "Create": (POINTER(c_void_p),), "Destroy": (POINTER(c_void_p),), "SetUp": (c_void_p,), "Step": (c_void_p,),
    "SetOptions": (c_void_p, c_int, POINTER(c_char_p)), "SetFunction": (c_void_p, c_char_p, FUNCTION, c_void_p),
    "SetMonitor": (c_void_p, MONITOR, c_void_p), "Run": (c_void_p, Real), "IsOver": (c_void_p, POINTER(c_bool)),
    "GetTime": (c_void_p, POINTER(Real), POINTER(Real), POINTER(Int)),
    "GetSizes": (c_void_p, POINTER(Int), POINTER(Int), POINTER(Int)), "GetIds": (c_void_p, POINTER(POINTER(c_int64))),
    "GetField": (c_void_p, c_char_p, POINTER(Int), POINTER(POINTER(Real))),
    "ComputeField": (c_void_p, c_char_p, POINTER(Int), POINTER(Real)), "Changed": (c_void_p,),
    "Insert": (c_void_p, Int, POINTER(Real), POINTER(Real)), "Remove": (c_void_p, Int, POINTER(c_int64)),
    "GetBoundary": (c_void_p, Int, POINTER(c_char_p), POINTER(c_char_p)),
    "GetForce": (c_void_p, Int, POINTER(Real), POINTER(Real), POINTER(Real)),
    "GetPose": (c_void_p, Int, *4 * (POINTER(Real),)), "Probe": (c_void_p, Int, *3 * (POINTER(Real),)),
    "Measure": (c_void_p,), "GetQuantity": (c_void_p, Int, POINTER(c_char_p), POINTER(Real), POINTER(Real)),
    "WriteSnapshot": (c_void_p, c_char_p), "WriteCheckpoint": (c_void_p, c_char_p),
}
for _name, _types in _SIGNATURES.items():
    getattr(lib, "IsphFlow" + _name).argtypes = _types
lib.IsphFlowGetError.argtypes, lib.IsphFlowGetError.restype = (c_void_p,), c_char_p


def call(flow, name, *arguments):
    """Calls IsphFlow<name>; an error becomes an exception with its text."""
    code = getattr(lib, "IsphFlow" + name)(flow, *arguments)
    if code:
        raise Error(lib.IsphFlowGetError(flow).decode() or f"IsphFlow{name}: error {code}", code)
