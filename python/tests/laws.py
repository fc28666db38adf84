"""Laws that the tests share."""

from __future__ import annotations

import timegap


def two_seconds(q: timegap.Question) -> float:
    """Keeps a time gap of two seconds, m/s²."""
    free = 0.4 * (q.set_speed_mps - q.speed_mps)
    follow = 0.2 * (q.gap_m - 5.0 - 2.0 * q.speed_mps) + 0.7 * q.relative_speed_mps
    return min(free, follow)


class Counting:
    """Remembers how often it was asked since it was told to forget."""

    def __init__(self) -> None:
        self.asked = 0
        self.resets = 0

    def reset(self) -> None:
        self.asked = 0
        self.resets += 1

    def __call__(self, q: timegap.Question) -> float:
        self.asked += 1
        return two_seconds(q)
