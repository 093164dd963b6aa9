"""Programs whose corrected joints land within 0.004 deg of where T, cf or CONFIG change, and what is written for them.

    turns.py make CONFIG KIND PROGRAM              also writes KIND.yaml, the identified arm
    turns.py check CONFIG KIND PROGRAM CORRECTED   how many points contradict what they state
"""

import json
import math
import random
import re
import sys

import yaml

ROBOTS = {"krl": "kr10-r1100", "rapid": "irb6700-200-260", "fanuc": "r2000ic-165f"}
STEP, SMALLEST_STEP = 1e-6, 1e-13  # rad


def product(a, b):
    columns = list(zip(*b))
    return [[u * x + v * y + w * z + t * o for x, y, z, o in columns] for u, v, w, t in a]


def unit():
    return [[float(i == j) for j in range(4)] for i in range(4)]


def rotation(axis, angle):
    pose, c, s = unit(), math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    pose[i][i], pose[i][j], pose[j][i], pose[j][j] = c, -s, s, c
    return pose


def shift(x, y, z):
    pose = unit()
    pose[0][3], pose[1][3], pose[2][3] = x, y, z
    return pose


def pose_of(links, q):
    pose, joints = unit(), iter(q)
    for link in links:
        turn = math.radians(link["theta_deg"]) + (next(joints) if link["joint"] == "revolute" else 0)
        fixed = rotation(0, math.radians(link["alpha_deg"]))
        fixed[0][3] = link["d_mm"]
        moved = rotation(2, turn)
        moved[2][3] = link["r_mm"]
        pose = product(product(pose, fixed), moved)
    return pose


def difference(wanted, reached):
    turn = [[sum(wanted[i][k] * reached[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    axis = [turn[2][1] - turn[1][2], turn[0][2] - turn[2][0], turn[1][0] - turn[0][1]]
    return [wanted[i][3] - reached[i][3] for i in range(3)] + [500 * a for a in axis]


def solved(columns, right):
    """Gauss with pivots; the matrix is given by its columns."""
    rows = [[column[i] for column in columns] + [right[i]] for i in range(6)]
    for i in range(6):
        pivot = max(range(i, 6), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(6):
            if k != i:
                factor = rows[k][i] / rows[i][i]
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i])]
    return [rows[i][6] / rows[i][i] for i in range(6)]


def joints_of(links, wanted, q):
    for _ in range(8):
        here = pose_of(links, q)
        columns = []
        for j in range(6):
            moved = pose_of(links, [v + STEP * (k == j) for k, v in enumerate(q)])
            columns.append([v / STEP for v in difference(moved, here)])
        steps = solved(columns, difference(wanted, here))
        q = [v + step for v, step in zip(q, steps)]
        if max(map(abs, steps)) < SMALLEST_STEP:
            break
    return q


def numbers_of(kind, pose):
    place = [pose[i][3] for i in range(3)]
    if kind != "rapid":
        b = math.atan2(-pose[2][0], math.hypot(pose[0][0], pose[1][0]))
        abc = [math.atan2(pose[1][0], pose[0][0]), b, math.atan2(pose[2][1], pose[2][2])]
        return place + [math.degrees(angle) for angle in (abc if kind == "krl" else reversed(abc))]
    w = math.sqrt(max(0, 1 + pose[0][0] + pose[1][1] + pose[2][2])) / 2
    if w < 0.1:
        return None
    xyz = [pose[2][1] - pose[1][2], pose[0][2] - pose[2][0], pose[1][0] - pose[0][1]]
    return place + [w] + [v / (4 * w) for v in xyz]


def pose_of_numbers(kind, n):
    pose = shift(*n[:3])
    if kind != "rapid":
        for axis, angle in zip((2, 1, 0), n[3:] if kind == "krl" else reversed(n[3:])):
            pose = product(pose, rotation(axis, math.radians(angle)))
        return pose
    length = math.sqrt(sum(v * v for v in n[3:]))
    w, x, y, z = (v / length for v in n[3:])
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    for i in range(3):
        pose[i][:3] = turn[i]
    return pose


def stated(kind, q):
    if kind == "krl":
        return [sum(1 << j for j in range(6) if q[j] < 0)]
    if kind == "fanuc":
        return [round(math.degrees(q[j]) / 360) for j in (3, 4, 5)]
    return [math.floor(math.degrees(q[j]) / 90) for j in (0, 3, 5)]


def line_of(kind, numbers, state):
    if kind == "fanuc":
        n = [f"{k} = {value:.3f} {'mm' if k in 'XYZ' else 'deg'}" for k, value in zip("XYZWPR", numbers)]
        return f"   UF : 0, UT : 1, CONFIG : 'N U T, {state[0]}, {state[1]}, {state[2]}', " + ", ".join(n)
    n = [f"{value:.4f}" if kind == "krl" or i < 3 else f"{value:.8f}" for i, value in enumerate(numbers)]
    if kind == "krl":
        return "PTP {" + ",".join(f"{k} {v}" for k, v in zip("XYZABC", n)) + f",S 6,T {state[0]}}}"
    external = ",".join(["9E9"] * 6)
    cf = ",".join(map(str, state))
    return f"MoveJ [[{','.join(n[:3])}],[{','.join(n[3:])}],[{cf},0],[{external}]],v100,fine,tool0;"


def read(kind, line):
    number = r"(-?\d+\.?\d*)"
    if kind == "krl":
        values = [float(re.search(rf"\b{k} {number}", line)[1]) for k in "XYZABCT"]
        return values[:6], [int(values[6])]
    if kind == "fanuc":
        values = [float(re.search(rf"\b{k} *= *{number}", line)[1]) for k in "XYZWPR"]
        return values, [int(v) for v in re.search(r"T, (-?\d), (-?\d), (-?\d)", line).groups()]
    values = [float(v) for v in re.findall(number, line.split("[[")[1])]
    return values[:7], [int(v) for v in values[7:10]]


def near_border(random_, kind):
    """Joint angles, some within 0.004 deg of where what a point states changes."""

    def near(*of):
        return random_.choice(of) + random_.uniform(-0.004, 0.004)

    if kind == "krl":
        q = [random_.uniform(-80, 80), random_.uniform(-120, -60), random_.uniform(60, 120)]
        q += [near(0, 30), random_.uniform(20, 80), near(0, -40)]
    elif kind == "fanuc":
        q = [random_.uniform(-80, 80), random_.uniform(-20, 40), random_.uniform(-40, 20)]
        q += [random_.uniform(-40, 40), random_.uniform(-120, -40), near(180, -180)]
    else:
        q = [near(0, 90, -90), random_.uniform(-20, 40), random_.uniform(-40, 30)]
        q += [near(0, 90, -90), random_.uniform(30, 90), near(0, 90, -90)]
    return [math.radians(angle) for angle in q]


def make(kind, links, closed, path):
    random_ = random.Random(5)
    lines, angles = [], []
    while len(lines) < 120:
        want = near_border(random_, kind)
        wanted = pose_of(closed, want)
        numbers = numbers_of(kind, wanted)
        if not numbers:
            continue
        q = joints_of(links, wanted, want)
        line = line_of(kind, numbers, stated(kind, q))
        as_written = joints_of(links, pose_of_numbers(kind, read(kind, line)[0]), q)
        if stated(kind, as_written) == stated(kind, q):
            lines.append(line)
            angles.append(as_written)
    head, end = "DEF turns()\n$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\n", "END\n"
    if kind == "rapid":
        head, end = "MODULE turns\nPROC main()\n", "ENDPROC\nENDMODULE\n"
    if kind == "fanuc":
        moves = [f"{i + 1}:J P[{i + 1}] 50% FINE ;" for i in range(len(lines))]
        lines = [f"P[{i + 1}]{{\n   GP1:\n{line}\n}};" for i, line in enumerate(lines)]
        head, end = "/PROG TURNS\n/MN\n" + "\n".join(moves) + "\n/POS\n", "/END\n"
    with open(path, "w") as file:
        file.write(head + "\n".join(lines) + "\n" + end)
    with open(path + ".json", "w") as file:
        json.dump(angles, file)


def check(kind, links, path, corrected):
    move = {"krl": "PTP {", "rapid": "MoveJ", "fanuc": "   UF"}[kind]
    with open(corrected) as file:
        lines = [line for line in file if line.startswith(move)]
    with open(path + ".json") as file:
        angles = json.load(file)
    wrong = 0
    for q, line in zip(angles, lines, strict=True):
        numbers, state = read(kind, line)
        wrong += stated(kind, joints_of(links, pose_of_numbers(kind, numbers), q)) != state
    print(f"{kind}: {wrong} of {len(lines)} contradict their numbers")


def main(what, config, kind, path, *corrected):
    with open(f"{config}/robots/{ROBOTS[kind]}.yaml") as file:
        robot = yaml.safe_load(file)
    links = robot["links"]
    if what == "check":
        return check(kind, links, path, *corrected)
    changed = [dict(link) for link in links]
    for at, key, by in [(1, "theta_deg", 0.04), (2, "d_mm", 0.4), (3, "alpha_deg", 0.03), (4, "theta_deg", -0.02)]:
        changed[at][key] += by
    with open(f"{kind}.yaml", "w") as file:
        yaml.safe_dump({**robot, "links": changed}, file, sort_keys=False)
    make(kind, links, changed, path)


main(*sys.argv[1:])
