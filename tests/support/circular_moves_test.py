#!/usr/bin/env python3
"""Circular moves of corrected programs, driven by a controller of its own: it moves the TCP on the circle through three
points of its nominal model, and a true arm follows its joint angles. With --spacing-mm the true TCP has to stay on the
programmed circle. The tool turns evenly about one axis or, by RAPID, relative to the tangent. Nothing here shares code
with armtrue.

    circular_moves_test.py BIN [--figures]
"""

import math
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True

import robot_programs_test as programs
import straight_moves_test as straight
import virtual_cell as vc

BIN = None
SPACING_MM = 0.01
ARCS = 2
RADIUS_MM = {"krl": 300, "rapid": 90, "urscript": 180, "fanuc": 300}


class Arc:
    """From start through via to end, poses of the TCP in R_0; the orientation of via counts for nothing."""

    def __init__(self, start, via, end, with_path):
        self.start, self.end, self.with_path = start, end, with_path
        a, b = vc.sub(via[1], start[1]), vc.sub(end[1], start[1])
        normal = vc.cross(a, b)
        square = vc.dot(normal, normal)
        to_centre = vc.scaled(vc.add(vc.scaled(vc.cross(b, normal), vc.dot(a, a)), vc.scaled(vc.cross(normal, a), vc.dot(b, b))),
                              1 / (2 * square))
        self.centre, self.radius = vc.add(start[1], to_centre), vc.length(to_centre)
        self.normal = vc.scaled(normal, 1 / math.sqrt(square))
        self.x = vc.scaled(to_centre, -1 / self.radius)
        self.y = vc.cross(self.normal, self.x)
        self.angle = self.turned_to(end[1])

    def turned_to(self, point):
        away = vc.sub(point, self.centre)
        return math.atan2(vc.dot(self.y, away), vc.dot(self.x, away)) % (2 * math.pi)

    def at(self, t):
        here = vc.add(vc.scaled(self.x, math.cos(t * self.angle)), vc.scaled(self.y, math.sin(t * self.angle)))
        along = lambda share: vc.about(self.normal, share * self.angle) if self.with_path else vc.NONE[0]
        end = vc.rotation_times(vc.transposed(along(1)), self.end[0])
        turn = programs.rotation_vector(vc.rotation_times(vc.transposed(self.start[0]), end))
        size = vc.length(turn)
        rotation = vc.rotation_times(self.start[0], vc.about(vc.scaled(turn, 1 / size), t * size))
        return vc.rotation_times(along(t), rotation), vc.add(self.centre, vc.scaled(here, self.radius))

    def off(self, pose):
        """Distance of a pose from the circle [mm], and from the orientation that belongs there [mrad]."""
        error = programs.difference(self.at(self.turned_to(pose[1]) / self.angle), pose)
        return vc.length(error[:3]), 1000 * vc.length(error[3:])


def joints_along(arm, way, tool, q, count):
    found = []
    for k in range(1, count + 1):
        q = programs.joints_at(arm, vc.after(way.at(k / count), programs.inverse(tool)), q)
        found.append(q)
    return found


def arcs_of(cell, dialect):
    """Joint angles of the start and of the two points of each arc, which the nominal arm can drive far from singular
    postures, and the arcs."""
    tool, uniform = cell.tools[0], cell.rng.uniform
    while True:
        q = cell.posture(*straight.POSTURES[dialect])
        postures, start, arcs = [q], vc.after(cell.nominal.pose(q), tool), []
        try:
            for _ in range(ARCS):
                u, v = random_plane(cell.rng)
                radius, sweep, share = RADIUS_MM[dialect] * uniform(0.6, 1), uniform(1.2, 2.4), uniform(0.35, 0.65)
                on_circle = lambda a: vc.add(start[1], vc.scaled(vc.sub(vc.add(vc.scaled(u, math.cos(a)),
                                                                              vc.scaled(v, math.sin(a))), u), radius))
                turn = vc.small_motion([uniform(-0.2, 0.2) for _ in range(3)], vc.NONE[1], vc.NONE[1])[0]
                end = vc.rotation_times(turn, start[0]), on_circle(sweep)
                arc = Arc(start, (start[0], on_circle(share * sweep)), end, dialect == "rapid")
                along = joints_along(cell.nominal, arc, tool, postures[-1], 12)
                inside = all(low + 0.05 < a < high - 0.05 for q in along
                             for a, (low, high) in zip(q, cell.nominal.travel))
                if not inside or min(abs(math.sin(q[4])) for q in along) < 0.3:
                    raise AssertionError
                flange = vc.after(arc.at(share), programs.inverse(tool))
                via = programs.joints_at(cell.nominal, flange, along[round(12 * share) - 1])
                postures += [via, along[-1]]
                arcs.append(arc)
                start = end
            return postures, arcs
        except (AssertionError, ZeroDivisionError):
            continue


def random_plane(rng):
    """Two unit vectors at a right angle."""
    while True:
        u, w = ([rng.gauss(0, 1) for _ in range(3)] for _ in range(2))
        if vc.length(vc.cross(u, w)) > 0.1:
            u = vc.scaled(u, 1 / vc.length(u))
            v = vc.cross(u, w)
            return u, vc.scaled(v, 1 / vc.length(v))


def krl_program(cell, postures):
    base, tool = cell.bases[0], cell.tools[0]
    points = [programs.kuka_frame(cell, q, base, tool, k == 0) for k, q in enumerate(postures)]
    lines = ["DEF part( )", programs.kuka_setting("BASE", base), programs.kuka_setting("TOOL", tool), f"PTP {points[0]}",
             "CIRC XP1, XP2 C_DIS", f"SCIRC {points[3]}, {points[4]} WITH $VEL.CP=0.2"]
    return ("\r\n".join(lines + ["END", ""]),
            f"DEFDAT PART\r\nDECL E6POS XP1={points[1]}\r\nDECL E6POS XP2={points[2]}\r\nENDDAT\r\n")


def rapid_program(cell, postures):
    base, tool = cell.bases[0], cell.tools[0]
    points = [programs.robtarget(cell, q, base, tool) for q in postures]
    frames = "t0\\WObj:=w0;"
    lines = ["MODULE part", f"PERS tooldata t0:=[TRUE,[{programs.abb_pose(tool)}],[1,[0,0,1],[1,0,0,0],0,0,0]];",
             f'PERS wobjdata w0:=[FALSE,TRUE,"",[{programs.abb_pose(base)}],[[0,0,0],[1,0,0,0]]];',
             f"CONST robtarget p1:={points[1]};", f"CONST robtarget p2:={points[2]};", "PROC main()",
             f"MoveJ {points[0]},v100,fine,{frames}", f"  MoveC p1,p2,v100,z5,{frames}",
             f"MoveC {points[3]},{points[4]},v50,fine,{frames}", "ENDPROC", "ENDMODULE", ""]
    return "\n".join(lines), ""


def urscript_program(cell, postures):
    points = [programs.ur_pose(cell.written(q, vc.NONE, cell.tools[0])) for q in postures]
    joints = "[" + ",".join(f"{a:.9f}" for a in postures[0]) + "]"
    lines = ["def part():", f"  set_tcp({programs.ur_pose(cell.tools[0])})", f"  global p1={points[1]}",
             f"  global p2={points[2]}", f"  movej({joints}, a=1.4, v=1.05)", "  movec(p1, p2, a=1.2, v=0.25, r=0.005)",
             f"  movec({points[3]}, {points[4]}, 1.2, 0.25, 0, 0)", "end", ""]
    return "\n".join(lines), ""


def fanuc_program(cell, postures):
    positions = "".join(programs.fanuc_position(cell, k, q, 1, 1, k == 1) for k, q in enumerate(postures, 1))
    lines = ["J P[1] 100% FINE    ;", "C P[2]    \n    :  P[3:middle] 250mm/sec CNT50    ;",
             "C P[4]    \n    :  P[5] 250mm/sec FINE    ;"]
    moves = "".join(f"{n:4}:{line}\n" for n, line in enumerate(lines, 1))
    return f"/PROG  PART\n/ATTR\nLINE_COUNT\t= {len(lines)};\n/MN\n{moves}/POS\n{positions}/END\n", ""


def arc_of_each(pieces, arcs):
    """For each commanded piece the number of its arc: an arc ends at the command next to its end."""
    ends, first = [], 0
    for arc in arcs:
        first = min(range(first, len(pieces)), key=lambda i: vc.length(vc.sub(pieces[i].end[1], arc.end[1]))) + 1
        ends.append(first)
    if ends[-1] != len(pieces):
        raise AssertionError("the last command is not the last end")
    return [sum(i >= end for end in ends) for i in range(len(pieces))]


class CircularMoves(unittest.TestCase):
    def run_dialect(self, dialect, make):
        cell = programs.Cell(dialect, 12)
        postures, arcs = arcs_of(cell, dialect)
        text, dat = make(cell, postures)
        texts = straight.corrected(BIN, cell, dialect, text, dat, SPACING_MM)
        if dialect == "fanuc":
            straight.numbers_lines_on(self, texts[-1][0])
        straight.compare(self, (text, dat), texts, lambda of: self.largest(dialect, cell, of, postures, arcs),
                         f"{dialect}: off the circle", SPACING_MM)

    def largest(self, dialect, cell, texts, postures, arcs):
        """Largest distance from the circles, from their orientations, and how many pieces were added."""
        targets, tool = straight.interpreter(dialect, cell)(*texts), cell.tools[0]
        commanded = [vc.after(cell.nominal.pose(t.value), tool) if t.kind == "joints" else vc.after(t.base, t.value)
                     for t in targets]
        self.assertEqual(len(commanded) % 2, 1)
        pieces = [Arc(*commanded[k:k + 3], dialect == "rapid") for k in range(0, len(commanded) - 2, 2)]
        largest, turned, q = 0.0, 0.0, postures[0]
        for number, piece in zip(arc_of_each(pieces, arcs), pieces):
            along = joints_along(cell.nominal, piece, tool, q, 6)
            q = along[-1]
            for angles in along:
                off = arcs[number].off(vc.after(cell.true.pose(angles), tool))
                largest, turned = max(largest, off[0]), max(turned, off[1])
        return largest, turned, len(pieces) - ARCS

    def test_krl(self):
        self.run_dialect("krl", krl_program)

    def test_rapid(self):
        self.run_dialect("rapid", rapid_program)

    def test_urscript(self):
        self.run_dialect("urscript", urscript_program)

    def test_fanuc(self):
        self.run_dialect("fanuc", fanuc_program)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1], verbosity=0)
