"""commandline.py SOURCE COMMAND... - requests that need no run, and options files that are good

Usage and versions are printed once, whatever the number of ranks, with exit status 0.
"""
import re
import subprocess
import sys

source, command = sys.argv[1], sys.argv[2:]


def isph(*arguments):
    """Returns the output of isph; asserts that its exit status is 0 and stderr is empty."""
    done = subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, (arguments, done.returncode, done.stdout, done.stderr)
    assert not done.stderr, (arguments, done.stderr)
    return done.stdout


usage = isph()
assert usage.count("usage: isph") == 1, usage
assert 10 <= len(usage.splitlines()) <= 16, usage
for option in ("-help", "-catalogue", "-version"):
    assert option in usage, option

for words in (["-version"], ["--version"], ["-n", "abc", "-version"]):
    version = isph(*words)
    for line in (r"isph \d+\.\d+\.\d+", r"PETSc \d+\.\d+\.\d+", r"hypre ", r"HDF5 \d+\.\d+\.\d+"):
        assert len(re.findall("^" + line, version, re.M)) == 1, (line, version)

banner = isph("-options_file", f"{source}/tests/options_files/good.opts")
assert re.search(r"^case +scene", banner, re.M) and re.search(r"^particles +256 fluid", banner, re.M), banner
banner = isph("-options_file", f"{source}/tests/options_files/good.yaml")
assert re.search(r"^case +cavity", banner, re.M) and re.search(r"^particles +256 fluid", banner, re.M), banner
