"""Random expressions of place and time, and random changes of a text."""
FUNCTIONS = "sin cos tan asin acos atan sinh cosh tanh sqrt exp log log10 log2 abs sign rint min max sum avg".split()


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
