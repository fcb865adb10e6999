"""Exact solutions, numbers of tables and pictures of studies/free_surface."""
import math

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
from runs import reference_rows  # noqa: E402

BARE = "-progress none -options_file options/"
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00"]


def times(values):
    """Returns the options that report at these times, of which the last is the end of the run."""
    return "-report_times " + ",".join(f"{t:g}" for t in values[:-1]) + f" -t_end {values[-1]:g}"


def series(q, name, values):
    """Returns a quantity at its times; None where the run ended earlier."""
    return [q.get(f"{name}@{t:.4g}", q.get(name) if abs(q.get("t", -1) - t) < 1e-9 * t else None) for t in values]


def percent(error):
    return "" if error is None else f"{100 * error:.2g} %"


def signed(error):
    return "" if error is None else f"{100 * error:+.2f} %"


def off(value, exact):
    return None if value is None else value / exact - 1


def stretching_drop(times, steps=2000):
    """Returns semi-axes and pressure at the centre at ascending times: da/dt = -A a, db/dt = A b, dA/dt = A^2 (a^2 -
    b^2)/(a^2 + b^2), p = A^2 a^2 b^2/(a^2 + b^2), from A = a = b = 1, by the fourth-order Runge-Kutta method."""
    def slope(y):
        a, b, rate = y
        return -rate * a, rate * b, rate**2 * (a * a - b * b) / (a * a + b * b)

    def moved(y, k, dt):
        return [value + dt * change for value, change in zip(y, k)]

    y, t, found = [1.0, 1.0, 1.0], 0.0, []
    for end in times:
        dt = (end - t) / steps
        for _ in range(steps):
            k1 = slope(y)
            k2 = slope(moved(y, k1, dt / 2))
            k3 = slope(moved(y, k2, dt / 2))
            k4 = slope(moved(y, k3, dt))
            y = [value + dt / 6 * (p + 2 * q + 2 * r + s) for value, p, q, r, s in zip(y, k1, k2, k3, k4)]
        t, (a, b, rate) = end, y
        found.append({"a": a, "b": b, "p": rate**2 * a * a * b * b / (a * a + b * b)})
    return found


def wave_amplitude(t, decay=0.87262, omega=2.01957, crest=0.01):
    """Returns the amplitude of the standing wave, whose mode docs/verification/standing_wave.md has, by its first crest."""
    first = math.atan2(omega, decay) / omega
    return crest * math.exp(-decay * (t - first)) * math.sin(omega * t) / math.sin(omega * first)


def dam_front():
    """Returns the front Z of the experiment by the time T."""
    return [(float(row["T"]), float(row["value"])) for row in reference_rows("martin_moyce.csv")
            if row["quantity"] == "front"]


def draw_errors(axis, errors):
    """Draws errors against n, with a line of order 2; errors: {label: {n: error}}."""
    for (label, points), colour in zip(errors.items(), COLOURS):
        axis.loglog(list(points), list(points.values()), "o-", color=colour, ms=4, lw=1.2, label=label)
    sides = sorted({n for points in errors.values() for n in points})
    top = max(points[min(points)] * min(points)**2 for points in errors.values())
    axis.loglog(sides, [top / n**2 for n in sides], "--", color="#999999", lw=0.8, label="order 2")
    axis.set(xlabel="n", ylabel="error", title="against n")
    axis.set_xticks(sides, [str(n) for n in sides])
    axis.minorticks_off()


def draw_series(axis, found, exact, labels, title):
    """Draws series as points beside their references as lines; found and exact: {label: (x, y)}."""
    for (label, (x, y)), mark in zip(exact.items(), ("-", "--")):
        axis.plot(x, y, mark, color="black", lw=1, label=label)
    for (label, (x, y)), colour, mark in zip(found.items(), COLOURS, "os^Dv"):
        points = [(a, b) for a, b in zip(x, y) if b is not None]
        axis.plot(*zip(*points), mark, color=colour, ms=3.5, mfc="none", label=label)
    axis.set(xlabel=labels[0], ylabel=labels[1], title=title)


def draw_gains(axis, measured, wanted):
    """Draws errors against CPU time at the largest n of each flow, implicit and explicit runs in one colour."""
    largest = {name: max(n for other, n, *_ in measured if other == name) for name, *_ in measured}
    for name, n, implicit, explicit, same in measured:
        if n != largest[name]:
            continue
        for kind, tried, mark in (("implicit", implicit, "o-"), ("implicit, order 3", same, "^--"), ("explicit", explicit, "s")):
            points = [(cpu, error) for _, error, cpu in tried if error is not None]
            if not points:
                continue
            axis.loglog(*zip(*points), mark, ms=4, lw=1.2, color=COLOURS[list(largest).index(name)],
                        mfc="none" if kind == "explicit" else None, label=f"{kind}: {name}, n = {n}")
    axis.axhline(wanted, color="#999999", lw=0.8)
    axis.set(xlabel="CPU time [s]", ylabel="error of the velocity", title="implicit and explicit steps")


def draw(path, panels):
    """Draws the page's figure; panels: functions of an axis."""
    plt.rcParams.update({"font.size": 9, "axes.titlesize": 10, "legend.fontsize": 7, "legend.frameon": False})
    columns = (len(panels) + 1) // 2
    figure, grid = plt.subplots(2, columns, figsize=(4.2 * columns, 7))
    for axis, panel in zip(grid.flat, panels):
        panel(axis)
        axis.grid(alpha=0.3)
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=130)
