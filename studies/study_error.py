"""isph-study error: error against CPU time of a scene, over resolution and words of the user."""
import argparse
import importlib.util
import math
import os
import re
import sys

from runs import table
from study_runs import GOOD, Run, UserError, last, make, pyplot, real, say, split, whole, write_rows

FIELDS = ("velocity", "pressure", "vorticity", "strain_rate", "viscosity", "density")  # of snapshots
ORDERS = (0.3, 6.0)  # of three runs that may be extrapolated
SLOW = 0.7  # order below which a limit means little: it lies further from the finest run than that from the next
ESTIMATE = "velocity_l2_estimate"
EPILOG = """examples:
  isph-study error SCENE.opts --swap "-visc_laplacian morris" --swap "-visc_laplacian mls" --n 16,32,64
  isph-study error SCENE.opts --n 16,32 --reference 96 --quantity velocity,body_1_fx
  isph-study error SCENE.opts -motion eulerian --vary dt=0.1,0.05,0.025 --quantity kinetic_energy

A quantity is a row of -report (at an earlier time name@t), a number of a -probe_ file (body_1_fx, point_0_p), or a field
of snapshots (velocity, pressure, vorticity), for which there must be a --reference. Its error, in this order:

  reference    against the run of --reference; a field by fits to its particles
  exact        against the exact or published value that the report names
  richardson   against the limit that the three finest runs of a setting extrapolate to
  estimate     the program's own estimate of the error of the velocity

The names of vectors end in x, y, z: their error is relative to the length of the vector."""


def add(parsers, common):
    parser = parsers.add_parser("error", parents=[common], help="error against CPU time", description=__doc__, epilog=EPILOG,
                                formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--swap", action="append", default=[], metavar="WORDS", help="more words of isph; one curve each")
    parser.add_argument("--n", metavar="N1,N2", help="particles along L, a run each (16,32,64)")
    parser.add_argument("--vary", metavar="NAME=V1,V2", help="another option in place of -n, such as dt; the last is finest")
    parser.add_argument("--quantity", default="", metavar="NAME,NAME", help="whose error is shown (the velocity, else the "
                        "first that has an error)")
    parser.add_argument("--reference", metavar="WORDS", help="number for -n of a finer run, or words: \"-n 96 -cfl 0.1\"")
    parser.add_argument("--by", choices=METHODS, help="how the error is found (the first of these that is possible)")
    parser.set_defaults(study=study)


def refinement(options):
    """Returns the option that is refined, and its values from coarse to fine."""
    if options.vary and options.n:
        raise UserError("--n and --vary are two refinements; choose one")
    name, equal, values = (options.vary or f"n={options.n or '16,32,64'}").partition("=")
    values = values.split(",")
    if not name or not equal or not all((real(value) or 0.0) > 0.0 for value in values):
        raise UserError(f"--{'vary' if options.vary else 'n'} {options.vary or options.n}: numbers above 0 are required, "
                        "such as 16,32,64 or dt=0.2,0.1")
    if name == "n":
        values = [str(n) for n in sorted({whole(value, "--n") for value in values})]
    return name, list(dict.fromkeys(values))


# ---- how an error is found: each returns errors by value of the refined option, or None, and a sentence ----

def components(name, numbers):
    """Returns the length of the vector of which `name` is a component, or the magnitude of the number."""
    found = re.fullmatch(r"(.*_)?([ft])([xyz])(@.*)?", name)
    names = [f"{found[1] or ''}{found[2]}{axis}{found[4] or ''}" for axis in "xyz"] if found else [name]
    return math.hypot(*(numbers.get(other, 0.0) for other in names)) or 1.0


def by_reference(name, runs, finer):
    if name in FIELDS:
        import study_fields
        pairs = {value: study_fields.error(run, finer, name) for value, run in runs.items()}
        least = min(share for _, share in pairs.values())
        note = f" ({100 * least:.0f} % of the particles or more lie in its fluid)" if least < 0.99 else ""
        return {value: off for value, (off, _) in pairs.items()}, f"relative L2 norm against the run {finer.label}{note}"
    exact = finer.record["numbers"].get(name)
    if exact is None:
        return None, ""
    scale = components(name, finer.record["numbers"])
    return ({value: abs(run.record["numbers"][name] - exact) / scale for value, run in runs.items()
             if name in run.record["numbers"]}, f"against {exact:.6g} of the run {finer.label}")


def by_exact(name, runs, _):
    found = {value: run.record["errors"][name] for value, run in runs.items() if name in run.record["errors"]}
    return (None if name == ESTIMATE else found), "against the exact or published value of the report"


def observed(values, numbers):
    """Returns the order and the limit of three numbers at spacings h > h' > h'': q = limit + c h^order."""
    (h1, h2, h3), (q1, q2, q3) = values, numbers
    if q2 == q3 or (q1 - q2) / (q2 - q3) <= 0.0:
        return None
    low, high, ratio = *ORDERS, (q1 - q2) / (q2 - q3)

    def rest(order):
        return (h1**order - h2**order) / (h2**order - h3**order) - ratio

    if rest(low) * rest(high) > 0.0:
        return None
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rest(low) * rest(middle) > 0.0 else (low, middle)
    return low, q3 + (q3 - q2) / ((h2 / h3)**low - 1.0)


def by_richardson(name, runs, _):
    points = [(spacing(run.refined), run.record["numbers"][name]) for run in runs.values() if name in run.record["numbers"]]
    points = sorted(points, reverse=True)[-3:]
    found = observed(*zip(*points)) if len(points) == 3 else None
    if not found:
        return None, ""
    scale = components(name, {**next(iter(runs.values())).record["numbers"], name: found[1]})
    return ({value: abs(run.record["numbers"][name] - found[1]) / scale for value, run in runs.items()
             if name in run.record["numbers"]}, f"against the limit {found[1]:.6g} of the three finest runs, order {found[0]:.2f}")


def by_estimate(name, runs, _):
    if not re.fullmatch(r"velocity(_l2|_l2_estimate)?", name):
        return None, ""
    return ({value: run.record["numbers"][ESTIMATE] for value, run in runs.items() if ESTIMATE in run.record["numbers"]},
            "the program's own estimate")


METHODS = {"reference": by_reference, "exact": by_exact, "richardson": by_richardson, "estimate": by_estimate}


def find(name, curves, finer, options):
    """Returns the method of a quantity, and errors with a sentence by curve. A method must serve at least one curve."""
    for word in [options.by] if options.by else METHODS:
        if word == "reference" and not finer:
            continue
        found = {swap: METHODS[word](name, runs, finer) for swap, runs in curves.items() if runs}
        if any(errors for errors, _ in found.values()):
            return word, {swap: (errors or {}, told) for swap, (errors, told) in found.items()}
    known = list(dict.fromkeys(n for runs in curves.values() for run in runs.values() for n in run.record["numbers"]))
    if name in known:
        return None, {}
    raise UserError(f"--quantity {name}: the runs have no such number{'; a field needs --reference N' if name in FIELDS else ''}"
                    f"; they have {', '.join(known)}")


def spacing(refined):
    name, value = refined
    return 1.0 / float(value) if name == "n" else float(value)


def order(coarse, fine, errors):
    """Returns the observed order between two runs as a text."""
    one, two = errors.get(coarse.refined[1], 0.0), errors.get(fine.refined[1], 0.0)
    ratio = spacing(coarse.refined) / spacing(fine.refined)
    return f"{math.log(one / two) / math.log(ratio):.2f}" if one > 0.0 and two > 0.0 and ratio not in (0.0, 1.0) else ""


def quantities(options, curves, finer):
    """Returns the quantities to show: those of the user, or the velocity, or the first that has an error."""
    if options.quantity:
        return options.quantity.split(",")
    if finer:
        return ["velocity"]
    errors = [name for runs in curves.values() for run in runs.values() for name in run.record["errors"]]
    return [name for name in ["velocity_l2", *errors] if name in errors and name != ESTIMATE][:1] or [ESTIMATE]


def lines(name, word, refined, curves, found):
    """Yields the table of a quantity."""
    if word is None:
        yield (f"{name}: no error is known: there is no exact value, and no three runs that converge in order; --reference N "
               "makes a finer run")
    else:
        yield f"{name}: error by {word}"
    same = len({told for _, told in found.values()}) == 1
    for swap, (_, told) in list(found.items())[:1 if same else None]:
        if told:
            yield f"  {told}" if same else f"  {swap or 'as typed'}: {told}"
    yield ""
    rows = []
    for swap, runs in curves.items():
        errors, before = found.get(swap, ({}, ""))[0], None
        for value, run in runs.items():
            number = run.record["numbers"].get(name)
            rows.append([swap or "as typed", value, f"{run.record['cpu_s']:.3g}", "" if number is None else f"{number:.6g}",
                         f"{100 * errors[value]:.3g}" if value in errors else "", order(before, run, errors) if before else "",
                         run.record["kind"]])
            before = run
    yield from table(["setting", refined, "CPU s", "value", "error %", "order", "run"], rows)
    yield ""


def reference_words(options):
    """Returns the words of the run of --reference."""
    words = split(options.reference, "--reference")
    return ["-n", *words] if words and not words[0].startswith("-") else words


def coarse(word, finer, refined, curves, options):
    """Yields a warning if the run of --reference is not twice as fine as the finest run."""
    finest = max((float(value) for runs in curves.values() for value in runs), default=0.0)
    words = reference_words(options) if finer else []
    n = words[words.index("-n") + 1] if "-n" in words[:-1] else None
    if word == "reference" and refined == "n" and n and float(n) < 2.0 * finest:
        yield (f"The reference, n = {n}, is less than twice as fine as n = {finest:g}: its own error, a large part of these, is in "
               "them.\n")


def limits(word, found):
    """Yields a warning if runs converge too slowly for a limit, or if the limits of settings differ, which errors do not show."""
    orders = [float(told.split("order ")[1]) for _, told in found.values() if "order " in told]
    if word == "richardson" and orders and min(orders) < SLOW:
        yield (f"An order of {min(orders):.2g} is too low for a limit: these errors may be far off; finer runs, or "
               "--reference.\n")
    ends = [float(told.split("limit ")[1].split()[0]) for _, told in found.values() if "limit " in told]
    offs = [min(errors.values()) for errors, _ in found.values() if errors]
    if word == "richardson" and len(ends) > 1 and max(ends) - min(ends) > 2.0 * max(offs) * max(map(abs, ends)):
        yield ("The limits differ by more than these errors: not all settings converge to the same flow, which only "
               "--reference or an exact value shows.\n")


def study(scene, options):
    """Makes the runs, then prints, writes and draws the errors of each quantity."""
    refined, values = refinement(options)
    asked = options.quantity.split(",") if options.quantity else ["velocity"] if options.reference else []
    shown = [name for name in asked if name in FIELDS] if options.reference else []
    if shown and not (importlib.util.find_spec("h5py") and importlib.util.find_spec("numpy")):
        raise UserError(f"--quantity {shown[0]}: {sys.executable} has no h5py and numpy, which compare fields (Debian: "
                        "python3-h5py)")
    fields = ["-output", "flow.h5"] if shown and not last(scene.known, "-output") else []
    curves = {}
    for swap in dict.fromkeys(options.swap or [""]):
        curves[swap] = {}
        for value in values:
            curves[swap][value] = run = Run(scene, [*split(swap, "--swap"), f"-{refined}", value], options.isph, options.out,
                                            fields)
            run.refined = refined, value
    finer = None
    if options.reference:
        finer = Run(scene, reference_words(options), options.isph, options.out, fields)
    wanted = [run for runs in curves.values() for run in runs.values()] + ([finer] if finer else [])
    make(wanted, options)
    if finer and finer.record["kind"] not in GOOD:
        raise UserError(f"--reference {options.reference}: {finer.record['reason']}")
    lost = [run for run in wanted if run.record["kind"] not in GOOD]
    good = {swap: {value: run for value, run in runs.items() if run not in lost} for swap, runs in curves.items()}
    if not any(good.values()):
        raise UserError(f"no run reached its end; {lost[0].label}: {lost[0].record['reason']}")
    report(good, lost, finer, refined, options)


def report(curves, lost, finer, refined, options):
    """Prints and writes the tables, and draws a panel for each quantity."""
    results = {name: find(name, curves, finer, options) for name in quantities(options, curves, finer)}
    text, rows = [], []
    for name, (word, found) in results.items():
        text += [*lines(name, word, refined, curves, found), *limits(word, found), *coarse(word, finer, refined, curves, options)]
        for swap, runs in curves.items():
            for value, run in runs.items():
                rows.append({"quantity": name, "setting": swap, refined: value, **columns(run),
                             "value": run.record["numbers"].get(name, ""), "error": found.get(swap, ({}, ""))[0].get(value, ""), "by": word or ""})
    text += [f"{run.label}: {run.record['kind']}: {run.record['reason']}" for run in lost]
    text += sorted({f"doubtful: {run.label}: {line}" for runs in curves.values() for run in runs.values()
                    for line in run.record["said"]})
    rows += [{"setting": run.label, **columns(run), "reason": run.record["reason"]} for run in lost]
    write_rows(os.path.join(options.out, "error.csv"), rows)
    say(os.path.join(options.out, "error.md"), text)
    picture(results, curves, os.path.join(options.out, "error.png"))


def columns(run):
    return {"run": run.record["kind"], "folder": os.path.basename(run.folder),
            **{name: run.record.get(name, "") for name in ("particles", "steps", "cpu_s", "wall_s", "rss_mb")}}


def picture(results, curves, path):
    """Draws error against CPU time."""
    plt = pyplot()
    if not plt:
        return
    import costs
    results = {name: result for name, result in results.items() if result[0]}
    if not results:
        return
    figure, panels = plt.subplots(1, len(results), figsize=(5.6 * len(results), 4.2), squeeze=False)
    for axes, (name, (word, found)) in zip(panels[0], results.items()):
        points = {swap or "as typed": [(run.record["cpu_s"], found[swap][0][value]) for value, run in runs.items()
                                       if found[swap][0].get(value, 0.0) > 0.0] for swap, runs in curves.items() if runs}
        points = {label: some for label, some in points.items() if some}
        if points:
            costs.draw_curves(axes, points, f"error of {name}, by {word}", None)
        if axes is not panels[0][0] and axes.get_legend():
            axes.get_legend().remove()
    figure.subplots_adjust(wspace=0.3)
    figure.savefig(path, dpi=130, bbox_inches="tight")
    print(f"drew {path}")
