#!/usr/bin/env python3
"""Corrects robot programs of four makers with compensate and lets a true arm run them: a controller of its own computes
the joints by the nominal model, the true arm goes there. Neither shares code with armtrue.

    robot_programs_test.py BIN [--figures]
"""

import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import robot_programs as rp
import virtual_cell as vc

BIN = None
KUKA = vc.ROOT / "config/robots/kr360-spindle.yaml"


def fanuc_axes(text):
    """FANUC counts the axes 3 to 6 the other way round."""
    return re.sub(r"(name: A[3456],.*sign: )1", r"\g<1>-1", text)


def arm_text(name):
    """The nominal arm."""
    if name == "fanuc":
        return fanuc_axes(vc.data_sheet_yaml("heavy-2650")[0])
    return {"inform": (vc.ROOT / "config/robots/gp25.yaml").read_text, "krl": KUKA.read_text, "rapid": lambda: vc.data_sheet_yaml("bench-580")[0],
            "urscript": lambda: vc.data_sheet_yaml("cobot-1300")[0]}[name]()


def true_text(nominal, rng):
    """Each length of a link off by up to 1 mm, each angle by up to 1 mrad."""
    def changed(match):
        size = 1.0 if match[1].endswith("mm") else math.degrees(1e-3)
        return f"{match[1]}: {float(match[2]) + rng.uniform(-size, size):.9f}"
    return "\n".join(re.sub(r"((?:alpha|theta|beta)_deg|[dr]_mm): (-?[\d.]+)", changed, line) if "joint: revolute" in line
                     else line for line in nominal.splitlines()) + "\n"


def inverse(motion):
    rotation = vc.transposed(motion[0])
    return rotation, vc.scaled(vc.turned(rotation, motion[1]), -1.0)


def difference(wanted, reached):
    """Six numbers: mm and rad."""
    r = vc.rotation_times(wanted[0], vc.transposed(reached[0]))
    vector = ((r[2][1] - r[1][2]) / 2, (r[0][2] - r[2][0]) / 2, (r[1][0] - r[0][1]) / 2)
    return list(vc.sub(wanted[1], reached[1])) + list(vector)


def solved(matrix, right):
    """Gauss with pivots."""
    rows = [row[:] + [value] for row, value in zip(matrix, right)]
    n = len(rows)
    for i in range(n):
        best = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[best] = rows[best], rows[i]
        for k in range(n):
            if k != i:
                factor = rows[k][i] / rows[i][i]
                rows[k] = [a - factor * b for a, b in zip(rows[k], rows[i])]
    return [rows[i][n] / rows[i][i] for i in range(n)]


def joints_at(arm, wanted, start):
    """Newton's method with differences."""
    q = list(start)
    for _ in range(40):
        here = arm.pose(q)
        error = difference(wanted, here)
        if max(map(abs, error)) < 1e-10:
            return q
        columns = []
        for j in range(6):
            step = q[:]
            step[j] += 1e-7
            columns.append([-(b - a) / 1e-7 for a, b in zip(error, difference(wanted, arm.pose(step)))])
        change = solved([list(row) for row in zip(*columns)], error)
        largest = max(map(abs, change))
        q = [a + c * min(1.0, 0.2 / largest) for a, c in zip(q, change)]
    raise AssertionError("the controller does not reach its command")


def wrist(arm, q):
    """The centre of the wrist with axis 1 at zero."""
    here = vc.NONE
    for j in range(1, 4):
        here = vc.after(here, vc.screw(arm.axes[j], arm.points[j], q[j]))
    return vc.moved(here, arm.points[4])


def is_elbow_up(arm, q):
    """On the side of the zero posture, seen from the line through the axes 2 and 3."""
    def side(angles):
        shoulder, elbow = arm.points[1], vc.moved(vc.screw(arm.axes[1], arm.points[1], angles[1]), arm.points[2])
        return vc.dot(vc.Y, vc.cross(vc.sub(elbow, shoulder), vc.sub(wrist(arm, angles), elbow)))
    return side(q) * side([0.0] * 6) > 0


def quadrants(q):
    return tuple(math.floor(math.degrees(q[j]) / 90) for j in (0, 3, 5))


class Cell:
    """One dialect: arms, frames, and random postures on one branch or another."""

    def __init__(self, dialect, seed):
        self.rng = random.Random(seed)
        self.nominal_text = arm_text(dialect)
        self.true_text = true_text(self.nominal_text, self.rng)
        self.nominal, self.true = vc.Arm(self.nominal_text), vc.Arm(self.true_text)
        uniform = self.rng.uniform
        self.tools = [rp.abc_motion(uniform(-50, 50), uniform(-50, 50), uniform(50, 200), uniform(-90, 90),
                                    uniform(-60, 60), uniform(-90, 90)) for _ in range(2)]
        self.bases = [rp.abc_motion(uniform(-500, 500), uniform(-500, 500), uniform(0, 500), uniform(-180, 180),
                                    uniform(-20, 20), uniform(-20, 20)) for _ in range(2)]

    def posture(self, *ranges):
        return [math.radians(self.rng.uniform(low, high)) for low, high in ranges]

    def near(self, q, by=0.1):
        return [angle + self.rng.uniform(-by, by) for angle in q]

    def written(self, q, base, tool):
        """Base from TCP."""
        return vc.after(vc.after(inverse(base), self.nominal.pose(q)), tool)


def kuka_turn(q):
    return sum(1 << j for j in range(6) if q[j] < 0)


def kuka_frame(cell, q, base, tool, with_status=True):
    pose = cell.written(q, base, tool)
    text = "X {:.6f},Y {:.6f},Z {:.6f},A {:.6f},B {:.6f},C {:.6f}".format(*pose[1], *vc.kuka(pose[0]))
    status = (wrist(cell.nominal, q)[0] < 0) + 2 * (math.degrees(q[2]) > -3.07) + 4 * (q[4] < 0) + 16
    return "{" + text + (f",S {status},T {kuka_turn(q)}" if with_status else "") + "}"


def kuka_setting(name, motion):
    return "${}={{X {:.6f},Y {:.6f},Z {:.6f},A {:.6f},B {:.6f},C {:.6f}}}".format(name, *motion[1], *vc.kuka(motion[0]))


def krl_program(cell):
    """Text of the .src and of the .dat, and the posture of each target."""
    lines, points, postures = ["&ACCESS RVP", "DEF part( )"], ["DEFDAT PART"], []
    for k in range(16):
        base, tool = cell.bases[k // 4 % 2], cell.tools[k // 8 % 2]
        if k % 4 == 0:
            lines += [kuka_setting("BASE", base), kuka_setting("TOOL", tool)]
        sign = cell.rng.choice((-1, 1))
        q = cell.posture((-150, 150), (-105, -40), (30, 115), (-320, 320), (sign * 35, sign * 95), (-320, 320))
        postures.append(q)
        if k % 4 == 3:
            lines.append("PTP {" + ",".join(f"A{j} {math.degrees(a):.6f}" for j, a in enumerate(q, 1)) + "} C_PTP ; joints")
        else:
            points.append(f"DECL E6POS XP{k}={kuka_frame(cell, q, base, tool)}")
            lines.append(f"PTP XP{k}")
        for _ in range(2):
            q = cell.near(q)
            postures.append(q)
            lines.append(f"LIN {kuka_frame(cell, q, base, tool, k % 2 == 0)} C_DIS")
        via, q = cell.near(q), cell.near(q)
        postures += [via, q]
        lines.append(f"SCIRC {kuka_frame(cell, via, base, tool, False)}, {kuka_frame(cell, q, base, tool, False)}")
    return "\r\n".join(lines + ["END", ""]), "\r\n".join(points + ["ENDDAT", ""]), postures


def abb_pose(motion):
    """[x,y,z],[q1..q4]; the largest component of the quaternion by its diagonal, after Shepperd."""
    r, t = motion
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = [1 + trace, 1 + 2 * r[0][0] - trace, 1 + 2 * r[1][1] - trace, 1 + 2 * r[2][2] - trace]
    k = max(range(4), key=lambda i: squares[i])
    skew = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    if k == 0:
        q = [squares[0]] + skew
    else:
        q = [skew[k - 1]] + [r[k - 1][i] + r[i][k - 1] if i != k - 1 else squares[k] for i in range(3)]
    size = math.sqrt(sum(v * v for v in q))
    return "[{:.5f},{:.5f},{:.5f}],[{:.8f},{:.8f},{:.8f},{:.8f}]".format(*t, *(v / size for v in q))


EXTERNAL = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def robtarget(cell, q, base, tool):
    cfx = 4 * (wrist(cell.nominal, q)[0] < 0) + 2 * (not is_elbow_up(cell.nominal, q)) + (q[4] < 0)
    return f"[{abb_pose(cell.written(q, base, tool))},[{','.join(map(str, quadrants(q)))},{cfx}],{EXTERNAL}]"


def rapid_program(cell):
    lines, postures = ["MODULE part"], []
    for k, tool in enumerate(cell.tools):
        lines.append(f"PERS tooldata t{k}:=[TRUE,[{abb_pose(tool)}],[1,[0,0,1],[1,0,0,0],0,0,0]];")
    for k, base in enumerate(cell.bases):
        lines.append(f'PERS wobjdata w{k}:=[FALSE,TRUE,"",[{abb_pose(base)}],[[0,0,0],[1,0,0,0]]];')
    body = ["PROC main()"]
    bases, tools = cell.bases, cell.tools
    for k in range(16):
        base, tool = k // 4 % 2, k // 8 % 2
        frames = f"t{tool}\\WObj:=w{base};"
        sign = cell.rng.choice((-1, 1))
        q = cell.posture((-150, 150), (-40, 60), (-60, 40), (-150, 150), (sign * 35, sign * 90), (-300, 300))
        postures.append(q)
        if k % 4 == 3:
            body.append("MoveAbsJ [[" + ",".join(f"{math.degrees(a):.6f}" for a in q) + f"],{EXTERNAL}],v100,fine,{frames}")
        else:
            lines.append(f"CONST robtarget p{k}:={robtarget(cell, q, bases[base], tools[tool])};")
            body.append(f"MoveJ p{k},v100,fine,{frames}")
        for _ in range(2):
            q = cell.near(q)
            postures.append(q)
            body.append(f"MoveL {robtarget(cell, q, bases[base], tools[tool])},v100,z5,{frames} ! near")
        via, q = cell.near(q), cell.near(q)
        postures += [via, q]
        lines.append(f"CONST robtarget pv{k}:={robtarget(cell, via, bases[base], tools[tool])};")
        lines.append(f"CONST robtarget pe{k}:={robtarget(cell, q, bases[base], tools[tool])};")
        body.append(f"MoveC pv{k},pe{k},v100,fine,{frames}")
    return "\n".join(lines + body + ["ENDPROC", "ENDMODULE", ""]), "", postures


def rotation_vector(r):
    cosine = max(-1.0, min(1.0, (r[0][0] + r[1][1] + r[2][2] - 1) / 2))
    skew = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1])
    angle = math.atan2(vc.length(skew) / 2, cosine)
    return vc.scaled(skew, angle / vc.length(skew))


def ur_pose(motion):
    return "p[{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}]".format(*vc.scaled(motion[1], 1e-3), *rotation_vector(motion[0]))


def urscript_program(cell):
    lines, postures = ["def part():", f"  global Plane_1={ur_pose(cell.bases[0])}"], []
    for k in range(16):
        tool = cell.tools[k // 8 % 2]
        if k % 8 == 0:
            lines.append(f"  set_tcp({ur_pose(tool)})")
        sign = cell.rng.choice((-1, 1))
        q = cell.posture((-150, 150), (-80, -40), (50, 100), (-150, 150), (sign * 40, sign * 120), (-150, 150))
        joints = lambda angles: "[" + ",".join(f"{a:.9f}" for a in angles) + "]"
        postures.append(q)
        if k % 4 == 3:
            lines.append(f"  global q{k} = {joints(q)}")
            lines.append(f"  movej(q{k}, a=1.4, v=1.05)")
        else:
            pose = ur_pose(cell.written(q, vc.NONE, tool))
            lines.append(f"  movej(get_inverse_kin({pose}, qnear={joints(cell.near(q))}), a=1.4, v=1.05)")
        q = cell.near(q)
        postures.append(q)
        lines.append(f"  movel(pose_trans(Plane_1, {ur_pose(cell.written(q, cell.bases[0], tool))}), a=1.2, v=0.25)")
        q = cell.near(q)
        postures.append(q)
        pose = cell.written(q, vc.NONE, tool)
        shift = [float(cell.rng.randint(-90, 90)) for _ in range(3)]
        shifted = ur_pose((pose[0], vc.sub(pose[1], shift)))
        lines.append(f"  movel(pose_add({shifted}, p[{','.join(f'{s * 1e-3:.3f}' for s in shift)},0,0,0]), a=1.2, v=0.25)" if k % 2 else
                     f"  movel({ur_pose(pose)}, a=1.2, v=0.25, r=0.005)  # near")
        via, q = cell.near(q), cell.near(q)
        postures += [via, q]
        lines.append(f"  movec({ur_pose(cell.written(via, vc.NONE, tool))}, {ur_pose(cell.written(q, vc.NONE, tool))}, a=1)")
    return "\n".join(lines + ["end", ""]), "", postures


def fanuc_position(cell, number, q, uf, ut, as_joints):
    head = f"P[{number}]{{\n   GP1:\n\tUF : {uf}, UT : {ut},\t"
    if as_joints:
        j = [math.degrees(a) for a in q]
        j[2] -= j[1]
        rows = [f"J{k}= {a:9.3f} deg" for k, a in enumerate(j, 1)]
    else:
        pose = cell.written(q, cell.bases[uf - 1], cell.tools[ut - 1])
        a, b, c = vc.kuka(pose[0])
        turns = ", ".join(str(round(math.degrees(q[j]) / 360)) for j in (3, 4, 5))
        flip = "N" if q[4] < 0 else "F"
        elbow = "U" if is_elbow_up(cell.nominal, q) else "D"
        front = "T" if wrist(cell.nominal, q)[0] > 0 else "B"
        head += f"\tCONFIG : '{flip} {elbow} {front}, {turns}',"
        rows = [f"{n} = {v:9.3f}  mm" for n, v in zip("XYZ", pose[1])] + [f"{n} = {v:9.3f} deg" for n, v in zip("WPR", (c, b, a))]
    return head + "\n\t" + ",\t".join(rows[:3]) + ",\n\t" + ",\t".join(rows[3:]) + "\n};\n"


def fanuc_program(cell):
    lines, positions, postures = [], "", []
    for k in range(16):
        uf, ut = 1 + k // 4 % 2, 1 + k // 8 % 2
        sign = cell.rng.choice((-1, 1))
        q = cell.posture((-150, 150), (-5, 50), (-60, 40), (-150, 150), (sign * 35, sign * 95), (-150, 150))
        for letter in "JLCC":
            q = q if letter == "J" else cell.near(q)
            postures.append(q)
            positions += fanuc_position(cell, len(postures), q, uf, ut, letter == "J" and k % 4 == 3)
        p = len(postures)
        lines += [f"J P[{p - 3}] 100% FINE    ;", f"L P[{p - 2}:near] 250mm/sec CNT100    ;", f"C P[{p - 1}]    \n    :  P[{p}] 250mm/sec FINE    ;"]
    program = "".join(f"{n:4}:{line}\n" for n, line in enumerate(lines, 1))
    return f"/PROG  PART\n/ATTR\nOWNER = MNEDITOR;\n/MN\n{program}/POS\n{positions}/END\n", "", postures


class Compensation:
    """Corrects one program in a folder; of FANUC all frames and tools are given."""

    EXTENSIONS = {"krl": ".src", "rapid": ".mod", "urscript": ".script", "fanuc": ".ls"}

    def __init__(self, bin_folder, folder, cell, dialect, text, dat):
        self.bin, self.folder, self.name = bin_folder, folder, "part" + self.EXTENSIONS[dialect]
        (folder / "nominal.yaml").write_text(cell.nominal_text)
        (folder / "true.yaml").write_text(cell.true_text)
        (folder / self.name).write_bytes(text.encode())
        if dat:
            (folder / "part.dat").write_bytes(dat.encode())
        (folder / "new").mkdir()
        self.frames = []
        if dialect == "fanuc":
            for name, motions in (("UF", cell.bases), ("UT", cell.tools)):
                for k, motion in enumerate(motions, 1):
                    self.frames += ["--frame", f"{name}[{k}]=" + ",".join(map(repr, [*motion[1], *vc.kuka(motion[0])]))]

    def __call__(self, robot, *options):
        """The program, and its .dat or an empty text."""
        out = self.folder / "new" / self.name
        subprocess.run([self.bin / "compensate", "-q", "--robot", self.folder / robot, "--controller",
                        self.folder / "nominal.yaml", "--program", self.folder / self.name, "--program-out", out, "--max-mm",
                        "50", *self.frames, *options], check=True)
        read = lambda path: path.read_bytes().decode() if path.exists() else ""
        return read(out), read(out.with_suffix(".dat"))


class RobotPrograms(unittest.TestCase):
    def run_dialect(self, dialect, make, millimetres, joint_millimetres):
        cell = Cell(dialect, 5)
        text, dat, postures = make(cell)
        with tempfile.TemporaryDirectory() as folder:
            compensate = Compensation(BIN, pathlib.Path(folder), cell, dialect, text, dat)
            self.assertEqual(compensate("nominal.yaml"), (text, dat))
            corrected = compensate("true.yaml")
        interpret = {"krl": rp.krl, "rapid": lambda src, dat: rp.rapid(src), "urscript": lambda src, dat: rp.urscript(src),
                     "fanuc": lambda src, dat: rp.fanuc(src, {k: b for k, b in enumerate(cell.bases, 1)},
                                                        {k: t for k, t in enumerate(cell.tools, 1)})}[dialect]
        before, after = interpret(text, dat), interpret(*corrected)
        self.assertEqual(len(before), len(postures))
        self.assertEqual(len(after), len(postures))
        self.judge(cell, dialect, before, after, postures, millimetres, joint_millimetres)

    def judge(self, cell, dialect, before, after, postures, millimetres, joint_millimetres):
        moved, left, left_of_joints, turned = [], [], [], []
        for was, now, q in zip(before, after, postures):
            if was.kind == "joints":
                intended, commanded = vc.after(cell.nominal.pose(was.value), was.tool), now.value
            else:
                intended = vc.after(was.base, was.value)
                commanded = joints_at(cell.nominal, vc.after(vc.after(now.base, now.value), inverse(now.tool)), q)
                self.keeps_configuration(dialect, was, now, q, commanded)
            error = lambda angles: difference(intended, vc.after(cell.true.pose(angles), was.tool))
            moved.append(vc.length(error(q)[:3]))
            reached = error(commanded)
            (left_of_joints if was.kind == "joints" else left).append(vc.length(reached[:3]))
            turned.append(vc.length(reached[3:]))
        if "--figures" in sys.argv:
            print(f"{dialect}: {len(moved)} targets, mm before {sum(moved) / len(moved):.3f}, after at most "
                  f"{max(left):.6f} (poses) {max(left_of_joints):.6f} (joints), mrad {1000 * max(turned):.6f}")
        self.assertGreater(sum(moved) / len(moved), 0.5)
        self.assertLess(max(left), millimetres)
        self.assertLess(max(left_of_joints), joint_millimetres)
        self.assertLess(max(turned), 1e-4)

    def keeps_configuration(self, dialect, was, now, q, commanded):
        self.assertLess(max(abs(a - b) for a, b in zip(q, commanded)), 0.15)
        if dialect == "krl" and now.configuration is not None:
            self.assertEqual(now.configuration, kuka_turn(commanded))
        if dialect == "rapid":
            self.assertEqual(now.configuration[:3], quadrants(commanded))
            self.assertEqual(now.configuration[3], was.configuration[3])
        if dialect == "fanuc":
            self.assertEqual(now.configuration, was.configuration)

    # What rounding leaves of joints: 0.0001 deg at 3 m, and so on. Check digits that stay if a pose is saved with three
    # decimals move each of its coordinates by up to 0.0032 mm, at random, so 0.0055 mm at most.
    def test_krl(self):
        self.run_dialect("krl", krl_program, 5.6e-3, 1e-2)

    def test_rapid(self):
        self.run_dialect("rapid", rapid_program, 5.6e-3, 1e-3)

    def test_urscript(self):
        self.run_dialect("urscript", urscript_program, 5.6e-3, 1e-3)

    def test_fanuc(self):
        self.run_dialect("fanuc", fanuc_program, 6e-3, 0.1)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1], verbosity=0)
