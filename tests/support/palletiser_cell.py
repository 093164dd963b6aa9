#!/usr/bin/env python3
"""A palletiser as its rods move it, with errors of its own. Shares no code with armtrue.

    palletiser_cell.py campaign --seed N --poses N [--noise-mm S] [--noise-mrad S] EFFECT... -o measured.csv
    palletiser_cell.py reach --seed N --commands FILE EFFECT... -o reached.csv

The mechanism is solved in the plane of the arm from the places of its joints: motor 2 turns the lower arm, motor 3 holds the
upper arm against the ground, and two four-bar linkages, from the column to a triangle at the elbow and from there to the
bracket of the flange, keep the bracket level. They are parallelograms but for what --rod adds. Lengths, axes, zeros, base and
tool are off, the same for the same seed. `campaign` visits each pose twice; `reach` writes where the flange truly stands at
commands, without noise. Columns: q1_deg to q4_deg; angles 2 and 3 as the motors show them, against the ground.

    EFFECT   --sag J:RAD_PER_NM    joint J = 2 or 3 gives way under gravity
             --rod MM              the rod along the lower arm is longer than the arm
             --play J:MRAD         joint J stands by half of it on the side from which it came
"""

import argparse
import csv
import math
import random
import sys

COLUMN, SHOULDER, LOWER, UPPER, REACH, DROP = 742.5, 260.0, 945.0, 1025.0, 220.0, 250.0
CRANK = 250.0  # of the four-bar linkage
LEAN = math.radians(22)  # in the middle of the travel of joint 2 the cranks stand at right angles to the lower arm
TRAVEL = [(-150, 150), (-35, 80), (-15, 110), (-280, 280)]
MASS_LOWER, MASS_UPPER, MASS_END, GRAVITY = 120.0, 90.0, 160.0, 9.81


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def on(a, v):
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def turn(axis, angle):
    """Rodrigues' formula about a unit vector."""
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


def small(vector):
    size = math.hypot(*vector)
    return turn([v / size for v in vector], size) if size > 0 else turn((0, 0, 1), 0)


def kuka(r):
    return (math.degrees(math.atan2(r[1][0], r[0][0])), math.degrees(math.asin(-r[2][0])),
            math.degrees(math.atan2(r[2][1], r[2][2])))


def four_bar(direction, length, rod, crank):
    """How far the far crank of a four-bar linkage turns against the near one: the bar leads from the pivot of the near crank
    `length` in `direction`; the rod joins the ends of the cranks."""
    pivot = (length * direction[0], length * direction[1])
    end = (-crank * math.cos(LEAN), crank * math.sin(LEAN))  # of the near crank, fixed to the column
    # The end of the far crank: at `crank` from the pivot, at `rod` from `end`; the solution next to the parallelogram.
    between = (end[0] - pivot[0], end[1] - pivot[1])
    away = math.hypot(*between)
    along = (crank**2 - rod**2 + away**2) / (2 * away)
    beside = math.sqrt(crank**2 - along**2)
    unit = (between[0] / away, between[1] / away)
    ends = [(unit[0] * along - side * unit[1] * beside, unit[1] * along + side * unit[0] * beside) for side in (1, -1)]
    x, z = min(ends, key=lambda p: math.hypot(p[0] - end[0], p[1] - end[1]))
    return math.atan2(x, z) - math.atan2(*end)  # positive: the far crank leans forward, as a positive pitch does


class Arm:
    def __init__(self, options):
        rng = random.Random(options.seed)
        off = lambda size: rng.gauss(0, size)
        self.lower, self.upper = LOWER + off(0.3), UPPER + off(0.3)
        self.shoulder, self.reach, self.drop = SHOULDER + off(0.3), REACH + off(0.3), DROP + off(0.3)
        self.zeros = [0.0] + [off(1.0e-3) for _ in range(2)] + [0.0]
        self.level = off(1e-3)
        vector = lambda size: [off(size) for _ in range(3)]
        self.tilts = [small(vector(3e-4)) for _ in range(4)]  # of the axes 2, 3, of the bracket and 4
        self.aside = [off(0.3) for _ in range(4)]
        self.base = (times(turn((0, 0, 1), math.radians(20)), small(vector(2e-3))), [1500.0, -400.0, 300.0])
        self.tool = (small(vector(2e-3)), [30 + off(1), -20 + off(1), 80 + off(1)])
        self.options = options

    def frame(self, q, arrival=(0, 0, 0, 0)):
        """R_A from the measured frame at angles as the motors show them, rad."""
        q = [value + zero for value, zero in zip(q, self.zeros)]
        for joint, play in self.options.play:
            q[joint] += 0.5e-3 * play * arrival[joint]
        lower, upper = q[1], q[2]  # of the arms, against the ground
        end = MASS_END
        for joint, softness in self.options.sag:
            if joint == 1:  # the forearm and the bracket only translate with the lower arm
                lower += softness * GRAVITY * (MASS_LOWER / 2 + MASS_UPPER + end) * 1e-3 * LOWER * math.sin(q[1])
            else:
                upper += softness * GRAVITY * (MASS_UPPER / 2 + end) * 1e-3 * UPPER * math.cos(q[2])
        triangle = four_bar((math.sin(lower), math.cos(lower)), LOWER, LOWER + self.options.rod, CRANK)
        pitch = self.level + triangle  # the second linkage is a parallelogram
        # Rotations and places along the arm, with what its parts are off; y points along the axes of the plane.
        here, place = turn((0, 0, 1), q[0]), [0.0, 0.0, COLUMN]

        def move(vector):
            step = on(here, vector)
            for k in range(3):
                place[k] += step[k]

        move([self.shoulder, self.aside[0], 0.0])
        here = times(times(here, self.tilts[0]), turn((0, 1, 0), lower))
        move([0.0, self.aside[1], self.lower])
        here = times(times(here, self.tilts[1]), turn((0, 1, 0), upper - lower))
        move([self.upper, self.aside[2], 0.0])
        here = times(times(here, self.tilts[2]), turn((0, 1, 0), pitch - upper))
        move([self.reach, self.aside[3], -self.drop])
        here = times(times(here, self.tilts[3]), turn((1, 0, 0), math.pi))
        here = times(here, turn((0, 0, 1), q[3]))
        tool = on(here, self.tool[1])
        point = [place[k] + tool[k] for k in range(3)]
        rotation, origin = self.base
        return (times(rotation, times(here, self.tool[0])), [a + b for a, b in zip(on(rotation, point), origin)])


def sides(q, before):
    return [0 if before is None else (a > b) - (a < b) for a, b in zip(q, before or q)]


def draw(rng):
    """Within the travels, and not where the arms fold or stretch: the angle between them is 15 to 165 deg."""
    while True:
        values = [math.radians(rng.uniform(low, high)) for low, high in TRAVEL]
        if 15 < math.degrees(math.pi / 2 + values[2] - values[1]) < 165:
            return values


def campaign(arm, options):
    rng, writer = random.Random(options.seed + 1 + 1000 * options.other_poses), csv.writer(options.output, lineterminator="\n")
    writer.writerow("pose repeat t_s q1_deg q2_deg q3_deg q4_deg x_mm y_mm z_mm a_deg b_deg c_deg".split())
    poses, t, before = [draw(rng) for _ in range(options.poses)], 0, None
    for repeat in (1, 2):
        order = list(range(options.poses))
        rng.shuffle(order)
        for pose in order:
            rotation, point = arm.frame(poses[pose], sides(poses[pose], before))
            before = poses[pose]
            noise = small([rng.gauss(0, 1e-3 * options.noise_mrad) for _ in range(3)])
            point = [x + rng.gauss(0, options.noise_mm) for x in point]
            writer.writerow([pose + 1, repeat, t, *(f"{math.degrees(v):.9f}" for v in poses[pose]),
                             *(f"{x:.6f}" for x in point), *(f"{x:.8f}" for x in kuka(times(noise, rotation)))])
            t += 20


def reach(arm, options):
    writer = csv.writer(options.output, lineterminator="\n")
    writer.writerow(["pose", "x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg"])
    before = None
    for row in csv.DictReader(options.commands):
        q = [math.radians(float(row[f"q{j}_deg"])) for j in range(1, 5)]
        rotation, point = arm.frame(q, sides(q, before))
        before = q
        writer.writerow([row["pose"], *(f"{x:.6f}" for x in point), *(f"{x:.8f}" for x in kuka(rotation))])


def numbers(text):
    joint, size = text.split(":")
    return int(joint) - 1, float(size)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["campaign", "reach"])
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--poses", type=int, default=60)
    parser.add_argument("--noise-mm", type=float, default=0.03)
    parser.add_argument("--noise-mrad", type=float, default=0.1)
    parser.add_argument("--other-poses", action="store_true")
    parser.add_argument("--exact", action="store_true", help="an arm without errors, seen in R_0, without tool")
    parser.add_argument("--commands", type=argparse.FileType("r"))
    parser.add_argument("-o", dest="output", type=argparse.FileType("w"), default=sys.stdout)
    parser.add_argument("--sag", type=numbers, action="append", default=[])
    parser.add_argument("--play", type=numbers, action="append", default=[])
    parser.add_argument("--rod", type=float, default=0.0)
    options = parser.parse_args()
    arm = Arm(options)
    if options.exact:
        still = turn((0, 0, 1), 0)
        arm.lower, arm.upper, arm.shoulder, arm.reach, arm.drop = LOWER, UPPER, SHOULDER, REACH, DROP
        arm.zeros, arm.level, arm.tilts, arm.aside = [0.0] * 4, 0.0, [still] * 4, [0.0] * 4
        arm.base, arm.tool = (still, [0.0] * 3), (still, [0.0] * 3)
    {"campaign": campaign, "reach": reach}[options.what](arm, options)


if __name__ == "__main__":
    main()
