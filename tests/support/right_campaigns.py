#!/usr/bin/env python3
"""Right campaigns of every shipped robot are never refused. Each is simulated without code of armtrue (any_arm_cell.py):
a robot of config/robots with or without its masses; R_A tilted against the foot by 0 to 180 deg, in three of ten by less
than 3, and known to the robot file or entered some degrees off; mounted on floor, wall or ceiling; a tool of up to
500 mm; nothing hidden, or joints that sag, gears that are uneven, a floor that gives way; poses, points, or distances
from four anchors. Robots whose joints follow others have a cell of their own (palletiser_cell.py).

    right_campaigns.py BIN CONFIG [--count N] [--seed N] [--loops SHARE]

Runs calibrate and evaluate-poses on each, close-loop on a share of them, and prints how many were refused (an exit code
but 0 and 3, or words of a library), by command, with the seed of each. Exit code 1 if any was.
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
import types

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import any_arm_cell as cells  # noqa: E402
from virtual_cell import Effect, NONE, about, cross, dot, kuka, moved, rotation_times, scaled, turned  # noqa: E402

NOISE_MM, NOISE_MRAD, STEP_S = 0.05, 0.1, 20
LIBRARY = re.compile(r"Error in function|boost|Eigen|Ceres|yaml-cpp|std::|terminate", re.I)
WEIGHT = (12.0, 6.0)      # kg: of a link of a robot without masses, near its axis and at the flange


def direction(rng):
    while True:
        v = tuple(rng.gauss(0, 1) for _ in range(3))
        size = math.sqrt(dot(v, v))
        if size > 1e-3:
            return scaled(v, 1 / size)


def replaced(text, block, line):
    """The text with another value of a key that stands in one line; at the end if it is new."""
    pattern = rf"^{block}:.*(?:\n +.*)*"
    return re.sub(pattern, lambda _: line, text, flags=re.M) if re.search(pattern, text, re.M) else text + line + "\n"


def pose_line(key, rotation, place):
    a, b, c = kuka(rotation)
    return "%s: {x_mm: %.3f, y_mm: %.3f, z_mm: %.3f, a_deg: %.6f, b_deg: %.6f, c_deg: %.6f}" % (key, *place, a, b, c)


class Campaign:
    def __init__(self, seed, config, folder):
        rng = self.rng = random.Random(seed)
        robots = sorted(path for path in (config / "robots").glob("*.yaml") if "follows:" not in path.read_text())
        source = robots[seed % len(robots)]
        text = re.sub(r"\s+#.*", "", source.read_text())
        self.words, self.folder = [source.stem], folder
        self.positioner = "positioner:" in text
        if not self.positioner:
            text = self.placed(text, rng)
        if rng.random() < 0.4 and not self.positioner:
            down = direction(rng) if rng.random() < 0.4 else rng.choice([(0, 0, 1), (1, 0, 0), (0, -1, 0)])
            text = replaced(text, "gravity_m_s2", "gravity_m_s2: [%.9f, %.9f, %.9f]" % scaled(down, 9.81))
            self.words.append("mounted otherwise")
        whole = text
        if "masses:" in text and rng.random() < 0.5:
            text = re.sub(r"^masses:\s*\n(?: +-.*\n)+", "", text, flags=re.M)
            self.words.append("without masses")
        if not self.positioner and rng.random() < 0.5:
            text = self.entered_roughly(text, rng)
        self.robot = folder / "robot.yaml"
        self.robot.write_text(text)
        (folder / "whole.yaml").write_text(whole)
        self.cell = cells.Cell(types.SimpleNamespace(robot=folder / "whole.yaml", seed=seed, other_poses=False,
                                                     sag=[], cycle=[], gain=[]))
        self.hide(rng)
        self.write(rng)

    def placed(self, text, rng):
        tilt = rng.uniform(0, 3) if rng.random() < 0.3 else rng.uniform(0, 180)
        turn = rotation_times(about(direction(rng), math.radians(tilt)), about((0, 0, 1), rng.uniform(-3, 3)))
        self.base = turn, [rng.uniform(-3000, 3000) for _ in range(3)]
        text = replaced(text, "base", pose_line("base", *self.base))
        tool = scaled(direction(rng), rng.uniform(0, 500))
        self.words += [f"tilt {tilt:.2f} deg", f"tool {math.sqrt(dot(tool, tool)):.0f} mm"]
        return replaced(text, "tool", pose_line("tool", about(direction(rng), rng.uniform(0, 3)), tool))

    def entered_roughly(self, text, rng):
        """The robot file knows R_A only to some degrees and centimetres."""
        tilt = rng.uniform(0, 4)
        self.words.append(f"base entered {tilt:.2f} deg off")
        turn = rotation_times(about(direction(rng), math.radians(tilt)), self.base[0])
        return replaced(text, "base", pose_line("base", turn, [x + rng.gauss(0, 20) for x in self.base[1]]))

    def overturning(self, values):
        """Of all weights about the origin of R_0, in its axes [N m]."""
        here, moment, masses = NONE, (0.0, 0.0, 0.0), self.cell.arm.masses
        frames = [here]
        for j, value in enumerate(values[:len(self.cell.arm.axes)]):
            here = cells.after(here, self.cell.arm.motion(j, value))
            frames.append(here)
        for joints, kg, point in masses:
            lever = scaled(moved(frames[joints], point), 1e-3)
            moment = tuple(m + t for m, t in zip(moment, cross(lever, scaled(self.cell.arm.gravity, kg))))
        return moment

    def hide(self, rng):
        arm = self.cell.arm
        if not arm.masses:
            last = len(arm.points)
            arm.masses = [(j + 1, WEIGHT[j + 1 == last], point) for j, point in enumerate(arm.points)]
        options = types.SimpleNamespace(sag=[], cycle=[], gain=[])
        joints, kind = range(len(arm.axes)), rng.choice(["nothing", "sag", "gears", "floor", "all"])
        self.words.append(kind)
        turning = [j for j in joints if not arm.slides[j]]
        if kind in ("sag", "all"):
            some = [self.cell.draw() for _ in range(20)]
            torques = [arm.torques(values[:len(arm.axes)], arm.masses) for values in some]
            for j in rng.sample(turning, 2):
                largest = max(abs(t[j]) for t in torques)
                if largest > 1:
                    options.sag.append((j, rng.uniform(1e-4, 8e-4) / largest))
        if kind in ("gears", "all"):
            options.cycle += [(j, math.degrees(rng.uniform(5e-5, 4e-4)), 360.0 / rng.choice([1, 2, 3]))
                              for j in rng.sample(turning, 2)]
        base = None
        if kind in ("floor", "all") and not self.positioner:
            levers = [self.overturning(self.cell.draw()) for _ in range(20)]
            soft = rng.uniform(5e-5, 3e-4) / max(1.0, max(math.sqrt(dot(m, m)) for m in levers))
            base = lambda state: (scaled(turned(arm.base[0], self.overturning(state.values)), soft), (0.0, 0.0, 0.0))
        self.cell.effect = Effect("hidden", "", joints=lambda state: self.cell.errors(state, options), base=base)

    def write(self, rng):
        kind = "poses" if self.positioner else rng.choice(["poses", "poses", "points", "distances"])
        count = rng.randint(55, 90)
        self.words.append(f"{count} {kind}")
        anchors = []
        if kind == "distances":
            anchors = [tuple(x + y for x, y in zip(self.cell.arm.base[1], scaled(direction(rng), rng.uniform(2500, 4500))))
                       for _ in range(4)]
            rows = "".join(f"  '{k}': {{x_mm: {x:.3f}, y_mm: {y:.3f}, z_mm: {z:.3f}}}\n"
                           for k, (x, y, z) in enumerate(anchors, 1))
            self.robot.write_text(self.robot.read_text() + "anchors:\n" + rows)
        self.readings = self.folder / "readings.csv"
        with open(self.readings, "w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            points, angles = ["x_mm", "y_mm", "z_mm"], ["a_deg", "b_deg", "c_deg"]
            columns = {"poses": points + angles, "points": points, "distances": ["anchor", "l_mm"]}[kind]
            writer.writerow(["pose", "t_s", *self.cell.columns, *columns])
            poses = [self.cell.draw() for _ in range(count)]
            for visit in range(2 * count):
                pose = visit if visit < count else rng.randrange(count)
                rotation, point = self.cell.frame(poses[pose])
                start = [pose + 1, visit * STEP_S, *(f"{v:.9f}" for v in self.cell.shown(poses[pose]))]
                for k, anchor in enumerate(anchors, 1):
                    length = math.dist(point, anchor) + rng.gauss(0, NOISE_MM)
                    writer.writerow([*start[:1], start[1] + k, *start[2:], k, f"{length:.6f}"])
                if anchors:
                    continue
                noise = about(direction(rng), rng.gauss(0, NOISE_MRAD * 1e-3))
                shown = [f"{x + rng.gauss(0, NOISE_MM):.6f}" for x in point]
                writer.writerow([*start, *shown, *([f"{x:.8f}" for x in kuka(rotation_times(noise, rotation))]
                                                   if kind == "poses" else [])])


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    refused = done.returncode not in (0, 3) or LIBRARY.search(done.stderr)
    return done.returncode, (done.stderr.strip().splitlines() or [""])[-1] if refused else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("config", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--loops", type=float, default=0.05)
    options = parser.parse_args()
    runs, refusals = {}, []
    for seed in range(options.seed, options.seed + options.count):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            campaign = Campaign(seed, options.config, folder)
            commands = [("calibrate", "--robot", campaign.robot, campaign.readings, "-o", folder / "calibrated.yaml"),
                        ("evaluate-poses", "--robot", folder / "calibrated.yaml", campaign.readings)]
            if random.Random(seed).random() < options.loops:
                commands.append(("close-loop", "--robot", campaign.robot, campaign.readings, "-o", folder / "loop.yaml"))
            for command in commands:
                code, why = run(options.bin / command[0], *command[1:])
                runs.setdefault(command[0], {}).setdefault(code, 0)
                runs[command[0]][code] += 1
                if why is not None:
                    refusals.append(f"{command[0]} seed {seed} ({', '.join(campaign.words)}): exit {code}: {why}")
                if code not in (0, 3):
                    break
    for command, codes in runs.items():
        print(command + ":", ", ".join(f"{count} with exit {code}" for code, count in sorted(codes.items())))
    print(f"{options.count} right campaigns, {len(refusals)} refused")
    print("\n".join(refusals))
    sys.exit(1 if refusals else 0)


if __name__ == "__main__":
    main()
