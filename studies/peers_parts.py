"""Comparison of runs by error and CPU time, for studies/peers and studies/peers_free."""
from typing import NamedTuple


class Point(NamedTuple):
    cpu: float
    error: float
    run: NamedTuple  # with its line of arguments
    row: dict


def of_code(some, word):
    return [point for point in some if point.run.arguments.split()[0] == word]


def cheapest(some, level):
    """Returns the cheapest point with an error of at most `level`, or None."""
    return min((point for point in some if point.error <= level), default=None, key=lambda point: point.cpu)


def best(some):
    """Returns the cheapest of the settings within 2 % of the smallest error."""
    return cheapest(some, 1.02 * min(point.error for point in some)) if some else None


def percent(error):
    return f"{100 * error:.2g} %"
