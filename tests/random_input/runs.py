"""Runs of isph with limits on time, memory and files, and the judgement of a run."""
import csv
import os
import re
import resource
import shlex
import signal
import subprocess

from starter import Starter

MEMORY = 4 << 30  # bytes of address space; not under AddressSanitizer, which reserves terabytes
FINDINGS = ("crash", "hang", "sanitizer", "not finite", "refusal", "balance")


def environment(folder):
    """Returns an environment in which MPI starts no daemon and writes into the folder."""
    kept = {name: text for name, text in os.environ.items() if not name.startswith("PETSC_")}
    sanitizer = {"ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "print_stacktrace=1"}
    return {**sanitizer, **kept, "HOME": folder, "OMP_NUM_THREADS": "1", "OMPI_MCA_ess_singleton_isolated": "1",
            "OMPI_MCA_orte_tmpdir_base": folder}


def sanitized(isph):
    """Returns true for a program under AddressSanitizer, which reserves more memory than a limit allows."""
    with open(isph, "rb") as file:
        return b"__asan_init" in file.read()


def limits(memory):
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 30, 1 << 30))
    if memory:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def starter(program, memory):
    """Returns a starter of runs with limits."""
    return Starter(program, env=environment(os.getcwd()), preexec_fn=lambda: limits(memory))


def execute(command, folder, seconds, memory, start=None):
    """Returns status, standard output and standard error; the status None after a timeout. With a starter, the run is
    a child of it."""
    if start:
        changed = {name: folder for name in ("HOME", "OMPI_MCA_orte_tmpdir_base")}
        status, *texts = start.run(command[1:], folder, changed, seconds)
        return status, *(text.decode(errors="replace") for text in texts)
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


def unbalanced(folder, out):
    """Returns a line about a balance out of its bound of which the run does not say so, or which it trusts, or None."""
    path = os.path.join(folder, "report.csv")
    if not os.path.isfile(path):
        return None
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        last = {row["quantity"]: float(row["value"] or "nan") for row in csv.DictReader(file) if row.get("value")}
    kinds = [line.partition(" not kept: ")[2] for line in out.splitlines() if " not kept: " in line]
    velocity = [kind for kind in kinds if not kind.startswith(("forces ", "torques "))]  # forces may err alone
    trusted = last.get("trust") == 1.0 and (velocity or not kinds)
    if last.get("balance", 0.0) > 1.0 and (trusted or " not kept: " not in out):
        return f"balance {last['balance']:.3g} of its bound, " + ("with trust 1" if trusted else "without a word")
    return None


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
        if strange:
            return "not finite", strange
        wrong = None if reported else unbalanced(folder, out)
        return ("balance", wrong) if wrong else None
    if len(lines) != 1 or not lines[0].startswith("isph: "):
        return "refusal", f"status {status} with {len(lines)} lines: {err[:200]!r}"
    return None


def quoted(word):
    """Returns a word for the shell, in printable characters."""
    if word.isascii() and word.isprintable():
        return shlex.quote(word)
    text = "".join(chr(b) if 32 <= b < 127 and chr(b) not in "'\\" else f"\\x{b:02x}" for b in os.fsencode(word))
    return f"$'{text}'"
