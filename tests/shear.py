#!/usr/bin/env python3
"""Measures how fast the velocity filter damps a wave across a shear, theory.md, (filters:velocity) and (filters:shear).

    shear.py ISPH

Couette flow u = y carries the wave v = 1e-6 sin(pi y)^2 cos(k x) of the length 4 dx, and the velocity u' that frees it of divergence. In
a step dt the filter of strength S = 4 takes the share kappa D = 2 S dt g f from v, with the shear rate g = 1 and the
residual f of a quadratic fit of the wave. With S = 1 it has no such term, and k |A A|^(1/2) is below 2 dt g 0.005. So the amplitudes of
both runs at the time t have the ratio exp(-2 S g f t), whatever else happens to the wave: pressure on coarse points and the tilt
of the wave are the same. The share f is that of a wave along x. The envelope and the tilt make the wave number larger by up to 4 %, and f,
which is of its fourth power, by up to 15 %."""
import math
import re
import subprocess
import sys

N, LENGTH, RATIO, STRENGTH, END = 16, 4, 1.3, 4, 0.1
FLOW = (f"-case scene -scene_box 0,0,1,1 -scene_periodic x -scene_wall_top_velocity 1,0 -n {N} -viscosity 1e-6 -h_over_dx {RATIO} "
        f"-kernel wendland_c2 -pressure_points coarse -shift none -dt 0.01 -t_end {END} -progress none").split()
WAVE = 2 * math.pi * N / LENGTH  # wave number
START = (f"y + 1e-6*{math.pi / WAVE}*sin({WAVE}*x)*sin(2*pi*y), 0-1e-6*cos({WAVE}*x)*sin(pi*y)^2")


def residual():
    """Returns the residual of the quadratic fit of cos(k x) at a crest on a lattice. The weights of the fitted value are
    W (a + b r^2), which give 1 for the constant and 0 for x^2."""
    reach = range(-3, 4)
    points = [(x, x * x + y * y) for x in reach for y in reach if math.hypot(x, y) < 2 * RATIO]
    kernel = [(1 - 0.5 * q) ** 4 * (1 + 2 * q) for q in (math.sqrt(r2) / RATIO for _, r2 in points)]
    one, square = sum(kernel), sum(w * r2 for w, (_, r2) in zip(kernel, points))
    along, fourth = square / 2, sum(w * x * x * r2 for w, (x, r2) in zip(kernel, points))
    a = fourth / (one * fourth - square * along)
    b = -a * along / fourth
    return 1 - sum(w * (a + b * r2) * math.cos(2 * math.pi * x / LENGTH) for w, (x, r2) in zip(kernel, points))


def amplitude(isph, strength):
    """Returns the relative error of the velocity against the flow without the wave."""
    done = subprocess.run([isph, *FLOW, "-scene_velocity", START, "-scene_exact", "y, 0", "-velocity_filter", str(strength)],
                          capture_output=True, text=True, check=True)
    return float(re.search(r"^velocity_l2 +(\S+)", done.stdout, re.MULTILINE).group(1))


def main():
    found = -math.log(amplitude(sys.argv[1], STRENGTH) / amplitude(sys.argv[1], 1))
    exact = 2 * STRENGTH * residual() * END
    print(f"decay of the wave by the filter: {found:.4f}, of a wave along the flow {exact:.4f}")
    sys.exit(0 if 0.95 * exact < found < 1.15 * exact else 1)


if __name__ == "__main__":
    main()
