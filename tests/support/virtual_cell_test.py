#!/usr/bin/env python3
"""Checks the virtual cell: its arms move as those of simulate-poses do, and its effects have the size they shall have.
Also checks how tests/practice/outside judges what is named.

    virtual_cell_test.py BIN
"""

import csv
import importlib.machinery
import importlib.util
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import virtual_cell as vc

BIN = None


def simulated(text, folder):
    """Poses of simulate-poses without noise."""
    robot = pathlib.Path(folder) / "robot.yaml"
    robot.write_text(text)
    done = subprocess.run([BIN / "simulate-poses", "-q", "--robot", robot, "--count", "40", "--noise-mm", "0",
                           "--noise-mrad", "0"], capture_output=True, text=True, check=True)
    return list(csv.DictReader(done.stdout.splitlines()))


class Kinematics(unittest.TestCase):
    def agrees(self, text):
        arm = vc.Arm(text)
        with tempfile.TemporaryDirectory() as folder:
            rows = simulated(text, folder)
        self.assertEqual(len(rows), 40)
        for row in rows:
            joints = [column for column in row if re.fullmatch(r"[qe]\d+_(deg|mm)", column)]
            self.assertEqual(len(joints), len(arm.axes))
            rotation, point = arm.pose([float(row[column]) if column.endswith("_mm") else
                                        math.radians(float(row[column])) for column in joints])
            self.assertLess(vc.length(vc.sub(point, [float(row[f"{axis}_mm"]) for axis in "xyz"])), 1e-6)
            angles = {f"{a}_deg": float(row[f"{a}_deg"]) for a in "abc"}
            given = vc.placed({"x_mm": 0, "y_mm": 0, "z_mm": 0, **angles})[0]
            for ours, theirs in zip(rotation, given):
                self.assertLess(vc.length(vc.sub(ours, theirs)), 1e-9)

    def test_robots_of_config(self):
        for path in sorted((vc.ROOT / "config" / "robots").glob("*.yaml")):
            if "\npositioner:" in path.read_text():
                continue  # of these the cell is any_arm_cell.py
            if "follows:" in path.read_text():
                continue  # and of these palletiser_cell.py
            with self.subTest(path.name):
                # What a file declares as effects is no part of the comparison.
                self.agrees(re.sub(r"^effects:.*\Z", "effects: []\n", path.read_text(), flags=re.M | re.S))

    def test_arms_of_data_sheets(self):
        for name in vc.DATA_SHEETS:
            with self.subTest(name):
                self.agrees(vc.robot_text(name)[1])

    def test_torque_is_the_slope_of_the_potential(self):
        arm = vc.Arm(vc.robot_text("heavy-2650")[1])
        q, step = [0.3, -0.4, 0.5, 1.0, -0.7, 0.2], 1e-5

        def potential(angles):
            here, total = vc.NONE, 0.0
            for j in range(7):
                total -= sum(kg * vc.dot(arm.gravity, vc.moved(here, centre)) / 1000
                             for joints, kg, centre in arm.masses if joints == j)
                if j < 6:
                    here = vc.after(here, vc.screw(arm.axes[j], arm.points[j], angles[j]))
            return total
        for j, torque in enumerate(arm.torques(q, arm.masses)):
            up, down = list(q), list(q)
            up[j] += step
            down[j] -= step
            self.assertAlmostEqual(-(potential(up) - potential(down)) / (2 * step), torque, delta=1e-3)


class Effects(unittest.TestCase):
    def test_points_move_by_the_size_of_the_effect(self):
        for k, name in enumerate(vc.EFFECTS):
            with self.subTest(name):
                cell = vc.campaign(1000 + k, effect=name, count=25, repeats=2)
                shifts = vc.shifts_by(cell, cell["size"])
                if name == "nothing":
                    self.assertEqual(vc.spread_rms(shifts), 0.0)
                    continue
                over = vc.spread_rms(shifts) / cell["noise_mm"]
                self.assertGreater(over, 0.99 * vc.SIZE[0])
                self.assertLess(over, 1.01 * vc.SIZE[1])
                self.assertAlmostEqual(vc.spread_rms(shifts), cell["goal_mm"], delta=1e-3 * cell["goal_mm"])
                self.assertLess(cell["left_rms_mm"], 2 * vc.spread_rms(shifts))

    def test_files_hold_noise_and_effect(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            cell = vc.campaign(7, effect="radial_offset", count=40, repeats=1)
            answer = vc.write(cell, folder)
            read = lambda name: {row["pose"]: row for row in csv.DictReader((folder / name).read_text().splitlines())}
            test, truth, train = read("test.csv"), read("truth_test.csv"), read("train.csv")
            self.assertEqual(len(train), 40)
            self.assertEqual(test.keys(), truth.keys())
            self.assertFalse(test.keys() & train.keys())
            point = lambda row: [float(row[f"{axis}_mm"]) for axis in "xyz"]
            off = [vc.sub(point(test[pose]), point(truth[pose])) for pose in test]
            expected = math.hypot(answer["effect_rms_mm"], math.sqrt(3) * answer["noise_mm"])
            self.assertLess(abs(vc.spread_rms(off) / expected - 1), 0.25)

    def test_a_seed_gives_the_same_files(self):
        with tempfile.TemporaryDirectory() as folder:
            folders = [pathlib.Path(folder) / name for name in "ab"]
            for one in folders:
                vc.write(vc.campaign(8, count=25), one)
            for path in folders[0].iterdir():
                self.assertEqual(path.read_text(), (folders[1] / path.name).read_text())


class Judgement(unittest.TestCase):
    def setUp(self):
        path = str(vc.ROOT / "tests" / "practice" / "outside")
        loader = importlib.machinery.SourceFileLoader("outside", path)
        self.outside = importlib.util.module_from_spec(importlib.util.spec_from_loader("outside", loader))
        loader.exec_module(self.outside)

    def judged(self, hidden, name, parameter, driver, confirmed=True, rivals=()):
        effect = vc.campaign(1, effect=hidden, robot="heavy-2650", count=25, repeats=1)["effect"]
        answer = {"right": effect.right, "stories": effect.stories, "near": effect.near, "family": effect.family}
        return self.outside.judge({"name": name, "parameter": parameter, "driver": driver, "confirmed": confirmed,
                                   "rivals": list(rivals)}, answer)

    def test_same_physics_is_right_and_other_physics_is_not(self):
        self.assertEqual(self.judged("base_tilt", "tracker knocked", "base", "time"), "right")
        self.assertEqual(self.judged("base_tilt", "tracker drift", "base.rx", "time"), "right")
        self.assertEqual(self.judged("base_tilt", "zero drift", "A2.theta", "time"), "near")
        self.assertEqual(self.judged("base_tilt", "joint compliance", "A2.theta", "gravity-torque 2"), "wrong")
        self.assertEqual(self.judged("tool_mass", "joint compliance", "A3.theta", "gravity-torque 3"), "right")
        self.assertEqual(self.judged("tool_mass", "link bending", "A5.beta", "moment"), "right")
        self.assertEqual(self.judged("tool_mass", "re-mastered joint", "A2.theta", "time"), "near")
        self.assertEqual(self.judged("gas_spring", "gear or encoder scale", "A2.theta", "joint-angle 2"), "story")
        self.assertEqual(self.judged("refraction", "floor compliance", "base.rx", "moment"), "wrong")
        self.assertEqual(self.judged("refraction", "instrument scale", "instrument.scale", "position"), "story")
        self.assertEqual(self.judged("refraction", "eccentric circle", "instrument.elevation", "elevation"), "story")
        self.assertEqual(self.judged("nothing", "backlash", "A1.theta", "arrival 1"), "wrong")

    def test_no_claim_is_not_false(self):
        self.assertEqual(self.judged("refraction", "unexplained", "A1.r", "joint-angle 1"), "curve")
        self.assertEqual(self.judged("refraction", "backlash", "A1.theta", "arrival 1", confirmed=False),
                         "not confirmed")

    def test_a_right_rival_makes_the_name_right(self):
        self.assertEqual(self.judged("parallelogram", "gear or encoder scale", "A2.theta", "joint-angle 2",
                                     rivals=[("A3.theta", "joint-angle 2")]), "right")

    def test_interval(self):
        low, high = self.outside.wilson(5, 100)
        self.assertAlmostEqual(low, 0.0215, delta=5e-4)
        self.assertAlmostEqual(high, 0.1118, delta=5e-4)

    def test_station_is_no_part_of_the_arm(self):
        text = ("links:\neffects:\n  - name: tracker knocked\n    parameter: base\n    driver: time\n"
                "    coefficients:\n      - {name: x, value: 0.1, std: 0.2}\n"
                "  - name: re-seated target\n    parameter: tool.z\n    driver: time\n"
                "    coefficients:\n      - {name: c, value: 0.1, std: 0.2}\n"
                "  - name: backlash\n    parameter: A1.theta\n"
                "    driver: arrival 1\n    coefficients:\n      - {name: c, value: 0.3}\nuncertainty:\n  value: 5\n")
        self.assertEqual(self.outside.without_station(text), text.replace("0.1,", "0,"))


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1))
    unittest.main()
