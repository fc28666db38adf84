"""Writes own.xodr, roads of our own, and two tables of its lines.

    python3 -m venv venv && venv/bin/pip install numpy scipy pyclothoids carla==0.9.16 && venv/bin/python roads.py
    venv/bin/python roads.py FILE.xodr ...          # lanes.csv for other files, on the standard output
    venv/bin/python roads.py --lines FILE.xodr ...  # lines.csv for other files, likewise

lanes.csv has the middles of the lanes by CARLA's reader, which computes in single precision: expect 0.6 mm. lines.csv has
the reference line (`r`), the line of lane 0 and the outer line of each other lane, by pyclothoids and scipy from the
file's own numbers. A line of both tables: file, road, lane, s along the road, x, y.
"""

import csv
import math
import re
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from scipy.optimize import brentq

sys.path.insert(0, str(Path(__file__).parent / "../../../road/tests/oracle"))
from oracle import Clothoids, Cubic  # noqa: E402


def geometry(kind, pose, s, length, numbers):
    """A geometry as text, with the pose of its end."""
    x, y, h = map(float, pose)
    length, numbers = float(length), [float(value) for value in numbers]
    number = lambda names: " ".join(f'{n}="{v!r}"' for n, v in zip(names, numbers))
    if kind == "line":
        part, text = Clothoids(pose, length, 0.0, 0.0), "<line/>"
    elif kind == "arc":
        part, text = Clothoids(pose, length, numbers[0], numbers[0]), f"<arc {number(['curvature'])}/>"
    elif kind == "spiral":
        part, text = Clothoids(pose, length, *numbers), f"<spiral {number(['curvStart', 'curvEnd'])}/>"
    elif kind == "poly3":
        part, text = Cubic(pose, length, [0.0, 1.0], list(numbers)), f"<poly3 {number('abcd')}/>"
    else:
        names = ["aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV"]
        part = Cubic(pose, length, list(numbers[:4]), list(numbers[4:]))
        # Without the attribute the standard says: normalized.
        kind_of = ' pRange="arcLength"' if kind == "arcLength" else ""
        text = f"<paramPoly3 {number(names)}{kind_of}/>"
    head = f'<geometry s="{s!r}" x="{x!r}" y="{y!r}" hdg="{h!r}" length="{length!r}">'
    return f"  {head}{text}</geometry>", part.at(length)


def true_length(u, v, end):
    return Cubic((0, 0, 0), 1.0, list(u), list(v)).arc(end)


def plan(pose, pieces):
    lines, s = [], 0.0
    for kind, length, *numbers in pieces:
        text, pose = geometry(kind, pose, s, float(length), [float(n) for n in numbers])
        lines.append(text)
        s += float(length)
    return "\n".join(lines), s, pose


def lane(id, width, before=None, after=None, kind="driving"):
    link = "".join(
        f'<{name} id="{to}"/>' for name, to in (("predecessor", before), ("successor", after)) if to is not None
    )
    widths = "".join(
        f'<width sOffset="{s}" a="{a}" b="{b}" c="{c}" d="{d}"/>' for s, a, b, c, d in width
    )
    return f'<lane id="{id}" type="{kind}"><link>{link}</link>{widths}</lane>'


def section(s, left, right):
    side = lambda name, lanes: f"<{name}>{''.join(lanes)}</{name}>" if lanes else ""
    middle = '<center><lane id="0" type="none"/></center>'
    return f'  <laneSection s="{s}">{side("left", left)}{middle}{side("right", right)}</laneSection>'


def road(id, length, view, lanes, link="", heights=""):
    return (
        f'<road id="{id}" junction="-1" length="{length!r}">\n<link>{link}</link>\n<planView>\n{view}\n</planView>\n'
        f"<elevationProfile>{heights}</elevationProfile>\n<lanes>\n{lanes}\n</lanes>\n</road>"
    )


def own():
    """Three roads in a row, 1, 2 and 3; the second has its reference line the other way."""
    three = [(0, 3.5, 0, 0, 0)]
    u = (0.0, 60.0, 0.0, -1.5)
    v = (0.0, 0.0, 6.0, -2.0)
    first = [
        ("line", 80), ("spiral", 60, 0, 0.004), ("arc", 120, 0.004), ("spiral", 70, 0.004, -0.002),
        ("normalized", true_length(u, v, 1.0), *u, *v),
    ]
    view, length1, pose = plan((100.0, -50.0, 0.7), first)
    lanes = "\n".join([
        '  <laneOffset s="0" a="0.2" b="0" c="0" d="0"/>'
        '<laneOffset s="150" a="0.2" b="0" c="0.0009" d="-0.000012"/><laneOffset s="200" a="0.95" b="0" c="0" d="0"/>',
        section(0, [lane(1, three, None, 1)], [lane(-1, three, None, -1), lane(-2, [(0, 3.2, 0, 0, 0)], None, -2)]),
        section(150, [lane(1, three, 1, 1)], [
            lane(-1, [(0, 3.5, 0, 0, 0), (60, 3.5, 0, 0.0002, 0)], -1, -1),
            lane(-2, [(0, 3.2, 0, 0, 0)], -2, -2),
            lane(-3, [(0, 0, 0, 0.0036, -0.000048), (50, 3, 0, 0, 0)], None, -3),
        ]),
        section(300, [lane(1, three, 1, -1)], [
            lane(-1, [(0, 5.12, 0, 0, 0)], -1, 1), lane(-2, [(0, 3.2, 0, 0, 0)], -2, 2),
            lane(-3, [(0, 3, -0.02, 0, 0)], -3, None),
        ]),
    ])
    heights = '<elevation s="0" a="5" b="0.01" c="0" d="0"/><elevation s="200" a="7" b="0.01" c="-0.0001" d="0"/>'
    roads = [road(1, length1, view, lanes, '<successor elementType="road" elementId="2" contactPoint="end"/>', heights)]
    # Road 2 ends where road 1 ends: it is laid backwards from there.
    p = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0012, -0.000008)
    arc_u, arc_v = p[:4], p[4:]
    second = [("poly3", 90, 0.0, 0.0, 0.0008, -0.000006), ("arcLength", true_length(arc_u, arc_v, 80.0), *p)]
    second[1] = ("arcLength", 80.0, *scaled(arc_u, arc_v, 80.0))
    _, length2, end = plan((0.0, 0.0, 0.0), second)
    turn = pose[2] + math.pi - end[2]
    x = pose[0] - end[0] * math.cos(turn) + end[1] * math.sin(turn)
    y = pose[1] - end[0] * math.sin(turn) - end[1] * math.cos(turn)
    view, length2, _ = plan((x, y, turn), second)
    lanes = "\n".join([
        '  <laneOffset s="0" a="-0.95" b="0" c="0" d="0"/>',
        section(0, [lane(1, [(0, 5.12, 0, 0, 0)], -1, -1), lane(2, [(0, 3.2, 0, 0, 0)], -2, -2)], [lane(-1, three, 1, 1)]),
    ])
    link = '<predecessor elementType="road" elementId="3" contactPoint="start"/>' \
        '<successor elementType="road" elementId="1" contactPoint="end"/>'
    roads.append(road(2, length2, view, lanes, link))
    view, length3, _ = plan((x, y, turn + math.pi), [("line", 40), ("spiral", 50, 0, -0.01), ("arc", 60, -0.01)])
    lanes = "\n".join([
        '  <laneOffset s="0" a="0.95" b="-0.01" c="0" d="0"/>',
        section(0, [lane(1, three, -1)], [lane(-1, [(0, 5.12, 0, 0, 0)], 1), lane(-2, [(0, 3.2, 0, 0, 0)], 2)]),
    ])
    roads.append(road(3, length3, view, lanes, '<predecessor elementType="road" elementId="2" contactPoint="start"/>'))
    head = '<OpenDRIVE>\n<header revMajor="1" revMinor="6" name="own" north="0" south="0" east="0" west="0"/>\n'
    return head + "\n".join(roads) + "\n</OpenDRIVE>\n"


def scaled(u, v, end):
    """A cubic whose true length is the length of its parameter."""
    share = end / true_length(u, v, end)
    return tuple(share * c for c in (*u, *v))


def table(path):
    import carla

    text = path.read_text()
    there = carla.Map(path.stem, re.sub(r'encoding="[^"]*"', "", text))
    for road in ET.fromstring(text.encode()).iter("road"):
        length = float(road.get("length"))
        sections = road.find("lanes").findall("laneSection")
        ends = [float(s.get("s")) for s in sections[1:]] + [length]
        for one, end in zip(sections, ends):
            start = float(one.get("s"))
            for side in ("left", "right"):
                for lane in one.findall(f"{side}/lane"):
                    for k in range(12):
                        s = start + (end - start) * (k + 0.37) / 12
                        here = there.get_waypoint_xodr(int(road.get("id")), int(lane.get("id")), s)
                        if here is not None:
                            at = here.transform.location
                            yield [path.name, road.get("id"), lane.get("id"), repr(s), f"{at.x:.6f}", f"{-at.y:.6f}"]


class Piece:
    """A geometry of a file: place and heading at a distance from its start."""

    def __init__(self, element):
        number = lambda name: float(element.get(name))
        self.s, self.length = number("s"), number("length")
        self.pose = number("x"), number("y"), number("hdg")
        shape = next(child for child in element if child.tag != "userData")
        get = lambda name: float(shape.get(name))
        self.curve = None
        if shape.tag == "line":
            self.curve = Clothoids(self.pose, self.length, 0.0, 0.0)
        elif shape.tag == "arc":
            self.curve = Clothoids(self.pose, self.length, get("curvature"), get("curvature"))
        elif shape.tag == "spiral":
            self.curve = Clothoids(self.pose, self.length, get("curvStart"), get("curvEnd"))
        else:
            u, v = [0.0, 1.0], []
            if shape.tag == "poly3":
                v = [get(n) for n in "abcd"]
            else:
                u, v = ([get(n + side) for n in "abcd"] for side in "UV")
            self.cubic = Cubic((0.0, 0.0, 0.0), self.length, u, v)
            if shape.tag == "poly3":
                self.share = 1.0
            else:
                # The whole parameter's range has the declared length.
                end = self.length if shape.get("pRange") == "arcLength" else 1.0
                self.share = self.cubic.arc(end) / self.length

    def at(self, s):
        q = s - self.s
        if self.curve:
            return self.curve.at(q)
        cubic, way = self.cubic, (s - self.s) * self.share
        top = 1.0
        while cubic.arc(top) < way:
            top *= 2.0
        t = brentq(lambda t: cubic.arc(t) - way, 0.0, top, xtol=1e-14) if way > 0 else 0.0
        x, y, h = self.pose
        u, v = cubic.u(t), cubic.v(t)
        heading = h + math.atan2(cubic.dv(t), cubic.du(t))
        return x + u * math.cos(h) - v * math.sin(h), y + u * math.sin(h) + v * math.cos(h), heading


def value(elements, key, s):
    """Value at s of a list of cubics, each from its own start on; 0 before the first."""
    begun = [e for e in elements if float(e.get(key)) <= s + 1e-12]
    if not begun:
        return 0.0
    last = max(begun, key=lambda e: float(e.get(key)))
    d = s - float(last.get(key))
    return sum(float(last.get(n)) * d**k for k, n in enumerate("abcd"))


def lines(path):
    """The reference line, lane 0 and the outer line of each lane, at twelve places of each section."""
    for road in ET.fromstring(path.read_bytes()).iter("road"):
        pieces = [Piece(element) for element in road.find("planView")]
        length = float(road.get("length"))
        offsets = road.find("lanes").findall("laneOffset")
        sections = road.find("lanes").findall("laneSection")
        ends = [float(s.get("s")) for s in sections[1:]] + [length]
        for one, end in zip(sections, ends):
            start = float(one.get("s"))
            for k in range(12):
                s = start + (end - start) * (k + 0.37) / 12
                piece = max((p for p in pieces if p.s <= s), key=lambda p: p.s)
                x, y, heading = piece.at(s)
                row = lambda lane, t: [
                    path.name, road.get("id"), lane, repr(s),
                    f"{x - t * math.sin(heading):.6f}", f"{y + t * math.cos(heading):.6f}",
                ]
                middle = value(offsets, "s", s)
                yield row("r", 0.0)
                yield row("0", middle)
                for side, sign in (("left", 1), ("right", -1)):
                    t = middle
                    lanes = one.findall(f"{side}/lane")
                    for lane in sorted(lanes, key=lambda lane: abs(int(lane.get("id")))):
                        borders = lane.findall("border")
                        if borders and not lane.findall("width"):
                            t = middle + sign * abs(value(borders, "sOffset", s - start))
                        else:
                            t += sign * value(lane.findall("width"), "sOffset", s - start)
                        yield row(lane.get("id"), t)


if __name__ == "__main__":
    if len(sys.argv) > 1 and sys.argv[1] == "--lines":
        write = csv.writer(sys.stdout, lineterminator="\n")
        for name in sys.argv[2:]:
            write.writerows(lines(Path(name)))
    elif len(sys.argv) > 1:
        write = csv.writer(sys.stdout, lineterminator="\n")
        for name in sys.argv[1:]:
            write.writerows(table(Path(name)))
    else:
        folder = Path(__file__).parent
        (folder / "own.xodr").write_text(own())
        with open(folder / "lanes.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table(folder / "own.xodr"))
        with open(folder / "lines.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(lines(folder / "own.xodr"))
