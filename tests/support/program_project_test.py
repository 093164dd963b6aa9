#!/usr/bin/env python3
"""Whole projects of three makers: names that other texts declare, points that programs share, displaced points. An
interpreter of its own reads the texts before and after compensate --project as a controller does; a true arm, driven by
the corrected texts, goes to the targets of the original ones. It shares no code with armtrue.

    program_project_test.py BIN [--projects N]
"""

import csv
import io
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import program_corpus as pc
import robot_programs as rp
import robot_programs_test as programs
import virtual_cell as vc

BIN = None
PROJECTS = int(sys.argv[sys.argv.index("--projects") + 1]) if "--projects" in sys.argv else 20
# What rounding leaves [mm].
LEFT_MM = {"pose": 5e-3, "joints": 1e-2}
NUMBER = rp.NUMBER


def entries(text):
    return {name.upper(): float(value) for name, value in re.findall(rf"([A-Za-z]\d?)\s+({NUMBER})", text)}


def braces(values, kind=""):
    return "{" + kind + ",".join(f"{name} {value}" for name, value in values) + "}"


def frame_text(motion):
    return braces(zip("XYZABC", (f"{v:.6f}" for v in (*motion[1], *vc.kuka(motion[0])))))


class Krl:
    """Two programs of one controller and its $config.dat."""

    def __init__(self, cell):
        self.cell, self.q, self.texts = cell, {}, {}
        self.ends = (".src",)
        shift = rp.abc_motion(*(cell.rng.uniform(-20, 20) for _ in range(3)), *(cell.rng.uniform(-4, 4) for _ in range(3)))
        base, tools = cell.bases[0], [cell.tools[0], vc.after(cell.tools[0], shift)]
        q0 = pc.posture_krl(cell)
        config = ["DEFDAT  $CONFIG", "DECL FRAME TOOL_DATA[16]", f"TOOL_DATA[1]={frame_text(tools[0])}",
                  f"TOOL_DATA[2]={frame_text(tools[1])}", f"BASE_DATA[3]={frame_text(base)}",
                  "DECL FDAT FHOME={TOOL_NO 1,BASE_NO 3,IPO_FRAME #BASE}",
                  f"DECL E6AXIS XHOME={braces((f'A{j}', f'{math.degrees(a):.4f}') for j, a in enumerate(q0, 1))}"]
        public = ["DEFDAT  POINTS PUBLIC", "DECL FRAME fUp={X 1.5,Y -2.0,Z 30.0,A 2.0,B 1.0,C -3.0}".replace("DECL", "DECL GLOBAL"),
                  "DECL E6POS XHIDDEN={X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T 2}"]

        def point(name, tool, into, q=None):
            q = q or [a + cell.rng.uniform(-0.08, 0.08) for a in q0]
            pose = cell.written(q, base, tools[tool - 1])
            values = list(zip("XYZABC", (f"{v:.4f}" for v in (*pose[1], *vc.kuka(pose[0])))))
            into.append(f"DECL {'GLOBAL ' if into is public else ''}E6POS {name}=" +
                        braces(values + [("S", pc.wrist_bits(cell, q)), ("T", programs.kuka_turn(q))]))
            self.q[name] = q
            return q

        point("XSHARED", 1, config)     # all moves agree: written once
        point("XTWICE", 1, public)      # with two tools: each move its own
        point("XREAD", 1, public)       # another text reads it: each move its own
        self.q["XHOME"] = q0
        for number, name in ((1, "one"), (2, "two")):
            dat = [f"DEFDAT  {name.upper()}"]
            src = [f"DEF {name}( )", "INI"]

            def move(word, target, tool, behind=""):
                src.extend([f";FOLD {word} {target};%{{PE}}", "$BWDSTART=FALSE", f"FDAT_ACT=F{tool}", "BAS(#CP_PARAMS,0.2)",
                            "SET_CD_PARAMS (0)", f"{word} {target}{behind}", ";ENDFOLD"])

            for tool in (1, 2):
                dat.append(f"DECL FDAT F{tool}={{TOOL_NO {tool},BASE_NO 3,IPO_FRAME #BASE}}")
            point(f"XP{number}", 1, dat)
            src.append("FDAT_ACT=FHOME\nPTP XHOME")
            move("PTP", f"XP{number}", 1)
            move("LIN", "XSHARED", 1, " C_DIS")
            move("LIN", f"XP{number}:{{X 0,Y 0,Z -12.5,A 0,B 0,C 0}}", 1)
            move("LIN", f"XP{number} : fUp", 1)
            if number == 1:
                move("LIN", "XREAD", 1)
                move("LIN", "XTWICE", 1)
            else:
                move("LIN", "XTWICE", 2)
            src.append("LIN XHIDDEN")  # of another list, and not global
            src += ["PTP XHOME", "END"]
            self.texts[f"KRC/R1/Program/{name}.src"] = "\r\n".join(src) + "\r\n"
            self.texts[f"KRC/R1/Program/{name}.dat"] = "\r\n".join(dat + ["ENDDAT"]) + "\r\n"
        self.texts["KRC/R1/System/$config.dat"] = "\n".join(config + ["ENDDAT"]) + "\n"
        self.texts["KRC/R1/Program/points.dat"] = "\n".join(public + ["ENDDAT"]) + "\n"
        self.texts["KRC/R1/System/sps.sub"] = "DEF SPS( )\n; XSHARED\nIF $POS_ACT.X > XREAD.X THEN\nENDIF\nEND\n"
        self.rows = {"KRC/R1/Program/one.src": (9, 8), "KRC/R1/Program/two.src": (8, 7)}
        self.stays = {"KRC/R1/System/sps.sub"}
        self.changes_only = {"KRC/R1/Program/points.dat": ()}
        self.frames = []

    def targets(self, texts):
        found = []
        everywhere = texts["KRC/R1/System/$config.dat"] + texts["KRC/R1/Program/points.dat"]
        of = lambda text: {n.upper(): v for n, v in re.findall(r"([\w$]+(?:\[\d+\])?)\s*=\s*(\{[^}]*\})", text)}
        motion = lambda text: rp.abc_motion(*(entries(text)[c] for c in "XYZABC"))
        for name in ("one", "two"):
            names = {**of(everywhere), **of(texts[f"KRC/R1/Program/{name}.dat"])}
            base = tool = None
            for line in texts[f"KRC/R1/Program/{name}.src"].splitlines():
                line = line.strip()
                if fdat := re.match(r"FDAT_ACT=(\w+)", line):
                    of_fdat = names[fdat[1]]
                    tool = motion(names[f"TOOL_DATA[{re.search(r'TOOL_NO (.)', of_fdat)[1]}]"])
                    base = motion(names[f"BASE_DATA[{re.search(r'BASE_NO (.)', of_fdat)[1]}]"])
                move = re.match(r"(?:PTP|LIN)\s+(.*?)(?:\s+C_DIS)?$", line)
                if not move or "XHIDDEN" in line:
                    continue
                values = [f if f.startswith("{") else names[f.strip().upper()] for f in re.split(r"\s*:\s*", move[1])]
                if "A1" in entries(values[0]):
                    q = [math.radians(entries(values[0])[f"A{j}"]) for j in range(1, 7)]
                    found.append(("joints", q, base, tool))
                    continue
                pose = motion(values[0])
                for value in values[1:]:
                    pose = vc.after(pose, motion(value))
                found.append(("pose", pose, base, tool))
        return found

    def starts(self, targets):
        return [self.q["XHOME"]] * len(targets)


class Rapid:
    """Two modules of a task and one with their data."""

    def __init__(self, cell):
        self.cell, self.texts = cell, {}
        base, tool = cell.bases[0], cell.tools[0]
        border = lambda q: max(abs(math.degrees(q[j]) % 90 - 45) for j in (0, 3, 5))
        # The turned targets are in the same quadrants and within reach: the wrist stands clear of axis 1, and the arm is not
        # stretched.
        clear = lambda q: border(q) <= 20 and abs(programs.wrist(cell.nominal, q)[0]) > 250 and q[2] > math.radians(-40)
        self.q0 = pc.posture_rapid(cell)
        while not clear(self.q0):
            self.q0 = pc.posture_rapid(cell)
        data = ["MODULE Data(SYSMODULE)", f'PERS wobjdata wPart:=[FALSE,TRUE,"",[{programs.abb_pose(base)}],[[0,0,0],[1,0,0,0]]];',
                f"PERS tooldata tMill:=[TRUE,[{programs.abb_pose(tool)}],[1.5,[0,0,100],[1,0,0,0],0,0,0]];", "CONST num nUp:=-7.5;"]

        def point(name, kind="CONST"):
            q = [a + cell.rng.uniform(-0.04, 0.04) for a in self.q0]
            pose = programs.abb_pose(cell.written(q, base, tool))
            cfx = 4 * (programs.wrist(cell.nominal, q)[0] < 0) + 2 * (not programs.is_elbow_up(cell.nominal, q)) + (q[4] < 0)
            quads = ",".join(map(str, programs.quadrants(q)))
            return f"{kind} robtarget {name}:=[{pose},[{quads},{cfx}],[9E9,9E9,9E9,9E9,9E9,9E9]]; ! {name}"

        data += [point("pShared"), point("pRead"), "LOCAL " + point("pHidden"), "ENDMODULE"]
        end = r",v100,fine,tMill\WObj:=wPart;"
        one = ["MODULE One", point("p1", "PERS"), "PROC main()", f"MoveJ p1{end}", f"MoveL Offs(p1,0,0,-nUp){end}".replace("-nUp", "nUp"),
               f"MoveL Offs(p1, 5, -3.5, 10){end}", f"MoveL RelTool(p1,1,2,3\\Rx:=4\\Ry:=-5\\Rz:=6){end}", f"MoveL pShared{end}",
               f"MoveL RelTool(pRead,0,0,-10){end}", f"MoveL pHidden{end}", "ENDPROC", "ENDMODULE"]
        at = ",".join(f"{math.degrees(a):.6f}" for a in self.q0)
        start = f"MoveAbsJ [[{at}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tMill;"
        two = ["MODULE Two", "PROC rTwo()", start, f"MoveL pShared{end}", f"MoveL Offs(pShared,0,0,nUp){end}", f"MoveL Offs(pShared,0,0,x){end}",
               "TPWrite \"x\" \\Num:=pRead.trans.x;", "ENDPROC", "ENDMODULE"]
        for name, lines in (("One", one), ("Two", two), ("Data", data)):
            self.texts[f"RAPID/TASK1/PROGMOD/{name}.mod"] = "\n".join(lines) + "\n"
        self.rows = {"RAPID/TASK1/PROGMOD/One.mod": (7, 6), "RAPID/TASK1/PROGMOD/Two.mod": (4, 3)}
        self.stays, self.frames = set(), []

    def targets(self, texts):
        whole = "\n".join(texts[f"RAPID/TASK1/PROGMOD/{n}.mod"] for n in ("One", "Two", "Data"))
        whole = re.sub(r"!.*", "", whole)
        numbers = lambda text: [float(n) for n in re.findall(NUMBER, text)]
        names = dict(re.findall(r"(?:robtarget|tooldata|wobjdata)\s+(\w+)\s*:=(.*?);", whole, re.S))
        tool = (lambda n: rp.quaternion_motion(n[:3], n[3:7]))(numbers(names["tMill"]))
        n = numbers(names["wPart"])
        base = rp.quaternion_motion(n[:3], n[3:7])
        pose_of = lambda text: (lambda v: rp.quaternion_motion(v[:3], v[3:7]))(numbers(names.get(text.strip(), text)))
        found = []
        for word, target in re.findall(r"Move(AbsJ|[LJ])\s+(.*?),v100,fine", whole):
            if word == "AbsJ":
                found.append(("joints", [math.radians(v) for v in numbers(target)[:6]], base, tool))
                continue
            if target in ("pHidden", "Offs(pShared,0,0,x)"):
                continue
            target = target.replace("nUp", "-7.5")
            if call := re.match(r"(Offs|RelTool)\((\w+|\[.*\]),(.*)\)$", target):
                pose = pose_of(call[2])
                arguments, _, options = call[3].partition("\\")
                shift = tuple(map(float, arguments.split(",")))
                if call[1] == "Offs":
                    pose = pose[0], vc.add(pose[1], shift)
                else:
                    pose = vc.after(pose, (vc.NONE[0], shift))
                    for axis, angle in re.findall(rf"R([xyz]):=({NUMBER})", options):
                        pose = vc.after(pose, (vc.about({"x": vc.X, "y": vc.Y, "z": vc.Z}[axis], math.radians(float(angle))), (0, 0, 0)))
            else:
                pose = pose_of(target)
            found.append(("pose", pose, base, tool))
        return found

    def starts(self, targets):
        return [self.q0] * len(targets)


class Fanuc:
    """A program and the listing of the registers."""

    def __init__(self, cell):
        self.cell = cell
        self.base, self.tool = cell.bases[0], cell.tools[0]
        self.q0 = pc.posture_fanuc(cell)
        turns = ", ".join(str(round(self.q0[j] / (2 * math.pi))) for j in (3, 4, 5))
        letters = ("F" if self.q0[4] > 0 else "N") + " " + ("U" if programs.is_elbow_up(cell.nominal, self.q0) else "D") + " "
        letters += "T" if programs.wrist(cell.nominal, self.q0)[0] > 0 else "B"

        def numbers():
            q = [a + cell.rng.uniform(-0.04, 0.04) for a in self.q0]
            pose = cell.written(q, self.base, self.tool)
            a, b, c = vc.kuka(pose[0])
            return [f"{v:.3f}" for v in (*pose[1], c, b, a)]

        positions = ""
        for p in (1, 2):
            n = numbers()
            positions += f"P[{p}]{{\n   GP1:\n\tUF : 1, UT : 1,\t\tCONFIG : '{letters}, {turns}',\n\t" + ",\t".join(
                f"{name} = {value}  mm" for name, value in zip("XYZ", n)) + ",\n\t" + ",\t".join(
                f"{name} = {value} deg" for name, value in zip("WPR", n[3:])) + "\n};\n"
        lines = ["UFRAME_NUM=1 ;", "UTOOL_NUM=1 ;", "J P[1] 100% FINE    ;", "L P[1] 100mm/sec FINE Offset,PR[2]    ;",
                 "L P[1] 100mm/sec CNT50 Tool_Offset,PR[3:back]    ;", "L PR[1:reg] 100mm/sec FINE    ;",
                 "L P[2] 100mm/sec FINE Offset,PR[2]    ;", "L P[2] 100mm/sec FINE Offset,PR[4]    ;", "L PR[5] 100mm/sec FINE    ;"]
        self.texts = {"part.ls": "/PROG  part\n/ATTR\nLINE_COUNT = 9;\n/MN\n" + "".join(
            f"{n:4}:{'' if line[:2] in ('J ', 'L ') else '  '}{line}\n" for n, line in enumerate(lines, 1)) + "/POS\n" + positions + "/END\n"}
        registers = [numbers(), ["10.000", "-20.000", "5.500", "0.000", "0.000", "0.000"],
                     ["0.000", "0.000", "-15.000", "0.000", "0.000", "0.000"], ["0.000", "0.000", "0.000", "5.000", "0.000", "0.000"]]
        listing = "[*POSREG*]$POSREG  Storage: SHADOW  Access: RW  : ARRAY[1,5] OF Position Reg\n"
        for i, n in enumerate(registers, 1):
            listing += f"    [1,{i}] =   'X: 1.0 name' \n  Group: 1   Config: {letters}, {turns}\n  X: {n[0]:>9}   Y: {n[1]:>9}   Z: {n[2]:>9}\n"
            listing += f"  W: {n[3]:>9}   P: {n[4]:>9}   R: {n[5]:>9}\n"
        self.texts["posreg.va"] = listing + "    [1,5] =   '' Uninitialized\n"
        self.rows = {"part.ls": (7, 5)}
        self.stays = {"posreg.va", "sysframe.va"}
        written = lambda motion: ",".join(map(repr, [*motion[1], *vc.kuka(motion[0])]))
        world = cell.bases[1]
        self.has_world = cell.rng.random() < 0.5
        self.frames = ["--frame", "UF[0]=" + written(world)] if self.has_world else []
        listed = vc.after(programs.inverse(world), self.base) if self.has_world else self.base
        frame_of = lambda motion: (lambda a, b, c: [f"{v:.6f}" for v in (*motion[1], c, b, a)])(*vc.kuka(motion[0]))
        entry = lambda group, i, n: (f"    [{group},{i}] = \n  Group: {group}   Config: N D B, 0, 0, 0\n  X: {n[0]:>9}   Y: {n[1]:>9}   Z: {n[2]:>9}\n"
                                     f"  W: {n[3]:>9}   P: {n[4]:>9}   R: {n[5]:>9}\n")
        other = ["1.000"] * 6
        self.texts["sysframe.va"] = "[*SYSTEM*]$MNUFRAME  Storage: SHADOW  Access: RW  : ARRAY[2,2] OF POSITION\n" + entry(
            1, 1, frame_of(listed)) + entry(1, 2, other) + entry(2, 1, other) + "[*SYSTEM*]$MNUFRAMENUM  Storage: SHADOW  Access: RW  : ARRAY[2] OF BYTE\n    [1] = 2\n" + (
            "[*SYSTEM*]$MNUTOOL  Storage: SHADOW  Access: RW  : ARRAY[1,2] OF POSITION\n") + entry(1, 1, frame_of(self.tool)) + entry(1, 2, other) + (
            "[*SYSTEM*]$OTHER  Storage: SHADOW  Access: RW  : ARRAY[1,1] OF POSITION\n") + entry(1, 1, other)

    def targets(self, texts):
        text = texts["part.ls"]
        values = lambda body: (lambda of: rp.abc_motion(of["X"], of["Y"], of["Z"], of["R"], of["P"], of["W"]))(
            {k: float(v) for k, v in re.findall(rf"\b([XYZWPR])\s*[=:]\s*({NUMBER})", body)})
        positions = {n: values(body) for n, body in re.findall(r"P\[(\d+)\]\s*\{(.*?)\};", text, re.S)}
        registers = {n: values(body.partition("Group: 1")[2]) for n, body in re.findall(
            r"\[1,(\d)\] = (.*?)(?=\n    \[|\Z)", texts["posreg.va"], re.S) if "Uninit" not in body}
        found = []
        for line in text.partition("/POS")[0].splitlines():
            move = re.match(r"\s*\d+:[JL] (PR?)\[(\d+)[^\]]*\]", line)
            if not move or "PR[4]" in line or "PR[5]" in line:
                continue
            pose = (registers if move[1] == "PR" else positions)[move[2]]
            if offset := re.search(r"(Tool_)?Offset,PR\[(\d)", line):
                shift = registers[offset[2]][1]
                pose = vc.after(pose, (vc.NONE[0], shift)) if offset[1] else (pose[0], vc.add(pose[1], shift))
            found.append(("pose", pose, self.base, self.tool))
        return found

    def starts(self, targets):
        return [self.q0] * len(targets)


class Project(unittest.TestCase):
    def compensate(self, folder, project, robot, out):
        done = subprocess.run([BIN / "compensate", "--robot", folder / robot, "--controller", folder / "nominal.yaml", "--project",
                               folder / "in", "--project-out", folder / out, "--max-mm", "50", *project.frames],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        texts = {name: (folder / out / name).read_bytes().decode() for name in project.texts}
        return texts, list(csv.DictReader(io.StringIO(done.stdout))), done.stderr

    def refuse_again(self, folder, project, texts, dialect):
        """What was written is known by the mark of each text that changed, and by its numbers."""
        for path, text in texts.items():
            self.assertEqual(text.count("corrected by armtrue compensate"), text != project.texts[path], path)
        unmarked = {path: re.sub(r".*corrected by armtrue.*\r?\n", "", text) for path, text in texts.items()}
        for number, again in enumerate([texts] + [unmarked] * (dialect != "fanuc")):  # fanuc: too few numbers
            for path, text in again.items():
                (folder / f"in{number}" / path).parent.mkdir(parents=True, exist_ok=True)
                (folder / f"in{number}" / path).write_bytes(text.encode())
            done = subprocess.run([BIN / "compensate", "--robot", folder / "true.yaml", "--controller", folder / "nominal.yaml",
                                   "--project", folder / f"in{number}", "--project-out", folder / "again", *project.frames],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertRegex(done.stderr, "corrected already")
            self.assertFalse((folder / "again").exists())

    def run_project(self, kind, dialect, number):
        cell = programs.Cell(dialect, f"project {dialect} {number}")
        project = kind(cell)
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "nominal.yaml").write_text(cell.nominal_text)
            (folder / "true.yaml").write_text(cell.true_text)
            for path, text in project.texts.items():
                (folder / "in" / path).parent.mkdir(parents=True, exist_ok=True)
                (folder / "in" / path).write_bytes(text.encode())
            same, _, _ = self.compensate(folder, project, "nominal.yaml", "same")
            self.assertEqual(same, project.texts)
            texts, rows, said = self.compensate(folder, project, "true.yaml", "new")
            self.refuse_again(folder, project, texts, dialect)
        self.assertEqual({row["program"]: (int(row["moves"]), int(row["corrected"])) for row in rows}, project.rows)
        for path in project.stays:
            self.assertEqual(texts[path], project.texts[path])
        before, after = project.targets(project.texts), project.targets(texts)
        self.assertEqual(len(before), len(after))
        self.assertEqual(len(before), sum(corrected for _, corrected in project.rows.values()))
        moved = 0.0
        for (how, value, base, tool), (_, command, _, _), start in zip(before, after, project.starts(before)):
            if how == "joints":
                intended, commanded = vc.after(cell.nominal.pose(value), tool), command
                was = value
            else:
                intended = vc.after(base, value)
                flange = lambda pose: vc.after(vc.after(base, pose), programs.inverse(tool))
                was = programs.joints_at(cell.nominal, flange(value), start)
                commanded = programs.joints_at(cell.nominal, flange(command), start)
            error = lambda q: vc.length(programs.difference(intended, vc.after(cell.true.pose(q), tool))[:3])
            moved += error(was)
            self.assertLess(error(commanded), LEFT_MM[how])
        self.assertGreater(moved / len(before), 0.1)
        return project, texts, said

    def test_krl(self):
        for number in range(PROJECTS):
            with self.subTest(number=number):
                project, texts, said = self.run_project(Krl, "krl", number)
                self.assertEqual(texts["KRC/R1/Program/points.dat"], project.texts["KRC/R1/Program/points.dat"])
                self.assertIn("LIN XSHARED C_DIS", texts["KRC/R1/Program/one.src"])
                self.assertIn("PTP XP1\r\n", texts["KRC/R1/Program/one.src"])
                self.assertNotEqual(texts["KRC/R1/System/$config.dat"], project.texts["KRC/R1/System/$config.dat"])
                self.assertIn("XSHARED is a point that other texts may use; it is changed here once", said)
                self.assertIn("XREAD is a point that other texts may use; it stays", said)

    def test_rapid(self):
        for number in range(PROJECTS):
            with self.subTest(number=number):
                _, texts, _ = self.run_project(Rapid, "rapid", number)
                self.assertIn("MoveJ p1,v100", texts["RAPID/TASK1/PROGMOD/One.mod"])

    def test_fanuc(self):
        for number in range(PROJECTS):
            with self.subTest(number=number):
                project, _, said = self.run_project(Fanuc, "fanuc", number)
                self.assertEqual("FANUC's world frame" in said, not project.has_world)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1], verbosity=0)
