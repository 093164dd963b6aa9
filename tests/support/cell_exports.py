#!/usr/bin/env python3
"""What the machines of two cells write: a KUKA with a laser tracker, and an arm under ROS with motion capture.

    cell_exports.py kuka --robot nominal.yaml --seed N --out DIR
        tracker.txt      points as SpatialAnalyzer exports them, two visits as two groups
        controller.csv   log of the controller: semicolons, decimal commas, unit in the header, E1 that stands still
        pendant.txt      pose of the flange that the pendant shows at 0, -90, 90, 0, 0, 0
        part.src, part.dat   a program with Cartesian targets and joint targets
    cell_exports.py runs --robot nominal.yaml --seed N --program FILE.src --as PROGRAM.src
        prints the mean and the largest distance [mm] from where PROGRAM puts the tool when the true arm runs FILE,
        in the frame that fits best: a tracker anywhere does not show where the foot is, and $BASE is measured
    cell_exports.py ros --urdf FILE --seed N --out DIR [--once]
        take.csv         rigid body and marker as Motive exports them, with a clock of its own
        joint_states.csv joint states as PlotJuggler exports them, joints in the order of their names
        tree.txt         transform base_link to tool0 at six angles, as the transform tree has it
        unseen.csv       measured poses of other postures, for evaluate-poses
        The arm stops every 4 s; each posture is visited twice, two visits are hidden; with --once it is visited once.

It shares no code with armtrue: the KUKA is the product of exponentials of virtual_cell.py, the arm under ROS a chain of
the origins that stand in the URDF. The same seed gives the same files. Lengths are mm, angles rad, but in the files.
"""

import argparse
import math
import pathlib
import random
import sys
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import robot_programs  # noqa: E402
from any_arm_cell import Cell  # noqa: E402
from robot_programs_test import difference, inverse, joints_at, solved  # noqa: E402
from virtual_cell import (NONE, X, Y, Z, Arm, about, after, kuka, length, moved, rotation_times, small_motion,  # noqa: E402
                          turned)

# ---- the KUKA

POSES = 60
TRACKER_NOISE_MM = 0.03
SAG_RAD_PER_NM = 3e-7
PROGRAM_TOOL = robot_programs.abc_motion(0, 0, 180, 0, 0, 0)


class Options:
    """What Cell of any_arm_cell.py takes from its command line."""

    def __init__(self, robot, seed):
        self.robot, self.seed, self.other_poses = robot, seed, False
        self.sag, self.gain, self.cycle = [(2, SAG_RAD_PER_NM)], [], []


def comma(value, decimals):
    return f"{value:.{decimals}f}".replace(".", ",")


def write_kuka(options):
    cell, out = Cell(Options(options.robot, options.seed)), options.out
    poses = [cell.draw() for _ in range(POSES)]
    rng, seconds = cell.rng, 8 * 3600
    points = ["// SpatialAnalyzer SA 2024.2.0923.4 ( x64 )", "// Points Relative to Coordinate Frame 'A::WORLD'",
              "// AXES = CARTESIAN: X,  Y,  Z (mm)"]
    log = ["Robot KR360;Log 4711", "Name;Repeat;" + ";".join(f"A{j} [deg]" for j in range(1, 7)) + ";E1 [mm]"]
    # From the foot of the robot to the tracker.
    tracker = after((about(Z, 2.1), (0.0, 0.0, 0.0)), (NONE[0], (-3100.0, 900.0, -350.0)))
    for visit in (1, 2):
        order = list(range(POSES))
        rng.shuffle(order)
        for pose in order:
            point = moved(tracker, cell.frame(poses[pose])[1])
            seconds += 21
            clock = f"{seconds // 3600:02}:{seconds // 60 % 60:02}:{seconds % 60:02}"
            points.append(f"Cell 4,  {visit},  P{pose + 1},  " +
                          ",  ".join(f"{x + rng.gauss(0, TRACKER_NOISE_MM):.6f}" for x in point) + f",  05/03/24 {clock}")
            log.append(f"P{pose + 1};{visit};" + ";".join(comma(q, 5) for q in cell.shown(poses[pose])) + ";0,000")
    (out / "tracker.txt").write_text("\n".join(points) + "\n")
    (out / "controller.csv").write_text("\r\n".join(log) + "\r\n")
    flange = cell.arm.home_flange([math.radians(v) for v in (0, -90, 90, 0, 0, 0)])
    (out / "pendant.txt").write_text(",".join(f"{v:.4f}" for v in (*flange[1], *kuka(flange[0]))) + "\n")
    write_part(cell, out)


def write_part(cell, out):
    """A closed way over a part of 1.4 m, and the joint target that it begins with."""
    start = [math.radians(v) for v in (10, -75, 95, 5, 60, -10)]
    at_start = after(cell.arm.home_flange(start), PROGRAM_TOOL)
    lines = ["DEF  part( )", "$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}", "$TOOL={X 0,Y 0,Z 180,A 0,B 0,C 0}",
             "PTP {" + ",".join(f"A{j} {math.degrees(q):.6f}" for j, q in enumerate(start, 1)) + "}"]
    for k in range(12):
        shift = (350 * math.cos(k * math.pi / 6) - 350, 700 * math.sin(k * math.pi / 6), -150.0 * (k % 3))
        pose = (at_start[0], tuple(a + b for a, b in zip(at_start[1], shift)))
        lines.append("LIN {{X {:.6f},Y {:.6f},Z {:.6f},A {:.6f},B {:.6f},C {:.6f}}}".format(*pose[1], *kuka(pose[0])))
    (out / "part.src").write_text("\r\n".join(lines + ["END", ""]))
    (out / "part.dat").write_text("\r\n".join(["DEFDAT PART", "ENDDAT", ""]))


def left_by_frame(points, errors):
    """What a shift and a small turn of the frame cannot take off, by least squares."""
    rows, right = [], []
    for (x, y, z), error in zip(points, errors):
        rows += [[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]]
        right += error
    normal = [[sum(row[i] * row[k] for row in rows) for k in range(6)] for i in range(6)]
    frame = solved(normal, [sum(row[i] * value for row, value in zip(rows, right)) for i in range(6)])
    left = [value - sum(a * b for a, b in zip(row, frame)) for row, value in zip(rows, right)]
    return [left[k:k + 3] for k in range(0, len(left), 3)]


def judge_program(options):
    """The controller computes joints by the nominal model, the true arm goes there."""
    cell = Cell(Options(options.robot, options.seed))
    nominal = cell.arm
    programmed = robot_programs.krl(options.shown_as.read_text())
    run = robot_programs.krl(options.program.read_text())
    if len(programmed) != len(run):
        raise SystemExit("the programs have other numbers of targets")
    q, points, errors = list(run[0].value), [], []
    for wanted, target in zip(programmed, run):
        if target.kind == "joints":
            q = list(target.value)
            intended = after(nominal.home_flange(wanted.value), wanted.tool)
        else:
            intended = after(wanted.base, wanted.value)
            flange = after(after(target.base, target.value), inverse(target.tool))
            q = joints_at(nominal.at_foot(), flange, q)
        reached = after(cell.true_flange(q), wanted.tool)
        points.append(intended[1])
        errors.append(difference(intended, reached)[:3])
    off = [length(error) for error in left_by_frame(points, errors)]
    print(f"{sum(off) / len(off):.4f} {max(off):.4f}")


def add_flanges():
    """Poses in R_0, without the base and the tool of the robot file."""
    def at_foot(arm):
        other = Arm.__new__(Arm)
        other.__dict__.update(arm.__dict__, base=NONE, tool=NONE)
        return other
    Arm.at_foot = at_foot
    Arm.home_flange = lambda arm, q: at_foot(arm).pose(q)

    def true_flange(cell, q):
        frame = cell.frame(q)
        return after(after(inverse(cell.truth["base"]), frame), inverse(cell.truth["tool"]))
    Cell.true_flange = true_flange


# ---- the arm under ROS

POSTURES = 26
MOVE_S, STOP_S, STEP_S = 2.5, 1.5, 0.04
CAPTURE_NOISE_MM, CAPTURE_NOISE_RAD = 0.08, 2e-4
CLOCK_OFFSET_S, CLOCK_RATE = -1624000000.0, 8e-5


def rpy(text):
    roll, pitch, yaw = (float(v) for v in text.split())
    return rotation_times(about(Z, yaw), rotation_times(about(Y, pitch), about(X, roll)))


def origin(element):
    found = element.find("origin")
    if found is None:
        return NONE
    return rpy(found.get("rpy", "0 0 0")), tuple(1000 * float(v) for v in found.get("xyz", "0 0 0").split())


class UrdfArm:
    """The joints from base_link to tool0: name, origin, whether it is driven. All turn about z."""

    def __init__(self, path):
        root = xml.etree.ElementTree.parse(path).getroot()
        above = {joint.find("child").get("link"): joint for joint in root.findall("joint") if joint.find("child") is not None}
        self.joints, link = [], "tool0"
        while link != "base_link":
            joint = above[link]
            self.joints.insert(0, [joint.get("name"), origin(joint), joint.get("type") == "revolute"])
            link = joint.find("parent").get("link")
        self.driven = [name for name, _, is_driven in self.joints if is_driven]

    def spoiled(self, rng):
        """The true arm: each driven joint's origin is off but the first and the last."""
        other = UrdfArm.__new__(UrdfArm)
        other.driven = self.driven
        vector = lambda size: tuple(rng.gauss(0, size) for _ in range(3))
        inner = self.driven[1:-1]
        other.joints = [[name, after(place, small_motion(vector(1.5e-3), vector(0.6), (0.0, 0.0, 0.0)))
                         if name in inner else place, is_driven] for name, place, is_driven in self.joints]
        return other

    def pose(self, q):
        here, angles = NONE, iter(q)
        for _, place, is_driven in self.joints:
            here = after(here, place)
            if is_driven:
                here = after(here, (about(Z, next(angles)), (0.0, 0.0, 0.0)))
        return here


def quaternion(r):
    """x, y, z, w of a rotation."""
    w = math.sqrt(max(0.0, 1 + r[0][0] + r[1][1] + r[2][2])) / 2
    x = math.copysign(math.sqrt(max(0.0, 1 + r[0][0] - r[1][1] - r[2][2])) / 2, r[2][1] - r[1][2])
    y = math.copysign(math.sqrt(max(0.0, 1 - r[0][0] + r[1][1] - r[2][2])) / 2, r[0][2] - r[2][0])
    z = math.copysign(math.sqrt(max(0.0, 1 - r[0][0] - r[1][1] + r[2][2])) / 2, r[1][0] - r[0][1])
    return x, y, z, w


def smooth(s):
    return s * s * s * (10 - 15 * s + 6 * s * s)


def draw_posture(rng):
    return [math.radians(rng.uniform(*limits)) for limits in
            ((-150, 150), (-130, -30), (-120, 120), (-150, 150), (-120, 120), (-150, 150))]


def write_ros(options):
    rng, out = random.Random(options.seed), options.out
    nominal = UrdfArm(options.urdf)
    arm = nominal.spoiled(rng)
    # The body is 100 mm off the flange and turned, the capture has its own frame with y up.
    body = (rotation_times(about(Z, 0.7), about(X, -0.4)), (62.0, -35.0, 71.0))
    world = (rotation_times(about(X, -math.pi / 2), about(Z, 0.3)), (1210.0, -740.0, 860.0))
    measured = lambda q: after(after(world, arm.pose(q)), body)
    postures = [draw_posture(rng) for _ in range(POSTURES)]
    visits = []
    for _ in range(1 if options.once else 2):
        order = postures[:]
        rng.shuffle(order)
        visits += order

    def noisy(frame):
        vector = lambda size: tuple(rng.gauss(0, size) for _ in range(3))
        turn = small_motion(vector(CAPTURE_NOISE_RAD), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))[0]
        return rotation_times(turn, frame[0]), tuple(a + b for a, b in zip(frame[1], vector(CAPTURE_NOISE_MM)))

    take, states, start = [], [], 1624114603.0
    names = sorted(nominal.driven)
    end = len(visits) * (MOVE_S + STOP_S)
    for k in range(int(end / STEP_S)):
        t = k * STEP_S
        stop, within = divmod(t, MOVE_S + STOP_S)
        stop = int(stop)
        share = smooth(max(0.0, within - STOP_S) / MOVE_S)
        here, there = visits[stop], visits[min(stop + 1, len(visits) - 1)]
        q = [a + share * (b - a) for a, b in zip(here, there)]
        shown = dict(zip(nominal.driven, q))
        states.append(f"{start + t:.6f}," + ",".join(f"{shown[name] + rng.gauss(0, 2e-5):.6f},0.000000" for name in names))
        seconds = CLOCK_OFFSET_S + (1 + CLOCK_RATE) * (start + t + 0.013)
        if not options.once and stop in (7, 8):  # hidden from the cameras
            take.append(f"{k},{seconds:.6f},,,,,,,,,,,")
            continue
        frame = noisy(measured(q))
        take.append(f"{k},{seconds:.6f}," + ",".join(f"{v:.6f}" for v in quaternion(frame[0])) + "," +
                    ",".join(f"{v / 1000:.6f}" for v in frame[1]) + ",0.000100,1.000000,2.000000,3.000000")
    eight = lambda text: ",".join([text] * 8)
    three = lambda text: ",".join([text] * 3)
    (out / "take.csv").write_text("\n".join([
        "Format Version,1.23,Take Name,arm,Capture Frame Rate,25.000000,Rotation Type,Quaternion,Length Units,Meters,"
        "Coordinate Space,Global", "", f",Type,{eight('Rigid Body')},{three('Marker')}",
        f",Name,{eight('flange body')},{three('Unlabeled 1001')}", ",ID," + eight('"9E20"') + "," + three('"1001"'),
        ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error," + three("Position"),
        "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z", *take]) + "\n")
    (out / "joint_states.csv").write_text("\n".join([
        "__time," + ",".join(f"/joint_states/{name}/position,/joint_states/{name}/velocity" for name in names),
        *states]) + "\n")
    at = (20, -70, 80, -35, 50, 10)
    tool = nominal.pose([math.radians(v) for v in at])
    (out / "tree.txt").write_text(",".join(map(str, at)) + "\n" +
                                  ",".join(f"{v:.4f}" for v in (*tool[1], *kuka(tool[0]))) + "\n")
    unseen = ["pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg"]
    for k in range(30):
        q = draw_posture(rng)
        frame = measured(q)
        unseen.append(f"{k}," + ",".join(f"{v:.9f}" for v in (*map(math.degrees, q), *frame[1], *kuka(frame[0]))))
    (out / "unseen.csv").write_text("\n".join(unseen) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["kuka", "runs", "ros"])
    parser.add_argument("--robot")
    parser.add_argument("--urdf")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("."))
    parser.add_argument("--once", action="store_true")
    parser.add_argument("--program", type=pathlib.Path)
    parser.add_argument("--as", dest="shown_as", type=pathlib.Path)
    options = parser.parse_args()
    add_flanges()
    {"kuka": write_kuka, "runs": judge_program, "ros": write_ros}[options.what](options)


if __name__ == "__main__":
    main()
