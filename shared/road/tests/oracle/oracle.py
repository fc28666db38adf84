"""Makes pieces.csv and points.csv: roads of our own, evaluated by libraries that are not ours.

Clothoids, arcs and lines by pyclothoids 0.2.0, cubics by scipy 1.17 (quad for the arc length, brentq for its inverse):

    python3 -m venv venv && venv/bin/pip install numpy scipy pyclothoids && venv/bin/python oracle.py

200 roads of one piece, then 20 of many. A point is (p, l) of the road and x, y, heading in the plane.
"""

import csv
import math

import numpy as np
from pyclothoids import Clothoid
from scipy.integrate import quad
from scipy.optimize import brentq

rng = np.random.default_rng(20261126)


class Clothoids:
    """Line, arc or spiral from a pose."""

    def __init__(self, pose, length, start, end):
        self.length, self.pose = length, pose
        self.curve = Clothoid.StandardParams(*pose, start, (end - start) / length, length)

    def at(self, q):
        return self.curve.X(q), self.curve.Y(q), self.curve.Theta(q)


class Cubic:
    """u(t), v(t) from a pose: the tangent at t = 0 is the pose's."""

    def __init__(self, pose, length, u, v):
        self.length, self.pose = length, pose
        self.u, self.v = np.polynomial.Polynomial(u), np.polynomial.Polynomial(v)
        self.du, self.dv = self.u.deriv(), self.v.deriv()

    def arc(self, t):
        return quad(lambda t: math.hypot(self.du(t), self.dv(t)), 0, t, epsabs=1e-12, limit=500)[0]

    def at(self, q):
        top = 1.0
        while self.arc(top) < q:
            top *= 2.0
        t = brentq(lambda t: self.arc(t) - q, 0.0, top, xtol=1e-14) if q > 0 else 0.0
        x, y, h = self.pose
        first = math.atan2(self.dv(0), self.du(0))
        turn = h - first
        a, b = self.u(t) - self.u(0), self.v(t) - self.v(0)
        return (
            x + a * math.cos(turn) - b * math.sin(turn),
            y + a * math.sin(turn) + b * math.cos(turn),
            math.atan2(self.dv(t), self.du(t)) + turn,
        )


def curvature(most):
    return float(rng.uniform(-most, most))


def piece(kind, before):
    """The numbers of a random piece: kind, length, and up to nine more."""
    length = float(rng.uniform(5, 300))
    if kind == "line":
        return [kind, length]
    if kind == "arc":
        return [kind, length, curvature(min(0.05, 1.5 / length))]
    if kind == "spiral":
        end = curvature(min(0.05, 1.5 / length))
        return [kind, length, before, end]
    # Cubics of moderate slope, as roads have them.
    length = float(rng.uniform(30, 120))
    bend, twist = curvature(0.15 / length), curvature(0.15 / length**2)
    slope, lift = curvature(0.1), curvature(1.0)
    if kind == "cubic":
        return [kind, length, lift, slope, bend, twist]
    end = 1.0 if rng.uniform() < 0.5 else length
    s = length / end
    u = [curvature(1.0), s, 0.05 * curvature(0.3 / length) * s**2, 0.1 * curvature(0.3 / length**2) * s**3]
    v = [lift, slope * s, bend * s**2, twist * s**3]
    true = Cubic((0, 0, 0), length, u, v).arc(end)
    return [kind, true, *u, *v, end]


def laid(numbers, pose):
    kind, length, *rest = numbers
    if kind == "line":
        return Clothoids(pose, length, 0.0, 0.0)
    if kind == "arc":
        return Clothoids(pose, length, rest[0], rest[0])
    if kind == "spiral":
        return Clothoids(pose, length, rest[0], rest[1])
    if kind == "cubic":
        return Cubic(pose, length, [0.0, 1.0], rest)
    return Cubic(pose, length, rest[:4], rest[4:8])


def end_curvature(numbers):
    return {"arc": numbers[2:3], "spiral": numbers[3:4]}.get(numbers[0], [0.0])[0]


def road(kinds):
    pieces, before = [], 0.0
    for kind in kinds:
        pieces.append(piece(kind, before))
        before = end_curvature(pieces[-1])
    return pieces


def main():
    kinds = ["spiral", "cubic", "param-cubic", "spiral", "arc"]
    roads = [road([kinds[i % len(kinds)]]) for i in range(200)]
    for _ in range(20):
        roads.append(road(["line", *rng.choice(["line", "arc", "spiral", "spiral", "cubic", "param-cubic"], 9)]))
    with open("pieces.csv", "w", newline="") as file:
        write = csv.writer(file, lineterminator="\n")
        write.writerow(["road", "kind", "length_m"] + [f"c{i}" for i in range(9)])
        for number, pieces in enumerate(roads):
            for numbers in pieces:
                row = [number, numbers[0]] + [repr(float(x)) for x in numbers[1:]]
                write.writerow(row + [""] * (12 - len(row)))
    with open("points.csv", "w", newline="") as file:
        write = csv.writer(file, lineterminator="\n")
        write.writerow(["road", "p_m", "l_m", "x_m", "y_m", "heading_rad"])
        for number, pieces in enumerate(roads):
            pose, start = (0.0, 0.0, 0.0), 0.0
            for numbers in pieces:
                part = laid(numbers, pose)
                for share in [*rng.uniform(0.02, 0.98, 3), 1.0]:
                    q = float(share) * part.length
                    x, y, h = part.at(q)
                    l = float(rng.choice([0.0, 3.5, -3.5, -7.0]))
                    row = [start + q, l, x - l * math.sin(h), y + l * math.cos(h), h]
                    write.writerow([number] + [f"{value:.10f}" for value in row])
                pose, start = part.at(part.length), start + part.length


if __name__ == "__main__":
    main()
