#!/usr/bin/env python3
"""Mistakes of people, made in shipped or simulated data: none leaves a plausible result without a word. A line of the
table says what the command answers: exit code and words. Exit 0 is a warning, which stands in the document as well.

    mistakes_test.py BIN [-v] [NAME...]
"""

import csv
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config"
ROBOT = CONFIG / "robots/kr360-spindle.yaml"
UNDECLARED = CONFIG / "robots/kr360-undeclared.yaml"
ABOUT = CONFIG.parent / "tests/cli/certify/about.yaml"
ROUGHING = CONFIG / "robots/kr360-roughing.yaml"
CAMPAIGN = CONFIG / "campaigns/tutorial.csv"
LINE = CONFIG / "paths/line300.csv"
BIN = FOLDER = None

POINT = ("x_mm", "y_mm", "z_mm")
FORCE = ("fx_n", "fy_n", "fz_n")
JOINTS = tuple(f"q{j}_deg" for j in range(1, 7))
ANGLES = ("a_deg", "b_deg", "c_deg")
ANCHORS = ('anchors: {"1": {x_mm: 2500, y_mm: 1500, z_mm: 100}, "2": {x_mm: 2500, y_mm: -1500, z_mm: 300}, '
           '"3": {x_mm: -500, y_mm: 2800, z_mm: 1500}}')


def run(command, *arguments):
    return subprocess.run([str(BIN / command), *map(str, arguments)], cwd=FOLDER, capture_output=True, text=True)


def make(command, *arguments):
    done = run(command, *arguments)
    assert done.returncode == 0, done.stderr


def rows(path):
    with open(FOLDER / path) as file:
        return list(csv.DictReader(file))


def written(name, table):
    with open(FOLDER / name, "w") as file:
        writer = csv.DictWriter(file, table[0].keys())
        writer.writeheader()
        writer.writerows(table)
    return name


def changed(source, change, name="changed.csv"):
    """A table with a mistake; `change` gets all rows, or returns the new ones."""
    table = rows(source)
    return written(name, change(table) or table)


def each(change, where=lambda row: True):
    def all_rows(table):
        for row in table:
            if where(row):
                change(row)
    return all_rows


def scale(columns, factor, where=lambda row: True):
    return each(lambda row: row.update({c: repr(float(row[c]) * factor) for c in columns}), where)


def every(n):
    return lambda row: int(row["pose"]) % n == 0


def without(*columns):
    return each(lambda row: [row.pop(c) for c in columns])


def in_turn(*changes):
    def all_rows(table):
        for change in changes:
            table = change(table) or table
        return table
    return all_rows


def exchange(a, b, where=lambda row: True):
    return each(lambda row: row.update({a: row[b], b: row[a]}), where)


def add(column, value, where=lambda row: True):
    return each(lambda row: row.update({column: repr(float(row[column]) + value)}), where)


def twice(table):
    return table + [dict(row) for row in table]


def later_copies(table):
    return table + [dict(row, t_s=repr(float(row["t_s"]) + 1e5)) for row in table]


def copies_of_poses(table):
    return table + [dict(row, pose=row["pose"] + "b", t_s=repr(float(row["t_s"]) + 1e5)) for row in table]


def numbered_copies(table):
    return table + [dict(row, repeat=str(int(row["repeat"]) + 9), t_s=repr(float(row["t_s"]) + 1e5)) for row in table]


def rows_late(late):
    """The readings stand some rows later than their joint angles."""
    def all_rows(table):
        read = [{c: row[c] for c in POINT + ANGLES} for row in table]
        for row, reading in zip(table, read[-late:] + read[:-late]):
            row.update(reading)
    return all_rows


def while_off(table):
    """Some millimetres off in every reading for a sixth of the time."""
    table.sort(key=lambda row: float(row["t_s"]))
    for row in table[60:90]:
        row["z_mm"] = repr(float(row["z_mm"]) + 3)


def time_of_day(seconds):
    minutes, s = divmod(float(seconds), 60)
    return f"{int(minutes // 60) + 8:02}:{int(minutes % 60):02}:{s:06.3f}"


def clock_reset(table):
    table.sort(key=lambda row: float(row["t_s"]))
    for number, row in enumerate(table):
        row["t_s"] = str(20 * (number % 120))


def turned(a, b, degrees, where=lambda row: True):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

    def turn(row):
        x, y = float(row[a]), float(row[b])
        row[a], row[b] = repr(c * x - s * y), repr(s * x + c * y)
    return each(turn, where)


def longer_rays(length):
    """Every point farther from the origin, as by a wrong constant of the reflector."""
    def change(row):
        point = [float(row[c]) for c in POINT]
        for column, x in zip(POINT, point):
            row[column] = repr(x * (1 + length / math.hypot(*point)))
    return each(change)


def cut_from(line, column, value):
    def all_rows(table):
        for row in table[line:]:
            row[column] = repr(float(row[column]) + value)
    return all_rows


def rounded(step, columns=POINT):
    return each(lambda row: row.update({c: f"{round(float(row[c]) / step) * step:.3f}" for c in columns}))


def wave(table):
    for row in table:
        row["z_mm"] = repr(float(row["z_mm"]) + 4 * math.sin(2 * math.pi * (float(row["x_mm"]) + 100) / 150))


def robot_with(old, new):
    text = ROBOT.read_text()
    changed_text = re.sub(old, new, text, count=1)
    assert changed_text != text, old
    (FOLDER / "robot.yaml").write_text(changed_text)
    return "robot.yaml"


def campaign(change, robot=ROBOT, command="calibrate", source=CAMPAIGN, more=()):
    return lambda: (command, "--robot", robot() if callable(robot) else robot, changed(source, change), *more)


def since(source, calibrated="calibrated.yaml"):
    return lambda: ("trace-residual", "--since", calibrated, source)


def certificate(source, robot="calibrated.yaml", more=(), change=None):
    return lambda: ("certify", "--robot", robot, "--about", ABOUT, changed(source, change) if change else source,
                    *(word() if callable(word) else word for word in more))


def reflector_moved(mm, where):
    """Stands aside along y of the measured frame; y of it is the second column of Rz(a) Ry(b) Rx(c)."""
    def change(row):
        if not where(row):
            return
        (sa, ca), (sb, cb), (sc, cc) = ((math.sin(t), math.cos(t)) for t in (math.radians(float(row[c])) for c in ANGLES))
        for column, part in zip(POINT, (ca * sb * sc - sa * cc, sa * sb * sc + ca * cc, cb * sc)):
            row[column] = repr(float(row[column]) + mm * part)
    return each(change)


def targets(change, *more):
    """Targets of a program, with a mistake, for the arm of the tutorial."""
    return lambda: ("compensate", "--robot", "calibrated.yaml", "--controller", ROBOT, changed("targets.csv", change),
                    "--summary", "summary.yaml", "-o", "commands.csv", *more)


def computed_orientations(source):
    """The orientations that a controller computes, with the digits that it shows."""
    def all_rows(table):
        computed = {row["pose"]: row for row in rows(source)}
        for row in table:
            row.update({c: f"{float(computed[row['pose']][c]):.6f}" for c in ANGLES})
    return all_rows


def lengths_in_metres():
    return robot_with(r"(?s)\nlinks:.*", lambda found: re.sub(
        r"([dr]_mm: )([-0-9.]+)", lambda length: f"{length[1]}{float(length[2]) / 1000:.7f}", found[0]))


def with_contacts(contacts):
    return robot_with(r"(\ntool:.*)", lambda found: f"{found[1]}\ncontacts: {{{contacts}}}")


def centres_in_metres():
    return robot_with(r"(?s)\nmasses:.*", lambda found: re.sub(
        r"com_mm: \[(.*?)\]", lambda c: f"com_mm: [{', '.join(str(float(x) / 1000) for x in c[1].split(','))}]", found[0]))


def poses_of_targets(change, *more):
    """Cartesian targets of the flange with the joint angles of the controller, with a mistake."""
    return lambda: ("compensate", "--robot", "calibrated.yaml", "--controller", ROBOT, changed("poses.csv", change),
                    "--summary", "summary.yaml", "-o", "commands.csv", *more)


def commands_again(columns, factor, ending, source="targets.csv", decimals=None):
    """The commands for a table of targets as another one, without the columns of compensate and in another unit."""
    number = lambda value: repr(value) if decimals is None else f"{value:.{decimals}f}"
    def arguments():
        make("compensate", "-q", "--robot", "calibrated.yaml", "--controller", ROBOT, source, "-o", "first-commands.csv")
        kept = rows(source)[0].keys()
        change = lambda row: {c[:c.rindex("_")] + ending if c in columns else c:
                              number(float(row[c]) * (factor if c in columns else 1)) if c != "pose" else row[c]
                              for c in kept}
        written("commands-again.csv", [change(row) for row in rows("first-commands.csv")])
        return ("compensate", "--robot", "calibrated.yaml", "--controller", ROBOT, "commands-again.csv", "--max-mm", 1e4,
                "--summary", "summary.yaml")
    return arguments


def arm_program(name, *lines, more=()):
    """A program of the arm of the tutorial."""
    def arguments():
        (FOLDER / name).write_text("\n".join(lines) + "\n")
        return ("compensate", "--robot", "calibrated.yaml", "--controller", ROBOT, "--program", name, "--program-out",
                "new" + name[4:], "--summary", "summary.yaml", *more)
    return arguments


def krl(*lines, tool="$TOOL={X 0,Y 0,Z 150,A 0,B 0,C 0}"):
    return arm_program("line.src", "DEF line()", *([tool] if tool else []), *lines, "END")


def ur(*lines, tool="set_tcp(p[0,0,0.15,0,0,0])"):
    return arm_program("line.script", "def line():", *(["  " + tool] if tool else []), *("  " + line for line in lines),
                       "end")


def about_with(old, new, calibrated="2026-12-31"):
    text = ABOUT.read_text().replace("calibrated_until: 2026-12-31", f"calibrated_until: {calibrated}")
    assert old in text, old
    (FOLDER / "about.yaml").write_text(text.replace(old, new))
    return lambda: ("certify", "--robot", "calibrated.yaml", "--about", "about.yaml", "visits.csv")


def against_certificate_with(old, new):
    text = (FOLDER / "certificate.yaml").read_text()
    assert old in text, old
    (FOLDER / "other.yaml").write_text(text.replace(old, new))
    return "certify", "--robot", "calibrated.yaml", "--about", ABOUT, "--against", "other.yaml", "visits.csv"


def effect(coefficients):
    """The robot file with a harmonic effect."""
    return lambda: robot_with("effects: .*", "effects:\n  - {name: e, parameter: A2.theta, driver: joint-angle 2, shape: "
                              f"harmonic 1, coefficients: [{coefficients}]}}")


def quaternion(row):
    """w, x, y, z of Rz(a) Ry(b) Rx(c)."""
    (ca, sa), (cb, sb), (cc, sc) = ((math.cos(half), math.sin(half)) for half in
                                    (math.radians(float(row[angle])) / 2 for angle in ANGLES))
    return (ca * cb * cc + sa * sb * sc, ca * cb * sc - sa * sb * cc, ca * sb * cc + sa * cb * sc,
            sa * cb * cc - ca * sb * sc)


def quaternions(order="wxyz", where=lambda row: True, sign=1):
    """Orientations as quaternions. In some rows the columns hold their parts in another order, or x, y, z negated."""
    def all_rows(table):
        for row in table:
            parts = dict(zip("wxyz", quaternion(row)))
            wrong = where(row)
            for column, part in zip("wxyz", order if wrong else "wxyz"):
                row["q" + column] = repr(parts[part] * (sign if wrong and part != "w" else 1))
            for angle in ANGLES:
                del row[angle]
    return all_rows


def mirror(record=None, programmed=LINE, more=()):
    return lambda: ("mirror-correct", "--programmed", programmed() if callable(programmed) else programmed,
                    "--measured", *(record() if callable(record) else [record]), "--summary", "summary.yaml", *more,
                    "-o", "corrected.csv")


def in_metres(source):
    """A path in m with six decimals."""
    return written("metres.csv", [{c.replace("_mm", "_m"): f"{float(v) / 1000:.6f}" if c in POINT else v
                                   for c, v in row.items()} for row in rows(source)])


CENTRE = (100.0, -1750.0)


def round_part():
    """A circle of 100 mm from rest to rest, with a second of standstill before and behind."""
    speed, start, radius = 60, 0.5, 100
    whole = 2 * math.pi * radius / speed + start
    table = []
    for k in range(int((whole + 2) / 0.016) + 1):
        t = min(max(0.016 * k - 1, 0), whole)
        way = (speed / 2 / start * t ** 2 if t < start else speed * (t - start / 2) if t < whole - start
               else speed * (whole - start) - speed / 2 / start * (whole - t) ** 2)
        table.append({"t_s": f"{0.016 * k:.3f}", "x_mm": f"{CENTRE[0] + radius * math.cos(way / radius):.6f}",
                      "y_mm": f"{CENTRE[1] + radius * math.sin(way / radius):.6f}", "z_mm": "850",
                      "a_deg": "0", "b_deg": "0", "c_deg": "0"})
    return table


def with_corners():
    """A rectangle of 200 x 120 mm about the centre, at 25 mm/s, from rest to rest."""
    corners, table, way = [(-100, -60), (100, -60), (100, 60), (-100, 60), (-100, -60)], [], [0]
    for (x, y), (u, v) in zip(corners, corners[1:]):
        way.append(way[-1] + math.hypot(u - x, v - y))
    for k in range(int((way[-1] / 25 + 2) / 0.016) + 1):
        s = min(max(25 * (0.016 * k - 1), 0), way[-1])
        side = max(i for i in range(4) if way[i] <= s)
        share = (s - way[side]) / (way[side + 1] - way[side])
        x, y = (a + share * (b - a) for a, b in zip(corners[side], corners[side + 1]))
        table.append({"t_s": f"{0.016 * k:.3f}", "x_mm": f"{CENTRE[0] + x:.6f}", "y_mm": f"{CENTRE[1] + y:.6f}",
                      "z_mm": "850", "a_deg": "0", "b_deg": "0", "c_deg": "0"})
    return table


def about_the_part(degrees):
    def turn(row):
        x, y = (float(row[c]) - at for c, at in zip(POINT, CENTRE))
        s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        row.update(x_mm=repr(CENTRE[0] + c * x - s * y), y_mm=repr(CENTRE[1] + s * x + c * y))
    return changed("round-pass.csv", each(turn), "turned.csv")


def beside_the_part(left):
    """The pass over the round part with the edge of a tool, to the left of travel: inside of the circle."""
    def change(row):
        x, y = (float(row[c]) - at for c, at in zip(POINT, CENTRE))
        shorter = 1 - left / math.hypot(x, y)
        row.update(x_mm=repr(CENTRE[0] + shorter * x), y_mm=repr(CENTRE[1] + shorter * y))
    return changed("round-pass.csv", each(change), "beside.csv")


def of_size(factor):
    """The pass over the round part, of a part of another size."""
    def change(row):
        row.update({c: repr(at + factor * (float(row[c]) - at)) for c, at in zip(POINT, CENTRE)})
    return changed("corners-pass.csv", each(change), "sized.csv")


def between(table):
    """Four samples in the place of one, on straight lines."""
    columns = ("t_s",) + POINT
    numbers = [[float(row[c]) for c in columns] for row in table]
    return [{c: f"{a + (b - a) * k / 4:.6f}" for c, a, b in zip(columns, one, other)}
            for one, other in zip(numbers, numbers[1:]) for k in range(4)]


def trimmed(table):
    return [dict(row, t_s=repr(float(row["t_s"]) + 7)) for row in table[8:-8]]


def mapped(*more):
    return lambda: ("map-errors", "--robot", "calibrated.yaml", "--controller", ROBOT, "--box-mm",
                    "1400,2200,-400,400,800,1600", "--grid", "2,2,2", "--summary", "summary.yaml", "-o", "map.csv", *more)


def root_times(factor):
    """A certificate by a robot file whose uncertainty was changed by hand."""
    def arguments():
        text = (FOLDER / "calibrated.yaml").read_text()
        changed_text = re.sub(r"(?s)(\n  root: \[)(.*?)(\])", lambda found: found[1] + ", ".join(
            repr(factor * float(number)) for number in found[2].split(",")) + found[3], text, count=1)
        assert changed_text != text
        (FOLDER / "changed.yaml").write_text(changed_text)
        return "certify", "--robot", "changed.yaml", "--about", ABOUT, "visits.csv"
    return arguments


def from_force(change, robot=ROUGHING):
    """The line under the force of a cut in N, with a mistake."""
    def arguments():
        written("cut.csv", [dict(row, fx_n="4.6", fy_n="40", fz_n="-9.3") for row in rows(LINE)])
        return ("mirror-correct", "--programmed", changed("cut.csv", change), "--from-force", "--robot", robot, "-o",
                "corrected.csv")
    return arguments


def imported(*units, robot=(), change=lambda row, number: None):
    """Points and joint angles of the campaign as tables without units; `change` alters a row."""
    def arguments():
        table = rows("once.csv")
        for number, row in enumerate(table):
            change(row, number)
        written("points.csv", [{"Time": row["t_s"], **{c[0].upper(): row[c] for c in POINT}} for row in table])
        written("joints.csv", [{"Time": row["t_s"], **{f"A{c[1]}": row[c] for c in JOINTS}} for row in table])
        return ("import-readings", "--points", "points.csv", "--joints", "joints.csv", "--join", "order", "--time-unit", "s",
                "--length-unit", units[0], "--angle-unit", units[1], *robot, "-o", "imported.csv")
    return arguments


def record(change, source="pass.csv"):
    return lambda: [changed(source, change, "record.csv")]


def program(*lines):
    def arguments():
        (FOLDER / "line.src").write_text("\n".join(lines) + "\n")
        return mirror("pass.csv", more=("--program", "line.src", "--program-out", "cut.src"))()
    return arguments


def prepare():
    """Passes of the shipped line, and distances from three anchors."""
    for name, seed, more in (("pass", 1, ("--clock-offset-s", 1)), ("air", 2, ("--depth-mm", 0)), ("again", 3, ())):
        make("simulate-path", "--robot", ROUGHING, "--noise-mm", 0.095, "--noise-n", 1, "--seed", seed, *more, LINE, "-o",
             f"{name}.csv")
    make("simulate-path", "--robot", ROUGHING, "--noise-mm", 0.02, LINE, "-o", "quiet.csv")
    make("mirror-correct", "--programmed", LINE, "--measured", "pass.csv", "-o", "first.csv")
    written("round.csv", round_part())
    make("simulate-path", "--robot", ROUGHING, "--noise-mm", 0.05, "--seed", 5, "--clock-offset-s", 1, "round.csv", "-o",
         "round-pass.csv")
    written("corners.csv", with_corners())
    make("simulate-path", "--robot", ROUGHING, "--noise-mm", 0.03, "corners.csv", "-o", "corners-pass.csv")
    written("line.csv", [dict(row, pose=k) for k, row in enumerate(rows(LINE))])
    make("compensate", "-q", "--robot", UNDECLARED, "--controller", ROBOT, "--start=-90,-90,90,0,0,0", "line.csv", "-o",
         "line-commands.csv")
    written("commanded.csv", [{c: row[c] for c in ("t_s",) + POINT} for row in rows("line-commands.csv")])
    make("simulate-path", "--robot", ROUGHING, "--noise-mm", 0.095, "--seed", 4, "--part", LINE, "first.csv", "-o",
         "second.csv")
    nominal = re.sub(r"(\ntool:.*)", lambda found: found[1] + "\n" + ANCHORS, ROBOT.read_text())
    (FOLDER / "wires.yaml").write_text(nominal)
    make("simulate-poses", "--robot", "wires.yaml", "--count", 60, "--repeats", 3, "--noise-mm", 0.095, "-o", "wires.csv")
    make("simulate-poses", "--robot", ROBOT, "--count", 60, "--repeats", 2, "--noise-mm", 0.1, "--points", "--box-mm",
         "1400,2200,-400,400,800,1600", "-o", "near.csv")
    make("simulate-poses", "--robot", ROBOT, "--count", 40, "--points", "-o", "computed.csv")
    make("calibrate", "--robot", ROBOT, CAMPAIGN, "-o", "calibrated.yaml")
    make("simulate-poses", "--robot", "calibrated.yaml", "--count", 20, "--repeats", 3, "-o", "controller.csv")
    make("simulate-poses", "--robot", "calibrated.yaml", "--count", 20, "--repeats", 3, "--noise-mm", 0.05, "--noise-mrad",
         0.1, "-o", "visits.csv")
    make("simulate-poses", "--robot", "calibrated.yaml", "--count", 20, "--repeats", 3, "--noise-mm", 0.05, "--noise-mrad",
         0.1, "--seed", 2, "-o", "others.csv")
    make("simulate-poses", "--robot", ROBOT, "--count", 12, "--repeats", 2, "--points", "-o", "computed-visits.csv")
    make("plan-poses", "--robot", ROBOT, "--count", 20, "-o", "targets.csv")
    written("one-joint.csv", [dict(row, **{q: "20" for q in JOINTS if q != "q2_deg"}) for row in rows("targets.csv")])
    make("simulate-poses", "--robot", ROBOT, "--truth", UNDECLARED, "--targets", "one-joint.csv", "--repeats", 2,
         "--noise-mm", 0.095, "--noise-mrad", 0.15, "-o", "bowing.csv")
    make("simulate-poses", "--robot", ROBOT, "--truth", UNDECLARED, "--count", 40, "--noise-mm", 0.05, "--noise-mrad", 0.1,
         "-o", "arm.csv")
    written("arm-joints.csv", [{c: row[c] for c in ("pose",) + JOINTS} for row in rows("arm.csv")])
    (FOLDER / "own-frames.yaml").write_text(re.sub(
        r"(?m)^(base|tool): .*", r"\1: {x_mm: 100, y_mm: 0, z_mm: 0, a_deg: 100, b_deg: 20, c_deg: 5}", ROBOT.read_text()))
    for model in ("calibrated", "own-frames"):
        make("simulate-poses", "-q", "--robot", ROBOT, "--truth", f"{model}.yaml", "--targets", "arm-joints.csv", "-o",
             f"{model}.csv")
    make("simulate-poses", "--robot", ROBOT, "--count", 12, "--box-mm", "1400,2200,-400,400,800,1600", "-o", "poses.csv")
    written("poses.csv", [{c: row[c] for c in ("pose",) + JOINTS + POINT + ANGLES} for row in rows("poses.csv")])
    make("certify", "-q", "--robot", "calibrated.yaml", "--about", ABOUT, "visits.csv", "-o", "certificate.yaml")
    written("once.csv", [row for row in rows(CAMPAIGN) if row["repeat"] == "1"])


with open(CAMPAIGN) as first_rows:
    FIRST = next(csv.DictReader(first_rows))
NO_ORIENTATION = without(*ANGLES)
EVEN_OFF = add("y_mm", 18, every(2))
MIXED = in_turn(NO_ORIENTATION, exchange("q4_deg", "q6_deg", every(10)))
NO_NOISE = lambda: robot_with(r"noise: .*", "")
START = "PTP {A1 10,A2 -60,A3 80,A4 5,A5 40,A6 -10}"
NEXT = ("LIN {X 2180.0,Y -470.0,Z 1440.0,A 73.0,B 1.5,C -28.5}", "LIN {X 1980.0,Y 270.0,Z 1440.0}")
UR_START = "movej([0.17,-1.05,1.4,0.09,0.7,-0.17])"
UR_NEXT = ("movel(p[2.18,-0.47,1.44,0.7,-0.4,-1.0])", "movel(p[2.08,-0.27,1.44,0.7,-0.4,-1.0])")

# name: arguments, exit code, words
TABLE = {
    # units of some rows
    "a tenth in metres": (campaign(scale(POINT, 1e-3, every(10))), 1, "metres among millimetres"),
    "a third in inches": (campaign(scale(POINT, 1 / 25.4, every(3))), 1, "inches among millimetres"),
    "angles of a tenth in radians": (campaign(scale(JOINTS, math.pi / 180, every(10))), 1, "radians among degrees"),
    "angles of targets in radians": (targets(scale(JOINTS, math.pi / 180)), 0, "are these radians?"),
    "sigma in um": (campaign(each(lambda r: r.update(sigma_mm="95")), command="close-loop", source="once.csv",
                             more=("--only-catalogue",)), 0, "the rows state a noise of 95 mm"),
    "sigma of some rows in um": (campaign(each(lambda r: r.update(sigma_mm="95" if every(5)(r) else "0.095"))), 0,
                                 "are these one unit?"),
    # orientations of some rows
    "quaternions of a tenth in another order": (campaign(quaternions("xyzw", every(10))), 1,
                                                "x, y, z, w in place of w, x, y, z"),
    "orientations of a tenth inverted": (campaign(quaternions(where=every(10), sign=-1)), 1, "turned the other way"),
    "a and c of a tenth exchanged": (campaign(exchange("a_deg", "c_deg", every(10))), 1, "a and c look exchanged"),
    # lost readings
    "lost readings are -9999": (campaign(each(lambda r: r.update({c: "-9999" for c in POINT}), every(15))), 1,
                                "a mark of lost readings?"),
    "lost readings are 0": (campaign(each(lambda r: r.update({c: "0" for c in POINT}), every(15)), command="close-loop"), 0,
                            "a mark of lost readings?"),
    # joint columns
    "joint columns of a tenth exchanged": (campaign(MIXED), 1, "q4 and q6 look exchanged"),
    "joint columns exchanged": (campaign(in_turn(NO_ORIENTATION, exchange("q4_deg", "q6_deg"))), 1,
                                "q4_deg and q6_deg look exchanged"),
    "a joint column written twice": (campaign(in_turn(NO_ORIENTATION, each(lambda r: r.update(q6_deg=r["q4_deg"])))), 3,
                                     "more than an arm of this size"),
    "joint angles 10 turns beyond": (campaign(add("q6_deg", 3600)), 1, "count no turns"),
    "directions negated": (campaign(each(lambda r: r.update({f"dir{j}": str(-int(r[f"dir{j}"])) for j in range(1, 7)}))),
                           0, "is their sign wrong"),
    # the clock
    "clock reset": (campaign(clock_reset), 0, "was the clock reset?"),
    "all times equal": (campaign(each(lambda r: r.update(t_s="1000"))), 0, "the clock stands still"),
    "times of day": (campaign(each(lambda r: r.update(t_s=time_of_day(r["t_s"])))), 1, "(import-readings does so"),
    "times of day in a record": (mirror(record(each(lambda r: r.update(t_s=time_of_day(r["t_s"]))))), 1,
                                 "write seconds since the first row"),
    "times in milliseconds": (campaign(scale(("t_s",), 1000)), 0, "does it count milliseconds?"),
    "sessions named in two ways": (campaign(each(
        lambda r: r.update(session="Day1" if float(r["t_s"]) < 1800 else "day 1"))), 0, "if they are one, write one name"),
    # copies
    "rows doubled": (campaign(in_turn(without("repeat"), twice)), 1, "time included"),
    "rows doubled without time": (campaign(in_turn(without("repeat", "t_s"), twice)), 0, "a copy is no second visit"),
    "rows doubled with a later time": (campaign(in_turn(without("repeat"), later_copies)), 0, "a copy is no second visit"),
    # the frame and the scale of the instrument
    "later half in another frame": (campaign(in_turn(turned("x_mm", "y_mm", 0.2, lambda r: float(r["t_s"]) > 2000),
                                                     add("a_deg", 0.2, lambda r: float(r["t_s"]) > 2000))), 0,
                                    "lie in another frame"),
    "mirrored axis": (campaign(scale(("y_mm",), -1)), 1, "left-handed"),
    "mirrored axis, points": (campaign(in_turn(NO_ORIENTATION, scale(("y_mm",), -1))), 1, "left-handed"),
    "mirrored axis of a third": (campaign(scale(("y_mm",), -1, every(3))), 1, "y seems to have the wrong sign"),
    "instrument's scale 1 % off": (campaign(scale(POINT, 1.01)), 3, "the links come out longer"),
    "constant of the reflector 10 mm off": (campaign(longer_rays(10)), 0, "check the constant of its reflector"),
    "points of the controller": (campaign(lambda table: None, source="computed.csv"), 0, "as no arm is made"),
    "points of the controller, certificate": (certificate("controller.csv"), 0, "as no instrument reads"),
    "points of the controller, certificate of the nominal robot": (
        certificate("computed-visits.csv", ROBOT), 0, "as no arm is made"),
    "points of the controller, change": (since("controller.csv"), 0, "as no instrument reads"),
    "one wire 1 % long": (campaign(scale(("l_mm",), 1.01, lambda r: r["anchor"] == "1"), "wires.yaml",
                                   source="wires.csv"), 0, "the distances from anchor 1 are too long by"),
    "two wires exchanged in one pose": (
        campaign(each(lambda r: r.update(anchor={"1": "2", "2": "1"}.get(r["anchor"], r["anchor"])), lambda r: r["pose"] == "7"),
                 "wires.yaml", source="wires.csv"), 0, "look exchanged"),
    "all wires 1 % long": (campaign(scale(("l_mm",), 1.01), "wires.yaml", source="wires.csv"), 3,
                           "the links come out longer"),
    "orientations of the calibrated model of the controller": (
        campaign(computed_orientations("calibrated.csv"), source="arm.csv"), 0, "they look computed by the controller"),
    "orientations in frames of the controller": (
        campaign(computed_orientations("own-frames.csv"), source="arm.csv"), 0, "they look computed by the controller"),
    # the robot file
    "robot is calibrated already": (campaign(each(lambda r: None), "calibrated.yaml"), 0, "is calibrated already"),
    "zero of joint 4 half a turn off": (campaign(each(lambda r: None),
                                                 lambda: robot_with(r"(name: A4,.* theta_deg: )0", r"\g<1>180")), 1,
                                        "joint 5 seems to count the other way"),
    "zero of joint 5 half a turn off, points": (
        campaign(NO_ORIENTATION, lambda: robot_with(r"(name: A5,.* theta_deg: )0", r"\g<1>180")), 3,
        "more than an arm of this size"),
    "length 200 mm off": (campaign(NO_ORIENTATION, lambda: robot_with(r"(name: A2,.* d_mm: )500", r"\g<1>700")), 1,
                          "which is no error of an arm"),
    "length 60 mm off": (campaign(each(lambda r: None), lambda: robot_with(r"(name: A5,.* d_mm: )0", r"\g<1>60")), 0,
                         "is the robot file that of this model?"),
    "length 150 mm off, where poses hardly tell": (
        campaign(each(lambda r: None), lambda: robot_with(r"(name: A2,.* d_mm: )500", r"\g<1>650"), source="near.csv"), 1,
        "which is no error of an arm"),
    "gravity in g": (campaign(each(lambda r: None), lambda: robot_with(r"(gravity_m_s2: ).*", r"\1[0, 0, -1]")), 1,
                     "is 1 m/s2 long"),
    "a coefficient twice": (
        campaign(each(lambda r: None), effect("{name: cos, value: 1e-4}, {name: cos, value: 2e-4}")), 1,
        "'cos' stands in the place of 'sin'"),
    "coefficients with other names": (
        campaign(each(lambda r: None), effect("{name: amplitude, value: 1e-4}, {name: phase, value: 0}")), 1,
        "'amplitude' stands in the place of 'sin'"),
    "coefficient of an angle in m": (
        campaign(each(lambda r: None), effect("{name: sin, value: 1e-4, unit: m}, {name: cos, value: 0, unit: m}")), 1,
        "which this coefficient moves in rad"),
    "only one joint moves": (campaign(each(lambda r: None), command="close-loop", source="bowing.csv",
                                      more=("--only-catalogue",)), 0, "these poses cannot show A2.alpha"),
    "only one joint moves, trace-residual": (
        campaign(each(lambda r: None), command="trace-residual", source="bowing.csv", more=("--only-catalogue",)), 0,
        "these poses cannot show A2.alpha"),
    # no result beyond what an arm can have leaves with exit 0
    "half the poses 18 mm off, calibrate": (campaign(EVEN_OFF), 3, "more than an arm of this size"),
    "half the poses 18 mm off, close-loop": (campaign(EVEN_OFF, command="close-loop", source="once.csv",
                                                      more=("--only-catalogue",)), 3, "more than an arm of this size"),
    "half the poses 18 mm off, trace-residual": (campaign(EVEN_OFF, command="trace-residual", source="once.csv",
                                                          more=("--only-catalogue",)), 3, "more than an arm of this"),
    "half the poses 18 mm off, evaluate-poses of a calibrated robot": (
        campaign(EVEN_OFF, "calibrated.yaml", "evaluate-poses"), 3, "more than an arm of this size"),
    "half the poses 18 mm off, evaluate-poses --refit": (
        campaign(EVEN_OFF, "calibrated.yaml", "evaluate-poses", more=("--refit", "base,tool")), 3,
        "more than an arm of this size"),
    "no floor": (campaign(each(lambda r: None), NO_NOISE, "close-loop", "once.csv", ("--only-catalogue",)), 0,
                 "say how large the noise is"),
    "all poses twice under other names": (campaign(copies_of_poses, command="close-loop",
                                                   more=("--only-catalogue",)), 1, "as another pose"),
    "payload in g": (campaign(each(lambda r: r.update(payload_kg="120000"))), 1, "more than any arm carries"),
    "a code of a sensor as temperature": (
        campaign(each(lambda r: r.update(temp_arm_c="3276.7" if r["pose"] == "7" else "21.5"))), 1,
        "no temperature of an arm"),
    "masses in g": (campaign(each(lambda r: None), lambda: robot_with(r"mass_kg: (\d+)", r"mass_kg: \g<1>000")), 1,
                    "more than any link of an arm has"),
    "noise of 1e-300 mm": (campaign(each(lambda r: None), lambda: robot_with(r"position_mm: 0.095", "position_mm: 1e-300")),
                           1, "less than any instrument has"),
    "noise in um": (campaign(each(lambda r: None), lambda: robot_with(r"position_mm: 0.095", "position_mm: 95"),
                             source="once.csv"), 0, "readings scatter by"),
    "something off for a while": (campaign(while_off), 0, "off for a while"),
    # rows
    "readings one row late": (campaign(rows_late(1)), 1, "stand 1 row later than their joint angles"),
    "readings two rows early": (campaign(rows_late(-2)), 1, "stand 2 rows earlier than their joint angles"),
    "readings one row late, in a long table": (
        lambda: (make("simulate-poses", "--robot", ROBOT, "--count", 600, "--noise-mm", 0.1, "--noise-mrad", 0.15, "-o",
                      "long.csv"), campaign(rows_late(1), source="long.csv")())[1], 1,
        "stand 1 row later than their joint angles"),
    "rows doubled with other numbers": (campaign(numbered_copies), 0, "a copy is no second visit"),
    # digits
    "points in steps of 1 mm": (campaign(rounded(1)), 0, "the points have steps of 1 mm"),
    "orientations in steps of 0.1 deg": (campaign(rounded(0.1, ANGLES)), 0, "the orientations have steps of 0.1 deg"),
    # units of the robot file
    "lengths of the robot file in m": (campaign(each(lambda r: None), lengths_in_metres), 1,
                                       "the lengths of the robot file look like metres"),
    "centres of mass in m": (campaign(each(lambda r: None), centres_in_metres), 1, "as centres in m would be"),
    "noise in m": (campaign(each(lambda r: None), lambda: robot_with(r"position_mm: 0.095", "position_mm: 0.000095"),
                            "close-loop", "once.csv", ("--only-catalogue",)), 0, "is it in another unit?"),
    "noise of the orientation in rad": (
        campaign(each(lambda r: None), lambda: robot_with(r"orientation_mrad: 0.15", "orientation_mrad: 0.00015"),
                 "close-loop", "once.csv", ("--only-catalogue",)), 0, "Correct noise: orientation_mrad"),
    "payload of 3 kg in g": (campaign(each(lambda r: r.update(payload_kg="3000"))), 1, "more than any arm carries"),
    # joint angles beside Cartesian targets
    "targets in a base that is not stated": (poses_of_targets(add("x_mm", -400)), 0, "at each of them with --base=400,"),
    "targets of a tool that is not stated": (
        poses_of_targets(each(lambda r: None), "--tool", "0,0,150,0,0,0"), 0, "at each of them with --tool=0,0,0,"),
    "y of the targets negated": (poses_of_targets(scale(("y_mm",), -1)), 0, "if the file gives y_mm with the other sign"),
    "targets in m": (poses_of_targets(scale(POINT, 1e-3)), 0, "if the file gives x_mm, y_mm, z_mm in m"),
    "a and c of the targets exchanged": (poses_of_targets(exchange("a_deg", "c_deg")), 0,
                                         "reach their places, but not with their a_deg"),
    "targets one row late, the first of elsewhere": (
        poses_of_targets(in_turn(rows_late(1), add("x_mm", 50, lambda r: r["pose"] == "1"))), 0,
        "at those of the row before: move the columns by one row"),
    "targets one row early": (poses_of_targets(rows_late(-1)), 0,
                              "at those of the row behind: move the columns by one row"),
    "targets in m without hints": (poses_of_targets(in_turn(without(*JOINTS), scale(POINT, 1e-3)), "--start=0,-90,90,0,0,0"),
                                   0, "are they in m?"),
    "commands in rad as targets": (commands_again(JOINTS, math.pi / 180, "_rad"), 1, "those that compensate writes"),
    "commands in m as targets": (commands_again(POINT, 1e-3, "_m", "poses.csv"), 1, "those that compensate writes"),
    "commands in inches as targets": (commands_again(POINT, 1 / 25.4, "_mm", "poses.csv"), 1,
                                      "those that compensate writes"),
    "commands in rad, called deg, as targets": (commands_again(JOINTS, math.pi / 180, "_deg"), 1, "taken as radians"),
    "rounded commands in m, called mm, beside their hints": (
        commands_again(POINT, 1e-3, "_mm", "poses.csv", 6), 0, "if the file gives x_mm, y_mm, z_mm in m"),
    "rounded commands in inches, called mm, beside their hints": (
        commands_again(POINT, 1 / 25.4, "_mm", "poses.csv", 6), 0, "if the file gives x_mm, y_mm, z_mm in inches"),
    "tool of targets in m": (targets(each(lambda r: None), "--tool", "0,0,0.15,0,0,0"), 0, "is it in m?"),
    # imported tables
    "degrees imported as rad": (imported("mm", "rad"), 0, "is the unit of the joint angles right?"),
    "mm imported as m": (imported("m", "deg"), 0, "farther than arms reach"),
    "mm imported as um": (imported("um", "deg"), 0, "is the unit of their lengths right?"),
    "later rows imported in m": (
        imported("mm", "deg", change=lambda r, k: k > 34 and r.update({c: repr(float(r[c]) / 1000) for c in POINT})), 0,
        "are these rows in m, or those in mm?"),
    "later rows imported in rad": (
        imported("mm", "deg", change=lambda r, k: k > 34 and r.update({c: repr(math.radians(float(r[c]))) for c in JOINTS})), 0,
        "are these rows in rad?"),
    "a failed reading imported": (
        imported("mm", "deg", change=lambda r, k: k == 7 and r.update({c: "-9999" for c in POINT})), 0,
        "1 of 60 rows, the first in line 9, have the same number in x, y and z, -9999 mm"),
    "mm imported as inches": (imported("in", "deg", robot=("--robot", ROBOT)), 0, "25.4 times too large"),
    # another arm
    "iiwa 14 in place of an iiwa 7": (
        lambda: (make("simulate-poses", "--robot", CONFIG / "robots/iiwa7.yaml", "--count", 40, "--noise-mm", 0.1,
                      "--noise-mrad", 0.15, "-o", "iiwa7.csv"),
                 ("calibrate", "--robot", CONFIG / "robots/iiwa14.yaml", "iiwa7.csv"))[1], 0,
        "config/robots/iiwa7.yaml (KUKA LBR iiwa 7 R800) fits the points"),
    "UR10e in place of a UR5e": (
        lambda: (make("simulate-poses", "--robot", CONFIG / "robots/ur5e.yaml", "--count", 40, "--noise-mm", 0.1,
                      "--noise-mrad", 0.15, "-o", "ur5e.csv"),
                 ("calibrate", "--robot", CONFIG / "robots/ur10e.yaml", "ur5e.csv"))[1], 1,
        "config/robots/ur5e.yaml (UR5e) fits the points"),
    # robot programs of compensate
    "program without a tool": (krl(START, *NEXT, tool=None), 0, "no $TOOL stands before this move"),
    "program with a tool in m": (krl(START, *NEXT, tool="$TOOL={X 0,Y 0,Z 0.15,A 0,B 0,C 0}"), 0, "is it in m?"),
    "program with joint angles in rad": (krl("PTP {A1 0.174,A2 -1.047,A3 1.396,A4 0.087,A5 0.698,A6 -0.174}"), 0,
                                         "are these radians?"),
    "program with points in m": (
        krl("$BASE={X 2000,Y 0,Z 1400,A 0,B 0,C 0}", START, "LIN {X 0.18,Y -0.47,Z 0.04,A 73.0,B 1.5,C -28.5}",
            "LIN {X 0.08,Y 0.27,Z 0.04}"), 0, "are they in m?"),
    "program with a frame in m": (krl("$BASE={X 0.5,Y 0,Z 0.2,A 0,B 0,C 0}", START, *NEXT), 0, "from R_0: is it in m?"),
    "program with a tool turned in rad": (krl(START, *NEXT, tool="$TOOL={X 0,Y 0,Z 150,A 0,B 1.5708,C 0}"), 0,
                                          "which is 90 deg in rad"),
    "program that calls what changes the tool": (
        krl(START, NEXT[0], "CHANGE_TOOL(2)", NEXT[0]), 0, "no text that is given has CHANGE_TOOL: if it sets $BASE or $TOOL"),
    "program with many calls of texts that are not given": (
        krl(START, NEXT[0], "DRILL(1)", "DRILL(2)", "CLAMP()", "MILL()", "CLEAN()", NEXT[0]), 0,
        "no text that is given has DRILL, CLAMP, MILL and 1 more: if"),
    "program that is cut off": (arm_program("line.src", "DEF line()", START, *NEXT), 1, "has no END"),
    "program without set_tcp": (ur(UR_START, *UR_NEXT, tool=None), 0, "no set_tcp stands before this move"),
    "URScript with joint angles in deg": (ur("movej([10,-60,80,5,40,-10])"), 0,
                                          "a joint angle of 80 rad is 12.7 turns: are these degrees? A UR counts rad"),
    "URScript with rotation vectors in deg": (
        ur(UR_START, "movel(p[2.18,-0.47,1.44,40,-23,-57])"), 0,
        "the rotation vector is 73.33 rad long, more than a turn: are these degrees? A UR counts rad"),
    "orientation of a map in rad": (mapped("--orientation", "0,1.5708,0", "--start=0,-90,90,0,60,0"), 0,
                                    "which is 90 deg in rad"),
    "branch of a map in rad": (mapped("--start=0,-1.0472,1.5708,0,1.0472,0"), 0,
                               "--start: all joint angles lie within 1.57 deg of zero: are these radians?"),
    "part of a map in m": (mapped("--start=0,-90,90,0,60,0", "--part-mm", "0.4,0.4,0.2"), 0, "longer than 0.4 mm: is it in m?"),
    "branch of a simulated pass in rad": (
        lambda: ("simulate-path", "--robot", ROBOT, "--start-deg=-1.5708,-1.0472,1.3963,0,1.0472,0", LINE, "-o", "simulated.csv"),
        0, "--start-deg: all joint angles lie within 1.57 deg of zero"),
    "joint angles of a pendant in rad": (
        lambda: ("check-robot", ROBOT, "--at=0.1745,-1.0472,1.3963,0,1.0472,0", "-o", "shown.txt"), 0,
        "--at: all joint angles lie within 1.4 deg of zero"),
    "poses of an arm in m": (lambda: ("plan-poses", "--robot", lengths_in_metres(), "--count", 20, "-o", "planned.csv"), 0,
                             "are d_mm and r_mm in m?"),
    "readings of an arm in m": (lambda: ("simulate-poses", "--robot", lengths_in_metres(), "--count", 20, "-o", "simulated.csv"),
                                0, "are d_mm and r_mm in m?"),
    "flange of an arm in m": (
        lambda: ("check-robot", lengths_in_metres(), "--at", "0,-90,90,0,60,0", "-o", "shown.txt"), 0, "are d_mm and r_mm in m?"),
    "cube in m": (lambda: ("check-robot", with_contacts("cube: {kind: cube, edge_mm: 0.1}"), "--at", "0,-90,90,0,60,0", "-o",
                           "shown.txt"), 0, "contact 'cube': its points, faces and balls lie within 0.1 mm"),
    "tip in m": (lambda: ("check-robot", with_contacts("cube: {kind: cube, edge_mm: 100, tip_radius_mm: 0.003}"), "--at",
                          "0,-90,90,0,60,0", "-o", "shown.txt"), 0, "the tip that touches it has a radius of 0.003 mm: is it in m?"),
    "ball in m": (lambda: ("check-robot", with_contacts("ball: {kind: sphere, x_mm: 0, y_mm: 0, z_mm: 0, radius_mm: 0.0125}"),
                           "--at", "0,-90,90,0,60,0", "-o", "shown.txt"), 0, "contact 'ball': the sphere has a radius of 0.0125 mm"),
    "largest change in um": (lambda: ("compare-runs", "--before", ROBOT, "calibrated.yaml", "--max-change-mm", 200), 0,
                             "--max-change-mm 200: no arm changes by 20 mm"),
    # certificates
    "tolerance in um": (certificate("visits.csv", more=("--tolerance-mm", 400)), 0, "is it in um?"),
    "certificate compared with itself": (certificate("visits.csv", more=("--against", "certificate.yaml")), 0,
                                         "is the certificate of these same readings"),
    "certificate compared with one of other poses": (certificate("others.csv", more=("--against", "certificate.yaml")), 0,
                                                     "poses of 20 of 20 names have other joint values"),
    "certificate compared with that of another type": (
        lambda: against_certificate_with("type: KR 360", "type: KR 210"), 0,
        "other.yaml: robot: type is KR 210, and that of --robot"),
    "certificate of a day to come": (
        lambda: about_with("date: 2026-03-31", "date: 2099-03-31", calibrated="2099-12-31")(), 0, "is not yet, by the clock of this computer"),
    "uncertainty of the arm times 0": (root_times(0), 1, "and 'std' states one"),
    "second pass of a certificate in m": (
        certificate("visits.csv", more=("--path", LINE, "--pass", "pass.csv", "--pass", lambda: changed(
            "pass.csv", scale(POINT, 0.001), "metres.csv"))), 1, "metres.csv: the measured path is 0.001"),
    "MPE in mm": (lambda: about_with("constant: 15", "constant: 0.015")(), 0, "mpe_um: constant is 0.015 um"),
    "certificate of another type": (lambda: about_with("type: KR 360", "type: KR 210")(), 0,
                                    "robot: type is KR 210, and that of --robot"),
    "MPE of a metre in mm": (lambda: about_with("per_m: 6", "per_m: 0.006")(), 0, "mpe_um: per_m is 0.006 um"),
    "instrument knocked between visits": (
        certificate("visits.csv", change=add("x_mm", 0.4, lambda r: float(r["t_s"]) > 700)), 0,
        "all by one motion of the instrument or the foot of the robot"),
    "reflector knocked between visits": (
        certificate("visits.csv", change=reflector_moved(0.4, lambda r: float(r["t_s"]) > 700)), 0,
        "all by one motion of the reflector or the tool"),
    # records of paths
    "longest correction in m": (mirror("pass.csv", more=("--max-mm", 0.001)), 0, "leaves the mean deviation of"),
    "program and record exchanged": (mirror(lambda: [LINE], "pass.csv"), 1, "they look exchanged"),
    "program as record": (mirror(lambda: [LINE]), 1, "holds the same as"),
    "corrected path as record": (mirror(lambda: ["first.csv"]), 1, "those that mirror-correct writes"),
    "corrected path as pass of a certificate": (
        certificate("visits.csv", more=("--path", LINE, "--pass", "first.csv")), 1, "it is a corrected path"),
    "corrected path as program": (mirror("pass.csv", "first.csv"), 1, "those that mirror-correct writes"),
    "corrected path as program, of three decimals": (
        mirror("pass.csv", lambda: changed("first.csv", rounded(1e-3), "short.csv")), 1, "those that mirror-correct writes"),
    "corrected path in m as program": (mirror("pass.csv", lambda: in_metres("first.csv")), 1,
                                       "those that mirror-correct writes"),
    "commands of compensate as program": (mirror("pass.csv", "commanded.csv"), 1, "those that compensate writes"),
    "corrected path as that of a certificate": (
        certificate("visits.csv", more=("--path", "first.csv", "--pass", "pass.csv")), 1, "it is a corrected path"),
    "record turned about a round part": (mirror(lambda: [about_the_part(1)], "round.csv"), 0, "is turned by 1.0"),
    "edge of the tool in place of its centre": (mirror(lambda: [beside_the_part(5)], "round.csv"), 0,
                                                "runs 5.78 mm to the left of travel all along"),
    "part of another size": (mirror(lambda: [of_size(0.99)], "corners.csv"), 0, "smaller than the program, along its way"),
    "record interpolated": (mirror(record(between)), 0, "the record was interpolated"),
    "a pass once more, trimmed": (mirror(lambda: ["pass.csv", changed("pass.csv", trimmed, "copy.csv")]), 1,
                                  "it holds the readings of pass.csv from line 10 on"),
    "a pass once more, rounded and moved": (
        mirror(lambda: ["pass.csv", changed("pass.csv", in_turn(rounded(0.001), add("y_mm", 0.1)), "copy.csv")]), 1,
        "it holds the readings of pass.csv from line 2 on"),
    "a pass of a certificate once more, trimmed": (
        certificate("visits.csv", more=("--path", LINE, "--pass", "pass.csv", "--pass", lambda: changed(
            "pass.csv", trimmed, "copy.csv"))), 1, "it holds the readings of pass.csv from line 10 on"),
    "half a pass of a certificate in another frame": (
        certificate("visits.csv", more=("--path", LINE, "--pass", lambda: changed(
            "pass.csv", cut_from(206, "y_mm", 2), "knocked.csv"))), 0, "was the instrument knocked"),
    "frame fitted to a round part": (mirror(lambda: [about_the_part(1)], "round.csv", ("--fit-frame",)), 0,
                                     "takes up a part of the deviation"),
    "z of the record is the program's": (mirror(record(each(lambda r: r.update(z_mm="850")))), 0,
                                         "z_mm: no noise at all"),
    "y and z of the record stand still": (mirror(record(each(lambda r: r.update(y_mm="-1649.9", z_mm="850.1")))), 0,
                                          "y_mm and z_mm: no noise at all"),
    "z of a certified pass is the program's": (
        certificate("visits.csv", more=("--path", LINE, "--pass", lambda: changed(
            "pass.csv", each(lambda r: r.update(z_mm="850")), "flat.csv"))), 0, "z_mm: no noise at all"),
    "program as previous correction": (mirror("pass.csv", more=("--previous", LINE)), 0, "corrects nothing"),
    "half a record in another frame": (mirror(record(cut_from(206, "y_mm", 2))), 0, "was the instrument knocked"),
    "frame turned by 0.2 deg": (mirror(record(turned("y_mm", "z_mm", 0.2))), 0, "is a motion of the whole record"),
    "record mirrored": (mirror(record(scale(("y_mm",), -1))), 1, "on it with y of the other sign"),
    "record mirrored, frame fitted": (mirror(record(scale(("y_mm",), -1)), more=("--fit-frame",)), 0,
                                      "nor whether an axis has the wrong sign"),
    "z of a flat part of the other sign, frame fitted": (
        mirror(lambda: [changed("round-pass.csv", scale(("z_mm",), -1))], "round.csv", ("--fit-frame",)), 1,
        "lies on round.csv with z of the other sign, without any frame"),
    "record mirrored at the line": (mirror(record(each(lambda r: r.update(y_mm=repr(-3300 - float(r["y_mm"])))))), 0,
                                    "deviates against the force"),
    "second pass without --previous": (mirror("second.csv"), 0, "name that as --previous"),
    "second pass with --before alone": (mirror("second.csv", more=("--before", "pass.csv")), 0,
                                        "--previous does not name the correction"),
    "air averaged with a cut": (mirror(lambda: ["air.csv", "again.csv"]), 0, "does one cut air"),
    "a pass averaged with its correction": (mirror(lambda: ["pass.csv", "second.csv"]), 0, "or a correction?"),
    "another program": (mirror("pass.csv", lambda: changed(LINE, wave, "other.csv")), 0,
                        "is it the record of this program?"),
    "another program, 30 mm beside": (mirror("pass.csv", lambda: changed(LINE, add("y_mm", 30), "other.csv")), 1,
                                      "of another pass"),
    "another program, slower": (mirror("pass.csv", lambda: changed(LINE, scale(("t_s",), 1.3), "other.csv")), 1,
                                "it ran at another feed"),
    "a pass twice": (mirror(lambda: ["pass.csv", changed("pass.csv", add("t_s", 5), "copy.csv")]), 1, "holds the same as"),
    "goal in um": (mirror("pass.csv", more=("--goal-mm", 50)), 0, "is it in um?"),
    "forces in kN": (mirror(record(scale(FORCE, 1e-3)), more=("--robot", ROUGHING)), 0, "check unit and axes of fx_n"),
    "forces in kN, without a robot": (mirror(record(scale(FORCE, 1e-3))), 0, "are fx_n, fy_n and fz_n in N?"),
    "forces in uN, without a robot": (mirror(record(scale(FORCE, 1e6))), 0, "are fx_n, fy_n and fz_n in N?"),
    "forces of the cut in kN": (from_force(scale(FORCE, 1e-6)), 0, "which is nothing: are they in N"),
    "forces of the cut in kN, of a stiff robot": (from_force(scale(FORCE, 1e-3)), 0, "which is nothing: are they in N"),
    "forces of the cut in mN": (from_force(scale(FORCE, 1e3)), 0, "are they in N?"),
    "cut with a robot that does not yield": (from_force(each(lambda r: None), ROBOT), 0, "which is nothing"),
    "record in steps of 1 mm": (mirror(record(rounded(1))), 0, "have steps of 1 mm"),
    "record in steps of 0.1 mm, larger than the noise": (mirror(record(rounded(0.1), "quiet.csv")), 0,
                                                         "have steps of 0.1 mm"),
    # programs
    "$BASE changes": (program("DEF line( )", "$BASE=BASE_DATA[1]", "LIN {X -100,Y -1650,Z 850,A 0,B 0,C 0}",
                              "$BASE=BASE_DATA[2]", "LIN {X 200,Y -1650,Z 850,A 0,B 0,C 0}", "END"), 0,
                      "$BASE is another one"),
    "$BASE changes by inline forms": (
        program("DEF line( )", "DECL FDAT FA={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE}",
                "DECL FDAT FB={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE}", "FDAT_ACT=FA",
                "LIN {X -100,Y -1650,Z 850,A 0,B 0,C 0}", "FDAT_ACT=FB", "LIN {X 200,Y -1650,Z 850,A 0,B 0,C 0}", "END"),
        0, "$BASE is another one"),
    "$BASE is $WORLD in between": (
        program("DEF line( )", "$BASE=BASE_DATA[1]", "LIN {X -100,Y -1650,Z 850,A 0,B 0,C 0}", "$BASE=$WORLD",
                "LIN {X 200,Y -1650,Z 850,A 0,B 0,C 0}", "END"), 0, "$BASE is another one"),
    "$TOOL changes": (program("DEF line( )", "$TOOL=TOOL_DATA[1]", "LIN {X -100,Y -1650,Z 850,A 0,B 0,C 0}",
                              "BAS(#TOOL,2)", "LIN {X 200,Y -1650,Z 850,A 0,B 0,C 0}", "END"), 0,
                      "$TOOL is another one"),
    "the tool stands in the room": (
        program("DEF line( )", "$IPO_MODE=#TCP", "LIN {X -100,Y -1650,Z 850,A 0,B 0,C 0}",
                "LIN {X 200,Y -1650,Z 850,A 0,B 0,C 0}", "END"), 0, "its tool stands in the room"),
}

# The same without the mistake: not a word.
SOUND = {
    "campaign": campaign(each(lambda r: None)),
    "points": campaign(NO_ORIENTATION),
    "two sessions": campaign(each(lambda r: r.update(session="day 1" if float(r["t_s"]) < 1800 else "day 11"))),
    "distances": campaign(each(lambda r: None), "wires.yaml", source="wires.csv"),
    "quaternions": campaign(quaternions()),
    "sigma of two instruments": campaign(each(lambda r: r.update(sigma_mm="0.3" if every(2)(r) else "0.095"))),
    "sigma of single readings": campaign(each(lambda r: r.update(sigma_mm="0.095")), command="close-loop", source="once.csv",
                                         more=("--only-catalogue",)),
    "origin at a pose": campaign(each(lambda r: r.update({c: repr(float(r[c]) - float(FIRST[c])) for c in POINT}))),
    "effect": campaign(each(lambda r: None), effect("{name: sin, value: 1e-4, unit: rad}, {name: cos, value: 0, unit: rad}")),
    "effect without names": campaign(each(lambda r: None), effect("{value: 1e-4}, {value: 0}")),
    "measured orientations": campaign(each(lambda r: None), source="arm.csv"),
    "points in steps of 0.01 mm": campaign(rounded(0.01)),
    "Cartesian targets": poses_of_targets(each(lambda r: None)),
    "Cartesian targets, rough hints": poses_of_targets(add("q6_deg", 7)),
    "program of compensate": krl(START, *NEXT),
    "program that calls a routine of its own": krl(START, NEXT[0], "WAIT_HERE( )", NEXT[0], "END", "DEF WAIT_HERE( )"),
    "cut of a robot that yields": from_force(each(lambda r: None)),
    "UR program": ur(UR_START, *UR_NEXT),
    "certificate": certificate("visits.csv"),
    "certificate, arm that warms up": certificate("visits.csv", change=each(
        lambda r: r.update(z_mm=repr(float(r["z_mm"]) + 0.3 * (1 - math.exp(-float(r["t_s"]) / 400)))))),
    "certificate, one gross reading": certificate("visits.csv", change=add("x_mm", 3, lambda r: r["t_s"] == "700")),
    "rectangle": mirror("corners-pass.csv", "corners.csv"),
    "rectangle, 0.3 % smaller": mirror(lambda: [of_size(0.997)], "corners.csv"),
    "round part": mirror("round-pass.csv", "round.csv"),
    "round part, turned by a tenth of a degree": mirror(lambda: [about_the_part(0.1)], "round.csv"),
    "unchanged": since("visits.csv"),
    "close-loop": campaign(each(lambda r: None), command="close-loop", more=("--only-catalogue",)),
    "pass": mirror("pass.csv"),
    "pass in steps of its noise": mirror(record(rounded(0.1))),
    "two cuts": mirror(lambda: ["pass.csv", "again.csv"]),
    "second pass": mirror("second.csv", more=("--previous", "first.csv", "--before", "pass.csv")),
    "program": program("DEF line( )", "$BASE=BASE_DATA[1]", "BAS(#TOOL,1)", "LIN {X -100,Y -1650,Z 850,A 0,B 0,C 0}",
                       "BAS(#BASE,1)", "LIN {X 200,Y -1650,Z 850,A 0,B 0,C 0}", "END"),
}


class Mistakes(unittest.TestCase):
    def answer(self, arguments):
        for name in ("summary.yaml", "cut.src", "corrected.csv"):
            (FOLDER / name).unlink(missing_ok=True)
        return run(*arguments())

    def mistake(self, name):
        arguments, code, words = TABLE[name]
        done = self.answer(arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(words, done.stderr)
        if code == 1:
            return self.assertEqual(done.stdout, "")
        summary = FOLDER / "summary.yaml"
        document = summary.read_text() if summary.exists() else done.stdout
        if not document:
            return  # a table in a file
        self.assertIn(words, re.sub(r"\s*\n\s*", " ", document), "the document does not say it")

    def sound(self, name):
        done = self.answer(SOUND[name])
        self.assertEqual((done.returncode, done.stderr), (0, ""))


def identifier(name):
    return re.sub(r"\W+", "_", name)


for name in TABLE:
    setattr(Mistakes, "test_mistake_" + identifier(name), lambda self, name=name: self.mistake(name))
for name in SOUND:
    setattr(Mistakes, "test_sound_" + identifier(name), lambda self, name=name: self.sound(name))


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1)).resolve()
    with tempfile.TemporaryDirectory() as place:
        FOLDER = pathlib.Path(place)
        prepare()
        unittest.main()
