#!/usr/bin/env python3
"""The arm as it is applied, judged blind: campaigns with hidden physics, close-loop and calibrate, compensate, and the true
arm drives what comes out.

    applied_arm_study.py run --bin DIR --campaigns A-B --out FOLDER [--again]
    applied_arm_study.py summary --out FOLDER [--against FOLDER]
    applied_arm_study.py families

`run` makes the campaigns of these seeds (applied_arm_cell.py; they are the same on every machine), runs
    close-loop --robot robot.yaml train.csv --robot-out closed.yaml     (one of ten with --test: other poses of the same visits)
    calibrate --robot robot.yaml fitted.csv        (the geometry, from the poses that close-loop does not hold out)
    calibrate --robot robot.yaml train.csv         (the geometry from all poses)
    compensate --robot PRODUCT --controller robot.yaml --tool-is-measured targets.csv     (of each product)
and lets the arm as it is go to the targets as they are (nominal), and as each product corrects them. A user measures base
and tool of his cell once; so the judge fits both, to the same targets, for each of them. What remains is the error of the
arm: mean over targets that no fit has seen, without noise. Each campaign has a folder FOLDER/c/SEED with robot.yaml,
train.csv, targets.csv, answer.json (what hides), true-geometry.yaml, the products, errors.csv (each target) and cmd.txt;
FOLDER/results.csv gets one row as each is ready. A seed that stands there is not run again without --again.

The whole study is `run --campaigns 1-300`, some 20 minutes of CPU, in parts as one likes; `summary` prints the shares
that count, and with --against the campaigns in which two builds differ. `families` lists what may hide. applied_arm_study_test.py
tests the judge itself and runs some of the campaigns.

Best: the expected error of a fit that knows the forms of all that hides, from the covariance of its sizes and of the geometry;
it is not run. Shown: of each that hides, the fall of BIC that such a fit expects of it. A scale of the instrument is a
length of the arm: it moves each reading, and shows in none. What falls by odds of 1000 to 1 is shown.
Harmed: more than 5 % and more than a tenth of the floor above the error of the geometry of the same poses (or of all poses, or
of the nominal arm). False confidence:
the verdict is closed or nothing-to-explain, the arm errs by more than two floors, and its own std says less than half of
the error. Wrong cause without doubt: a finding with a name, confirmed, with no rival, no "or", not perhaps of the instrument,
that no hidden family explains.
"""

import argparse
import copy
import csv
import json
import math
import operator
import os
import pathlib
import re
import subprocess
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import yaml  # noqa: E402

from applied_arm_cell import FAMILIES, NULL, TARGETS, Cell  # noqa: E402
from virtual_cell import NONE, add, after, cross, length, moved, scaled, small_motion, sub, turned  # noqa: E402

MAX_MM = 100                   # no correction is refused for its size: the nominal arms err by some mm
LEFT_ALONE = {"unreachable", "limit", "beyond-max", "singular"}
HARM_SHARE, HARM_FLOORS = 0.05, 0.1
FALSE_FLOORS = 2.0
SHOWN = 2 * math.log(1000)
PRODUCTS = ("closed", "geometry", "all-poses")


# ---- linear algebra ----------------------------------------------------------------------------------------------

def solve(matrix, right):
    """Gauss with pivots; the matrix is a list of rows and is lost."""
    n = len(right)
    rows = [list(row) + [x] for row, x in zip(matrix, right)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            if factor:
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k])]
    result = [0.0] * n
    for k in reversed(range(n)):
        result[k] = (rows[k][n] - sum(rows[k][j] * result[j] for j in range(k + 1, n))) / rows[k][k]
    return result


def replaced(frames, tool, points):
    """What remains of points if base and tool of the nominal frames are fitted to them: vectors in R_0."""
    base, centre = NONE, scaled(tuple(map(sum, zip(*points))), 1 / len(points))
    size = max(length(sub(p, centre)) for p in points) or 1.0
    for _ in range(8):
        normal, right = [[0.0] * 9 for _ in range(9)], [0.0] * 9
        for frame, point in zip(frames, points):
            here = after(base, frame)
            at = moved(here, tool)
            lever, rest = scaled(sub(at, centre), 1 / size), sub(point, at)
            columns = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
            columns += [cross(axis, lever) for axis in columns[:3]]
            columns += [tuple(row[k] for row in here[0]) for k in range(3)]
            for a in range(9):
                right[a] += sum(x * y for x, y in zip(columns[a], rest))
                for b in range(9):
                    normal[a][b] += sum(x * y for x, y in zip(columns[a], columns[b]))
        for a in range(9):
            normal[a][a] += 1e-9 * len(points)         # a tool that only turns about a vertical axis has no height
        step = solve(normal, right)
        base = after(small_motion(scaled(step[3:6], 1 / size), tuple(step[:3]), centre), base)
        tool = add(tool, tuple(step[6:]))
        if max(map(abs, step)) < 1e-7:
            break
    return [sub(point, moved(after(base, frame), tool)) for frame, point in zip(frames, points)]


# ---- the best possible fit ---------------------------------------------------------------------------------------

READINGS_OF_BEST = 120         # visits of a campaign that stand for all


class Point:
    """Numbers of the true campaign, one of which is moved."""

    def __init__(self, cell):
        self.rows, self.tool, self.bases = [copy.copy(row) for row in cell.rows], cell.tool, list(cell.bases)
        self.sizes, self.zeros = [list(effect.sizes) for effect in cell.effects], list(cell.zeros) if cell.anchors else []
        self.anchors = list(cell.anchors)


def unknowns(cell):
    """All that a fit which knows the forms has to find: (prior standard deviation, step, function that moves a Point)."""
    result = []
    def geometry(i, key, deviation):
        def move(point, step):
            setattr(point.rows[i], key, getattr(point.rows[i], key) + step)
        result.append((deviation, 0.01 * deviation, move))
    for i, row in enumerate(cell.arm.rows):
        geometry(i, "alpha", cell.made_turn)
        geometry(i, "d", cell.made_shift)
        geometry(i, "theta", cell.made_zero if row.joint == "R" else cell.made_turn)
        geometry(i, "r", 3 * cell.made_shift if row.joint == "P" else cell.made_shift)
        if abs(math.sin(row.alpha)) < 1e-3 and i > 0:
            geometry(i, "beta", cell.made_turn)
    for k in range(6):
        small = lambda step, k=k: small_motion(*[tuple(step if 3 * half + i == k else 0.0 for i in range(3)) for half in (0, 1)],
                                               (0.0, 0.0, 0.0))
        deviation = 0.05 if k < 3 else 100.0
        for session in range(cell.sessions):
            def move_base(point, step, small=small, session=session):
                point.bases[session] = after(point.bases[session], small(step))
            result.append((deviation, 1e-4 * deviation, move_base))
        if cell.with_orientation or k > 2:
            def move_tool(point, step, small=small):
                point.tool = after(point.tool, small(step))
            result.append((deviation, 1e-4 * deviation, move_tool))
    for k in range(len(cell.anchors)):
        def move_zero(point, step, k=k):
            point.zeros[k] += step
        result.append((10.0, 0.01, move_zero))
        for axis in range(3):
            def move_anchor(point, step, k=k, axis=axis):
                point.anchors[k] = add(point.anchors[k], tuple(step * (a == axis) for a in range(3)))
            result.append((1.0, 0.01, move_anchor))
    for e, effect in enumerate(cell.effects):
        for k in range(len(effect.sizes)):
            def move_size(point, step, e=e, k=k):
                point.sizes[e][k] += step
            deviation = max(map(abs, effect.sizes))
            result.append((deviation, 0.01 * deviation, move_size))
    return result


def derivatives(cell, moves, look):
    """Change of the numbers that `look` reads, for each unknown in standard deviations of its prior."""
    start, columns = look(Point(cell)), []
    for deviation, step, move in moves:
        point = Point(cell)
        move(point, step)
        columns.append([(b - a) * deviation / step for a, b in zip(start, look(point))])
    return columns


def information(cell, moves):
    """Normal matrix of a fit of the geometry and of the sizes of all that hides, forms known, from as many readings as close-loop
    fits, with its priors, and the number of equations."""
    step = max(1, len(cell.visits) // READINGS_OF_BEST)
    visits = cell.visits[::step]
    share = len(cell.visits) / len(visits) * (0.8 if cell.with_test else 0.75)
    weight, turn_weight = 1 / cell.noise_mm, 1 / (cell.noise_mrad * 1e-3) if cell.with_orientation else 0.0
    upright = [tuple(zip(*cell.readings(v)[0])) for v in visits]

    def look(point):
        numbers = []
        for v, back in zip(visits, upright):
            known = (v, point.sizes, point.rows, point.tool, point.bases[v.session])
            if cell.anchors:
                numbers += [weight * (l + zero) for l, zero in zip(cell.lengths(*known, point.anchors), point.zeros)]
                continue
            rotation, place = cell.readings(*known)
            numbers += [weight * x for x in place]
            if turn_weight:
                small = [turned(back, column) for column in zip(*rotation)]      # columns of R0^T R
                numbers += [turn_weight * x for x in (small[1][2], small[2][0], small[0][1])]
        return numbers

    columns = derivatives(cell, moves, look)
    n = len(columns)
    normal = [[0.0] * n for _ in range(n)]
    for a in range(n):
        for b in range(a, n):
            normal[a][b] = normal[b][a] = share * sum(map(operator.mul, columns[a], columns[b])) + (a == b)
    return normal, share * len(columns[0])


def shown(cell, moves, normal, equations):
    """Fall of BIC, without noise, by each that hides beside the geometry and all else that hides."""
    falls, first = [], len(moves) - sum(len(effect.sizes) for effect in cell.effects)
    for effect in cell.effects:
        own = list(range(first, first + len(effect.sizes)))
        order = [k for k in range(len(moves)) if k not in own] + own
        lower = cholesky([[normal[a][b] for b in order] for a in order])
        sizes = [size / moves[k][0] for size, k in zip(effect.sizes, own)]
        # The last block of N = L L^T leaves L_own L_own^T to it, of which 1 is its prior.
        begin = len(moves) - len(own)
        gain = sum(sum(lower[a][b] * size for a, size in zip(range(begin, len(moves)), sizes)) ** 2
                   for b in range(begin, len(moves))) - sum(size * size for size in sizes)
        falls.append(gain - len(own) * math.log(equations))
        first += len(own)
    return falls


def best_possible(cell, moves, normal):
    """Expected error of the arm, mean over the targets, mm, by the posterior covariance of that fit."""
    n = len(moves)
    cell.follow(cell.judged, cell.targets)
    frames = [cell.chain(v) for v in cell.judged[1:]]
    at_targets = derivatives(cell, moves, lambda point: [x for v in cell.judged[1:] for x in cell.chain(
        v, point.sizes, point.rows, point.tool)[1]])
    replace = [[x for frame in frames for x in column(frame)] for column in
               [lambda f, k=k: [float(i == k) for i in range(3)] for k in range(3)]
               + [lambda f, k=k: scaled(cross([float(i == k) for i in range(3)], f[1]), 1e-3) for k in range(3)]
               + [lambda f, k=k: [row[k] for row in f[0]] for k in range(3)]]
    basis = []
    for column in replace:
        size = math.sqrt(sum(map(operator.mul, column, column)))
        for unit in basis + basis:
            along = sum(map(operator.mul, column, unit))
            column = [x - along * y for x, y in zip(column, unit)]
        left = math.sqrt(sum(map(operator.mul, column, column)))
        if left > 1e-6 * size:
            basis.append([x / left for x in column])
    for k, column in enumerate(at_targets):
        for unit in basis:
            along = sum(map(operator.mul, column, unit))
            column = [x - along * y for x, y in zip(column, unit)]
        at_targets[k] = column
    # With N = L L^T the variance of a row a is |L^-1 a|^2.
    lower = cholesky(normal)
    rows, total = [list(row) for row in zip(*at_targets)], []
    for k in range(0, len(rows), 3):
        variance = 0.0
        for row in rows[k:k + 3]:
            for i in range(n):
                row[i] = (row[i] - sum(map(operator.mul, lower[i][:i], row[:i]))) / lower[i][i]
            variance += sum(map(operator.mul, row, row))
        total.append(math.sqrt(variance * 8 / (3 * math.pi)))
    return mean(total)


def cholesky(matrix):
    lower = [[0.0] * len(matrix) for _ in matrix]
    for i, row in enumerate(matrix):
        for j in range(i + 1):
            rest = row[j] - sum(map(operator.mul, lower[i][:j], lower[j][:j]))
            lower[i][j] = math.sqrt(rest) if i == j else rest / lower[j][j]
    return lower


# ---- one campaign ------------------------------------------------------------------------------------------------

class Command:
    """Runs one command in the folder of the campaign."""

    def __init__(self, binaries, folder, log):
        self.binaries, self.folder, self.log = binaries, folder, log

    def __call__(self, name, *arguments):
        """Exit code, CPU seconds, peak memory in MB; standard error stands in NAME.err, numbered."""
        line = [str(self.binaries / name)] + [str(a) for a in arguments]
        self.log.append(" ".join([name] + line[1:]))
        with open(self.folder / f"{len(self.log)}-{name}.err", "w") as errors:
            process = subprocess.Popen(line, cwd=self.folder, stderr=errors, stdin=subprocess.DEVNULL)
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def read_commands(path, columns):
    """Joint values of the file, std and notes of each target."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return ([[float(row[column]) for column in columns] for row in rows],
            [float(row["std_mm"]) if row.get("std_mm") else None for row in rows],
            [set(row["note"].split()) for row in rows])


KINDS = (("space", r"^(range|azimuth|elevation|place|incidence|position)"), ("arrival", r"^(arrival|stroke)"),
         ("load", r"gravity|motor-torque|moment|payload|force|tool-weight"), ("temperature", r"temperature"),
         ("time", r"^time|\* *time|^order|^visit|^session"), ("angle", r"^joint-angle"))


def kind_of(driver):
    return next((kind for kind, pattern in KINDS if re.search(pattern, driver)), driver)


def owner_of(parameter, driver):
    if re.match(r"(instrument|anchor|target)\b", parameter):
        return "station"
    if parameter.startswith("tool"):
        return "tool"
    if parameter.startswith("base"):
        return "arm" if kind_of(driver) in ("load", "angle") else "station"
    return "arm"


def explained(cell, effect):
    """The hidden families that explain a finding. Neighbours of a joint count: their axes may be parallel, and beta behind
    a right angle is theta by another name."""
    owner, kind = owner_of(effect["parameter"], effect["driver"]), kind_of(effect["driver"])
    link = effect["parameter"].rsplit(".", 1)[0]
    names = [row.name for row in cell.arm.rows]
    at = None
    if link in names:
        before = [i for i in cell.arm.driven if i <= names.index(link)]
        at = len(before) - 1
    return [hidden.name for hidden in cell.effects
            if any((owner, kind) == (claimed_owner, claimed_kind)
                   and (joints is None or at is None or any(abs(at - j) <= 1 for j in joints))
                   for claimed_owner, claimed_kind, joints in hidden.claims)]


def is_without_doubt(effect):
    return (effect["name"] != "unexplained" and effect.get("confirmed") is True and not effect.get("indistinguishable")
            and not effect.get("shared_with") and not effect.get("may_be_instrument") and not re.search(r"\bor\b", effect.get("sentence", "")))


def mean(values):
    values = list(values)
    return sum(values) / len(values) if values else float("nan")


FIELDS = ["seed", "arm", "instrument", "poses", "repeats", "hidden", "kinds", "owners", "size_mm", "shown", "floor_mm", "verdict", "found",
          "sentences", "wrong", "unexplained_by", "not_applied", "without_name", "before_mm", "after_mm", "nominal_mm",
          "geometry_mm", "all_poses_mm", "result_mm", "best_mm", "std_mm", "inside_95", "geometry_std_mm", "geometry_inside_95", "left_alone",
          "exits", "cpu_s", "memory_mb", "harmed", "harmed_all_poses", "harmed_nominal", "false_confidence", "problem"]


def run_one(seed, binaries, out):
    cell = Cell(seed)
    folder = out / "c" / f"{seed:03d}"
    cell.write(folder)
    log, cpu, memory, exits = [], 0.0, 0.0, []
    command = Command(binaries, folder, log)
    row = {field: "" for field in FIELDS}
    row |= {"seed": seed, "arm": cell.arm.name, "hidden": " + ".join(cell.hidden), "poses": cell.count,
            "instrument": cell.instrument + ("-6d" if cell.with_orientation else ""), "repeats": cell.repeats,
            "kinds": " ".join(sorted({e.kind for e in cell.effects if e.kind})),
            "owners": " ".join(sorted({e.owner for e in cell.effects})), "floor_mm": cell.floor_mm(),
            "size_mm": " ".join(f"{size:.3f}" for size in sizes_of(cell))}
    try:
        extra = ["--test", "test.csv"] if (folder / "test.csv").exists() else []
        code, used, peak = command("close-loop", "--robot", "robot.yaml", "train.csv", *extra, "--robot-out", "closed.yaml",
                                   "--residuals", "residuals.csv", "-o", "loop.yaml")
        cpu, memory = used, peak
        exits.append(code)
        if code not in (0, 3):
            row["problem"] = "close-loop refuses: " + (folder / "1-close-loop.err").read_text().strip()[:300]
        if not row["problem"]:
            write_fitted(folder)
            for readings, product in (("fitted", "geometry"), ("train", "all-poses")):
                exits.append(command("calibrate", "--robot", "robot.yaml", f"{readings}.csv", "-o", f"{product}.yaml")[0])
            judge_products(cell, folder, command, exits, row)
    except (OSError, KeyError, ValueError, yaml.YAMLError) as error:
        row["problem"] = f"{type(error).__name__}: {error}"
    (folder / "cmd.txt").write_text("\n".join(log) + "\n")
    row |= {"exits": " ".join(map(str, exits)), "cpu_s": f"{cpu:.2f}", "memory_mb": f"{memory:.0f}"}
    return {key: f"{value:.4f}" if isinstance(value, float) else value for key, value in row.items()}


def write_fitted(folder):
    """The readings of the poses that close-loop fitted."""
    with open(folder / "residuals.csv", newline="") as file:
        fitted = {row["pose"] for row in csv.DictReader(file) if row["split"] == "training"}
    with open(folder / "train.csv", newline="") as file:
        rows = list(csv.reader(file))
    with open(folder / "fitted.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows[:1] + [row for row in rows[1:] if row[0] in fitted])


def sizes_of(cell):
    """What each hidden effect moves the arm at the targets (of the station: the readings), with base and tool fitted: mean, mm."""
    sizes, everything = [], cell.effects
    frames = [cell.arm.frames(v.q)[-1] for v in cell.judged]
    cell.follow(cell.judged, cell.targets)
    for effect in everything:
        visits = cell.visits if effect.owner == "station" else cell.judged
        cell.effects = [effect]
        if effect.wire:
            with_it = [cell.lengths(v) for v in visits]
            cell.effects = []
            sizes.append(mean(abs(a - b) for v, l in zip(visits, with_it) for a, b in zip(l, cell.lengths(v))))
            continue
        read = cell.readings if effect.owner == "station" else cell.chain
        with_it = [read(v)[1] for v in visits]
        cell.effects = []
        frames = [after(read(v), inverse(cell.tool)) for v in visits]
        sizes.append(mean(map(length, replaced(frames, cell.tool[1], with_it))))
    cell.effects = everything
    return sizes


def inverse(motion):
    rotation = tuple(zip(*motion[0]))
    return rotation, scaled(turned(rotation, motion[1]), -1.0)


def judge_products(cell, folder, command, exits, row):
    with open(folder / "loop.yaml") as file:
        loop = yaml.load(file, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    columns = cell.arm.columns()
    session = []
    for product in PRODUCTS:
        text = (folder / f"{product}.yaml").read_text()
        if cell.sessions > 1 and re.search(r"theta_deg: *\{|theta_deg:\n", text.split("links:")[0]):
            session = ["--session", f"day {cell.sessions}"]
        arguments = ["--robot", f"{product}.yaml", "--controller", "robot.yaml", "--tool-is-measured", "--max-mm", MAX_MM, *session,
                     "targets.csv", "-o", f"commands-{product}.csv", "--summary", f"summary-{product}.yaml"]
        code = command("compensate", *arguments)[0]
        exits.append(code)
        if code not in (0, 3):
            row["problem"] += f"compensate of {product} fails: " + (
                folder / f"{len(command.log)}-compensate.err").read_text().strip()[:300]
            return
    frames = [cell.arm.frames(q)[-1] for q in cell.targets]
    points = {"nominal": cell.execute(cell.targets)}
    std, notes = {}, {}
    for product in PRODUCTS:
        commanded, std[product], notes[product] = read_commands(folder / f"commands-{product}.csv", columns)
        points[product] = cell.execute([cell.arm.values(q) for q in commanded])
    judged = [k for k in range(1, TARGETS) if not any(LEFT_ALONE & notes[p][k] for p in PRODUCTS)]
    row["left_alone"] = TARGETS - 1 - len(judged)
    errors = {}
    for product, reached in points.items():
        errors[product] = list(map(length, replaced([frames[k] for k in judged], cell.tool[1], [reached[k] for k in judged])))
    with open(folder / "errors.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["pose", "nominal_mm", "geometry_mm", "all_poses_mm", "result_mm", "geometry_std_mm", "result_std_mm", "note"])
        for n, k in enumerate(judged):
            writer.writerow([f"T{k + 1}"] + [f"{errors[p][n]:.5f}" for p in ("nominal", "geometry", "all-poses", "closed")]
                            + [std["geometry"][k], std["closed"][k], " ".join(sorted(notes["closed"][k]))])
    nominal, geometry, all_poses, result = (mean(errors[p]) for p in ("nominal", "geometry", "all-poses", "closed"))
    row |= {"nominal_mm": nominal, "geometry_mm": geometry, "all_poses_mm": all_poses, "result_mm": result}
    for product, prefix in (("closed", ""), ("geometry", "geometry_")):
        known = [(e, std[product][k]) for e, k in zip(errors[product], judged) if std[product][k]]
        if known:
            row[prefix + "std_mm"] = math.sqrt(mean(s * s for _, s in known))
            row[prefix + "inside_95"] = mean(e < 1.7 * s for e, s in known)
    moves = unknowns(cell)
    normal, equations = information(cell, moves)
    row["shown"] = " ".join(f"{fall:.1f}" for fall in shown(cell, moves, normal, equations))
    row["best_mm"] = best_possible(cell, moves, normal)
    floor = cell.floor_mm()
    harmed = lambda other: result - other > max(HARM_SHARE * other, HARM_FLOORS * floor)
    effects = loop.get("effects") or []
    wrong = [e for e in effects if is_without_doubt(e) and not explained(cell, e)]
    confident = loop["verdict"] in ("closed", "nothing-to-explain")
    row |= {"verdict": loop["verdict"],
            "found": " | ".join(f"{e['name']}: {e['parameter']} ~ {e['driver']} ({e['shape']})"
                                + ("" if is_without_doubt(e) else " ?")
                                + (" [instrument?]" if e.get("may_be_instrument") else "")
                                + f" -> {', '.join(explained(cell, e)) or 'nothing hidden'}" for e in effects),
            "sentences": " | ".join(e.get("sentence", "") for e in effects),
            "wrong": " | ".join(f"{e['parameter']} ~ {e['driver']}" for e in wrong),
            "unexplained_by": sum(not explained(cell, e) for e in effects),
            "not_applied": sum(bool(e.get("may_be_instrument")) for e in effects),
            "without_name": nameless(loop),
            "before_mm": loop["before_after"]["before_mm"], "after_mm": loop["before_after"]["after_mm"],
            "harmed": int(harmed(geometry)), "harmed_all_poses": int(harmed(all_poses)),
            "harmed_nominal": int(harmed(nominal)),
            "false_confidence": int(confident and result > FALSE_FLOORS * floor
                                    and result > 2 * float(row["std_mm"] or 0.0))}


def nameless(loop):
    """What is in the model without a finding."""
    held = [f"held by a prior: {e['parameter']} ~ {e['driver']}" for e in loop.get("held_by_priors") or []]
    return " | ".join(held + [f"{g['group']} ({g['owner']}) {g['of_noise']:.2g}" for g in loop.get("without_name") or []])


# ---- the study ---------------------------------------------------------------------------------------------------

def read_results(out):
    path = out / "results.csv"
    if not path.exists():
        return {}
    with open(path, newline="") as file:
        return {int(row["seed"]): row for row in csv.DictReader(file)}


def run(options):
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    done = {} if options.again else read_results(out)
    path = out / "results.csv"
    if not done:
        with open(path, "w", newline="") as file:
            csv.DictWriter(file, FIELDS, lineterminator="\n").writeheader()
    first, last = map(int, options.campaigns.split("-")) if "-" in options.campaigns else [int(options.campaigns)] * 2
    for seed in range(first, last + 1):
        if seed in done:
            continue
        row = run_one(seed, options.bin.resolve(), out)
        with open(path, "a", newline="") as file:
            csv.DictWriter(file, FIELDS, lineterminator="\n").writerow(row)
        print(f"{seed:4d} {row['arm']:16s} {row['instrument']:10s} {row['hidden'][:44]:44s} {row['verdict']:18s} nominal "
              f"{row['nominal_mm']} geometry {row['geometry_mm']} (all poses {row['all_poses_mm']}) result {row['result_mm']} floor {row['floor_mm']}"
              f"{' HARMED' if row['harmed'] == 1 else ''}{' ' + row['problem'] if row['problem'] else ''}", flush=True)
    return 0


def percent(part, whole):
    return f"{part} of {whole} ({100 * part / whole:.1f} %)" if whole else "0 of 0"


def names_of(row):
    """The hidden families that the findings name."""
    return {name for names in re.findall(r"-> ([^|]*)", row["found"]) for name in names.strip().split(", ")}


def lists(rows, title):
    if rows:
        print(f"\n{title}")
    for row in rows:
        print(f"  {int(row['seed']):03d} {row['arm']}, {row['instrument']}, {row['poses']} x {row['repeats']}: {row['hidden']} "
              f"[{row['size_mm']}]; said {row['verdict']}: {row['found'] or 'nothing'}"
              f"{'; without a name: ' + row['without_name'] if row['without_name'] else ''}; "
              f"nominal {row['nominal_mm']}, geometry {row['geometry_mm']}, of all poses {row['all_poses_mm']}, result {row['result_mm']}, floor {row['floor_mm']}, "
              f"std {row['std_mm']}")


def summary(options):
    everything = list(read_results(options.out).values())
    rows = [row for row in everything if row["result_mm"] and not row["problem"]]
    number = lambda row, key: float(row[key] or "nan")
    is_null = lambda row: row["hidden"] in NULL
    n = len(rows)
    harmed = [row for row in rows if row["harmed"] == "1"]
    worse_than_nominal = [row for row in rows if row["harmed_nominal"] == "1"]
    false, wrong = [r for r in rows if r["false_confidence"] == "1"], [r for r in rows if r["wrong"]]
    nulls = [row for row in rows if is_null(row)]
    print(f"campaigns {len(everything)}, judged {n}, refused or failed {len(everything) - n}")
    print("harmed against geometry:", percent(len(harmed), n))
    print("harmed against the geometry of all poses:", percent(sum(row["harmed_all_poses"] == "1" for row in rows), n))
    print("harmed against nominal:", percent(len(worse_than_nominal), n))
    print("null campaigns harmed:", percent(sum(row in harmed or row in worse_than_nominal for row in nulls), len(nulls)))
    logs = lambda chosen: math.exp(mean(math.log(number(r, "result_mm") / number(r, "geometry_mm")) for r in chosen)) if chosen else 0
    with_physics = [row for row in rows if not is_null(row)]
    of_arm = [row for row in with_physics if {"arm", "tool"} & set(row["owners"].split())]
    print(f"geometric mean of result / geometry: all {logs(rows):.3f}, with physics {logs(with_physics):.3f}, of the arm or tool "
          f"{logs(of_arm):.3f}, of the station alone {logs([r for r in with_physics if r not in of_arm]):.3f}, null {logs(nulls):.3f}")
    best = [row for row in rows if row["best_mm"]]
    if best:
        print("within 1.3 of the best possible fit:", percent(
            sum(number(r, "result_mm") <= 1.3 * number(r, "best_mm") for r in best), len(best)),
            f"; geometric mean of result / best {math.exp(mean(math.log(number(r, 'result_mm') / number(r, 'best_mm')) for r in best)):.2f}")
    print("false confidence:", percent(len(false), n))
    print("wrong cause without doubt:", percent(len(wrong), n))
    missed = {}
    for kind in ("growth", "load", "distortion", "backlash"):
        hidden = [row for row in rows if kind in row["kinds"].split()]
        families = {name for name, entry in FAMILIES.items() if entry[2] == kind}
        most = lambda row, key: max((float(x) for x, name in zip(row.get(key, "").split(), row["hidden"].split(" + "))
                                     if name in families), default=0.0)
        large = [row for row in hidden if most(row, "size_mm") > 0.5 * number(row, "floor_mm")]
        seen = [row for row in hidden if most(row, "shown") > SHOWN]
        named = lambda chosen: percent(sum(bool(families & names_of(row)) for row in chosen), len(chosen))
        print(f"{kind}: hidden in {len(hidden)}; larger than half a floor in {len(large)}, named {named(large)}; shown in {len(seen)}, "
              f"named {named(seen)}")
        missed[kind] = [row for row in seen if not families & names_of(row)]
    known = [row for row in rows if row["inside_95"]]
    print(f"targets within the 95 % bounds of the applied arm: {100 * mean(number(r, 'inside_95') for r in known):.1f} %; of the "
          f"geometry {100 * mean(number(r, 'geometry_inside_95') for r in known if r['geometry_inside_95']):.1f} %")
    print(f"close-loop: CPU {sum(number(r, 'cpu_s') for r in everything):.0f} s, most "
          f"{max(number(r, 'cpu_s') for r in everything):.1f} s; memory at most "
          f"{max(number(r, 'memory_mb') for r in everything):.0f} MB")
    lists(harmed, "harmed against geometry")
    lists([row for row in worse_than_nominal if row not in harmed], "harmed against nominal")
    lists(false, "false confidence")
    lists(wrong, "wrong cause without doubt")
    for kind, campaigns in missed.items():
        lists(campaigns, f"{kind} that readings show, not named")
    for row in everything:
        if row["problem"]:
            print(f"  {row['seed']} {row['arm']} {row['hidden']}: {row['problem']}")
    if options.against:
        other = read_results(options.against)
        print("\nchanged by more than 5 % and a tenth of the floor:")
        for row in rows:
            old = other.get(int(row["seed"]))
            if old and old["result_mm"]:
                change = number(row, "result_mm") - number(old, "result_mm")
                if abs(change) > max(0.05 * number(old, "result_mm"), 0.1 * number(row, "floor_mm")):
                    print(f"  {row['seed']} {row['hidden']}: {old['result_mm']} -> {row['result_mm']} (geometry {row['geometry_mm']}) "
                          f"{'worse' if change > 0 else 'better'}")
    return 0


def families(_):
    for name, (function, needs, kind) in FAMILIES.items():
        print(f"{name:28s} {kind or '':12s} {' '.join(needs):22s} {' '.join((function.__doc__ or '').split())}")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("run")
    one.add_argument("--bin", type=pathlib.Path, required=True)
    one.add_argument("--campaigns", required=True)
    one.add_argument("--out", type=pathlib.Path, required=True)
    one.add_argument("--again", action="store_true")
    two = commands.add_parser("summary")
    two.add_argument("--out", type=pathlib.Path, required=True)
    two.add_argument("--against", type=pathlib.Path)
    commands.add_parser("families")
    options = parser.parse_args()
    return {"run": run, "summary": summary, "families": families}[options.command](options)


if __name__ == "__main__":
    sys.exit(main())
