#!/usr/bin/env python3
"""Moves in which joints with backlash reverse on the way, driven by a controller of its own: it moves the TCP on the line or
the circle in its nominal model, and each joint of the true arm stands by its backlash behind the direction of its last
motion. The true TCP has to reach the programmed ends. Nothing here shares code with armtrue.

    reversing_moves_test.py BIN [--figures]
"""

import math
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import circular_moves_test as circular
import robot_programs_test as programs
import straight_moves_test as straight
import virtual_cell as vc

BIN = None
BACKLASH = (-1e-4, -3e-4, -2e-4, -1e-4, -2e-4, -3e-4)  # rad: each joint lags behind its motion
SEEDS = range(4)
PLACES = [k / 12 for k in range(1, 12)] + [0.999, 1]  # on a way


def with_backlash(text):
    effects = [f"  - {{name: backlash, parameter: A{j}.theta, driver: arrival {j}, shape: sign, "
               f"coefficients: [{{name: c, value: {c}, unit: rad}}]}}" for j, c in enumerate(BACKLASH, 1)]
    return text.replace("effects: []\n", "\n".join(["effects:", *effects, ""]))


def arm_with_backlash(text):
    """For each direction of the joints the arm as it stands then."""
    def stands(directions):
        links = iter(c * d for c, d in zip(BACKLASH, directions))
        lines = [turned(line, next(links)) if "joint: revolute" in line else line for line in text.splitlines()]
        return vc.Arm("\n".join(lines) + "\n")
    return stands


def turned(line, angle):
    head, tail = line.split("theta_deg: ")
    number, rest = tail.split(",", 1)
    return f"{head}theta_deg: {float(number) + math.degrees(angle)!r},{rest}"


def directions_of(along):
    """The direction of the last motion of each joint on a way."""
    return tuple(1 if b > a else -1 for a, b in zip(along[-2], along[-1]))


class ReversingMoves(unittest.TestCase):
    def run_dialect(self, dialect):
        before, after, reversals = [], [], 0
        for seed in SEEDS:
            cell = programs.Cell(dialect, f"reversing {seed}")
            for of_kind in (self.straight, self.circular):
                nominal, compensated, reversing = of_kind(cell, dialect)
                before += nominal
                after += compensated
                reversals += reversing
        rms = lambda errors: math.sqrt(sum(e * e for e in errors) / len(errors))
        if "--figures" in sys.argv:
            print(f"{dialect}: {len(after)} ends, {reversals} joints reverse; programmed max {max(before):.4f} mm, rms "
                  f"{rms(before):.4f} mm; corrected max {max(after):.4f} mm, rms {rms(after):.4f} mm")
        self.assertGreater(reversals, 10)
        self.assertGreater(max(before), 0.1)
        self.assertLess(max(after), 0.006)

    def straight(self, cell, dialect):
        postures, places = straight.corners(cell, dialect)
        make = getattr(straight, dialect + "_program")
        return self.errors(cell, dialect, make(cell, postures), postures, places[1:], 1,
                           lambda poses: lambda t: straight.part_of_way(*poses, t))

    def circular(self, cell, dialect):
        postures, arcs = circular.arcs_of(cell, dialect)
        make = getattr(circular, dialect + "_program")
        ends = [arc.end for arc in arcs]
        return self.errors(cell, dialect, make(cell, postures), postures, ends, 2,
                           lambda poses: circular.Arc(*poses, dialect == "rapid").at)

    def errors(self, cell, dialect, texts, postures, ends, points, way_through):
        """Of the programmed and of the corrected program: distances of the true TCP from the ends of the moves [mm]; and how
        many joints reverse on a programmed way. `points`: of a move."""
        cell.true_text = with_backlash(programs.true_text(cell.nominal_text, cell.rng))
        stands = arm_with_backlash(cell.true_text)
        with tempfile.TemporaryDirectory() as folder:
            corrected = programs.Compensation(BIN, pathlib.Path(folder), cell, dialect, *texts)("true.yaml")
        found, reversing = [], 0
        for text in (texts, corrected):
            targets, tool, q = straight.interpreter(dialect, cell)(*text), cell.tools[0], postures[0]
            commanded = [vc.after(cell.nominal.pose(t.value), tool) if t.kind == "joints" else vc.after(t.base, t.value)
                         for t in targets]
            errors = []
            for end, first in zip(ends, range(0, len(commanded) - points, points)):
                at = way_through(commanded[first:first + points + 1])
                along = [q]
                for t in PLACES:
                    along.append(programs.joints_at(cell.nominal, vc.after(at(t), programs.inverse(tool)), along[-1]))
                reversing += text is texts and sum((b - a) * d < 0 for a, b, d in zip(q, along[-1], directions_of(along)))
                q = along[-1]
                reached = vc.after(stands(directions_of(along)).pose(q), tool)
                errors.append(vc.length(vc.sub(reached[1], end[1])))
            found.append(errors)
        return *found, reversing

    # Near a reversal the joint moves less from point to point than the check digits move the written numbers: there the
    # direction of an inserted point would be that of chance, and the point would miss by twice the backlash.
    def test_inserted_points(self):
        for dialect in ("krl", "urscript"):
            errors = [error for seed in SEEDS for error in self.of_inserted(dialect, seed)]
            if "--figures" in sys.argv:
                rms = math.sqrt(sum(e * e for e in errors) / len(errors))
                print(f"{dialect}: {len(errors)} inserted points, max {max(errors):.4f} mm, rms {rms:.4f} mm")
            self.assertGreater(len(errors), 20)
            self.assertLess(max(errors), 0.006)

    def of_inserted(self, dialect, seed):
        """Distances of the true TCP from the programmed lines at the commanded points [mm]."""
        cell = programs.Cell(dialect, f"reversing {seed}")
        postures, places = straight.corners(cell, dialect)
        commanded, reached = self.driven(cell, dialect, getattr(straight, dialect + "_program")(cell, postures))
        lines = straight.lines_of(commanded, places)
        ways = [lambda t, ends=ends: straight.part_of_way(*ends, t) for ends in zip(commanded, commanded[1:])]
        return [straight.off_lines(places, line, pose)[0] for line, pose in zip(lines, reached(ways, postures[0]))]

    def driven(self, cell, dialect, texts):
        """The commanded poses of the program that is corrected for an arm with backlash, and a function that gives the true
        TCP at the ends of ways which that arm drives one after another."""
        cell.true_text = with_backlash(programs.true_text(cell.nominal_text, cell.rng))
        stands, tool = arm_with_backlash(cell.true_text), cell.tools[0]
        with tempfile.TemporaryDirectory() as folder:
            compensate = programs.Compensation(BIN, pathlib.Path(folder), cell, dialect, *texts)
            targets = straight.interpreter(dialect, cell)(*compensate("true.yaml", "--spacing-mm", "0.05"))

        def reached(ways, q):
            for way in ways:
                along = [q]
                for t in PLACES:
                    along.append(programs.joints_at(cell.nominal, vc.after(way(t), programs.inverse(tool)), along[-1]))
                q = along[-1]
                yield vc.after(stands(directions_of(along)).pose(q), tool)

        return [vc.after(cell.nominal.pose(t.value), tool) if t.kind == "joints" else vc.after(t.base, t.value)
                for t in targets], reached

    # The controller draws an arc through its three commands: where the correction jumps at one of them, a joint may
    # arrive at the end in the other direction than on the programmed arc. No end may miss by more than 0.02 mm.
    def test_ends_of_inserted_arcs(self):
        for dialect in ("krl", "fanuc"):
            errors = [error for seed in range(3) for error in self.of_inserted_arcs(dialect, seed)]
            if "--figures" in sys.argv:
                print(f"{dialect}: {len(errors)} ends of inserted arcs, max {max(errors):.4f} mm")
            self.assertGreater(len(errors), 30)
            self.assertLess(max(errors), 0.02)

    def of_inserted_arcs(self, dialect, seed):
        """Distances of the true TCP from the programmed circles at the ends of the commanded arcs [mm]."""
        cell = programs.Cell(dialect, f"reversing {seed}")
        postures, arcs = circular.arcs_of(cell, dialect)
        commanded, reached = self.driven(cell, dialect, getattr(circular, dialect + "_program")(cell, postures))
        pieces = [circular.Arc(*commanded[k:k + 3], dialect == "rapid") for k in range(0, len(commanded) - 2, 2)]
        ends = reached([piece.at for piece in pieces], postures[0])
        return [arcs[number].off(pose)[0] for number, pose in zip(circular.arc_of_each(pieces, arcs), ends)]

    def test_krl(self):
        self.run_dialect("krl")

    def test_rapid(self):
        self.run_dialect("rapid")

    def test_urscript(self):
        self.run_dialect("urscript")

    def test_fanuc(self):
        self.run_dialect("fanuc")


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1], verbosity=0)
