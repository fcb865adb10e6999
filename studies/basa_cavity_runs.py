"""Runs of studies/basa_cavity. Times are in L/U."""
import basa_parts as parts

N = 25
ENDS = {100: 10.0, 1000: 10.0}
TIMES = {reynolds: [end * k / 20 for k in range(1, 21)] for reynolds, end in ENDS.items()}
HEIGHTS = [round(0.05 * k, 2) for k in range(1, 20)]
POINTS = "-probe_point " + ",".join(f"0.5,{y:g}" for y in HEIGHTS)
REDUCED = "-pressure_reduction local_mean"
SECONDS = 60.0  # of CPU time of a run
# Section 6.2: stationary particles with densities and pressures of their own, tangential velocities extrapolated
PAPER = parts.PAPER.replace("-wall dummy_linear", "-wall dynamic")


def models(paper):
    """Returns the options of each model and correction by its name."""
    return {**{f"{model}, shepard": f"{paper} {REDUCED} -correction shepard -visc_laplacian {form}"
               for model, form in parts.MODELS.items()},
            "E, none": f"{paper} {REDUCED} -correction none -visc_laplacian morris",
            "E, mixed": f"{paper} {REDUCED} -correction mixed -visc_laplacian morris"}


SERIES = {  # name: options
    **models(PAPER),
    "wcsph": "-scheme wcsph -progress none",
    "projection": "-scheme projection -progress none",
}
DUMMIES = models(parts.PAPER)  # walls with the pressure of the particle that reads them
CONTINUITY = parts.PAPER.replace("-density_form summation", "-density_form continuity -density_diffusion 0")
READINGS = {  # readings of the paper's settings, model E with shepard, Re = 100
    "as in all runs": SERIES["E, shepard"],
    "density by continuity": f"{CONTINUITY} {REDUCED} -correction shepard -visc_laplacian morris",
    "walls with the pressure of the particle": DUMMIES["E, shepard"],
    "no pressure reduction": f"{PAPER} -pressure_reduction none -correction shepard -visc_laplacian morris",
    "particles on the walls too": SERIES["E, shepard"] + " -wall_surface 1",
    "midpoint, acoustic CFL 0.1": SERIES["E, shepard"] + " -wcsph_ts_rk_type midpoint",
    "half the step": SERIES["E, shepard"] + " -acoustic_cfl 0.25",
}
READING_END = 2.5
# At the paper's resolution and to its times
LONG_N, LONG_ENDS, LONG_SECONDS = 50, {100: 20.0, 1000: 80.0}, 1800.0
LONG_TIMES = {reynolds: [end * k / 20 for k in range(1, 21)] for reynolds, end in LONG_ENDS.items()}
LASTING = ("D, shepard", "C, shepard", "E, shepard", "A, shepard", "B, shepard")
LONG = ("wcsph", "projection", *LASTING)
FEW_SECONDS = 600.0  # of a run with N by N particles to the times of the paper


def cavity(run, options, reynolds):
    """Returns a run to the end of its Reynolds number."""
    return run(f"-case cavity -n {N} -reynolds {reynolds} {options} {parts.times(TIMES[reynolds])}",
               f"{POINTS} -probe_every {ENDS[reynolds]:g}")


def reading(run, options):
    """Returns a run at Re = 100 to a quarter of the way."""
    ends = [t for t in TIMES[100] if t <= READING_END]
    return run(f"-case cavity -n {N} -reynolds 100 {options} {parts.times(ends)}")


def long(run, name, reynolds, n=LONG_N):
    """Returns a run with the paper's number of particles, or another, to its time."""
    run.seconds = LONG_SECONDS if n == LONG_N else FEW_SECONDS
    q = run(f"-case cavity -n {n} -reynolds {reynolds} {SERIES[name]} {parts.times(LONG_TIMES[reynolds])}",
            f"{POINTS} -probe_every {LONG_ENDS[reynolds]:g}")
    run.seconds = SECONDS
    return q


def plan(run):
    """Makes all runs, the most telling first."""
    first = ["E, shepard", "wcsph", "projection", "B, shepard", "D, shepard", "E, none", "A, shepard", "C, shepard", "E, mixed"]
    for reynolds in ENDS:
        for name in first:
            cavity(run, SERIES[name], reynolds)
        for options in READINGS.values():
            reading(run, options)
    for name in LASTING:
        long(run, name, 1000, N)
    for reynolds in (1000, 100):
        for name in LONG:
            long(run, name, reynolds)
