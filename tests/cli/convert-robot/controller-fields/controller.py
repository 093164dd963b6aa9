"""controller.py ROBOT FIELDS POSES: a KUKA controller with the model of ROBOT, whose fields are those of the table, shows
other joint angles at the same postures; the largest distance, in mm, of the poses that it computes from those of the
table POSES. Of a robot with a positioner these are seen from the part, and the table says where that is."""

import csv
import math
import re
import sys

import yaml


def product(*frames):
    result = [[float(i == j) for j in range(4)] for i in range(4)]
    for frame in frames:
        result = [[sum(result[i][k] * frame[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
    return result


def about(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    frame = [[float(i == j) for j in range(4)] for i in range(4)]
    a, b = [(1, 2), (2, 0), (0, 1)]["xyz".index(axis)]
    frame[a][a] = frame[b][b] = c
    frame[a][b], frame[b][a] = -s, s
    return frame


def shifted(x, y, z):
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def kuka(x, y, z, a, b, c):
    return product(shifted(x, y, z), about("z", a), about("y", b), about("x", c))


def inverse(frame):
    turned = [[frame[j][i] for j in range(3)] for i in range(3)]
    moved = [-sum(turned[i][k] * frame[k][3] for k in range(3)) for i in range(3)]
    return [turned[i] + [moved[i]] for i in range(3)] + [[0, 0, 0, 1]]


def frame_of(entry):
    return kuka(*(entry.get(key, 0) for key in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")))


robot = yaml.safe_load(open(sys.argv[1]))
fields = list(csv.DictReader(open(sys.argv[2])))
shown = {row["axis"]: float(row["new"]) - float(row["old"]) if row["old"] else float(row["change"])
         for row in fields if row["unit"]}
frames = {row["field"]: kuka(*(float(n) for n in re.findall(r"[XYZABC] ([-.\d]+)", row["new"])))
          for row in fields if row["new"].startswith("{")}


def arm(row):
    tip = product()
    k = 0
    for link in robot["links"]:
        q = 0
        if link["joint"] == "revolute":
            k += 1
            q = link.get("sign", 1) * (float(row[f"q{k}_deg"]) + shown[link["name"]])
        tip = product(tip, about("y", link.get("beta_deg", 0)), about("x", link["alpha_deg"]),
                      shifted(link["d_mm"], 0, 0), about("z", link["theta_deg"] + q), shifted(0, 0, link["r_mm"]))
    return product(tip, frame_of(robot["tool"]))


def part(row):
    if not frames:
        return inverse(frame_of(robot["base"]))
    return product(frames["MACHINE_DEF[].ROOT"], frames["$ET1_TA1KR"], about("z", float(row["e1_deg"])),
                   frames["$ET1_TA2A1"], about("z", float(row["e2_deg"])), frames["$ET1_TFLA3"],
                   frames["BASE_DATA[]"])


worst = 0
for row in csv.DictReader(open(sys.argv[3])):
    tip = product(inverse(part(row)), arm(row))
    worst = max(worst, math.dist([float(row[f"{x}_mm"]) for x in "xyz"], [tip[i][3] for i in range(3)]))
print(f"{worst:.9f}")
