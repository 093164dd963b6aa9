"""AP, RP and vAP of measured.csv against the points of commanded.csv, by the formulas of ISO 9283, and the largest."""
import collections
import csv
import math
import statistics
import sys


def mean(points):
    return [statistics.fmean(axis) for axis in zip(*points)]


def point(row):
    return [float(row[key]) for key in ("x_mm", "y_mm", "z_mm")]


command = {row["pose"]: point(row) for row in csv.DictReader(open(sys.argv[2]))}
visits = collections.defaultdict(list)
for row in csv.DictReader(open(sys.argv[1])):
    visits[row["pose"]].append((tuple(int(row[f"dir{j}"]) for j in range(1, 7)), point(row)))
ap, rp, vap = {}, {}, {}
for pose, list_ in visits.items():
    centre = mean([x for _, x in list_])
    lengths = [math.dist(x, centre) for _, x in list_]
    ap[pose] = math.dist(centre, command[pose])
    rp[pose] = statistics.fmean(lengths) + 3 * statistics.stdev(lengths)
    by_direction = collections.defaultdict(list)
    for direction, x in list_:
        if any(direction):
            by_direction[direction].append(x)
    means = [mean(group) for group in by_direction.values() if len(group) > 1]
    vap[pose] = max((math.dist(a, b) for a in means for b in means), default=0)
for name, values in (("ap", ap), ("rp", rp), ("vap", vap)):
    pose = max(values, key=values.get)
    print(f"{name} {values[pose]:.4g} {pose}")
