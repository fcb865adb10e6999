"""isph-study need: what a scene pays for, in time and memory, and what other words would add."""
import argparse
import csv
import os
import re
import subprocess

from runs import table
from study_runs import GOOD, Run, UserError, last, make, say, split, write_rows

STEPS = 10
PHASES = {"Main Stage": "start of PETSc and end"}
LEAST = 0.01  # share of the time of a part that is shown
EPILOG = """examples:
  isph-study need SCENE.opts
  isph-study need SCENE.opts --swap "-motion eulerian" --swap "-surface_tension 0.07"

Parts of a step are those of its scheme (isph -catalogue); a part that the scene does not need is left out. Parts within
them (assembly, solves, products) are events of PETSc and lie within each other. Memory is that of the largest rank; the
libraries alone take the first line. --swap makes the same measurement with more words, and shows what differs."""


def add(parsers, common):
    parser = parsers.add_parser("need", parents=[common], help="what a scene pays for", description=__doc__, epilog=EPILOG,
                                formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False)
    parser.add_argument("--swap", action="append", default=[], metavar="WORDS", help="words whose cost is compared")
    parser.add_argument("--steps", type=int, default=STEPS, metavar="K", help=f"steps of the measured run ({STEPS})")
    parser.set_defaults(study=study)


class Cost:
    """Costs of a run: its banner, stages of a step, seconds and calls of events by stage of the run, and memory."""

    def __init__(self, run):
        self.run = run
        with open(os.path.join(run.folder, "stdout"), errors="replace") as file:
            lines = file.read().splitlines()
        self.banner = {}
        for line in lines:
            found = re.match(r"([a-z][a-zA-Z. ]{0,10}\S?) {1,11}(\S.*)", line[:12].ljust(12) + line[12:])
            if not line.strip() and self.banner:
                break
            if found and len(line) > 12 and line[:12].strip() and not line.startswith("isph "):
                self.banner[line[:12].strip()] = line[12:]
        self.stages = [word.strip() for word in self.banner.get("step", "").split(",") if word.strip()]
        self.events, self.phases = {}, {}
        with open(os.path.join(run.folder, "log.csv"), newline="", errors="replace") as file:
            rows = list(csv.DictReader(file))
        ranks = max((int(row["Rank"]) for row in rows), default=0) + 1
        for row in rows:
            phase, event, spent = row["Stage Name"], row["Event Name"].strip(), float(row["Time"]) / ranks
            if event == "summary":
                self.phases[phase] = self.phases.get(phase, 0.0) + spent
            elif phase == "Steps":
                before = self.events.get(event, (0.0, 0))
                self.events[event] = before[0] + spent, before[1] + int(float(row["Count"])) // ranks
        self.step = self.phases.get("Steps", 0.0) / max(run.record.get("steps", 1.0), 1.0)

    def share(self, event):
        return self.events.get(event, (0.0, 0))[0] / (self.phases.get("Steps") or 1.0)


def catalogue(isph, scheme):
    """Returns the stages of a scheme with what they do."""
    text = subprocess.run([isph, "-catalogue"], capture_output=True, text=True, check=False).stdout
    found = re.search(rf"^Stages of a step \(-scheme {re.escape(scheme)}\)\n(.*?)(?:\n\n|\Z)", text, re.M | re.S)
    return dict(re.findall(r"^  (\S+) +(.+)$", found[1], re.M)) if found else {}


def libraries(isph):
    """Returns the memory of the program without a flow [MB]."""
    with subprocess.Popen([isph, "-version"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = status
    return used.ru_maxrss / 1024


def percent(share):
    return f"{100 * share:.1f}"


def scene_lines(cost, known):
    """Yields what the scene pays for."""
    record, banner, run = cost.run.record, cost.banner, cost.run
    yield f"{run.label}\n"
    for name in ("flow", "particles", "physics", "regime", "scheme", "motion", "visc lap.", "gradient", "wall", "pressure"):
        if name in banner:
            yield f"  {name:<11} {banner[name]}"
    yield ""
    whole = sum(cost.phases.values()) or 1.0
    yield from table(["part of the run", "s", "share, %"],
                     [[PHASES.get(name, name), f"{spent:.3g}", percent(spent / whole)] for name, spent in cost.phases.items() if spent > 0.0])
    yield f"\n{record.get('steps', 0):.0f} steps of {1e3 * cost.step:.3g} ms. Parts of a step:\n"
    rows = [[name, f"{1e3 * cost.events[name][0] / max(record.get('steps', 1.0), 1.0):.3g}", percent(cost.share(name)),
             known.get(name, "")] for name in cost.stages if name in cost.events]
    yield from table(["part", "ms a step", "share, %", "what it does"], rows)
    unused = [f"{name} ({what})" for name, what in known.items() if name not in cost.stages]
    if unused:
        yield "\nLeft out: " + "; ".join(unused) + "."
    yield "\nWithin them:\n"
    inner = sorted(((share, name) for name in cost.events if name not in known and (share := cost.share(name)) >= LEAST), reverse=True)
    yield from table(["event", "calls a step", "share, %"],
                     [[name, f"{cost.events[name][1] / max(record.get('steps', 1.0), 1.0):.3g}", percent(share)] for share, name in inner[:14]])
    own = libraries(run.isph)
    fluid = record.get("particles") or 1.0
    yield "\nMemory:\n"
    yield from table(["", "MB", "share, %"], [["program and libraries", f"{own:.3g}", percent(own / record["rss_mb"])],
                                              ["the flow", f"{record['rss_mb'] - own:.3g}", percent(1.0 - own / record["rss_mb"])]])
    yield f"\nThat is {1e3 * max(record['rss_mb'] - own, 0.0) / fluid:.3g} kB a particle.\n"


def swap_lines(base, cost):
    """Yields what differs with more words."""
    added = [name for name in cost.stages if name not in base.stages]
    removed = [name for name in base.stages if name not in cost.stages]
    yield f"With {cost.run.label}:\n"
    if added or removed:
        yield "  stages: " + "; ".join(filter(None, ["adds " + ", ".join(added) if added else "",
                                                    "leaves out " + ", ".join(removed) if removed else ""]))
    for name in dict.fromkeys([*base.banner, *cost.banner]):
        if base.banner.get(name) != cost.banner.get(name) and name not in ("step", "case"):
            yield f"  {name}: {cost.banner.get(name, 'none')}  (as typed: {base.banner.get(name, 'none')})"
    yield ""
    rows = [["ms a step", f"{1e3 * base.step:.3g}", f"{1e3 * cost.step:.3g}", ratio(cost.step, base.step)]]
    for name in dict.fromkeys([*base.stages, *cost.stages]):
        one, two = (of.events.get(name, (0.0, 0))[0] / max(of.run.record.get("steps", 1.0), 1.0) for of in (base, cost))
        if one or two:
            rows.append([f"{name}, ms a step", f"{1e3 * one:.3g}", f"{1e3 * two:.3g}", ratio(two, one)])
    for name, label in (("particles", "fluid particles"), ("visc_its", "iterations of the velocity"),
                        ("ppe_its", "iterations of the pressure"), ("rss_mb", "memory, MB")):
        one, two = base.run.record.get(name), cost.run.record.get(name)
        if one is not None or two is not None:
            rows.append([label, *("" if x is None else f"{x:.4g}" for x in (one, two)), ratio(two, one) if one and two else ""])
    yield from table(["", "as typed", "with it", "ratio"], rows)
    yield ""


def ratio(new, old):
    return f"{new / old:.2f}" if old else ""


def study(scene, options):
    """Makes a short run with PETSc's log for the scene and each swap, and tells their costs."""
    if options.steps < 1:
        raise UserError(f"--steps {options.steps}: a number of 1 or more is required")
    steady = any(word.lower() == "-steady" for word in scene.known)
    more = ["-log_view", ":log.csv:ascii_csv", *([] if steady else ["-max_steps", str(options.steps)])]
    runs = {swap: Run(scene, split(swap, "--swap"), options.isph, options.out, more) for swap in ["", *dict.fromkeys(options.swap)]}
    make(runs.values(), options)
    lost = {swap: run for swap, run in runs.items() if run.record["kind"] not in GOOD or "steps" not in run.record}
    if "" in lost:
        raise UserError(runs[""].record.get("reason", "the run has no steps"))
    costs = {swap: Cost(run) for swap, run in runs.items() if swap not in lost}
    base = costs.pop("")
    scheme = base.banner.get("scheme", "").split(" ")[0]
    text = list(scene_lines(base, catalogue(base.run.isph, scheme)))
    for cost in costs.values():
        text += swap_lines(base, cost)
    text += [f"With {run.label}: {run.record['kind']}: {run.record.get('reason', 'the run has no steps')}" for run in lost.values()]
    say(os.path.join(options.out, "need.md"), text)
    write_rows(os.path.join(options.out, "need.csv"),
               [{"setting": cost.run.label, "part": name, "stage": name in cost.stages, "s": spent, "calls": calls,
                 "share": cost.share(name)} for cost in (base, *costs.values()) for name, (spent, calls) in cost.events.items() if calls])
