"""Compares the tables of --parameters and --correlations with the robot before and after, both as JSON.

    parameters_check.py PARAMETERS CORRELATIONS NOMINAL.json CALIBRATED.json COEFFICIENTS

COEFFICIENTS: how many rows are those of effects. The correlations are computed anew from `uncertainty` of the calibrated
robot, whose root was written apart from the table; the values are those of the robot files.
"""

import csv
import json
import math
import sys


def scalar(robot, name):
    """The value of a parameter in a robot file; None of turns, which have none."""
    owner, _, component = name.rpartition(".")
    if owner in ("base", "tool"):
        return robot[owner].get(f"{component}_mm")
    link = next(link for link in robot["links"] if link["name"] == owner)
    return link[f"{component}_mm" if component in ("d", "r") else f"{component}_deg"]


def near(a, b, tolerance):
    return abs(a - b) <= tolerance * max(1.0, abs(a), abs(b))


def main():
    parameters, correlations, nominal, calibrated, coefficients = sys.argv[1:]
    rows = list(csv.DictReader(open(parameters)))
    before, after = json.load(open(nominal)), json.load(open(calibrated))
    fit = after["calibration"]
    geometric = rows[:len(rows) - int(coefficients)]
    assert [row["parameter"] for row in geometric] == fit["identified"], rows
    values_of_effects = [c for effect in after["effects"] for c in effect["coefficients"]]
    for row in geometric:
        name = row["parameter"]
        assert row["unit"] == ("deg" if name.rpartition(".")[2] in ("alpha", "theta", "beta", "rx", "ry", "rz") else "mm")
        for column, robot in (("nominal", before), ("value", after)):
            expected = scalar(robot, name)
            assert row[column] == "" if expected is None else float(row[column]) == expected, (name, column, row)
        if row["value"]:
            assert near(float(row["value"]) - float(row["nominal"]), float(row["change"]), 1e-9), row
        assert float(row["std"]) == after["std"][name], row
        middle = float(row["value"] or row["change"])
        low, high = float(row["ci95_low"]), float(row["ci95_high"])
        assert near((low + high) / 2, middle, 1e-9) and low < middle < high
        # Student's t: 1.96 for many poses, 2.1 for twenty.
        assert 1.95 < (high - low) / 2 / float(row["std"]) < 2.1, row
        assert float(row["share_of_readings"]) == fit.get("share_of_readings", {}).get(name, 1)
    for row, c in zip(rows[len(geometric):], values_of_effects):
        assert " follows " in row["parameter"] and row["parameter"].endswith(": " + c["name"])
        assert (float(row["value"]), row["unit"], float(row["std"])) == (c["value"], c["unit"], c["std"]), (row, c)
    table = list(csv.reader(open(correlations)))
    names = [row["parameter"] for row in rows]
    assert table[0] == ["parameter", *names] and [row[0] for row in table[1:]] == names
    # The turn of a base by its rotation vector, about the file's: of a turn of degrees and less.
    turn = math.dist([before["base"][k] for k in ("a_deg", "b_deg", "c_deg")], [after["base"][k] for k in ("a_deg", "b_deg", "c_deg")])
    vector = [float(row["change"]) for row in geometric if row["parameter"] in ("base.rx", "base.ry", "base.rz")]
    assert near(math.hypot(*vector), turn, 1e-3), (vector, turn)
    root, factor = after["uncertainty"]["root"], []
    stated = len(after["uncertainty"]["parameters"]) + int(coefficients)
    for k in range(stated):
        at = k * (k + 1) // 2
        factor.append(root[at:at + k + 1] + [0] * (stated - k - 1))
    covariance = [[math.fsum(a * b for a, b in zip(one, other)) for other in factor] for one in factor]
    for i in range(stated):
        for j in range(stated):
            expected = covariance[i][j] / math.sqrt(covariance[i][i] * covariance[j][j])
            assert abs(float(table[i + 1][j + 1]) - expected) < 2e-4, (names[i], names[j], table[i + 1][j + 1], expected)
    print(f"{len(geometric)} parameters, {coefficients} coefficients, {len(names)} correlations each")


main()
