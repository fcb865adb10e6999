"""Random values of options: words, numbers, names, files and shapes."""
import math
import re

from random_input.expressions import expression

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
