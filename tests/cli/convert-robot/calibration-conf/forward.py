"""forward.py CONF POSES: largest distance, in mm and mrad, between what a controller computes with its calibration.conf
and poses x,y,z,a,b,c. DH parameters of the UR5e in the maker's convention, from its published table; the file adds to
them."""

import csv
import math
import re
import sys

TYPE = {"theta": [0] * 6, "a": [0, -0.425, -0.3922, 0, 0, 0], "d": [0.1625, 0, 0, 0.1333, 0.0997, 0.0996],
        "alpha": [math.pi / 2, 0, 0, math.pi / 2, -math.pi / 2, 0]}
text = open(sys.argv[1]).read()
dh = {}
for key, nominal in TYPE.items():
    row = re.search(rf"^delta_{key}\s*=\s*\[(.*?)\]", text, re.M)[1].split(",")
    dh[key] = [value + float(added) for value, added in zip(nominal, row, strict=True)]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def about_z(angle, length):
    c, s = math.cos(angle), math.sin(angle)
    return [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, length], [0, 0, 0, 1]]


def along_x(length, angle):
    c, s = math.cos(angle), math.sin(angle)
    return [[1, 0, 0, length], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]]


def rotation(a, b, c):
    ca, sa, cb, sb, cc, sc = (f(v) for v in (a, b, c) for f in (math.cos, math.sin))
    return [[ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
            [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc], [-sb, cb * sc, cb * cc]]


worst = [0.0, 0.0]
for row in csv.DictReader(open(sys.argv[2])):
    tip = [[float(i == j) for j in range(4)] for i in range(4)]
    for k in range(6):
        q = math.radians(float(row[f"q{k + 1}_deg"]))
        tip = product(product(tip, about_z(dh["theta"][k] + q, dh["d"][k])), along_x(dh["a"][k], dh["alpha"][k]))
    worst[0] = max(worst[0], math.dist([float(row[f"{x}_mm"]) for x in "xyz"], [1000 * tip[i][3] for i in range(3)]))
    own = rotation(*(math.radians(float(row[f"{x}_deg"])) for x in "abc"))
    worst[1] = max(worst[1], *(1000 * abs(own[i][j] - tip[i][j]) for i in range(3) for j in range(3)))
print(f"{worst[0]:.9f} {worst[1]:.9f}")
