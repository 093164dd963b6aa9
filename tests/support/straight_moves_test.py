#!/usr/bin/env python3
"""Straight moves of corrected programs, driven by a controller of its own: it moves the TCP on a line in its nominal model
from point to point, and a true arm follows its joint angles. With --spacing-mm the true TCP has to stay on the programmed
line. Nothing here shares code with armtrue.

    straight_moves_test.py BIN [--figures]
"""

import math
import pathlib
import re
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import robot_programs as rp
import robot_programs_test as programs
import virtual_cell as vc

BIN = None
SPACING_MM = 0.01
LINES = 3
STRIDE_MM = {"krl": 500, "rapid": 150, "urscript": 300, "fanuc": 500}
POSTURES = {"krl": ((-60, 60), (-90, -60), (60, 100), (-30, 30), (35, 70), (-90, 90)),
            "rapid": ((-60, 60), (-10, 30), (-30, 10), (-30, 30), (35, 70), (-90, 90)),
            "urscript": ((-60, 60), (-80, -50), (60, 90), (-60, -30), (50, 110), (-90, 90)),
            "fanuc": ((-60, 60), (0, 30), (-30, 10), (-30, 30), (-70, -35), (-90, 90))}


def part_of_way(start, end, t):
    """Straight in position, the rotation about one axis."""
    turn = vc.rotation_times(vc.transposed(start[0]), end[0])
    vector = programs.rotation_vector(turn)
    rotation = vc.rotation_times(start[0], vc.about(vc.scaled(vector, 1 / vc.length(vector)), t * vc.length(vector)))
    return rotation, vc.add(start[1], vc.scaled(vc.sub(end[1], start[1]), t))


def joints_along(arm, start, end, tool, q, count):
    """Joint angles at the points 1 to count of a straight way of the TCP."""
    found = []
    for k in range(1, count + 1):
        pose = part_of_way(start, end, k / count)
        q = programs.joints_at(arm, vc.after(pose, programs.inverse(tool)), q)
        found.append(q)
    return found


def corners(cell, dialect):
    """Joint angles of the corners of a polygon that the nominal arm can drive far from singular postures, and where the
    TCP is in R_0."""
    tool, uniform = cell.tools[0], cell.rng.uniform
    while True:
        q = cell.posture(*POSTURES[dialect])
        postures, places = [q], [vc.after(cell.nominal.pose(q), tool)]
        try:
            for _ in range(LINES):
                way = [uniform(-1, 1) for _ in range(3)]
                way = vc.scaled(way, STRIDE_MM[dialect] * uniform(0.6, 1) / vc.length(way))
                turn = vc.small_motion([uniform(-0.1, 0.1) for _ in range(3)], vc.NONE[1], vc.NONE[1])[0]
                end = vc.rotation_times(turn, places[-1][0]), vc.add(places[-1][1], way)
                along = joints_along(cell.nominal, places[-1], end, tool, postures[-1], 8)
                inside = all(low + 0.05 < a < high - 0.05 for q in along
                             for a, (low, high) in zip(q, cell.nominal.travel))
                if not inside or min(abs(math.sin(q[4])) for q in along) < 0.3:
                    raise AssertionError
                postures.append(along[-1])
                places.append(end)
            return postures, places
        except (AssertionError, ZeroDivisionError):
            continue


def krl_program(cell, postures):
    base, tool = cell.bases[0], cell.tools[0]
    points = [programs.kuka_frame(cell, q, base, tool) for q in postures]
    lines = ["DEF part( )", programs.kuka_setting("BASE", base), programs.kuka_setting("TOOL", tool), f"PTP {points[0]}",
             "$VEL.CP=0.2", "LIN XP1 C_DIS", f"LIN {points[2]}", ";FOLD wait", "WAIT SEC 0.5", ";ENDFOLD", f"SLIN {points[3]}"]
    return "\r\n".join(lines + ["END", ""]), f"DEFDAT PART\r\nDECL E6POS XP1={points[1]}\r\nENDDAT\r\n"


def rapid_program(cell, postures):
    base, tool = cell.bases[0], cell.tools[0]
    points = [programs.robtarget(cell, q, base, tool) for q in postures]
    frames = "t0\\WObj:=w0;"
    lines = ["MODULE part", f"PERS tooldata t0:=[TRUE,[{programs.abb_pose(tool)}],[1,[0,0,1],[1,0,0,0],0,0,0]];",
             f'PERS wobjdata w0:=[FALSE,TRUE,"",[{programs.abb_pose(base)}],[[0,0,0],[1,0,0,0]]];',
             f"CONST robtarget p1:={points[1]};", "PROC main()", f"MoveJ {points[0]},v100,fine,{frames}",
             f"  MoveL p1,v100,z5,{frames}", "SetDO do1,1;", f"MoveL {points[2]},v100,fine,{frames}",
             f"MoveL {points[3]},v50,z1,{frames}", "ENDPROC", "ENDMODULE", ""]
    return "\n".join(lines), ""


def urscript_program(cell, postures):
    base, tool = cell.bases[0], cell.tools[0]
    of_foot = [programs.ur_pose(cell.written(q, vc.NONE, tool)) for q in postures]
    of_plane = programs.ur_pose(cell.written(postures[2], base, tool))
    joints = "[" + ",".join(f"{a:.9f}" for a in postures[0]) + "]"
    lines = ["def part():", f"  set_tcp({programs.ur_pose(tool)})", f"  global plane={programs.ur_pose(base)}",
             f"  global p1={of_foot[1]}", f"  movej({joints}, a=1.4, v=1.05)", "  movel(p1, a=1.2, v=0.25, r=0.01)",
             "  set_digital_out(1, True)", f"  movel(pose_trans(plane, {of_plane}), a=1.2, v=0.25)",
             f"  movel({of_foot[3]}, 1.2, 0.25)", "end", ""]
    return "\n".join(lines), ""


def fanuc_program(cell, postures):
    positions = "".join(programs.fanuc_position(cell, k, q, 1, 1, k == 1) for k, q in enumerate(postures, 1))
    lines = ["J P[1] 100% FINE    ;", "L P[2:end] 250mm/sec CNT50    ;", "  DO[1]=ON ;", "L P[3] 250mm/sec FINE    ;",
             "L P[4] 30cm/min FINE    ;"]
    moves = "".join(f"{n:4}:{line}\n" for n, line in enumerate(lines, 1))
    return f"/PROG  PART\n/ATTR\nLINE_COUNT\t= {len(lines)};\n/MN\n{moves}/POS\n{positions}/END\n", ""


def interpreter(dialect, cell):
    return {"krl": rp.krl, "rapid": lambda src, dat: rp.rapid(src), "urscript": lambda src, dat: rp.urscript(src),
            "fanuc": lambda src, dat: rp.fanuc(src, {1: cell.bases[0]}, {1: cell.tools[0]})}[dialect]


def lines_of(commanded, places):
    """For each commanded way the number of the line that it belongs to: a corner is the command next to it."""
    corner_at = [0]
    for place in places[1:]:
        rest = range(corner_at[-1] + 1, len(commanded))
        corner_at.append(min(rest, key=lambda i: vc.length(vc.sub(commanded[i][1], place[1]))))
    if corner_at[-1] != len(commanded) - 1:
        raise AssertionError("the last command is not the last corner")
    return [line for line, (a, b) in enumerate(zip(corner_at, corner_at[1:])) for _ in range(b - a)]


def driven(cell, commanded, tool, q, samples):
    """For each commanded way the poses of the true TCP along it."""
    ways = []
    for start, end in zip(commanded, commanded[1:]):
        along = joints_along(cell.nominal, start, end, tool, q, samples)
        ways.append([vc.after(cell.true.pose(angles), tool) for angles in along])
        q = along[-1]
    return ways


def off_line(start, end, pose):
    """Distance of a pose from the line [mm], and from the orientation that belongs there [mrad]."""
    way, offset = vc.sub(end[1], start[1]), vc.sub(pose[1], start[1])
    t = vc.dot(way, offset) / vc.dot(way, way)
    meant = part_of_way(start, end, t)
    error = programs.difference(meant, pose)
    return vc.length(error[:3]), 1000 * vc.length(error[3:])


def off_lines(places, line, pose):
    """Distance from a line, or from its neighbour within some mm of the corner: there an inserted point may be nearer to the
    corner than the corrected corner itself."""
    lines = {line}
    for corner, neighbour in ((line, line - 1), (line + 1, line + 1)):
        if 0 <= neighbour < len(places) - 1 and vc.length(vc.sub(pose[1], places[corner][1])) < 8:
            lines.add(neighbour)
    return min(off_line(places[k], places[k + 1], pose) for k in lines)


def corrected(bin_folder, cell, dialect, text, dat, spacing_mm):
    """The program as compensate writes it: for the nominal arm; for the true arm, ends alone; and divided."""
    with tempfile.TemporaryDirectory() as folder:
        compensate = programs.Compensation(bin_folder, pathlib.Path(folder), cell, dialect, text, dat)
        spacing = "--spacing-mm", str(spacing_mm)
        return compensate("nominal.yaml", *spacing), compensate("true.yaml"), compensate("true.yaml", *spacing)


def compare(case, programmed, corrected_texts, largest, what, spacing_mm):
    """`largest`: of texts, the distance from the way, from its orientation, and the number of moves that were added."""
    same, ends_only, divided = corrected_texts
    case.assertEqual(same, programmed)
    before, after = largest(ends_only), largest(divided)
    if "--figures" in sys.argv:
        print(f"{what} {before[0]:.4f} mm, {before[1]:.4f} mrad; with {after[2]} more moves {after[0]:.4f} mm, "
              f"{after[1]:.4f} mrad")
    case.assertEqual(before[2], 0)
    case.assertGreater(before[0], 1.5 * spacing_mm)
    case.assertLess(after[0], 1.1 * spacing_mm + 0.002)
    case.assertLess(after[1], before[1])
    case.assertLess(after[2], 40)


def numbers_lines_on(case, text):
    """Lines of /MN are numbered from 1, and LINE_COUNT says how many."""
    numbers = [int(n) for n in re.findall(r"^ *(\d+):", text[:text.index("/POS")], re.M)]
    case.assertEqual(numbers, list(range(1, len(numbers) + 1)))
    case.assertIn(f"LINE_COUNT\t= {len(numbers)};", text)


class StraightMoves(unittest.TestCase):
    def run_dialect(self, dialect, make):
        cell = programs.Cell(dialect, 11)
        postures, places = corners(cell, dialect)
        text, dat = make(cell, postures)
        texts = corrected(BIN, cell, dialect, text, dat, SPACING_MM)
        if dialect == "fanuc":
            numbers_lines_on(self, texts[-1][0])
        compare(self, (text, dat), texts, lambda of: self.largest(dialect, cell, of, postures, places),
                f"{dialect}: off the line", SPACING_MM)

    def largest(self, dialect, cell, texts, postures, places):
        """Largest distance from the lines, from their orientations, and the number of points between corners."""
        targets = interpreter(dialect, cell)(*texts)
        tool = cell.tools[0]
        commanded = [vc.after(cell.nominal.pose(t.value), tool) if t.kind == "joints" else vc.after(t.base, t.value)
                     for t in targets]
        ways = driven(cell, commanded, tool, postures[0], 6)
        largest, turned = 0.0, 0.0
        for line, way in zip(lines_of(commanded, places), ways):
            for pose in way:
                off = off_lines(places, line, pose)
                largest, turned = max(largest, off[0]), max(turned, off[1])
        return largest, turned, len(ways) - LINES

    # A controller reduces the zone of a corner to half of the way to the next point.
    def test_corners_keep_their_zones(self):
        zones = {"krl": ("$VEL.CP=0.2", "$APO.CDIS={}\r\n$VEL.CP=0.2"),
                 "rapid": (",z5,", ",[FALSE,{0},9,9,1,9,1],"),
                 "urscript": ("r=0.01", "r={1}")}
        for dialect, (without, with_zone) in zones.items():
            cell, zone = programs.Cell(dialect, 11), STRIDE_MM[dialect] // 6
            postures, places = corners(cell, dialect)
            text, dat = globals()[dialect + "_program"](cell, postures)
            nearest = []
            for mm in (1, zone):
                zoned = text.replace(without, with_zone.format(mm, mm / 1000))
                targets = interpreter(dialect, cell)(*corrected(BIN, cell, dialect, zoned, dat, SPACING_MM / 5)[-1])
                at = [vc.after(t.base, t.value)[1] for t in targets if t.kind == "pose"]
                away = sorted(vc.length(vc.sub(a, places[1][1])) for a in at)
                nearest.append(away[1])             # behind the corner itself
                self.assertGreater(len(at), LINES + 2)
            self.assertLess(nearest[0], 2 * zone - 1)
            self.assertGreater(nearest[1], 2 * zone - 3)   # the corner is corrected by some mm

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
