"""The picture of a case: particles beside its references, and errors against resolution."""
import csv
import os
import shlex
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend is chosen before)
import numpy as np  # noqa: E402
from centreline import REFERENCE, read_columns  # noqa: E402
from runs import COLOURS, MARKERS  # noqa: E402
from verification_parts import Panel  # noqa: E402

STYLE = {"font.size": 9, "axes.titlesize": 9, "legend.fontsize": 7, "legend.frameon": False, "savefig.dpi": 130,
         "figure.facecolor": "white"}


def make_lines(isph, panels):
    """The last rows along the lines of panels of one run, one list of rows each."""
    with tempfile.TemporaryDirectory() as folder:
        watch = ["-probe_line", ",".join(panel.line for panel in panels),
                 "-probe_output", os.path.join(folder, "probe")]
        if panels[0].every:
            watch += ["-probe_every", f"{panels[0].every:g}"]
        print(f"{panels[0].arguments} (picture)", flush=True)
        done = subprocess.run([isph, *shlex.split(panels[0].arguments), *watch], capture_output=True, text=True,
                              check=False)
        if done.returncode:
            sys.exit(f"verify: isph {panels[0].arguments}: {done.stderr.strip()}")
        with open(os.path.join(folder, "probe_line.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
    last = [row for row in rows if row["t"] == rows[-1]["t"]]
    return [[row for row in last if row["line"] == str(k)] for k in range(len(panels))]


def lines_of(path, isph, panels, anew):
    """Rows along the lines of all panels; those that the file has are not made again, unless all are to be made anew."""
    known, names = {}, ["run", "along", "x", "y", "u", "v", "p"]
    if os.path.exists(path) and not anew:
        with open(path, newline="") as file:
            for row in csv.DictReader(file):
                known.setdefault((row["run"], row["along"]), []).append(row)
    groups = {}
    for panel in panels:
        if (panel.arguments, panel.line) not in known:
            groups.setdefault(panel.arguments, {})[panel.line] = panel
    for arguments, missing in groups.items():
        for line, rows in zip(missing, make_lines(isph, list(missing.values()))):
            known[arguments, line] = [{"run": arguments, "along": line, **row} for row in rows]
    asked = list(dict.fromkeys((panel.arguments, panel.line) for panel in panels))
    if asked:
        with open(path, "w", newline="") as file:
            writer = csv.DictWriter(file, names, lineterminator="\n", extrasaction="ignore")
            writer.writeheader()
            writer.writerows(row for key in asked for row in known[key])
    return [known[panel.arguments, panel.line] for panel in panels]


def centre(x, values):
    """Values less the one in the middle of x."""
    return values - np.interp(0.5 * (x.min() + x.max()), *zip(*sorted(zip(x, values))))


def draw_panel(axes, panel, rows):
    rows = [row for row in rows if row[panel.column]]
    x = np.array([float(row[panel.over]) for row in rows])
    values = np.array([float(row[panel.column]) for row in rows])
    shift = centre if panel.centred else lambda x, values: values
    if panel.curve:
        fine = np.linspace(x.min(), x.max(), 401)
        axes.plot(fine, shift(fine, np.array([panel.curve(s) for s in fine])), color="black", linewidth=0.9,
                  label="exact")
    for label, name in panel.files:
        known = read_columns(os.path.join(REFERENCE, name))
        known = known[:, np.argsort(known[0])]
        mark = "o" if known.shape[1] < 50 else "-"
        axes.plot(known[0], shift(*known), mark, color="black", linewidth=0.9, markersize=4, markerfacecolor="none",
                  label=label)
    axes.plot(x, shift(x, values), "-" if panel.files else "o", color="#0072B2", linewidth=2.5, alpha=0.6, markersize=3,
              label="isph")
    axes.set(title=panel.title, xlabel=panel.labels[0], ylabel=panel.labels[1])
    axes.legend()


def draw_chart(axes, chart, sweeps):
    points = sorted((chart.numbers[sweep.study.title], sweep.rows[max(sweep.rows)][0]) for sweep in sweeps
                    if sweep.study.title in chart.numbers and sweep.rows)
    x, rows = zip(*points)
    axes.plot(x, [row[f"{chart.column}_reference"] for row in rows], color="black", linewidth=0.9, label="reference")
    axes.plot(x, [row[chart.column] for row in rows], "o", color="#0072B2", markersize=5, alpha=0.6, label="isph")
    axes.set(title=chart.title, xlabel=chart.labels[0], ylabel=chart.labels[1], yscale="log")
    axes.legend()


def draw_errors(axes, case, sweeps, rounding):
    """Mean errors of the drawn quantities against n, colours by study, marks by quantity; returns the legend."""
    colours, marks = list(COLOURS.values()), list(MARKERS.values())
    points, studies, quantities = [], {}, {}
    for k, sweep in enumerate(sweeps):
        for quantity in sweep.study.quantities:
            if quantity.label not in case.drawn:
                continue
            found = [(n, m.error()) for n, m in sweep.of(quantity).items() if m.errors and m.error() > rounding]
            if not found:
                continue
            mark = marks[case.drawn.index(quantity.label)]
            line = {"color": colours[k % len(colours)], "linestyle": "-" if k < len(colours) else ":"}
            axes.plot(*zip(*found), marker=mark, linewidth=1, markersize=4, **line)
            studies[sweep.study.title.replace("`", "")] = line
            quantities[quantity.label] = {"color": "black", "marker": mark, "markerfacecolor": "none",
                                          "linestyle": "none"}
            points += found
    if not points:
        return {}
    sides = sorted({n for n, _ in points})
    top = max(error for _, error in points)
    axes.plot([sides[0], sides[-1]], [top, top * (sides[0] / sides[-1]) ** 2], color="0.7", linestyle="--")
    axes.set(xscale="log", yscale="log", xlabel="n", ylabel="relative error", title="errors, means over starts")
    axes.set_xticks(sides, [str(n) for n in sides])
    axes.minorticks_off()
    return {**studies, **quantities, "second order": {"color": "0.7", "linestyle": "--"}}


def draw(path, case, sweeps, isph, rounding, anew):
    plt.rcParams.update(STYLE)
    panels = [panel for panel in case.panels if isinstance(panel, Panel)]
    lines = lines_of(os.path.splitext(path)[0] + "_lines.csv", isph, panels, anew)
    drawn = {id(panel): rows for panel, rows in zip(panels, lines)}
    cells = len(case.panels) + bool(case.drawn)
    columns = 2 if cells == 4 else min(3, cells)
    above = -(-cells // columns)
    key = 0.35 if case.drawn else 0.01  # height of the legend, in panels
    figure = plt.figure(figsize=(9.6 if cells > 1 else 7.2, 3.2 * (above + key)), layout="constrained")
    grid = figure.add_gridspec(above + 1, columns, height_ratios=[1] * above + [key])
    for k, panel in enumerate(case.panels):
        axes = figure.add_subplot(grid[k // columns, k % columns])
        if isinstance(panel, Panel):
            draw_panel(axes, panel, drawn[id(panel)])
        else:
            draw_chart(axes, panel, sweeps)
    if case.drawn:
        axes = figure.add_subplot(grid[len(case.panels) // columns, len(case.panels) % columns])
        told = draw_errors(axes, case, sweeps, rounding)
        below = figure.add_subplot(grid[above, :])
        below.axis("off")
        below.legend([plt.Line2D([], [], **style) for style in told.values()], told, loc="center", ncols=2)
    figure.savefig(path, bbox_inches="tight")
    plt.close(figure)
