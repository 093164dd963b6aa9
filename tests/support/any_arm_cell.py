#!/usr/bin/env python3
"""A virtual cell for arms of any joints: the arm of a robot file, with other lengths and zeros and with hidden effects.

    any_arm_cell.py campaign --robot FILE --seed N --poses N [--noise-mm S] [--noise-mrad S] EFFECT... -o measured.csv
    any_arm_cell.py touch --robot FILE --seed N --poses N --contact KIND:NAME:NUMBERS... EFFECT... -o touches.csv
    any_arm_cell.py beam --robot FILE --seed N --poses N --contact plane:NAME:NUMBERS... EFFECT... -o readings.csv
    any_arm_cell.py profile --robot FILE --seed N --poses N --contact KIND:NAME:NUMBERS... EFFECT... -o profiles.csv
    any_arm_cell.py look --robot FILE --seed N --poses N [--noise-px S] [--wrong-ids SHARE] [--at-rest] [--fisheye] [--knock KNOCK] EFFECT... -o images.csv
    any_arm_cell.py reach --robot FILE --seed N --commands FILE EFFECT... -o reached.csv

The arm is the product of exponentials of virtual_cell.py, which shares no code with armtrue. Links between the first and
the last joint are off; foot and flange are where the robot file has them. `campaign` visits every pose twice, in two
random orders; with --other-poses they are others. With --covariances each reading has a noise of its own, a random covariance of its
six numbers about the given size, and states it. `touch` touches each contact in turn: a point X,Y,Z, a plane X,Y,Z,NX,NY,NZ
by its normal, a sphere X,Y,Z,RADIUS; each number that a touch reads is off by the noise. A cube X,Y,Z,A,B,C,EDGE stands for
its faces NAME/+x to NAME/-z, the middle at X,Y,Z, turned by KUKA's angles; what touches has the radius --tip-mm, which moves
planes and faces outwards. `beam` reads how far a laser on the tool, whose zero is 7 mm off, is from each plane in turn, 50 to
600 mm and by at most 60 deg off the normal. `profile` takes 20 points of each plane or sphere in turn by a line scanner on the
tool, whose mounting is off by 4 mm and 2 deg: rays in its plane of 15 deg to both sides of its z axis, noise along z. `look` takes images of a board of
7 by 5 corners, 30 mm apart, by a camera on the arm, or at rest with the board on the arm; all corners are in the image, and the ids of a share of
them are exchanged. Camera and board are in the same places for a seed, and with --other-poses too; with --commands the poses are
those of a table. --knock WHICH:IMAGES:X,Y,Z,RX,RY,RZ: after so many images what is on the arm (`arm`) or at rest (`rest`) sits elsewhere by
a motion in its own axes, mm and degrees. Of a robot file with a
`positioner` all is seen from the part that it carries; its foot, links and zeros are off, too. `reach` writes where the flange truly stands, without noise. The same seed
gives the same arm.

    EFFECT   --sag J:RAD_PER_NM           joint J gives way under gravity
             --cycle J:SIZE:LENGTH        joint J errs by SIZE sin(2 pi value / LENGTH); mm, or degrees
             --gain J:RATIO               joint J moves RATIO of its way too far
Joints count from 1 in the order of the chain. Lengths are mm, angles of the files degrees.
"""

import argparse
import csv
import functools
import math
import pathlib
import random
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from virtual_cell import (NONE, Arm, Effect, about, after, fields, kuka, moved, rotation_times, scaled,  # noqa: E402
                          small_motion, transposed)

SHARE_OF_TRAVEL = 0.8


class State:
    def __init__(self, values, arm):
        self.values, self.arm = values, arm

    @functools.cached_property
    def torque(self):  # which takes longer than the pose, and few effects follow it
        return self.arm.torques(self.values, self.arm.masses)


def joint_columns(text):
    """Column and unit of every driven joint: a link named E1 to E6 is an external axis."""
    columns, number = [], 0
    links = [fields(line) for line in re.findall(r"\{.*\}", re.search(r"^links:(.*(?:\n +.*)*)", text, re.M)[1])]
    for link in links:
        if link["joint"] == "fixed":
            continue
        if re.fullmatch(r"E[1-6]", link["name"]):
            name = "e" + link["name"][1]
        else:
            number += 1
            name = f"q{number}"
        columns.append(name + ("_mm" if link["joint"] == "prismatic" else "_deg"))
    return columns


def positioner_of(text):
    """The positioner as the text of a robot file whose tool is the part; None without one."""
    block = re.search(r"^positioner:\n((?: +.*\n)*)", text, re.M)
    if not block:
        return None
    return re.sub(r"^part:", "tool:", re.sub(r"^  ", "", block[1], flags=re.M), flags=re.M)


class Cell:
    def __init__(self, options):
        text = pathlib.Path(options.robot).read_text()
        self.arm, self.columns, rng = Arm(text), joint_columns(text), random.Random(options.seed)
        joints = len(self.arm.axes)
        vector = lambda size: tuple(rng.gauss(0, size) for _ in range(3))
        links = [small_motion(vector(3e-4), vector(0.3), point) for point in self.arm.points]
        zeros = [rng.gauss(0, 1.5) if slides else rng.gauss(0, 1.5e-3) for slides in self.arm.slides]
        links[0], zeros[0], zeros[-1] = NONE, 0.0, 0.0
        self.truth = {"base": self.arm.base, "tool": self.arm.tool, "links": links + [NONE], "zeros": zeros}
        self.effect = Effect("hidden", "", joints=lambda state: self.errors(state, options))
        self.rng, self.joints = random.Random(options.seed + (2 if options.other_poses else 1)), joints
        self.travel, self.slides, self.table = list(self.arm.travel), list(self.arm.slides), None
        if positioner := positioner_of(text):
            self.add_positioner(positioner, rng)

    def add_positioner(self, text, rng):
        self.table = Arm(text)
        self.columns, self.travel = self.columns + joint_columns(text), self.travel + self.table.travel
        self.slides = self.slides + self.table.slides
        vector = lambda size: tuple(rng.gauss(0, size) for _ in range(3))
        place = lambda: small_motion(vector(2e-3), vector(2), NONE[1])
        links = [small_motion(vector(3e-4), vector(0.3), point) for point in self.table.points]
        self.table_truth = {"base": after(place(), self.table.base), "links": links + [NONE],
                            "zeros": [rng.gauss(0, 1.5e-3) for _ in self.table.points], "tool": after(self.table.tool, place())}

    def errors(self, state, options):
        total = {}
        add = lambda joint, error: total.__setitem__(joint, total.get(joint, 0.0) + error)
        for joint, softness in options.sag:
            add(joint, softness * state.torque[joint])
        for joint, ratio in options.gain:
            add(joint, ratio * state.values[joint])
        for joint, size, cycle in options.cycle:
            unit = 1.0 if self.arm.slides[joint] else math.radians(1)
            add(joint, size * unit * math.sin(2 * math.pi * state.values[joint] / (cycle * unit)))
        return total

    def frame(self, values):
        """Where the tool is, seen from the part if a positioner carries it."""
        own, others = values[:self.joints], values[self.joints:]
        state = State(own, self.arm)
        tool = self.arm.pose(own, self.truth, self.effect, 1.0, state)
        if not self.table:
            return tool
        rotation, point = self.table.pose(others, self.table_truth)
        back = transposed(rotation)
        return after((back, scaled(moved((back, NONE[1]), point), -1)), tool)

    def draw(self):
        values = []
        for low, high in self.travel:
            middle, half = (low + high) / 2, SHARE_OF_TRAVEL * (high - low) / 2
            values.append(self.rng.uniform(middle - half, middle + half))
        return values

    def shown(self, values):
        return [value if slides else math.degrees(value) for value, slides in zip(values, self.slides)]


AXES = ("x", "y", "z", "rx", "ry", "rz")
PAIRS = [(i, k) for i in range(6) for k in range(i, 6)]


def covariance_columns():
    unit = lambda i, k: "_mm2" if k < 3 else "_deg2" if i > 2 else "_mm_deg"
    return [f"cov_{AXES[i]}{AXES[k]}{unit(i, k)}" for i, k in PAIRS]


def correlated_noise(rng, options):
    """Six errors, mm and mrad, and their covariance in mm and deg."""
    sizes = [size * math.exp(rng.uniform(-2, 2)) for size in 3 * [options.noise_mm] + 3 * [options.noise_mrad]]
    share = lambda i, k: 0.0 if k > i else 0.3 + abs(rng.gauss(0, 1)) if k == i else rng.gauss(0, 1)
    root = [[sizes[i] * share(i, k) for k in range(6)] for i in range(6)]
    drawn = [rng.gauss(0, 1) for _ in range(6)]
    errors = [sum(r * z for r, z in zip(row, drawn)) for row in root]
    unit = 3 * [1.0] + 3 * [math.degrees(1e-3)]
    return errors, [unit[i] * unit[k] * sum(a * b for a, b in zip(root[i], root[k])) for i, k in PAIRS]


def campaign(cell, options):
    writer = csv.writer(options.output, lineterminator="\n")
    stated = covariance_columns() if options.covariances else []
    writer.writerow(["pose", "repeat", "t_s", *cell.columns, "x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg", *stated])
    poses, t, rng = [cell.draw() for _ in range(options.poses)], 0, cell.rng
    for repeat in (1, 2):
        order = list(range(options.poses))
        rng.shuffle(order)
        for pose in order:
            rotation, point = cell.frame(poses[pose])
            covariance = []
            if options.covariances:
                errors, covariance = correlated_noise(rng, options)
            else:
                errors = [rng.gauss(0, options.noise_mrad) for _ in range(3)]
                errors = [rng.gauss(0, options.noise_mm) for _ in range(3)] + errors
            noise = small_motion(tuple(error / 1000 for error in errors[3:]), NONE[1], NONE[1])
            point = [x + error for x, error in zip(point, errors)]
            angles = kuka(rotation_times(noise[0], rotation))
            writer.writerow([pose + 1, repeat, t, *(f"{value:.9f}" for value in cell.shown(poses[pose])),
                             *(f"{x:.6f}" for x in point), *(f"{x:.8f}" for x in angles),
                             *(f"{c:.15g}" for c in covariance)])
            t += 20


def off_contact(point, contact):
    """How far a point is off a contact: three numbers, or one."""
    away = [x - c for x, c in zip(point, contact["place"])]
    if contact["kind"] == "point":
        return away
    if contact["kind"] == "plane":
        size = math.hypot(*contact["shape"])
        return [sum(x * n for x, n in zip(away, contact["shape"])) / size]
    return [math.hypot(*away) - contact["shape"][0]]


def least_change(rows, wanted):
    """The shortest x with rows x = wanted."""
    size = len(rows)
    system = [[sum(a * b for a, b in zip(rows[i], rows[k])) for k in range(size)] + [wanted[i]] for i in range(size)]
    for i in range(size):
        pivot = max(range(i, size), key=lambda k: abs(system[k][i]))
        system[i], system[pivot] = system[pivot], system[i]
        for k in range(size):
            if k != i:
                share = system[k][i] / system[i][i]
                system[k] = [a - share * b for a, b in zip(system[k], system[i])]
    weights = [system[i][size] / system[i][i] for i in range(size)]
    return [sum(w * row[j] for w, row in zip(weights, rows)) for j in range(len(rows[0]))]


def solved(cell, miss, steps, close):
    """Joint values at which the arm misses by nothing, by Newton's steps from a random posture; None if it does not get there."""
    values, units = cell.draw(), [1.0 if slides else 1e-3 for slides in cell.slides]
    for _ in range(steps):
        here = miss(values)
        if math.hypot(*here) < close:
            return values if all(low <= v <= high for v, (low, high) in zip(values, cell.travel)) else None
        columns = []
        for j, unit in enumerate(units):
            beside = list(values)
            beside[j] += 1e-4 * unit
            columns.append([(b - h) / 1e-4 for b, h in zip(miss(beside), here)])
        try:
            change = least_change([list(row) for row in zip(*columns)], [-h for h in here])
        except ZeroDivisionError:
            return None
        longest = max(abs(c) for c in change)
        values = [v + c * unit * min(1, 500 / longest) for v, c, unit in zip(values, change, units)]
    return None


def approach(cell, contact, noise):
    """Joint values at which the arm touches."""
    return solved(cell, lambda q: [x - n for x, n in zip(off_contact(cell.frame(q)[1], contact), noise)], 40, 1e-7)


def touch(cell, options):
    writer = csv.writer(options.output, lineterminator="\n")
    writer.writerow(["pose", "t_s", *cell.columns, "contact"])
    for pose in range(options.poses):
        contact, values = options.contact[pose % len(options.contact)], None
        noise = [cell.rng.gauss(0, options.noise_mm) for _ in range(3)]
        while values is None:
            values = approach(cell, contact, noise)
        writer.writerow([pose + 1, 20 * pose, *(f"{value:.9f}" for value in cell.shown(values)), contact["name"]])


LASER = ((40.0, -25.0, 67.0), (0.2, -0.35, 0.9))  # origin, where it would read 0, and direction, from the tool


def beam(cell, options):
    writer = csv.writer(options.output, lineterminator="\n")
    writer.writerow(["pose", "t_s", *cell.columns, "contact", "l_mm"])
    size = math.hypot(*LASER[1])
    pose = 0
    while pose < options.poses:
        plane = options.contact[pose % len(options.contact)]
        values = cell.draw()
        frame = cell.frame(values)
        origin, end = moved(frame, LASER[0]), moved(frame, tuple(o + d / size for o, d in zip(*LASER)))
        normal = [n / math.hypot(*plane["shape"]) for n in plane["shape"]]
        cosine = sum(n * (e - o) for n, e, o in zip(normal, end, origin))
        if abs(cosine) < 0.5:
            continue
        length = sum(n * (p - o) for n, p, o in zip(normal, plane["place"], origin)) / cosine
        if not 50 < length < 600:
            continue
        pose += 1
        length += cell.rng.gauss(0, options.noise_mm)
        writer.writerow([pose, 20 * pose, *(f"{value:.9f}" for value in cell.shown(values)), plane["name"], f"{length:.6f}"])


SENSOR = (rotation_times(about((0.0, 0.0, 1.0), 0.03), about((1.0, 0.0, 0.0), -0.02)), (3.0, -2.0, 2.0))  # from the tool


def length_of_ray(contact, origin, along):
    """How far along a ray a plane or a sphere is; None if the ray misses it or meets it too obliquely."""
    away = [c - o for c, o in zip(contact["place"], origin)]
    if contact["kind"] == "plane":
        size = math.hypot(*contact["shape"])
        cosine = sum(n * d for n, d in zip(contact["shape"], along)) / size
        if abs(cosine) < 0.5:
            return None
        return sum(n * a for n, a in zip(contact["shape"], away)) / size / cosine
    middle, radius = sum(a * d for a, d in zip(away, along)), contact["shape"][0]
    beside = sum(a * a for a in away) - middle ** 2
    return None if beside > 0.75 * radius ** 2 else middle - math.sqrt(radius ** 2 - beside)


def profile_of(cell, values, contact):
    """Points (y, z) of the profile; None unless all rays end on the contact."""
    sensor, points = after(cell.frame(values), SENSOR), []
    for k in range(20):
        angle = math.radians(15) * (k - 9.5) / 9.5
        along = moved((sensor[0], NONE[1]), (0.0, math.sin(angle), math.cos(angle)))
        length = length_of_ray(contact, sensor[1], along)
        if length is None or not 80 < length < 400:
            return None
        points.append((length * math.sin(angle), length * math.cos(angle) + cell.rng.gauss(0, cell.noise)))
    return points


def profile(cell, options):
    """The middle of a sphere, or a place on a plane, is brought before the sensor."""
    writer, pose, rng = csv.writer(options.output, lineterminator="\n"), 0, cell.rng
    writer.writerow(["pose", "t_s", *cell.columns, "contact", "profile_y_mm", "profile_z_mm"])
    frame, cell.noise = cell.frame, options.noise_mm
    while pose < options.poses:
        contact = options.contact[pose % len(options.contact)]
        away = rng.uniform(120, 300) + (contact["shape"][0] if contact["kind"] == "sphere" else 0)
        spread = 0 if contact["kind"] == "sphere" else 300
        place = [x + rng.uniform(-spread, spread) for x in contact["place"]]
        cell.frame = lambda values: after(frame(values), (NONE[0], (0.0, 0.0, away)))
        values = approach(cell, {"kind": "point", "place": place}, (0, 0, 0))
        cell.frame = frame
        points = profile_of(cell, values, contact) if values else None
        if not points:
            continue
        pose += 1
        for y, z in points:
            writer.writerow([pose, 20 * pose, *(f"{value:.9f}" for value in cell.shown(values)), contact["name"], f"{y:.6f}", f"{z:.6f}"])


COLUMNS, ROWS, PITCH = 7, 5, 30.0
IMAGE = (1280, 960)
LENS = {"fx": 1200.0, "fy": 1205.0, "cx": 660.0, "cy": 470.0}
PINHOLE = {"k1": -0.12, "k2": 0.08, "p1": 7e-4, "p2": -4e-4, "k3": 0.01}
FISHEYE = {"k1": 0.03, "k2": -0.01, "k3": 0.004, "k4": -0.001}


def pixel(point, fisheye):
    """OpenCV's models of a lens; None of a point that the camera does not see."""
    if point[2] < 50:
        return None
    x, y = point[0] / point[2], point[1] / point[2]
    r = math.hypot(x, y)
    if fisheye:
        a = math.atan(r)
        bent = a * (1 + sum(k * a ** (2 * power + 2) for power, k in enumerate(FISHEYE.values())))
        x, y = (x * bent / r, y * bent / r) if r > 0 else (x, y)
    else:
        k1, k2, p1, p2, k3 = PINHOLE.values()
        g = 1 + k1 * r ** 2 + k2 * r ** 4 + k3 * r ** 6
        x, y = (x * g + 2 * p1 * x * y + p2 * (r * r + 2 * x * x), y * g + p1 * (r * r + 2 * y * y) + 2 * p2 * x * y)
    u, v = LENS["fx"] * x + LENS["cx"], LENS["fy"] * y + LENS["cy"]
    return (u, v) if 0 <= u < IMAGE[0] and 0 <= v < IMAGE[1] else None


def inverse(frame):
    back = transposed(frame[0])
    return back, scaled(moved((back, NONE[1]), frame[1]), -1)


def view(rng):
    """A board before a camera, of which it sees all."""
    rotation = about((0.0, 0.0, 1.0), rng.uniform(-math.pi, math.pi))
    for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)):
        rotation = rotation_times(about(axis, rng.uniform(-0.6, 0.6)), rotation)
    depth = rng.uniform(400, 800)
    middle = (depth * rng.uniform(-0.35, 0.35), depth * rng.uniform(-0.25, 0.25), depth)
    own = moved((rotation, NONE[1]), ((COLUMNS - 1) * PITCH / 2, (ROWS - 1) * PITCH / 2, 0.0))
    return rotation, tuple(m - o for m, o in zip(middle, own))


def go_to(cell, goal):
    """Joint values at which the measured frame is there."""
    def miss(values):
        rotation, point = cell.frame(values)
        turn = rotation_times(goal[0], transposed(rotation))
        skew = [turn[2][1] - turn[1][2], turn[0][2] - turn[2][0], turn[1][0] - turn[0][1]]
        trace = turn[0][0] + turn[1][1] + turn[2][2]
        angle = math.atan2(math.hypot(*skew), trace - 1)
        size = math.hypot(*skew) or 1.0
        return [p - g for p, g in zip(point, goal[1])] + [-1000 * angle * s / size for s in skew]
    return solved(cell, miss, 30, 1e-6)


def look(cell, options):
    mount = (rotation_times(about((0.0, 0.0, 1.0), 0.3), about((0.0, 1.0, 0.0), -0.2)), (50.0, -30.0, 80.0))
    places, corners = random.Random(options.seed), [(i % COLUMNS * PITCH, i // COLUMNS * PITCH, 0.0) for i in range(COLUMNS * ROWS)]
    cell.rng, rng = places, cell.rng
    postures = [cell.draw() for _ in range(30)]
    reach_of = lambda values: math.hypot(*(a - b for a, b in zip(cell.frame(values)[1], cell.arm.base[1])))
    middle = sorted(postures, key=reach_of)[len(postures) // 2]
    first = view(places)
    rest = after(after(cell.frame(middle), mount), inverse(first) if options.at_rest else first)
    cell.rng = rng
    writer = csv.writer(options.output, lineterminator="\n")
    writer.writerow(["pose", *cell.columns, "corner", "u_px", "v_px"])

    def sights():
        while True:
            wanted = view(rng)
            of_measured = after(rest, wanted if options.at_rest else inverse(wanted))
            if values := go_to(cell, after(of_measured, inverse(mount))):
                yield None, values

    pose = 0
    for name, values in commanded(cell, options) if options.commands else sights():
        if options.knock and pose >= options.knock[1]:
            which, _, motion = options.knock
            mount, rest = (after(mount, motion), rest) if which == "arm" else (mount, after(rest, motion))
            options.knock = None
        measured = after(cell.frame(values), mount)
        seen = after(inverse(rest), measured) if options.at_rest else after(inverse(measured), rest)
        pixels = [pixel(moved(seen, corner), options.fisheye) for corner in corners]
        if None in pixels:
            if options.commands:
                sys.exit(f"pose {name} does not show the whole board")
            continue
        pose += 1
        ids = list(range(len(corners)))
        for corner in ids[:]:
            if rng.random() < options.wrong_ids / 2:
                other = rng.randrange(len(corners))
                ids[corner], ids[other] = ids[other], ids[corner]
        for corner, (u, v) in zip(ids, pixels):
            u, v = u + rng.gauss(0, options.noise_px), v + rng.gauss(0, options.noise_px)
            writer.writerow([name or pose, *(f"{value:.9f}" for value in cell.shown(values)), corner, f"{u:.4f}", f"{v:.4f}"])
        if not options.commands and pose == options.poses:
            break


def commanded(cell, options):
    """The poses of the table --commands: name and joint values."""
    for row in csv.DictReader(options.commands):
        yield row["pose"], [float(row[column]) if column.endswith("_mm") else math.radians(float(row[column]))
                            for column in cell.columns]


def reach(cell, options):
    writer = csv.writer(options.output, lineterminator="\n")
    writer.writerow(["pose", "x_mm", "y_mm", "z_mm"])
    for name, values in commanded(cell, options):
        writer.writerow([name, *(f"{x:.6f}" for x in cell.frame(values)[1])])


def numbers(text):
    joint, *rest = text.split(":")
    return (int(joint) - 1, *(float(number) for number in rest))


def knock(text):
    which, images, motion = text.split(":")
    x, y, z, *turn = (float(number) for number in motion.split(","))
    return which, int(images), small_motion(tuple(math.radians(angle) for angle in turn), (x, y, z), NONE[1])


def contacts_of(text):
    kind, name, values = text.split(":")
    values = [float(number) for number in values.split(",")]
    if kind != "cube":
        return [{"kind": kind, "name": name, "place": values[:3], "shape": values[3:]}]
    a, b, c = (math.radians(angle) for angle in values[3:6])
    turned = rotation_times(about((0.0, 0.0, 1.0), a), rotation_times(about((0.0, 1.0, 0.0), b), about((1.0, 0.0, 0.0), c)))
    faces = []
    for axis in range(3):
        for side in (1, -1):
            normal = [side * row[axis] for row in turned]
            place = [m + n * values[6] / 2 for m, n in zip(values[:3], normal)]
            faces.append({"kind": "plane", "name": f"{name}/{'-+'[side > 0]}{'xyz'[axis]}", "place": place, "shape": normal})
    return faces


def grown(contact, tip):
    """A plane as the middle of a ball of this radius touches it."""
    if contact["kind"] != "plane":
        return contact
    size = math.hypot(*contact["shape"])
    return {**contact, "place": [p + tip * n / size for p, n in zip(contact["place"], contact["shape"])]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["campaign", "touch", "beam", "profile", "look", "reach"])
    parser.add_argument("--robot", required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--poses", type=int, default=60)
    parser.add_argument("--noise-mm", type=float, default=0.05)
    parser.add_argument("--noise-mrad", type=float, default=0.05)
    parser.add_argument("--noise-px", type=float, default=0.3)
    parser.add_argument("--wrong-ids", type=float, default=0.0)
    parser.add_argument("--at-rest", action="store_true", help="the camera; the board is on the arm")
    parser.add_argument("--fisheye", action="store_true")
    parser.add_argument("--knock", type=knock)
    parser.add_argument("--other-poses", action="store_true")
    parser.add_argument("--covariances", action="store_true")
    parser.add_argument("--commands", type=argparse.FileType("r"))
    parser.add_argument("--contact", type=contacts_of, action="extend", default=[])
    parser.add_argument("--tip-mm", type=float, default=0.0)
    parser.add_argument("-o", dest="output", type=argparse.FileType("w"), default=sys.stdout)
    for effect in ("--sag", "--cycle", "--gain"):
        parser.add_argument(effect, type=numbers, action="append", default=[])
    options = parser.parse_args()
    cell = Cell(options)
    options.contact = [grown(contact, options.tip_mm) for contact in options.contact]
    with options.output:  # what collects cycles may close a file before its last lines are in it
        {"campaign": campaign, "touch": touch, "beam": beam, "profile": profile, "look": look, "reach": reach}[options.what](cell, options)


if __name__ == "__main__":
    main()
