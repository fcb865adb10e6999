"""The parts of a case of studies/verify: runs, quantities, where their references come from, and what is drawn."""
import dataclasses
import typing


def lattice_first(k):
    """Arguments of the k-th start: the lattice, then lattices disturbed at random."""
    return f" -jitter 0.1 -seed {k}" if k else ""


def seeds(k):
    """Arguments of the k-th start where the options disturb the lattice already."""
    return f" -seed {k + 1}" if k else ""


@dataclasses.dataclass
class Quantity:
    """A column of a run, or a function of its row. `exact` is its reference, a number or a function of the row; True
    where the column is an error itself; None where there is none, and the change with n is all that is known."""
    kind: str  # velocity, pressure, force, energy, operator
    label: str
    column: typing.Any
    exact: typing.Any = None
    source: str = ""


@dataclasses.dataclass
class Study:
    """Runs of one setting at some resolutions, each from so many starts. Watch: -probe_ options."""
    title: str
    arguments: str
    sides: tuple
    quantities: list
    starts: tuple = ()
    start: typing.Callable = lattice_first
    watch: str = ""


@dataclasses.dataclass
class Panel:
    """A picture of one run along a line: a column of -probe_line over another, beside curves and points."""
    title: str
    arguments: str
    line: str  # -probe_line
    over: str
    column: str
    labels: tuple
    every: float = 0  # -probe_every: the last row is drawn
    curve: typing.Any = None  # exact, a function of `over`
    files: tuple = ()  # (label, file of cases/reference)
    centred: bool = False  # the curve is known up to a constant


@dataclasses.dataclass
class Chart:
    """A picture of a quantity of several studies at their finest n over a number that tells them apart."""
    title: str
    column: str
    labels: tuple
    numbers: dict  # by title of the study


@dataclasses.dataclass
class Case:
    title: str
    studies: list
    panels: list  # Panel or Chart
    drawn: tuple = ()  # labels of the quantities in the panel of errors; without, there is none


def report(kind, label, column, source):
    """A quantity whose reference the program reports."""
    return Quantity(kind, label, column, lambda row: row.get(f"{column}_reference"), source)


def norm(kind, label, column, source="exact solution"):
    """A quantity that is an error itself."""
    return Quantity(kind, label, column, True, source)


def sums(*names):
    """The sum of columns, a minus before a name taking it off; None where one is absent."""
    def add(row):
        terms = [(-1 if name[0] == "-" else 1, name.lstrip("-")) for name in names]
        if any(name not in row for _, name in terms):
            return None
        return sum(sign * row[name] for sign, name in terms)
    return add
