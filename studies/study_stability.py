"""isph-study stability: which settings of a scene reach their end, when and why the others fail."""
import argparse
import itertools
import math
import os
import re
import statistics
import textwrap

from runs import table
from study_runs import GOOD, PSEUDO, Run, UserError, build, make, pyplot, real, say, split, whole, write_rows

DRAWS = ("seed", "start")  # settings that only draw another noise: fractions and spreads over them
MOST = 9999  # values of a range
NO_NUMBERS = ("bursts", "resolved", "trust")
EPILOG = """examples:
  isph-study stability SCENE.opts --vary dt=0.01,0.1,1 --vary viscosity=1e-3,1e-2
  isph-study stability -case cavity -n 32 -t_end 4 -jitter 0.1 --vary reynolds=100,1000 --vary seed=1..8
  isph-study stability SCENE.opts --vary "body_force=1,0;10,0" --swap "-visc_laplacian morris" --bound "kinetic_energy<0.1"

A run holds if it reaches its end, and is doubtful if its report says so or it is outside of a --bound. Others fail in a
step, are refused before it, or take too long. --vary NAME takes any option of isph, and:

  seed=1..8    runs of -seed 1 to 8: with -jitter, or with shifting, other particles at the start
  start=1..8   -jitter larger by 1e-5 dx each: the same particles, another draw of a chaotic flow
  ranks=1,2    on several ranks
  isph=a,b     by several programs

Runs that differ in seed or start only are draws of a setting: the map has the share that holds, and numbers.csv the mean,
spread (standard deviation), least and greatest value of each number."""
COLOURS = {"holds": "#9bd0ee", "doubtful": "#f0e442", "fails": "#d55e00", "refused": "#d9d9d9", "late": "#999999"}
MARKS = {"holds": "", "doubtful": "?", "fails": "×", "refused": "–", "late": "s"}


def add(parsers, common):
    parser = parsers.add_parser("stability", parents=[common], help="settings that fail, when and why", description=__doc__,
                                epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--vary", action="append", default=[], metavar="NAME=V1,V2", help="values of an option; with commas "
                        "in them: V1;V2; whole numbers: 1..8; several --vary: all combinations")
    parser.add_argument("--swap", action="append", default=[], metavar="WORDS", help="words of isph that are another setting")
    parser.add_argument("--bound", action="append", default=[], metavar="NAME<X", help="a bound of a number of the report, < or >")
    parser.add_argument("--quantity", metavar="NAME,NAME", help="numbers whose mean and spread are printed (all)")
    parser.set_defaults(study=study)


def values_of(item):
    """Returns name and values of a --vary."""
    name, _, text = item.partition("=")
    found = re.fullmatch(r"(\d+)\.\.(\d+)", text)
    values = text.split(";") if ";" in text else text.split(",")
    if found:
        values = [str(k) for k in range(int(found[1]), min(int(found[2]), int(found[1]) + MOST) + 1)]
    if not re.fullmatch(r"[A-Za-z]\w*", name) or not values or not all(values):
        raise UserError(f"--vary {item}: NAME=V1,V2 or NAME=1..8 is required, for example dt=0.1,0.2 or seed=1..8")
    return name, list(dict.fromkeys(values))


def axes_of(options):
    """Returns names and values of all axes; values are words of isph with their label."""
    axes = {}
    for item in options.vary:
        name, values = values_of(item)
        if name.lower() in axes:
            raise UserError(f"--vary {item}: {name} is varied already")
        if name in ("start", "ranks"):
            values = [str(whole(value, f"--vary {name}")) for value in values]
        for value in values if name == "isph" else ():
            build(os.path.abspath(value))
        axes[name.lower()] = {value: [f"-{name}", value] for value in values}
    if options.swap:
        axes["setting"] = {swap or "as typed": split(swap, "--swap") for swap in options.swap}
    if not axes:
        raise UserError("stability needs --vary NAME=V1,V2 or --swap WORDS, for example --vary dt=0.1,1,10")
    return axes


def bounds_of(options):
    found = []
    for item in options.bound:
        name, sign, text = re.match(r"([^<>]*)([<>]?)=?(.*)", item).groups()
        if not name.strip() or not sign or real(text) is None:
            raise UserError(f'--bound {item}: a number with its bound is required, such as "kinetic_energy<0.1"')
        found.append((name.strip(), sign, float(text)))
    return found


def judge(run, bounds):
    """Returns how a run ended, and why."""
    kind, reason = run.record["kind"], run.record.get("reason", "; ".join(run.record["said"]))
    for name, sign, bound in bounds if kind in GOOD else ():
        if name not in run.record["numbers"]:
            raise UserError(f"--bound {name}: the runs report no such number; they have {', '.join(run.record['numbers'])}")
        value = run.record["numbers"][name]
        if not (value < bound if sign == "<" else value > bound):
            kind, reason = "doubtful", "; ".join(filter(None, [reason, f"{name} = {value:.6g}, bound {sign} {bound:g}"]))
    return kind, reason


def study(scene, options):
    """Makes the runs, then prints, writes and draws their outcome."""
    axes, bounds = axes_of(options), bounds_of(options)
    runs = {labels: Run(scene, [word for name, label in zip(axes, labels) for word in axes[name][label]], options.isph, options.out)
            for labels in itertools.product(*axes.values())}
    path = os.path.join(options.out, "stability.csv")

    def rows():
        return [row(axes, labels, run, bounds) for labels, run in runs.items() if run.record]

    make(runs.values(), options, lambda: write_rows(path, rows()))
    write_rows(path, rows())
    settings = gather(axes, runs)
    text = [*outcome_lines(axes, runs, bounds), *setting_lines(axes, settings, bounds)]
    draws = max(map(len, settings.values()))
    if draws > 1:
        found = {labels: numbers(some) for labels, some in settings.items()}
        text += number_lines(axes, found, options.quantity) if any(found.values()) else []
        write_rows(os.path.join(options.out, "numbers.csv"),
                   [{**dict(zip(kept(axes), labels)), "number": name, **of} for labels, all_of in found.items()
                    for name, of in all_of.items()])
    say(os.path.join(options.out, "stability.md"), text)
    picture(axes, settings, bounds, os.path.join(options.out, "stability.png"))


def row(axes, labels, run, bounds):
    kind, reason = judge(run, bounds)
    return {**dict(zip(axes, labels)), "run": kind, "t_failed": run.record["t"] if kind in ("fails", "late") and "t" in run.record else "",
            "step": run.record.get("step", ""), "reason": reason, "folder": os.path.basename(run.folder),
            **{name: run.record.get(name, "") for name in ("steps", "cpu_s", "wall_s", "rss_mb")}, **run.record["numbers"]}


def kept(axes):
    """Returns the names of axes that are no draws."""
    return [name for name in axes if name not in DRAWS]


def gather(axes, runs):
    """Returns the runs of each setting."""
    settings = {}
    for labels, run in runs.items():
        settings.setdefault(tuple(label for name, label in zip(axes, labels) if name not in DRAWS), []).append(run)
    return settings


def outcome_lines(axes, runs, bounds):
    kinds = [judge(run, bounds)[0] for run in runs.values()]
    yield "; ".join(f"{kinds.count(kind)} of {len(kinds)} runs {word}" for kind, word in
                    (("holds", "hold"), ("doubtful", "are doubtful"), ("fails", "fail"), ("refused", "are refused"),
                     ("late", "take too long")) if kind in kinds) + ".\n"


def head(axes):
    return [name if name in PSEUDO or name == "setting" else f"-{name}" for name in kept(axes)]


def setting_lines(axes, settings, bounds):
    """Yields a table of the settings that do not hold, with the first reason."""
    rows = []
    for labels, runs in settings.items():
        judged = [(*judge(run, bounds), run.record) for run in runs]
        bad = [(kind, reason, record) for kind, reason, record in judged if kind != "holds"]
        if bad:
            kind, reason, record = bad[0]
            when = [record["t"] for _, _, record in bad if "reason" in record and "t" in record]
            rows.append([*labels, f"{len(runs) - len(bad)} of {len(runs)}", kind, f"{min(when):.4g}" if when else "",
                         record.get("step", ""), reason.replace("|", "/")])
    if rows:
        yield from table([*head(axes), "hold", "first other", "earliest t", "step", "why"], rows)
        yield ""


def numbers(runs):
    """Returns the statistics of each number over the runs of a setting that have it; of failed runs at earlier times."""
    found = {}
    ended = [(run.record["numbers"], run.record["kind"] in GOOD, run.record) for run in runs]
    for name in dict.fromkeys(name for all_of, _, _ in ended for name in all_of if name not in NO_NUMBERS):
        values = [all_of[name] for all_of, good, _ in ended if name in all_of and (good or "@" in name)]
        references = [record["references"][name] for _, _, record in ended if name in record["references"]]
        if values:
            found[name] = {"runs": len(values), "mean": statistics.fmean(values),
                           "spread": statistics.stdev(values) if len(values) > 1 else 0.0, "min": min(values),
                           "max": max(values), "reference": references[0] if references else ""}
    return found


def number_lines(axes, found, wanted):
    """Yields a table of the statistics of numbers, all or the wanted ones."""
    rows, known = [], dict.fromkeys(name for all_of in found.values() for name in all_of)
    for name in wanted.split(",") if wanted else ():
        if name not in known:
            raise UserError(f"--quantity {name}: the runs have no such number; they have {', '.join(known)}")
    for labels, all_of in found.items():
        for name, of in all_of.items() if not wanted else [(n, all_of[n]) for n in wanted.split(",") if n in all_of]:
            reference = of["reference"]
            off = f"{100 * (of['mean'] - reference) / abs(reference):.2g}" if reference else ""
            scale = abs(reference or of["mean"])
            rows.append([*labels, name, of["runs"], *(f"{of[key]:.7g}" for key in ("mean", "spread", "min", "max")),
                         "" if reference == "" else f"{reference:.6g}", off, f"{100 * of['spread'] / scale:.2g}" if scale else ""])
    yield from table([*head(axes), "number", "runs", "mean", "spread", "min", "max", "reference", "error of the mean, %",
                      "spread, %"], rows)
    yield "\nThe last column is the spread over the reference, or over the mean where there is none.\n"


def picture(axes, settings, bounds, path):
    """Draws a map over the two longest axes, a panel for each combination of the others."""
    plt = pyplot()
    if not plt:
        return
    names = sorted(kept(axes), key=lambda name: -len(axes[name]))[:2] or [""]
    names = [name for name in kept(axes) if name in names]
    across, up = (names[-1], names[0]) if len(names) == 2 else ("".join(names), "")
    panels = {}
    for labels, runs in settings.items():
        at = dict(zip(kept(axes), labels))
        title = ", ".join(f"{name} {label}" for name, label in at.items() if name not in names)
        panels.setdefault(title, {})[at.get(across, ""), at.get(up, "")] = [judge(run, bounds)[0] for run in runs]
    columns, rows = list(axes.get(across, {"": None})), list(axes.get(up, {"": None}))
    wide = min(len(panels), 3)
    tall = math.ceil(len(panels) / wide)
    size = wide * (0.62 * max(len(columns), 3) + 1.8), tall * (0.5 * max(len(rows), 2) + 1.2) + 0.5
    figure, drawn = plt.subplots(tall, wide, figsize=size, squeeze=False, layout="constrained")
    shown = set()
    for axis in drawn.flat[len(panels):]:
        axis.set_axis_off()
    for axis, (title, cells) in zip(drawn.flat, panels.items()):
        for (column, line), kinds in cells.items():
            shown |= set(cell(axis, columns.index(column), rows.index(line), kinds, plt))
        axis.set(xlim=(0, len(columns)), ylim=(0, len(rows)), xlabel=f"-{across}" if across not in ("", "setting") else "",
                 ylabel=f"-{up}" if up not in ("", "setting") else "", title=textwrap.fill(title, 12 + 8 * len(columns)))
        turned = {"rotation": 30, "ha": "right"} if max(map(len, columns)) > 6 else {}
        axis.set_xticks([k + 0.5 for k in range(len(columns))], columns, **turned)
        axis.set_yticks([k + 0.5 for k in range(len(rows))], rows)
        axis.tick_params(length=0)
    handles = [plt.Rectangle((0, 0), 1, 1, color=COLOURS[kind], label=f"{kind} {MARKS[kind]}".strip()) for kind in COLOURS
               if kind in shown]
    figure.get_layout_engine().set(rect=(0, 0, 1, 1 - 0.36 / size[1]))
    figure.legend(handles=handles, ncols=len(handles), loc="upper center", frameon=False, handlelength=1.3)
    figure.savefig(path, dpi=130)
    print(f"drew {path}")


def cell(axis, x, y, kinds, plt):
    """Draws a cell: the share of each kind as a part of its area, the share that holds as a text; returns the kinds."""
    left = x
    for kind in COLOURS:
        share = kinds.count(kind) / len(kinds)
        axis.add_patch(plt.Rectangle((left, y), share, 1, facecolor=COLOURS[kind], edgecolor="none"))
        left += share
    axis.add_patch(plt.Rectangle((x, y), 1, 1, fill=False, edgecolor="white", linewidth=1.5))
    text = MARKS[kinds[0]] if len(kinds) == 1 else f"{sum(kind == 'holds' for kind in kinds)}/{len(kinds)}"
    axis.text(x + 0.5, y + 0.5, text, ha="center", va="center", fontsize=9)
    return kinds
