"""Models, settings and measures that studies/basa_poiseuille and studies/basa_cavity share: M. Basa, N. Quinlan, M. Lastiwka,
Int. J. Numer. Meth. Fluids 60 (2009) 1127-1148."""
from runs import Runs

MODELS = {"A": "direct", "B": "two_pass", "C": "violeau", "D": "cleary -cleary_xi 4.24", "E": "morris"}
COLOURS = dict(zip(MODELS, ["#CC79A7", "#E69F00", "#009E73", "#0072B2", "#D55E00"]))
MARKERS = dict(zip(MODELS, "Dsov^"))
# Model A has a form of order zero, Eq. (23), and no form of first order
CORRECTIONS = {"none": "ABCDE", "shepard": "ABCDE", "mixed": "BCDE"}
ORDERS = {"none": "no correction", "shepard": "order 0, shepard", "mixed": "order 1, mixed"}
FAILED = 0.12  # of the RMS error, section 6.1.3
# Sums, kernel and h/dx = 1/0.637 of section 6; walls with linear extrapolation, section 6.1.2
PAPER = ("-scheme wcsph -kernel cubic_spline -h_over_dx 1.56986 -wall dummy_linear -density_form summation -shift none "
         "-progress none")


class FewRuns(Runs):
    """Runs that keep only quantities whose names begin with a word of `kept`, at the end and at -report_times. With `only`,
    runs that the file lacks are not made, and have no quantities."""

    def __init__(self, *arguments, kept=(), only=False, **named):
        super().__init__(*arguments, **named)
        self.only = only
        self.kept = (*kept, "run", "failed", "build", "cpu_s", "date", "wall_s", "steps", "particles")

    def __call__(self, arguments, watch=""):
        if self.only and arguments not in self.rows:
            return {}
        return super().__call__(arguments, watch)

    def make(self, arguments, watch=""):
        row = super().make(arguments, watch)
        return {k: v for k, v in row.items() if k == "t" or k.startswith(self.kept)}


def times(values):
    """Returns the options that report at ascending times, of which the last is the end of the run."""
    early = ",".join(f"{t:.4g}" for t in values[:-1])
    return (f"-report_times {early} " if early else "") + f"-t_end {values[-1]:.4g}"


def series(q, name, values):
    """Returns pairs of time and quantity at the times that the run reached."""
    found = [(t, q[f"{name}@{t:.4g}"]) for t in values if f"{name}@{t:.4g}" in q]
    if name in q and "t" in q and (not found or q["t"] > found[-1][0] * (1 + 1e-9)):
        found.append((q["t"], q[name]))
    return found


def percent(value):
    """Returns a share as text in percent, two digits."""
    return "" if value is None else f"{100 * value:.2g} %" if value < 9.995 else "> 1000 %"
