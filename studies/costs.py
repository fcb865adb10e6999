"""Draws error against CPU time of the runs in -report files."""
import csv

from matplotlib import ticker

from runs import front

OF_THE_RUN = ("t", "quantity", "value", "reference", "error")  # columns that differ between rows of a run
COLOURS = ["#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#8C6D31", "#000000", "#999999"]
MARKERS = "osd^vPX*"  # with COLOURS: distinct for colour-blind readers too


class Plain(ticker.LogFormatter):
    """Labels of a logarithmic axis as 0.02 in place of 2e-02."""

    def _num_to_string(self, x, vmin, vmax):
        return f"{x:g}"


def read_runs(paths):
    """Returns (columns of the run, errors by quantity at its last time) of all successful runs."""
    runs = {}
    for path in paths:
        with open(path, newline="", errors="replace") as file:
            for row in csv.DictReader(file):
                if not {"cpu_s", "status", *OF_THE_RUN} <= row.keys():
                    raise ValueError(f"{path} is no file of -report, or one of another version")
                key = path, *(value for name, value in row.items() if name not in OF_THE_RUN)
                _, errors = runs.setdefault(key, (row, {}))
                if row["status"] == "ok" and row["error"]:
                    errors[row["quantity"]] = float(row["error"])  # later times overwrite earlier times
    return [(row, errors) for row, errors in runs.values() if errors]


def draw(axes, paths, quantity, group):
    """Draws a curve for each value of the columns of group, and the Pareto front."""
    runs = read_runs(paths)
    found = list(dict.fromkeys(name for _, errors in runs for name in errors))
    if not found:
        raise ValueError(f"{', '.join(paths)}: no run that ended well has an error")
    quantity = quantity or found[0]
    if quantity not in found:
        raise ValueError(f"--quantity {quantity} has no error in these files; those that have: {', '.join(found)}")
    for column in group:
        if column not in runs[0][0]:
            raise ValueError(f"--group {column} is no column of the files; columns: {', '.join(runs[0][0])}")
    curves = {}
    for row, errors in runs:
        if errors.get(quantity, 0) > 0:  # for the logarithmic axis
            label = ", ".join(row[column] or "none" for column in group)
            curves.setdefault(label, []).append((float(row["cpu_s"]), errors[quantity]))
    draw_curves(axes, curves, f"error of {quantity}", ", ".join(group))


def draw_curves(axes, curves, label, title):
    """Draws lists of (CPU time, error) by label; of several also the Pareto front."""
    for k, (name, points) in enumerate(curves.items()):
        axes.plot(*zip(*sorted(points)), MARKERS[(k + k // 8) % 8], linestyle="-", linewidth=0.8, markersize=5,
                  color=COLOURS[k % 8], alpha=0.8, label=name)
    if len(curves) > 1:
        best = front(point for points in curves.values() for point in points)
        axes.plot(*zip(*best), "-", color="#D55E00", linewidth=2.5, alpha=0.45, zorder=0, label="front")
    axes.set(xscale="log", yscale="log", xlabel="CPU time [s]", ylabel=label)
    axes.grid(alpha=0.3, which="both", linewidth=0.5)
    for axis in axes.xaxis, axes.yaxis:
        axis.set_major_formatter(Plain())
        axis.set_minor_formatter(Plain(minor_thresholds=(2, 0.5)))
    axes.legend(title=title, loc="upper center", bbox_to_anchor=(0.5, -0.16))
