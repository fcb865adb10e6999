"""Finds a Python interpreter that has the modules of a test."""
import os
import subprocess
import sys


def python_with(modules):
    """Restarts the test with an interpreter that has the modules, which the first python3 of the PATH may lack; without
    one, ends it as skipped."""
    for python in sys.executable, "/usr/bin/python3":
        found = subprocess.run([python, "-c", f"import {modules}"], capture_output=True, check=False).returncode == 0
        if found and python != sys.executable:
            os.execv(python, [python, *sys.argv])
        if found:
            return
    print(f"no Python has {modules}: not tested")
    sys.exit(77)
