"""Sections of studies/free_surface on long steps and on fluid that comes to rest: a mode of a drop, a film, a pulled drop, a
column and a puddle, with the length of the step in dt_explicit = 0.125 h^2/nu and h = 1.5 dx."""
import math

from free_surface_parts import BARE, off, percent, signed, times
from runs import table

EXPLICIT = 0.125 * 1.5**2  # dt_explicit [dx^2/nu]
SEEDS = (1, 2, 3)
MODE, MODE_N, MODE_RATE = f"{BARE}drop_mode.opts", 64, 5.54079  # nu/R^2, docs/verification/drop_mode.md
MODE_RATIOS = (5, 20, 100, 300)
FILM, FILM_N, FILM_RATIO = f"{BARE}film.opts", 20, 1000
PULL = ("-progress none -case scene -scene_box -1.6,-1.6,1.6,1.6 -scene_filled_1 circle,0,0,1 -scene_velocity 0,0 "
        "-viscosity 10 -body_force -32*x,32*y -scheme coupled")
PULL_N, PULL_END = (12, 16), 0.4
COLUMN, COLUMN_N, COLUMN_END = f"{BARE}column.opts", 16, 5
RATIOS = (10, 30, 100, 300)
PUDDLE, PUDDLE_STEPS = ("-progress none -case scene -scene_box 0,0,1,0.5 -scene_free top -viscosity 0.1 -body_force 0,-1 -n 12 "
                        "-jitter 0.2"), 5000
STIRRED = '-scene_velocity "0.3*sin(2*pi*x)*sin(2*pi*y), 0"'
PUDDLE_STEP = {"coupled": "0.05 -coupled_ksp_rtol 1e-12", "projection": "0.005"}


def decay(run, ratio, order):
    """Returns the rate of decay of the velocity over the second half of a run to about 0.1 R^2/nu, of at least eight steps,
    and the error of the velocity at its end."""
    dt = ratio * EXPLICIT / MODE_N**2
    half = max(4, round(0.05 / dt))
    first, last = half * dt, 2 * half * dt
    q = run(f"{MODE} -n {MODE_N} -dt {dt:.8g} {times((first, last))}" + (f" -time_order {order}" if order > 2 else ""))
    fall = q[f"kinetic_energy@{float(f'{first:g}'):.4g}"] / q["kinetic_energy"]
    return 2 * half, math.log(fall) / (2 * (last - first)), q["velocity_l2"]


def decay_rows(run):
    """Yields rows: length and number of steps, errors of the rate and of the velocity with steps of order 2 and 3."""
    for ratio in MODE_RATIOS:
        steps, rate, error = decay(run, ratio, 2)
        _, rate3, error3 = decay(run, ratio, 3)
        yield [ratio, steps, signed3(rate / MODE_RATE - 1), percent(error), signed3(rate3 / MODE_RATE - 1), percent(error3)]


def signed3(error):
    return f"{100 * error:+.3f} %"


def film_rows(run):
    """Yields rows: start, error of the steady film with moving and with fixed particles."""
    for seed in SEEDS:
        words = f"{FILM} -jitter 0.2 -seed {seed} -dt {FILM_RATIO * EXPLICIT / FILM_N**2:.6g} -t_end 20"
        yield [seed, *(f"{run(words + end)['velocity_l2']:.1e}" for end in ("", " -without convection"))]


def pull_rows(run):
    """Yields rows: n, length of the step, semi-axes of the pulled drop, a over that of the shortest steps."""
    for n in PULL_N:
        short = None
        for ratio in RATIOS:
            q = run(f"{PULL} -n {n} -dt {ratio * EXPLICIT / n**2 / 10:.6g} -t_end {PULL_END:g}")
            short = short or q["x_max"]
            yield [n, ratio, f"{q['x_max']:.4f}", f"{q['y_max']:.4f}", signed(off(q["x_max"], short)),
                   signed(off(q["fluid_volume"], math.pi))]


def column_rows(run):
    """Yields rows: length of the step, mean front and height of three starts, both over those of the shortest steps, largest
    error of the volume."""
    first = None
    for ratio in RATIOS:
        runs = [run(f"{COLUMN} -n {COLUMN_N} -jitter 0.2 -seed {seed} -dt {ratio * EXPLICIT / COLUMN_N**2:.6g} "
                    f"-t_end {COLUMN_END}") for seed in SEEDS]
        front = sum((q["x_max"] - q["x_min"]) / 2 for q in runs) / len(runs)
        height = sum(q["y_max"] for q in runs) / len(runs)
        first = first or (front, height)
        volume = max((q["fluid_volume"] - 1 for q in runs), key=abs)
        yield [ratio, f"{front:.4f}", f"{height:.4f}", signed(off(front, first[0])), signed(off(height, first[1])),
               signed(volume)]


def puddle_rows(run):
    """Yields rows: scheme, start, largest speed after 1000 steps at rest, speed and level after 5000 steps of a stirred puddle."""
    for scheme, step in PUDDLE_STEP.items():
        for seed in SEEDS:
            words = f"{PUDDLE} -seed {seed} -scheme {scheme} -dt {step}"
            rest = run(f"{words} -scene_exact 0,0,0.5-y -max_steps 1000 -t_end 1000")
            moved = run(f"{words} -scene_exact 0,0,0.5-y {STIRRED} -max_steps {PUDDLE_STEPS} -t_end 1000")
            yield [scheme, seed, f"{rest['velocity_linf'] / math.sqrt(0.5):.1e}", f"{moved['velocity_linf'] / math.sqrt(0.5):.1e}",
                   signed(off(moved["fluid_volume"], 0.5))]


def page(run):
    yield "\n## Decay of mode 2 by the length of the step\n"
    yield (f"`drop_mode.opts -n {MODE_N} -dt DT`, without and with `-time_order 3`: rate of decay of the velocity from nu t/R^2 = 0.05 to 0.1, "
           f"in runs of at least eight steps, against {MODE_RATE} nu/R^2, and error of the velocity at the end.\n")
    yield from table(["dt [dt_explicit]", "steps", "rate", "velocity", "rate, order 3", "velocity, order 3"], decay_rows(run))
    yield "\n## Steady film in long steps\n"
    yield (f"`film.opts -n {FILM_N} -jitter 0.2 -seed K -t_end 20` in steps of {FILM_RATIO} dt_explicit: error of the velocity in L2.\n")
    yield from table(["seed", "moving particles", "fixed particles"], film_rows(run))
    yield "\n## Long steps of a pulled drop and of a column\n"
    yield (f"A drop at rest, nu = 10, is pulled by the force (-32 x, 32 y) to t = {PULL_END:g}: semi-axes, and the shorter one over that in "
           f"steps of {RATIOS[0]} dt_explicit. The command is `{PULL.replace('-progress none ', '')} -n N -dt DT -t_end {PULL_END:g}`.\n")
    yield from table(["n", "dt [dt_explicit]", "x_max", "y_max", "x_max over the first", "volume"], pull_rows(run))
    yield (f"\n`column.opts -n {COLUMN_N} -jitter 0.2 -seed K -dt DT`, means of three starts at t = {COLUMN_END}; the volume is that of the worst.\n")
    yield from table(["dt [dt_explicit]", "front", "height", "front over the first", "height over the first", "volume"],
                     column_rows(run))
    yield "\n## A puddle at rest, and one that is stirred\n"
    yield (f"The puddle of `puddle.opts`, n = 12, jitter 0.2, between two walls without slip. Largest speed after 1000 steps from rest, and after "
           f"{PUDDLE_STEPS} steps from a flow with speeds up to 0.3, in (g H)^(1/2); volume inside the surface at the end, which is the level. Steps are "
           + " and ".join(f"{step.split()[0]} ({scheme})" for scheme, step in PUDDLE_STEP.items()) + ".\n")
    yield from table(["scheme", "seed", "at rest, speed", "stirred, speed", "stirred, level"], puddle_rows(run))
