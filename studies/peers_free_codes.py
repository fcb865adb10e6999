"""The runs of other codes for studies/peers_free, with the measures of both flows.

A run is a line of words: the code, the flow, and options of the code's driver. Its result is a dict of numbers, or of the
sentence `failed`. cpu_s is that of the time loop of PySPH, and of the whole program for DualSPHysics.
"""
import json
import os

import codes
import drop_mode
import dualsphysics
import dualsphysics_flows
import numpy as np

COLUMN_TIMES = (1, 2.5, 5)


def drop_measures(outputs):
    """Returns the error of the velocity at the last time, and that of the rate of decay from the kinetic energy."""
    energies, errors = [], []
    for x, y, u, v, t in zip(*(outputs[name] for name in "xyuv"), drop_mode.TIMES):
        inside = np.minimum(1, 1 / np.hypot(x, y))  # the exact flow ends at r = 1
        u_exact, v_exact = drop_mode.velocity(x * inside, y * inside, t)
        energies.append(np.mean(u * u + v * v))
        errors.append(np.sqrt(np.sum((u - u_exact)**2 + (v - v_exact)**2) / np.sum(u_exact**2 + v_exact**2)))
    return {"velocity_l2": errors[-1], "rate_error": rate_error(*energies)}


def rate_error(first, last):
    """Returns the relative error of the rate of decay, from the kinetic energies at both times."""
    return np.log(first / last) / (2 * (drop_mode.TIMES[1] - drop_mode.TIMES[0])) / drop_mode.RATE - 1


def column_measures(outputs, n):
    """Returns front and highest place; a particle is in the middle of its cell."""
    row = {}
    for x, y, t in zip(outputs["x"], outputs["y"], COLUMN_TIMES):
        when = "" if t == COLUMN_TIMES[-1] else f"@{t:g}"
        row.update({f"x_max{when}": np.max(x) + 0.5 / n, f"y_max{when}": np.max(y) + 0.5 / n})
    return row


def measures(flow, outputs, n):
    """Returns the measures of a flow, of which the last outputs are at its times."""
    if not all(np.isfinite(field).all() for fields in outputs.values() for field in fields):
        return {"failed": "a place or a velocity is no number"}
    last = {name: fields[-len(drop_mode.TIMES if flow == "drop" else COLUMN_TIMES):] for name, fields in outputs.items()}
    return drop_measures(last) if flow == "drop" else column_measures(last, n)


def run_pysph(words, folder):
    command = [codes.pysph_python(), os.path.join(codes.STUDIES, "pysph_run.py"), folder, *words]
    said, status, _ = codes.timed(command, folder)
    if status:
        return {"failed": "PySPH ended with an error: its particles left every bound" if "too many cells" in said
                or "Segmentation fault" in said else codes.end_of(said, status)["failed"]}
    with open(os.path.join(folder, "run.json")) as file:
        row = json.load(file)
    with np.load(os.path.join(folder, "run.npz")) as file:
        outputs = {name: file[name] for name in "xyuv"}
    return {**row, "particles": outputs["x"].shape[1], **measures(words[0], outputs, codes.option(words, "--nx", int))}


def run_dualsphysics(words, folder):
    n, share = codes.option(words, "-n", int), codes.option(words, "-share")
    case = dualsphysics_flows.column(n, share, COLUMN_TIMES)
    row, outputs = codes.dualsphysics_outputs(case, folder)
    return {**row, **measures(words[0], outputs, n)} if outputs else row


CODES = {  # by the first word of a run's arguments: function for the missing program, function for a run
    "pysph": (lambda: None if codes.pysph_python() else "no PySPH (Debian package python3-pysph)", run_pysph),
    "dualsphysics": (dualsphysics.absent, run_dualsphysics),
}
