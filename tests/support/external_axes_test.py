#!/usr/bin/env python3
"""KUKA programs of an arm on a rail and of one whose part a positioner carries, at arms that share no code with armtrue: a
campaign, close-loop, compensate, and the true arm drives the program under a controller that runs the nominal model.

The controller reads E1 to E6 of each point, keeps those that a point leaves out, turns them evenly from point to point, and
finds the six angles of the arm at each place of the line.

    external_axes_test.py BIN [--figures]
"""

import argparse
import csv
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import any_arm_cell
import closed_loop_test as loop
import robot_programs as interpreters
import robot_programs_test as programs
import straight_moves_test as straight
import virtual_cell as vc

BIN = None
CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config" / "robots"
POINTS, STEPS = 10, 8
BASE = vc.placed({"x_mm": 100, "y_mm": -50, "z_mm": 30, "a_deg": 20, "b_deg": 5, "c_deg": -3})
TOOL = vc.placed({"x_mm": 40, "y_mm": 0, "z_mm": 120, "a_deg": 0, "b_deg": 20, "c_deg": 0})
# The travel of the external axes in the program; of E1 of the rail mm, else degrees.
AXES = {"kr360-rail": {"E1": (1500, 3500)}, "kr360-dkp400": {"E1": (-25, 25), "E2": (-40, 40)}}
EFFECTS = {"kr360-rail": ["--sag", "3:2e-7", "--cycle", "1:0.4:3000"], "kr360-dkp400": ["--sag", "2:2e-7", "--sag", "3:2e-7"]}


class Cell:
    """The true arm, and the nominal one of the controller."""

    def __init__(self, robot):
        options = argparse.Namespace(robot=CONFIG / f"{robot}.yaml", seed=5, other_poses=False, sag=[], gain=[], cycle=[])
        for name, text in zip(EFFECTS[robot][::2], EFFECTS[robot][1::2]):
            getattr(options, name[2:]).append(any_arm_cell.numbers(text))
        self.true = any_arm_cell.Cell(options)
        self.columns, self.slides = self.true.columns, self.true.slides
        self.arm = [k for k, column in enumerate(self.columns) if column.startswith("q")]
        self.axis = {"E" + column[1]: k for k, column in enumerate(self.columns) if column.startswith("e")}

    def nominal(self, values):
        own, others = values[:self.true.joints], values[self.true.joints:]
        tool = self.true.arm.pose(own)
        return vc.after(programs.inverse(self.true.table.pose(others)), tool) if self.true.table else tool

    def with_axes(self, q, axes):
        values = [0.0] * len(self.columns)
        for k, angle in zip(self.arm, q):
            values[k] = angle
        for name, k in self.axis.items():
            values[k] = axes[name] if self.slides[k] else math.radians(axes[name])
        return values

    def joints_at(self, wanted, axes, q):
        """The six angles; programs.joints_at() by the pose with the external axes where they are."""
        arm = argparse.Namespace(pose=lambda angles: self.nominal(self.with_axes(angles, axes)))
        return programs.joints_at(arm, wanted, q)


def entries(text):
    return {name: float(value) for name, value in re.findall(rf"([A-Z]\d?)\s+({interpreters.NUMBER})", text)}


def read(src, dat):
    """Targets: whether it is a line, the motion base from TCP or six angles, external axes."""
    names = {name: entries(text) for name, text in re.findall(r"(\w+)=\{([^}]*)\}", dat)}
    axes, targets = {}, []
    for word, braces, name in re.findall(r"^(PTP|LIN) (?:\{([^}]*)\}|(\w+))", src, re.M):
        of = entries(braces) if braces else names[name]
        axes = axes | {key: value for key, value in of.items() if key[0] == "E"}
        if "A1" in of:
            value = [math.radians(of[f"A{j}"]) for j in range(1, 7)]
        else:
            value = interpreters.abc_motion(*(of[key] for key in "XYZABC"))
        targets.append((word == "LIN", value, dict(axes)))
    return targets


def program(cell, rng, travel):
    """A PTP to axes, a PTP to a pose and lines. The E of a point may be left out where it stays; one point is declared."""
    postures = []
    for k in range(POINTS):
        q = [math.radians(a + rng.uniform(-12, 12)) for a in (10, -75, 95, 15, 40, 30)]
        axes = {name: round(rng.uniform(*ends), 3) for name, ends in travel.items()}
        if k in (4, 5):
            axes = postures[-1][1]
        postures.append((q, axes))
    state = lambda axes: "".join(f",{name} {value:.3f}" for name, value in axes.items())
    lines, dat = ["DEF part()"], "DEFDAT part\n"
    for word, motion in (("BASE", BASE), ("TOOL", TOOL)):
        place = [*motion[1], *vc.kuka(motion[0])]
        lines.append(f"${word}={{" + ",".join(f"{n} {v:.6f}" for n, v in zip("XYZABC", place)) + "}")
    q, axes = postures[0]
    angles = ",".join(f"A{j} {math.degrees(a):.5f}" for j, a in enumerate(q, 1))
    lines.append(f"PTP {{{angles}{state(axes)}}}")
    for k, (q, axes) in enumerate(postures[1:], 1):
        pose = vc.after(vc.after(programs.inverse(BASE), cell.nominal(cell.with_axes(q, axes))), TOOL)
        frame = ",".join(f"{n} {v:.5f}" for n, v in zip("XYZABC", [*pose[1], *vc.kuka(pose[0])]))
        turn = sum(1 << j for j, a in enumerate(q) if a < 0)
        text = f"{{{frame},S 2,T {turn}{'' if k == 5 else state(axes)}}}"
        if k == 6:
            dat += f"DECL E6POS XP6={text}\n"
            text = "XP6"
        lines.append(("PTP " if k == 1 else "LIN ") + text + (" C_DIS" if k % 3 == 0 else "") + f" ; point {k}")
    return "\n".join(lines + ["END", ""]), dat + "ENDDAT\n", postures


def placed_by(meant, reached):
    base, tool = loop.placement(meant, reached)
    return [vc.after(vc.after(base, pose), tool) for pose in reached]


class ExternalAxes(unittest.TestCase):
    def run_robot(self, robot):
        self.cell, self.rng = Cell(robot), random.Random(f"external {robot}")
        with tempfile.TemporaryDirectory() as folder:
            self.folder, self.robot = pathlib.Path(folder), str(CONFIG / f"{robot}.yaml")
            done = subprocess.run([sys.executable, any_arm_cell.__file__, "campaign", "--robot", self.robot, "--seed", "5",
                                   "--poses", "90", *EFFECTS[robot], "-o", "m.csv"], cwd=folder)
            self.assertEqual(done.returncode, 0)
            self.run_command("close-loop", "--robot", self.robot, "--robot-out", "closed.yaml", "m.csv", "-o", "loop.yaml")
            src, dat, self.postures = program(self.cell, self.rng, AXES[robot])
            (self.folder / "part.src").write_text(src)
            (self.folder / "part.dat").write_text(dat)
            self.meant = self.points(self.drive((src, dat), 1, nominal=True))
            (self.folder / "new").mkdir()
            plain = self.compensate()
            self.check_text((src, dat), plain)
            before = self.errors(self.points(self.drive((src, dat), 1)), self.meant)
            after = self.errors(self.points(self.drive(plain, 1)), self.meant)
            moving = self.compensate("--move-external-axes")
            moved = self.errors(self.points(self.drive(moving, 1)), self.meant)
            self.say(f"{robot}: {POINTS} points, mean {loop.mean(before):.3f} mm before, {loop.mean(after):.4f} after, "
                     f"{loop.mean(moved):.4f} with external axes that may move")
            self.assertGreater(loop.mean(before), 0.2)
            self.assertLess(loop.mean(after), 0.15 * loop.mean(before))
            self.assertLess(loop.mean(moved), 0.15 * loop.mean(before))
            self.assertNotEqual(self.external(plain), self.external(moving))
            self.check_lines((src, dat), plain, robot)

    def run_command(self, command, *options):
        done = subprocess.run([BIN / command, "-q", *options], cwd=self.folder, capture_output=True, text=True)
        if done.returncode:
            raise AssertionError(f"{command}: {done.stderr}")

    def compensate(self, *options):
        self.run_command("compensate", "--robot", "closed.yaml", "--controller", self.robot, "--program", "part.src",
                         "--program-out", "new/part.src", "--max-mm", "30", *options)
        return tuple((self.folder / f"new/part.{ending}").read_text() for ending in ("src", "dat"))

    @staticmethod
    def external(texts):
        return re.findall(r"E\d [-.\d]+", "".join(texts))

    def check_text(self, before, after):
        """External axes stay byte for byte, and all that is no number of a point."""
        self.assertEqual(self.external(before), self.external(after))
        without = lambda texts: re.sub(r"(\b[XYZABC]\d? |T )[-.\d]+", r"\1#", "".join(texts))
        self.assertEqual(without(before), without(map(interpreters.without_mark, after)))
        self.assertNotEqual(before, after)

    def drive(self, texts, steps, nominal=False):
        """Poses R_0 from R_7 (the part's frame if it is carried): by move a list, `steps` on a line. All places of the arm."""
        q, last, moves = self.postures[0][0], None, []
        for is_line, value, axes in read(*texts):
            count = steps if is_line and last else 1
            if isinstance(value, list):
                q = value
                wanted = self.cell.nominal(self.cell.with_axes(q, axes))
            else:
                wanted = vc.after(vc.after(BASE, value), programs.inverse(TOOL))
            places = []
            for k in range(1, count + 1):
                t = k / count
                here = {name: last[1][name] + t * (axes[name] - last[1][name]) for name in axes} if last else axes
                tcp = straight.part_of_way(vc.after(last[0], TOOL), vc.after(wanted, TOOL), t) if count > 1 else None
                pose = vc.after(tcp, programs.inverse(TOOL)) if tcp else wanted
                if not isinstance(value, list):
                    q = self.cell.joints_at(pose, here, q)
                values = self.cell.with_axes(q, here)
                places.append(self.cell.nominal(values) if nominal else self.cell.true.frame(values))
            moves.append(places)
            last = wanted, axes
        return moves

    @staticmethod
    def points(moves):
        return [places[-1] for places in moves]

    @staticmethod
    def errors(reached, meant):
        return [vc.length(programs.difference(want, real)[:3]) for want, real in zip(meant, placed_by(meant, reached))]

    def check_lines(self, before, plain, robot):
        """Between the points, with the program's own corners as they are meant."""
        divided = self.compensate("--spacing-mm", "0.05")
        inserted = len(read(*divided)) - len(read(*plain))
        off = []
        for texts in (before, plain, divided):
            meant, moves = self.points(self.drive(before, 1, nominal=True)), self.drive(texts, STEPS)
            base, tool = loop.placement(meant, self.points(self.drive(before if texts is before else plain, 1)))
            lines = list(zip(meant[1:], meant[2:]))
            worst = []
            for pose in [pose for places in moves for pose in places][2:]:
                point = vc.after(vc.after(vc.after(base, pose), tool), TOOL)[1]
                worst.append(min(distance(point, vc.after(a, TOOL)[1], vc.after(b, TOOL)[1]) for a, b in lines))
            off.append((loop.mean(worst), max(worst)))
        self.say(f"{robot}: off the lines mean {off[0][0]:.3f}, largest {off[0][1]:.3f} mm before; corners corrected "
                 f"{off[1][0]:.4f}, {off[1][1]:.4f}; with {inserted} points {off[2][0]:.4f}, {off[2][1]:.4f}")
        self.assertGreater(inserted, 3)
        self.assertLess(off[2][1], 0.2 * off[0][1])
        self.assertLess(off[2][1], off[1][1])

    def say(self, text):
        if "--figures" in sys.argv:
            print(text)

    def test_rail(self):
        self.run_robot("kr360-rail")

    def test_positioner(self):
        self.run_robot("kr360-dkp400")


def distance(point, start, end):
    along, way = vc.sub(end, start), vc.sub(point, start)
    t = min(1.0, max(0.0, vc.dot(way, along) / vc.dot(along, along)))
    return vc.length(vc.sub(way, vc.scaled(along, t)))


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1]).resolve()
    unittest.main(argv=sys.argv[:1], verbosity=0)
