"""Inputs that are command lines: options with random values, expressions and scenes."""
import re

from random_input.expressions import expression, mutated
from random_input.values import number, shape, value

# Requests that print and end, and programs, pictures and places outside the folder
EXCLUDED = re.compile(r"draw|socket|saws|python|matlab|debugger|on_error|x11|/dev|\.\.|~|\$|(?:^|[\s:,='\"])/", re.I)


class Input:
    """The command line of one input, and the files that it finds."""

    def __init__(self, base, words, files=None):
        self.base, self.words, self.files = base, words, files or {}

    def arguments(self):
        return self.base + [word[:30000] for word in self.words]  # Linux takes 128 KiB in a word


def base(rng, cases, setting=()):
    """Returns the options of a small run of a random case, scheme and motion."""
    chosen = dict(zip(setting[::2], setting[1::2]))
    if rng.random() < 0.5:
        chosen.setdefault("-case", rng.choice(cases))
    if chosen.get("-case") != "patch":
        if rng.random() < 0.3:
            chosen.setdefault("-scheme", rng.choice(("projection", "coupled")))
        if rng.random() < 0.3:
            chosen.setdefault("-motion", rng.choice(("lagrangian", "eulerian")))
        if rng.random() < 0.3:
            chosen.setdefault("-probe_forces", "true")
        chosen.update({"-max_steps": "2", "-progress": "none"})
    chosen.update({"-n": rng.choice(("8", "8", "8", "12", "16")), "-report": "report.csv"})
    return [word for pair in chosen.items() for word in pair]


def safe(words):
    return not any(EXCLUDED.search(word) for word in words)


def options(rng, rows, count):
    """Returns options with values that name no place outside the folder, and their setting."""
    words, setting = [], []
    for _ in range(count):
        row = rng.choice(rows)
        while True:
            name = row.named(rng)
            text = value(rng, row, name)
            expressions = row.kind == "expression,..."  # a quotient may begin with a dash
            if text is None or expressions or safe([text]):
                break
        setting += row.setting(rng)
        words += [name] if text is None else [name, text]
    return words, setting


def expression_input(rng):
    words = ["-case", "scene"]
    for _ in range(rng.choice((1, 1, 2))):
        option, components = rng.choice((("-scene_wall_" + rng.choice(("left", "right", "bottom", "top")) + "_velocity", 2),
                                         ("-body_force", 2), ("-viscosity_field", 1), ("-scene_exact", rng.choice((2, 3))),
                                         ("-scene_velocity", 2)))
        text = ",".join(expression(rng) for _ in range(components))
        words += [option, mutated(rng, text) if rng.random() < 0.6 else text]
    return Input(["-n", "8", "-max_steps", "1", "-progress", "none", "-report", "report.csv"], words)


def scene_input(rng):
    words = ["-case", "scene"]
    if rng.random() < 0.5:
        box = [number(rng), number(rng), number(rng), number(rng)]
        if rng.random() < 0.6:
            box = ["0", "0", f"{rng.uniform(0.3, 2.5):.3g}", f"{rng.uniform(0.3, 2.5):.3g}"]
        words += ["-scene_box", ",".join(box)]
    for option, names in (("-scene_periodic", ("x", "y", "x,y")),
                          ("-scene_symmetry", ("left", "right", "bottom", "top", "left,right", "bottom,left", "top,bottom"))):
        if rng.random() < 0.3:
            words += [option, rng.choice(names)]
    for k in range(1, 1 + rng.choice((0, 1, 1, 2, 3, 6, 16))):
        words += [f"-scene_body_{k}", shape(rng)]
        if rng.random() < 0.3:
            words += [f"-scene_body_{k}_velocity", f"{number(rng)},{number(rng)}"]
        if rng.random() < 0.3:
            words += [f"-scene_body_{k}_rotation", number(rng)]
    if rng.random() < 0.3:
        words += ["-scene_domain", shape(rng)]
        for k in range(1, 1 + rng.choice((0, 1, 2))):
            words += [f"-scene_part_{k}", shape(rng), f"-scene_part_{k}_velocity", f"{number(rng)},{number(rng)}"]
    for k in range(1, 1 + rng.choice((0, 0, 0, 1, 3))):
        words += [f"-scene_filled_{k}", shape(rng)]
    for k in range(1, 1 + rng.choice((0, 0, 1, 2, 5))):
        words += [f"-scene_fluid_{k}", shape(rng), f"-scene_fluid_{k}_viscosity", f"{10 ** rng.uniform(-6, 4):.3g}"]
        if rng.random() < 0.2:
            words += [f"-scene_fluid_{k}_density", f"{10 ** rng.uniform(-3, 3):.3g}"]
        if rng.random() < 0.2:
            words += [f"-scene_fluid_{k}_tension", f"{10 ** rng.uniform(-3, 1):.3g}"]
    for side in "left", "right", "bottom", "top":
        if rng.random() < 0.15:
            words += [f"-scene_wall_{side}_velocity", f"{number(rng)},{number(rng)}"]
    if rng.random() < 0.15:
        one, other = rng.choice((("left", "right"), ("bottom", "top"), ("right", "top")))
        inwards = {"left": "1,0", "bottom": "0,1", "right": "-1,0"}[one]
        words += ["-scene_inflow", one, f"-scene_wall_{one}_velocity", inwards, "-scene_outflow", other]
    if rng.random() < 0.15:
        words += ["-surface_tension", f"{10 ** rng.uniform(-3, 1):.3g}"]
    if rng.random() < 0.15:
        law = rng.choice(("papanastasiou", "casson", "herschel_bulkley"))
        words += ["-rheology", law, "-rheology_yield", f"{10 ** rng.uniform(-2, 2):.3g}"]
        words += ["-rheology_exponent", f"{rng.uniform(0.2, 2):.3g}"] if law == "herschel_bulkley" else []
    if rng.random() < 0.1:
        words += ["-scene_scalar_1_name", "T", "-scene_scalar_1_start", expression(rng), "-scene_scalar_1_diffusivity",
                  f"{10 ** rng.uniform(-4, 2):.3g}", f"-scene_scalar_1_{rng.choice(('value', 'flux'))}",
                  f"{rng.choice(('left', 'top', 'body_1', 'walls'))}: {number(rng)}"]
        if rng.random() < 0.4:
            words += ["-scene_scalar_1_source", rng.choice((expression(rng), "exp(T)", "T*g^2"))]
        if rng.random() < 0.4:
            words += ["-scene_scalar_1_exchange", f"{rng.choice(('right', 'bottom', 'surface'))}: {number(rng)},{number(rng)}"]
        if rng.random() < 0.4:
            words += ["-viscosity_field", rng.choice(("exp(-T)", "1+T", "exp(-T)*g^(-0.5)"))]
    if rng.random() < 0.3:
        words += ["-body_force", f"{number(rng)},{number(rng)}"]
    if rng.random() < 0.3:
        words += ["-scheme", "coupled"]
    if rng.random() < 0.3:
        words += ["-motion", "eulerian"]
    if rng.random() < 0.3:
        words += ["-jitter", f"{rng.uniform(0, 0.5):.2g}"]
    if rng.random() < 0.3:
        words += ["-wall", rng.choice(("dummy_linear", "wall_layer"))]
    return Input(["-n", rng.choice(("8", "12", "16")), "-max_steps", "2", "-progress", "none", "-report", "report.csv",
                  "-probe_forces"], words)
