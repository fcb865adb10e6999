"""Flows of studies/peers and studies/peers_free for DualSPHysics: a column, a lid-driven cavity, a channel that starts.

Walls are `dynamic` (its dynamic boundary particles) or `no_slip` (modified ones, with density and velocity by mirrored points).
The lid's particles move with the velocity 1. The cavity and its walls are periodic along x, so that a particle of the lid that
leaves on the right comes back on the left; the fluid never meets its image, for the walls between them are eight rows thick.
"""
import math

import numpy as np
from dualsphysics import Case, points

WALL_ROWS = 4
COLUMN_SOUND = 10 * math.sqrt(2)  # ten times (2 g H)^(1/2)
WALLS = {"dynamic": {"Boundary": 1}, "no_slip": {"Boundary": 2, "SlipMode": 2}}
PERIODIC = {"XPeriodicIncZ": 0}


def column(n, share, times):
    """Returns the column of studies/peers_free, 1 wide and 1 high on a floor, with n particles along its height."""
    dx = 1 / n
    across = (np.arange(n) + 0.5) * dx
    return Case(dx, walls=points((np.arange(-2 * n, 2 * n) + 0.5) * dx, -(np.arange(WALL_ROWS) + 0.5) * dx),
                fluid=points(across - 0.5, across), nu=1, sound=COLUMN_SOUND, times=times, interval=times[0] / 2,
                parameters={"Shifting": 0}, gravity=(0, -1), share=share, domain=(-2, "default", 2, 1.5))


def cavity(n, reynolds, t_end, walls, shifting):
    """Returns the cavity of width and lid velocity 1; the last five outputs are 0.25 apart."""
    dx, t = 1 / n, t_end - 0.25 * np.arange(4, -1, -1)
    behind = -(np.arange(WALL_ROWS) + 0.5) * dx  # distances behind a surface
    inside = (np.arange(n) + 0.5) * dx
    across = (np.arange(-WALL_ROWS, n + WALL_ROWS) + 0.5) * dx
    fixed = np.concatenate([points(across, behind), points(np.concatenate([behind, 1 - behind]), inside)])
    lid = points(across, 1 - behind)
    nearest = np.concatenate([np.clip(fixed, 0, 1), np.stack([lid[:, 0], 0 * lid[:, 1], np.ones(len(lid))], axis=1)])
    return Case(dx, fixed, points(inside, inside), nu=1 / reynolds, sound=10, times=tuple(t), interval=0.25,
                parameters={**WALLS[walls], "Shifting": shifting, **PERIODIC}, share=0.125, lid=lid,
                normals=nearest - np.concatenate([fixed, lid]) if walls == "no_slip" else None)


def channel(n, reynolds, t_end, walls, shifting):
    """Returns the channel of width 1 and length 2, with the force that drives a parabola of largest velocity 1."""
    dx = 1 / n
    behind = -(np.arange(WALL_ROWS) + 0.5) * dx
    along, across = (np.arange(2 * n) + 0.5) * dx, (np.arange(n) + 0.5) * dx
    fixed = points(along, np.concatenate([behind, 1 - behind]))
    return Case(dx, fixed, points(along, across), nu=1 / reynolds, sound=10, times=(t_end,), interval=t_end,
                parameters={**WALLS[walls], "Shifting": shifting, **PERIODIC}, gravity=(8 / reynolds, 0), share=0.125,
                normals=fixed * (1, 1, 0) + np.clip(fixed, 0, 1) * (0, 0, 1) - fixed if walls == "no_slip" else None)


FLOWS = {"cavity": cavity, "channel": channel}
