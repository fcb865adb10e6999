#!/usr/bin/env python3
"""Runs isph with random input: options, files, expressions and scenes that a seed determines.

    fuzz.py [--count N] [--seed S] [--start K] [--jobs J] [--only KIND] [--patience X] ISPH

Input k of seed S is the same on every computer and with any --count, so `--seed S --start K --count 1` repeats it
(with the same --only). The options, their kinds and ranges come from `isph -options_reference`. Each input runs in a
folder fuzz_S_K of its own below the present folder. The folder stays if the input is a finding; the file `command` in
it holds the whole command line. Paths are names inside that folder, and options that run other programs, draw or wait
do not occur.

A finding is one of these:

    crash        a signal, or the statuses 59 and above 128, which stand for one
    hang         no end within 20 s times --patience, and within three times as long in a second run
    sanitizer    a report of AddressSanitizer or UndefinedBehaviorSanitizer
    not finite   the status 0 with nan or inf in the report file or in the printed table
    refusal      another status without exactly one line on standard error, which begins with "isph: "; a traceback.
                 Lines of Open MPI's own, which begin with "mca_" when it reads a damaged file, do not count

Exits with status 1 if there is a finding.
"""
import argparse
import concurrent.futures
import math
import os
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys

SECONDS = 20
MEMORY = 4 << 30  # bytes of address space; not under AddressSanitizer, which reserves terabytes
KINDS = ("option", "combination", "file", "expression", "scene")
SHARES = (35, 20, 15, 15, 15)  # of the kinds
FINDINGS = ("crash", "hang", "sanitizer", "not finite", "refusal")

# Requests that print and end, and programs, pictures and places outside the folder
EXCLUDED = re.compile(r"draw|socket|saws|python|matlab|debugger|on_error|x11|/dev|\.\.|~|\$|(?:^|[\s:,='\"])/", re.I)
# Largest values in range that finish in time
COSTLY = {"-n": 20, "-max_steps": 3, "-patch_repeats": 2}
ODD_REALS = ("0", "-0", "-1", "1e300", "-1e300", "1e-300", "4.9e-324", "1e400", "1e-400", "nan", "-nan", "inf", "-inf",
             "0x1p3", "1,2", "1e", "1.5.5", "--5", "+5", " 5", "5 ", "1d3", "1/3", "1e99999", ".", "-", "e5", "1_000")
ODD_INTS = ("0", "-1", "-2", "2147483647", "2147483648", "-2147483648", "4294967296", "9223372036854775807",
            "9223372036854775808", "1e3", "3.5", "0x10", "007", "+7", " 7", "1,2", "nan", "inf", "--3")
ODD_WORDS = ("", " ", "\t", "text", "true", "no", ",", ",,", "a,b", ":", "::", "%s%n%d", "\\", "'", '"', "a\nb", "\n",
             "\r", "é", "日本語", "\U0001f41f", "\udcff\udcfe", "\x01", "\x7f", "*", "?", "#", "# a", "(", ")", "{}", "[",
             ";", "&", "|", "<", ">", "=", "None", "NULL", "0", "-1", "1e300", "nan")
ODD_FILES = ("f.h5", "f", "f.csv", "a b.h5", "é.h5", "日本.h5", "none/f.h5", "sub/f.h5", "sub", ".", "./f.h5", "f,g", "f:g",
             "f.h5.part", "%s%n.h5", "f'.h5", 'f".h5', "f&g", "f#g", "text.h5", "empty.h5", "f.h5/", "f\ng", "*",
             "command", "_0000.h5", ".h5", "f.xdmf", "report.csv", "\udcff.h5", "#f", "[f]", "f?", "f;g")
VIEWERS = ("ascii:f.txt", "binary:f.bin", "ascii", "binary", "ascii:f:ascii_matlab", "hdf5:f.h5", "ascii::", ":", ":::",
           ":f.txt", ":f.txt:ascii_xml", ":f.txt:ascii_info_detail", "vtk:f.vtk", "ascii:f.txt:ascii_info:append",
           "ascii:none/f.txt", "ascii:sub", "hdf5", "vtk", "string", "ascii:f.txt:nonsense", "binary:f.bin:default",
           "exodusii:f", "adios:f", "glvis:", "ascii:f.txt:ascii_dense")
PETSC_TYPES = {  # the last words of PETSc's options, and words they may take
    "ksp_type": "cg gmres fgmres lgmres bcgs bcgsl ibcgs tfqmr minres preonly richardson chebyshev cr gcr pipecg "
                "pipefgmres dgmres symmlq lsqr cgs bicg fcg cgne nash stcg gltr pgmres qcg pipebcgs fbcgs tsirm",
    "pc_type": "none jacobi bjacobi sor ilu icc lu cholesky asm gasm gamg hypre ksp composite mg redundant fieldsplit "
               "pbjacobi vpbjacobi eisenstat mat cp lsc kaczmarz bddc nn svd tfs telescope redistribute patch hmg "
               "galerkin exotic shell",
    "norm_type": "none preconditioned unpreconditioned natural",
    "pc_side": "left right symmetric",
    "pc_hypre_type": "boomeramg euclid parasails pilut ams ads",
    "coarsen_type": "CLJP Ruge-Stueben modifiedRuge-Stueben Falgout PMIS HMIS",
    "interp_type": "classical direct multipass multipass-wts ext+i ext+i-cc standard standard-wts block block-wtd FF FF1 "
                   "ext ad-wts ext-mm ext+i-mm ext+e-mm",
    "relax_type_all": "Jacobi sequential-Gauss-Seidel seqboundary-Gauss-Seidel SOR/Jacobi backward-SOR/Jacobi "
                      "symmetric-SOR/Jacobi l1scaled-SOR/Jacobi Gaussian-elimination CG Chebyshev FCF-Jacobi "
                      "l1scaled-Jacobi",
    "gamg_type": "agg geo classical",
    "mat_type": "aij seqaij mpiaij baij sbaij dense aijperm aijsell aijcrl sell is mffd shell",
    "vec_type": "standard seq mpi shared node",
    "schur_fact_type": "diag lower upper full",
    "schur_precondition": "self selfp a11 user full",
    "adapt_type": "none basic dsp cfl glee history",
    "bdf_order": "1 2 3 4 5 6",
    "arkimex_type": "1bee a2 l2 ars122 2c 2d 2e prssp2 3 bpr3 ars443 4 5",
    "rosw_type": "2m 2p ra3pw ra34pw2 rodas3 sandu3 assp3p3s1c lassp3p4s2c lassp3p5s2c ark3 theta1 theta2 grk4t shamp4 "
                 "veldd4 4l",
    "rk_type": "1fe 2a 2b 3 3bs 4 5f 5dp 5bs 6vr 7vr 8vr",
    "ssp_type": "rks2 rks3 rk104",
    "snes_type": "newtonls newtontr ksponly ngmres anderson nrichardson qn ncg ksptransposeonly fas ms vinewtonrsls",
}
FUNCTIONS = "sin cos tan asin acos atan sinh cosh tanh sqrt exp log log10 log2 abs sign rint min max sum avg".split()


class Option:
    """A row of the reference page."""

    def __init__(self, cells, places):
        self.name, self.kind, _, _, self.allowed, self.where, _ = cells
        self.places = places

    def named(self, rng):
        """Returns the name with words in the places of <word>."""
        number = rng.choice(("1", "1", "1", "1", "2", "3", "16", "17", "0", "99999999999999999999"))
        name = self.name.replace("<k>", number)
        quantity = rng.choice(("kinetic_energy", "u_min", "velocity_l2", "divergence_max", "nonsense", ""))
        name = name.replace("<quantity>", quantity)
        for place, words in self.places.items():
            name = name.replace(f"<{place}>", rng.choice(words))
        return name

    def bounds(self):
        """Returns the least and the largest value allowed, as numbers."""
        match = re.match(r"(\S+) to (\S+)$", self.allowed)
        if match:
            return float(match[1]), float(match[2])
        if self.allowed == "above 0":
            return 1e-300, 1e300
        match = re.match(r"(\S+) or more$", self.allowed)
        return (float(match[1]), 1e300) if match else (-1e300, 1e300)

    def words(self):
        """Returns the names from which the option chooses."""
        return re.sub(r"^(one|some) of ", "", self.allowed).split(", ")

    def setting(self, rng):
        """Returns options with which most runs read this one."""
        found = []
        for option, value in re.findall(r"(-[a-z_]+) ([a-z_]+)", self.where):
            if option != "-visc_ts_type":
                found += [option, value]
        if "bodies that are given" in self.where:
            found += ["-scene_body_1", "circle,0.5,0.5,0.2"]
        if "fluids that are given" in self.where:
            found += ["-scene_fluid_1", "circle,0.5,0.5,0.2", "-scene_fluid_1_viscosity", "0.1"]
        if "with a probe" in self.where:
            found += ["-probe_point", "0.5,0.5"]
        if "not newtonian" in self.where:
            found += ["-rheology", "papanastasiou", "-rheology_yield", "0.1"]
        if "-rheology carreau" in self.where or "power\\_law" in self.where:
            found += ["-rheology_exponent", "0.5"]
        return found if rng.random() < 0.85 else []


def reference(isph):
    """Returns the options of the reference page, and the names of the cases."""
    text = subprocess.run([isph, "-options_reference"], stdout=subprocess.PIPE, text=True, check=True,
                          env=environment(os.getcwd())).stdout
    places = {}
    for place, words in re.findall(r"`<(\w+)>` stands for (.*)\.", text):
        places[place] = words.split(", ")
    rows = []
    for line in text.splitlines():
        if line.startswith("| `-"):
            cells = [re.sub(r"\\([_|>*])", r"\1", cell).strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
            assert len(cells) == 7, line
            cells[0] = cells[0].strip("`")
            rows.append(Option(cells, places))
    assert len(rows) > 100, text
    return rows, next(row for row in rows if row.name == "-case").words()


# ---- values ----


def oversized(rng):
    """Returns a very long word."""
    return rng.choice(("x", "9", "1,", "(", "é", "0.", "a,b:", " ")) * rng.choice((130, 260, 1100, 4100, 20000))


def any_word(rng):
    return oversized(rng) if rng.random() < 0.1 else rng.choice(ODD_WORDS)


def real(rng, low=-1e300, high=1e300):
    """Returns a number, mostly in the range."""
    draw = rng.random()
    if draw < 0.25:
        return rng.choice(ODD_REALS)
    if draw < 0.35:
        return any_word(rng)
    if draw < 0.5:
        return repr(rng.choice((low, high, low * (1 - 1e-9), high * (1 + 1e-9), low / 2, high * 2)))
    if low > 0:
        return f"{10 ** rng.uniform(math.log10(low), math.log10(high)):.6g}"
    if high - low < 1e6:
        return f"{rng.uniform(low, high):.6g}"
    return f"{rng.choice((1, 1, 1, -1)) * 10 ** rng.choice((rng.uniform(-3, 3), rng.uniform(-300, 300))):.6g}"


def integer(rng, low, high):
    draw = rng.random()
    if draw < 0.4:
        return rng.choice(ODD_INTS)
    if draw < 0.5:
        return any_word(rng)
    low, high = int(max(low, -1e9)), int(min(high, 1e9))
    if draw < 0.7:
        return str(rng.choice((low, low - 1, low + 1)))
    return str(rng.randint(low, rng.choice((min(high, low + 20), high))))


def petsc_value(rng, name):
    """Returns a value of an option that PETSc reads."""
    if rng.random() < 0.15:
        return any_word(rng)
    if re.search(r"_view|_monitor|converged_reason", name):
        return rng.choice((None, None) + VIEWERS)
    for end, words in PETSC_TYPES.items():
        if name.endswith(end) and rng.random() < 0.9:
            return rng.choice(words.split())
    return rng.choice((real(rng, 1e-12, 1), integer(rng, 0, 1000)))


def value(rng, row, name):
    """Returns a value for an option; None: no value."""
    kind = row.kind
    if rng.random() < 0.04:
        return None
    if kind == "int":
        low, high = row.bounds()
        text = integer(rng, low, min(high, COSTLY.get(name, high)))
        try:  # runs that are too long by their own request are no hangs
            if name in COSTLY and COSTLY[name] < float(text) <= min(high, 2**31 - 1):
                return str(COSTLY[name])
        except ValueError:
            pass
        return text
    if kind == "real":
        return real(rng, *row.bounds())
    if kind == "real,...":
        return ",".join(real(rng, 0, 1) for _ in range(rng.choice((1, 2, 2, 3, 4, 4, 5, 6, 9))))
    if kind == "true|false":
        return rng.choice((None, "true", "false", "1", "0", "yes", "off", any_word(rng)))
    if kind == "name":
        word = rng.choice(row.words())
        return rng.choice((word, word, word, word.upper(), word[:-1], word + " ", any_word(rng)))
    if kind == "name,...":
        words = [rng.choice(row.words()) for _ in range(rng.randint(1, 4))]
        if rng.random() < 0.3:
            words.insert(rng.randrange(len(words)), any_word(rng))
        return ",".join(words)
    if kind == "file":
        return rng.choice((rng.choice(ODD_FILES), rng.choice(ODD_FILES), "f" * rng.choice((190, 245, 256, 5000)) + ".h5"))
    if kind == "viewer":
        return rng.choice(VIEWERS)
    if kind == "expression,...":
        return ",".join(expression(rng) for _ in range(rng.choice((1, 2, 2, 2, 3, 4))))
    if kind == "shape,real,...":
        return shape(rng)
    if kind == "value":
        return petsc_value(rng, name)
    return any_word(rng)


def expression(rng, depth=0):
    """Returns a random expression of muParser's grammar."""
    draw = rng.random()
    if depth > 5 or draw < 0.3:
        return rng.choice(("x", "y", "t", "pi", "nu", "rho", "z", "_e", "0", "1", "2", "0.5", "1e-3", "1e300", "1e-300",
                           "rho0", f"{rng.uniform(-3, 3):.3g}"))
    if draw < 0.65:
        sign = rng.choice(("+", "-", "*", "/", "^", "+", "*", "<", ">", "==", "!=", "<=", ">=", "&&", "||"))
        return f"{expression(rng, depth + 1)}{sign}{expression(rng, depth + 1)}"
    if draw < 0.9:
        name = rng.choice(FUNCTIONS)
        arguments = rng.choice((1, 2, 3)) if name in ("min", "max", "sum", "avg") else 1
        return f"{name}({','.join(expression(rng, depth + 1) for _ in range(arguments))})"
    if draw < 0.95:
        return f"({expression(rng, depth + 1)}?{expression(rng, depth + 1)}:{expression(rng, depth + 1)})"
    return f"(-{expression(rng, depth + 1)})"


def mutated(rng, text):
    """Returns a text with a few random changes."""
    for _ in range(rng.choice((1, 1, 2, 5))):
        at, end = sorted((rng.randint(0, len(text)), rng.randint(0, len(text))))
        draw = rng.random()
        if draw < 0.25:
            text = text[:at] + text[end:]
        elif draw < 0.5:
            text = text[:at] + rng.choice("()+-*/^,?:=<>&|!. \t\n'\"\\;{}[]#%@0123456789exyztéλ\x01") + text[at:]
        elif draw < 0.65:
            text = text[:end] + text[at:end] + text[end:]
        elif draw < 0.75:
            text = text[:at] + rng.choice(FUNCTIONS + ["nan", "inf", "e", "1e999", "0x", "a=1", "x=2", "//", ""]) + text[at:]
        elif draw < 0.8:
            deep = rng.choice((10, 100, 480, 2000))
            text = rng.choice(("(", "-", "sin(", "abs(", "1+(")) * deep + text + ")" * deep
        elif draw < 0.85:
            text = "+".join([text] * rng.choice((5, 50, 400)))
        else:
            text = text[:at] + text[at:end][::-1] + text[end:]
    return text


def number(rng):
    """Returns a coordinate, mostly of the unit box."""
    if rng.random() < 0.06:
        return rng.choice(ODD_REALS)
    return f"{rng.choice((rng.uniform(0, 1), rng.uniform(0, 1), rng.uniform(-1, 2), round(rng.random(), 1))):.4g}"


def shape(rng):
    kind = rng.choice(("circle", "circle", "box", "polygon"))
    if kind == "circle":
        numbers = [number(rng), number(rng), f"{rng.choice((rng.uniform(0.05, 0.4), 10 ** rng.uniform(-12, 3))):.4g}"]
    elif kind == "box":
        numbers = [number(rng) for _ in range(4)]
    else:
        numbers = [number(rng) for _ in range(2 * rng.choice((3, 3, 4, 5, 8, 12, 40)))]
    if rng.random() < 0.05:
        numbers.pop()
    return ",".join([kind] + numbers)


# ---- inputs ----


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


def damaged(rng, data):
    """Returns bytes with bits flipped, cut off, put in or at the end."""
    data = bytearray(data)
    draw = rng.random()
    near = rng.random() < 0.5  # the beginning of an HDF5 file describes the rest
    length = min(len(data), 4096) if near else len(data)
    if draw < 0.5:
        for _ in range(rng.choice((1, 1, 2, 8, 64))):
            data[rng.randrange(length)] ^= 1 << rng.randrange(8)
    elif draw < 0.65:
        del data[rng.randrange(length):]
    elif draw < 0.75:
        at = rng.randrange(length)
        data[at:at + rng.choice((1, 2, 4, 8, 100))] = bytes(rng.randrange(256) for _ in range(rng.choice((0, 1, 4, 8, 100))))
    elif draw < 0.9:
        at = rng.randrange(length)
        count = rng.choice((1, 2, 4, 8))
        data[at:at + count] = rng.choice((b"\x00", b"\xff", b"\x7f", b"\x80")) * count
    else:
        data += bytes(rng.randrange(256) for _ in range(rng.choice((1, 100, 5000)))) if rng.random() < 0.5 else bytes(data)
    return bytes(data)


RESTART = ["-n", "8", "-progress", "none", "-report", "report.csv", "-max_steps"]
PROBES = ["-probe_point", "0.5,0.5", "-output", "s.h5", "-checkpoint", "c.h5"]
OPTIONS_TEXT = """# a scene
-case scene
-scene_box 0,0,1,1   # its corners
-scene_body_1 "circle,0.5,0.5,0.2"
-scene_wall_top_velocity 'sin(t), 0'
-body_force "x*y, -1"
-viscosity 0.1
-visc_ksp_rtol 1e-8
-ppe_pc_type hypre
-n 8
-max_steps 1
"""
YAML_TEXT = """# a scene
case: scene
scene_box: [0, 0, 1, 1]
scene_body_1: circle,0.5,0.5,0.2
viscosity: 0.1
ppe:
  ksp_rtol: 1e-8
n: 8
max_steps: 1
"""


def pristine(isph, folder):
    """Runs isph for the files that inputs change; returns their contents."""
    os.mkdir(folder)
    subprocess.run([isph, *RESTART, "2", *PROBES], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                   env=environment(folder))
    found = {}
    for name in os.listdir(folder):
        path = os.path.join(folder, name)
        if os.path.isfile(path):
            with open(path, "rb") as file:
                found[name] = file.read()
    shutil.rmtree(folder)
    return found


def file_input(rng, files):
    kind = rng.choice(("checkpoint", "checkpoint", "particles", "options", "yaml", "petscrc", "csv", "index"))
    if kind == "checkpoint":
        return Input(RESTART + ["3"], ["-restart", "c.h5"], {"c.h5": damaged(rng, files["c.h5"])})
    if kind == "particles":
        return Input(RESTART + ["1"], ["-particles", "p.h5"], {"p.h5": damaged(rng, files["s_0001.h5"])})
    if kind in ("options", "yaml", "petscrc"):
        text = YAML_TEXT if kind == "yaml" else OPTIONS_TEXT
        while True:
            data = damaged(rng, text.encode()) if rng.random() < 0.5 else mutated(rng, text).encode()
            if not EXCLUDED.search(data.decode("latin-1")):
                break
        name, words = {"options": ("o.opts", ["-options_file", "o.opts"]), "petscrc": (".petscrc", []),
                       "yaml": ("o.yaml", ["-options_file_yaml", "o.yaml"])}[kind]
        return Input(words, ["-n", "8", "-max_steps", "1", "-progress", "none"], {name: data})
    some = {name: files[name] for name in files if name not in ("report.csv", "probe_point.csv", "s.xdmf")}
    other = {name: files[name] for name in files if name not in some}
    name = "s.xdmf" if kind == "index" else rng.choice(("report.csv", "probe_point.csv"))
    other[name] = damaged(rng, other[name])
    return Input(RESTART + ["3"], ["-restart", "c.h5", *PROBES], {**some, **other})


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
        if rng.random() < 0.2:
            words += [f"-scene_body_{k}_around", "true"]
    for k in range(1, 1 + rng.choice((0, 0, 1, 2, 5))):
        words += [f"-scene_fluid_{k}", shape(rng), f"-scene_fluid_{k}_viscosity", f"{10 ** rng.uniform(-6, 4):.3g}"]
    for side in "left", "right", "bottom", "top":
        if rng.random() < 0.15:
            words += [f"-scene_wall_{side}_velocity", f"{number(rng)},{number(rng)}"]
    if rng.random() < 0.3:
        words += ["-body_force", f"{number(rng)},{number(rng)}"]
    if rng.random() < 0.3:
        words += ["-scheme", "coupled"]
    if rng.random() < 0.3:
        words += ["-motion", "eulerian"]
    if rng.random() < 0.3:
        words += ["-jitter", f"{rng.uniform(0, 0.5):.2g}"]
    if rng.random() < 0.3:
        words += ["-wall", rng.choice(("dummy_linear", "mirror", "linear", "quadratic", "adami"))]
    return Input(["-n", rng.choice(("8", "12", "16")), "-max_steps", "2", "-progress", "none", "-report", "report.csv",
                  "-probe_forces"], words)


def generate(rng, only, rows, cases, files):
    kind = only or rng.choices(KINDS, SHARES)[0]
    if kind == "file":
        return file_input(rng, files)
    if kind == "expression":
        return expression_input(rng)
    if kind == "scene":
        return scene_input(rng)
    words, setting = options(rng, rows, 1 if kind == "option" else rng.randint(2, 4))
    return Input(base(rng, cases, setting), words)


# ---- runs ----


def environment(folder):
    """Returns an environment in which MPI starts no daemon and writes into the folder."""
    kept = {name: text for name, text in os.environ.items() if not name.startswith("PETSC_")}
    sanitizer = {"ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "print_stacktrace=1"}
    return {**sanitizer, **kept, "HOME": folder, "OMP_NUM_THREADS": "1", "OMPI_MCA_ess_singleton_isolated": "1",
            "OMPI_MCA_orte_tmpdir_base": folder}


def limits(memory):
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30, 1 << 30))
    if memory:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def execute(command, folder, seconds, memory):
    """Returns status, standard output and standard error; the status None after a timeout."""
    process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, env=environment(folder), start_new_session=True,
                               preexec_fn=lambda: limits(memory))
    try:
        out, err = process.communicate(timeout=seconds)
        status = process.returncode
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        out, err = process.communicate()
        status = None
    return status, out.decode(errors="replace"), err.decode(errors="replace")


def infinite(folder, out):
    """Returns a number of the report or the table that is not finite, with its line, or None."""
    text = out[out.rfind("\nquantity "):] if "\nquantity " in out else ""
    path = os.path.join(folder, "report.csv")
    if os.path.isfile(path):
        with open(path, encoding="utf-8", errors="replace") as file:
            text += file.read()
    match = re.search(r"^.*(?:^|[\s,])[-+]?(?:nan|inf)(?:[\s,]|$).*$", text, re.M | re.I)
    return match and match[0].strip()[-100:]


def judge(status, out, err, folder, reported):
    """Returns the kind of a finding and its reason, or None."""
    if status is None:
        return "hang", "no end"
    if "ERROR: AddressSanitizer" in err or "runtime error:" in err:
        at = re.search(r"(?:ERROR: AddressSanitizer|runtime error:)[^\n]*", err)
        return "sanitizer", at[0]
    if status < 0 or status == 59 or status > 128:
        return "crash", f"status {status}"
    if "PETSC ERROR" in err or "PETSC ERROR" in out:
        return "refusal", f"status {status} with a traceback"
    lines = [line for line in err.rstrip("\n").split("\n") if not line.startswith("mca_")]
    if status == 0:
        strange = None if reported else infinite(folder, out)
        return ("not finite", strange) if strange else None
    if len(lines) != 1 or not lines[0].startswith("isph: "):
        return "refusal", f"status {status} with {len(lines)} lines: {err[:200]!r}"
    return None


def quoted(word):
    """Returns a word for the shell, in printable characters."""
    if word.isascii() and word.isprintable():
        return shlex.quote(word)
    text = "".join(chr(b) if 32 <= b < 127 and chr(b) not in "'\\" else f"\\x{b:02x}" for b in os.fsencode(word))
    return f"$'{text}'"


def try_input(isph, settings, index, rows, cases, files, memory):
    """Runs one input; returns the kind of its finding and a line about it, or None."""
    rng = random.Random(f"{settings.seed}:{index}:{settings.only}")
    made = generate(rng, settings.only, rows, cases, files)
    folder = os.path.abspath(f"fuzz_{settings.seed}_{index}")
    seconds = SECONDS * settings.patience
    command = [isph] + [os.fsencode(word) for word in made.arguments()]
    for attempt in 1, 3:  # a computer at work on other things is slow
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(os.path.join(folder, "sub"))
        for name, data in {"text.h5": b"no HDF5\n", "empty.h5": b"", **made.files}.items():
            with open(os.path.join(folder, name), "wb") as file:
                file.write(data)
        status, out, err = execute(command, folder, attempt * seconds, memory)
        if status is not None:
            break
    finding = judge(status, out, err, folder, reported="report.csv" in made.files)
    if not finding:
        shutil.rmtree(folder)
        return None
    line = " ".join([quoted(isph)] + [quoted(word) for word in made.arguments()])
    with open(os.path.join(folder, "command"), "w", encoding="utf-8") as file:
        file.write(f"{line}\n")
    for name, text in ("stdout", out), ("stderr", err):
        with open(os.path.join(folder, name), "w", encoding="utf-8", errors="replace") as file:
            file.write(text)
    if len(line) > 1000:
        line = f"sh {folder}/command"
    only = f" --only {settings.only}" if settings.only else ""
    return finding[0], (f"{finding[0]}: --seed {settings.seed} --start {index} --count 1{only}: {finding[1]}\n"
                        f"    cd {os.path.basename(folder)} && {line}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", choices=KINDS)
    parser.add_argument("--patience", type=float, default=1)
    parser.add_argument("isph")
    settings = parser.parse_args()
    isph = os.path.abspath(settings.isph)
    with open(isph, "rb") as file:
        memory = b"__asan_init" not in file.read()
    rows, cases = reference(isph)
    files = pristine(isph, os.path.abspath(f"fuzz_{settings.seed}_files"))
    counts = dict.fromkeys(FINDINGS, 0)
    with concurrent.futures.ThreadPoolExecutor(settings.jobs) as pool:
        tries = [pool.submit(try_input, isph, settings, index, rows, cases, files, memory)
                 for index in range(settings.start, settings.start + settings.count)]
        for done in tries:
            if done.result():
                counts[done.result()[0]] += 1
                print(done.result()[1], flush=True)
    print("{} inputs, {} crashes, {} hangs, {} sanitizer reports, {} not finite, "
          "{} refusals of more than one line".format(settings.count, *counts.values()))
    sys.exit(any(counts.values()))


if __name__ == "__main__":
    main()
