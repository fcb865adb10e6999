"""Runs of studies/basa_poiseuille. Times are t* = pi^2 nu t/(4 d^2), with nu = 1 and d = 1/2, so that t* = pi^2 t."""
import math

import basa_parts as parts

CHANNEL = "-case poiseuille -with pressure,convection -n 20"
STARS = [0.01 * (3000 ** (k / 24)) for k in range(25)]  # 0.01 to 30
TIMES = [star / math.pi**2 for star in STARS]
FIRST = 14  # reports of the first stage, to t* = 0.76: a run that has failed in it has no second stage
SOUND = math.sqrt(1.4 * 125e3)  # of a gas at 125 kPa and 1 kg/m^3 [m/s]
STATES = {"tait": "-equation_of_state tait", "gas": f"-equation_of_state ideal_gas -sound_speed {SOUND:.5g}"}
REDUCED = "-pressure_reduction local_mean"
# CPU seconds of a run: the first matching equation of state and Re
SECONDS = 5.0
LONG = 15.0  # at Re = 10,000, for which 5 s end at t* = 0.01
OWN_LONG = {100: 60.0, 1000: 600.0, 10000: 2000.0}  # of -scheme projection, to t* = 30
REYNOLDS = {"tait": (0.5, 10, 100, 1000, 10000), "gas": (0.5, 10)}
OWN = {
    "projection": "-scheme projection",
    "projection, morris": "-scheme projection -visc_laplacian morris",
    "wcsph": "-scheme wcsph",
    "projection, short steps": "-scheme projection -dt_max 0.005066",  # t* = 0.05
}
OWN_REYNOLDS = (0.1, 1, 10, 100, 1000, 10000)
SEEDS = (1, 2, 3)
SEEDED = {"projection": (0.1, 1, 10, 100, 1000, 10000), "projection, short steps": (0.1, 1), "wcsph": (1, 100)}  # Re with all seeds
RAW = "EAD"  # models with runs without pressure reduction
READINGS = {  # readings of the paper's settings, model E without correction, Re = 0.5
    "as in all runs": "",
    "midpoint, acoustic CFL 0.1": "-wcsph_ts_rk_type midpoint",
    "Runge-Kutta 2a, acoustic CFL 0.1": "-wcsph_ts_rk_type 2a",
    "density by continuity, no diffusion": "-density_form continuity -density_diffusion 0",
    "twice the speed of sound": "-sound_speed 56.5685",
    "particles on the walls too": "-wall_surface 1",
    "no pressure reduction": "-pressure_reduction none",
}


def flow(reynolds):
    """Returns options of the Reynolds number with the viscosity 1 m^2/s."""
    return f"-reynolds {reynolds:g} -speed {2 * reynolds:g}"


class Channel:
    """Runs in the channel, cut off where they have failed; an RMS error is that of Eq. (38)."""

    def __init__(self, run):
        self.run = run

    def __call__(self, arguments, reynolds, seconds=None):
        """Returns a run to t* = 30; to t* = 0.76 if it has failed there."""
        self.run.seconds = seconds or (LONG if reynolds >= 10000 else SECONDS)
        q = self.run(f"{CHANNEL} {arguments} {parts.times(TIMES[:FIRST])}")
        if not q or "failed" in q or q["u_relative_rms"] >= parts.FAILED:
            return q
        return self.run(f"{CHANNEL} {arguments} {parts.times(TIMES)}") or q

    def model(self, model, correction, state, reynolds, reduced=True, more=""):
        """Returns a run with the settings of the paper."""
        words = [parts.PAPER, STATES[state], REDUCED if reduced else "-pressure_reduction none",
                 f"-correction {correction}", f"-visc_laplacian {parts.MODELS[model]}", flow(reynolds), more]
        if "-pressure_reduction" in more:
            words.remove(REDUCED)
        if "-density_form" in more:
            words[0] = words[0].replace("-density_form summation ", "")
        return self(" ".join(word for word in words if word), reynolds)

    def own(self, name, reynolds, seed):
        """Returns a run of the project's own schemes from a disordered start."""
        seconds = OWN_LONG.get(reynolds) if name == "projection" else None
        return self(f"{OWN[name]} -jitter 0.2 -seed {seed} {flow(reynolds)} -progress none", reynolds, seconds)


def curve(q):
    """Returns pairs of t* and RMS error."""
    return [(t * math.pi**2, error) for t, error in parts.series(q, "u_relative_rms", TIMES)]


def failure(q):
    """Returns the t* from which the RMS error stays at 12 % or more, or at which the run is lost; and true if the run has
    failed there, false if it was still good at its end."""
    found = curve(q)
    lost = "failed" in q and "CPU time" not in q["failed"]
    good = [star for star, error in found if error < parts.FAILED]
    if found and found[-1][1] >= parts.FAILED:
        later = [star for star, _ in found if not good or star > good[-1]]
        return later[0], True
    if lost:
        return q.get("failed_t", q.get("t", 0.0)) * math.pi**2, True
    return (found[-1][0] if found else 0.0), False


def sweep(state, reynolds):
    """Yields models and corrections of a Reynolds number; shepard has runs with model A only at Re other than 0.5, and mixed
    at Re = 0.5 and 100 (Tait) or 10 (gas)."""
    if reynolds == 0.5:
        yield from ((model, correction) for correction, models in parts.CORRECTIONS.items() for model in models)
        return
    yield from ((model, "none") for model in ("E" if reynolds >= 10000 else "EDCB" if reynolds > 100 else "EDCBA"))
    yield "A", "shepard"
    yield from ((model, "mixed") for model in ("EDCB" if (state, reynolds) in (("tait", 100), ("gas", 10)) else ""))


def own_runs():
    """Yields name, Re and seed of the project's own schemes."""
    for seed in SEEDS:
        for reynolds in OWN_REYNOLDS:
            for name in OWN:
                if seed > 1 and reynolds not in SEEDED.get(name, ()):
                    continue
                if "morris" in name and reynolds not in (1, 100, 10000) or "short" in name and reynolds > 1:
                    continue
                yield name, reynolds, seed


def plan(channel):
    """Makes all runs, the most telling first."""
    for model, correction in sweep("tait", 0.5):
        channel.model(model, correction, "tait", 0.5)
    for model in RAW[:2]:
        channel.model(model, "none", "gas", 0.5, reduced=False)
    for name, reynolds, seed in own_runs():
        if seed == 1:
            channel.own(name, reynolds, seed)
    for state, reynolds in (("tait", 100), ("gas", 10), ("tait", 10), ("tait", 1000), ("tait", 10000)):
        for model, correction in sweep(state, reynolds):
            channel.model(model, correction, state, reynolds)
    for more in READINGS.values():
        channel.model("E", "none", "tait", 0.5, more=more)
    for model, correction in sweep("gas", 0.5):
        channel.model(model, correction, "gas", 0.5)
    for model in RAW:
        channel.model(model, "none", "gas", 0.5, reduced=False)
    for name, reynolds, seed in own_runs():
        channel.own(name, reynolds, seed)
