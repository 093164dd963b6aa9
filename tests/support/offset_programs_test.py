#!/usr/bin/env python3
"""Random programs of ABB and FANUC whose points are displaced where they are used, by Offs and RelTool or by position
registers, nested, in two tools and frames, with a part in the gripper and a tool in the room, on a positioner that carries the
frame, behind branches, loops, jumps and procedures. A controller of its own runs each
of them as it is and corrected, with the same inputs; the true arm goes where the controller's model says. Each move ends at
its programmed pose, or the program says the same of it as before. Nothing here shares code with armtrue.

    offset_programs_test.py BIN [--programs N] [--keep FOLDER]
"""

import collections
import math
import pathlib
import random
import re
import shutil
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
PROGRAMS = int(sys.argv[sys.argv.index("--programs") + 1]) if "--programs" in sys.argv else 60
KEEP = pathlib.Path(sys.argv[sys.argv.index("--keep") + 1]) if "--keep" in sys.argv else None
NEAR_MM = 0.02  # what rounding may leave
SAME_MM = 1e-6
MOST_MM = 10  # of a correction: of these arms
MOST_STEPS = 500

Move = collections.namedtuple("Move", "text kind value base tool")


def about_all(turns):
    motion = vc.NONE
    for axis, degrees in turns:
        motion = vc.after(motion, (vc.about(axis, math.radians(degrees)), (0, 0, 0)))
    return motion


# ---- ABB -----------------------------------------------------------------------------------------------------------

class RapidTarget:
    def __init__(self, parts):
        self.trans, self.rot, self.rest = list(parts[0]), list(parts[1]), parts[2:]

    def motion(self):
        return rp.quaternion_motion(self.trans, self.rot)


class RapidMachine:
    """Runs the procedure main of a module. Expressions are Python's but for the names of options."""

    def __init__(self, text, inputs):
        self.inputs, self.moves, self.steps = inputs, [], 0
        lines = [re.sub(r"!.*", "", line).strip() for line in text.replace("\r\n", "\n").split("\n")]
        self.names, self.routines, inside = {"offs": self.offs, "reltool": self.rel_tool}, {}, None
        for line in lines:
            if found := re.match(r"PROC (\w+)\((.*)\)", line):
                inside = []
                self.routines[found[1]] = [part.split()[-1].lower() for part in found[2].split(",") if part], inside
            elif line == "ENDPROC":
                inside = None
            elif inside is not None and line:
                inside.append(line)
            elif found := re.match(r"(?:LOCAL )?(?:CONST|PERS|VAR) (\w+) (\w+)(?::=(.*))?;", line):
                value = self.value(found[3]) if found[3] else None
                self.names[found[2].lower()] = RapidTarget(value) if found[1] == "robtarget" and isinstance(value, list) else value
        self.call("main", [])

    def call(self, name, values):
        """Each procedure of these programs changes only copies of what it is handed."""
        parameters, lines = self.routines[name]
        outside = dict(self.names)
        self.names.update(zip(parameters, values))
        self.run(lines)
        self.names.update((of, outside.get(of)) for of in parameters)

    @staticmethod
    def copy(target):
        return RapidTarget([list(target.trans), list(target.rot), *target.rest]) if isinstance(target, RapidTarget) else RapidTarget(target)

    def offs(self, target, x, y, z):
        target = self.copy(target)
        target.trans = [a + b for a, b in zip(target.trans, (x, y, z))]
        return target

    def rel_tool(self, target, x, y, z, rx=0, ry=0, rz=0):
        target = self.copy(target)
        moved = vc.after(vc.after(target.motion(), (vc.NONE[0], (x, y, z))), about_all(((vc.X, rx), (vc.Y, ry), (vc.Z, rz))))
        result = RapidTarget([moved[1], (1, 0, 0, 0)])
        result.motion = lambda: moved
        result.rest = target.rest
        # A turn about any axis, as a quaternion by its largest part.
        r = moved[0]
        w = [1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2], 1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]]
        k = w.index(max(w))
        rows = [[w[0], r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]], [r[2][1] - r[1][2], w[1], r[1][0] + r[0][1], r[0][2] + r[2][0]],
                [r[0][2] - r[2][0], r[1][0] + r[0][1], w[2], r[2][1] + r[1][2]], [r[1][0] - r[0][1], r[0][2] + r[2][0], r[2][1] + r[1][2], w[3]]]
        norm = math.sqrt(sum(v * v for v in rows[k]))
        result.rot = [v / norm for v in rows[k]]
        return result

    def value(self, text):
        text = re.sub(r"\\(R[xyz]):=", lambda m: "," + m[1] + "=", text.strip())
        text = re.sub(r"\.trans\.([xyz])", lambda m: f".trans[{'xyz'.index(m[1])}]", text)
        text = re.sub(r"(?i)\bTRUE\b", "1", re.sub(r"(?i)\bFALSE\b", "0", text)).replace('""', "0")
        return eval(text.lower(), {"__builtins__": {}}, self.names)

    def arguments(self, text):
        parts, depth = [""], 0
        for c in text:
            depth += (c in "([") - (c in ")]")
            if c == "," and depth == 0:
                parts.append("")
            else:
                parts[-1] += c
        return parts

    def frame(self, name, index):
        if name in ("wobj0", "tool0"):
            return vc.NONE
        pose = self.names[name.lower()][index]
        return rp.quaternion_motion(pose[0], pose[1])

    def move(self, line):
        word, rest = re.match(r"Move(AbsJ|[JLC])\s+(.*);$", line).groups()
        parts = self.arguments(rest)
        tool, _, work_object = parts[-1].partition("\\WObj:=")
        is_held = work_object and self.names[work_object.lower()][0]
        base, tool = self.frame(work_object or "wobj0", 3), self.frame(tool, 1)
        if calculated := re.match(r"CalcJointT\((.*)\)$", parts[0]):  # with a tool and a work object of its own
            *parts, own = self.arguments(calculated[1])
            parts = [",".join(parts)]
            own, _, work_object = own.partition("\\WObj:=")
            word, base, tool = "J", self.frame(work_object or "wobj0", 3), self.frame(own, 1)
        for text in parts[:2] if word == "C" else parts[:1]:
            target = self.value(text)
            if word == "AbsJ":
                self.moves.append(Move(line, "joints", target[0], base, tool))
            elif is_held:  # flange * part * target = tool of the room
                self.moves.append(Move(line, "pose", programs.inverse(self.copy(target).motion()), tool, base))
            else:
                self.moves.append(Move(line, "pose", self.copy(target).motion(), base, tool))

    def run(self, lines):
        at = 0
        while at < len(lines) and self.steps < MOST_STEPS:
            self.steps += 1
            line = lines[at]
            end = self.end_of(lines, at)
            if line.startswith("IF"):
                middle = next((k for k in range(at, end) if lines[k] == "ELSE" and self.depth(lines, at, k) == 1), end)
                self.run(lines[at + 1:middle] if self.inputs() else lines[middle + 1:end])
            elif found := re.match(r"FOR (\w+) FROM 1 TO (\d+) DO", line):
                for k in range(1, int(found[2]) + 1):
                    self.names[found[1].lower()] = k
                    self.run(lines[at + 1:end])
            elif line.startswith("WHILE"):
                while self.inputs() and self.steps < MOST_STEPS:
                    self.run(lines[at + 1:end])
            elif line.startswith("Move"):
                self.move(line)
            elif found := re.match(r"([\w.]+):=(.*);$", line):
                self.assign(found[1].lower(), self.value(found[2]))
            elif found := re.match(r"(\w+)(?: (.+))?;$", line):
                values = [self.value(part) for part in self.arguments(found[2] or "") if part]
                is_target = lambda value: isinstance(value, RapidTarget) or isinstance(value, list) and isinstance(value[0], list)
                self.call(found[1], [self.copy(value) if is_target(value) else value for value in values])
            else:
                raise AssertionError(line)
            at = end + 1

    def assign(self, name, value):
        if "." in name:
            name, part, c = name.split(".")
            target = self.names[name] = self.copy(self.names[name])
            target.trans["xyz".index(c)] = value
        else:
            self.names[name] = self.copy(value) if isinstance(value, (RapidTarget, list)) else value

    BLOCKS = ("IF", "FOR", "WHILE")

    def depth(self, lines, first, last):
        return sum(1 if line.startswith(self.BLOCKS) else -1 if line.startswith(("ENDIF", "ENDFOR", "ENDWHILE")) else 0 for line in lines[first:last])

    def end_of(self, lines, at):
        if not lines[at].startswith(self.BLOCKS):
            return at
        return next(k for k in range(at + 1, len(lines)) if self.depth(lines, at, k + 1) == 0)


class RapidWriter:
    dialect, files = "rapid", ("part.mod",)
    forms, of_carried = ("Offs", "RelTool"), "tRoom"
    from_points = ("Offs", "RelTool", "pV")

    def __init__(self, cell):
        self.cell, self.rng = cell, cell.rng
        # Displaced targets are in the same quadrants, and the wrist is not above axis 1, where corrections are damped.
        near_border = lambda q: (max(abs(math.degrees(q[j]) % 90 - 45) for j in (0, 3, 5)) > 20 or
                                 abs(programs.wrist(cell.nominal, q)[0]) < 150)
        self.q = pc.posture_rapid(cell)
        while near_border(self.q):
            self.q = pc.posture_rapid(cell)
        self.frames = [("tMill", "wPart", cell.tools[0], cell.bases[0]), ("tGrip", "wPart", cell.tools[1], cell.bases[0]),
                       ("tMill", "wobj0", cell.tools[0], vc.NONE)]
        self.held = cell.tools[1]
        self.room = vc.after(vc.after(cell.nominal.pose(self.q), self.held), rp.abc_motion(60, -40, 90, 30, -20, 140))

    def target(self, frame=0):
        _, _, tool, base = self.frames[frame]
        q = [a + self.rng.uniform(-0.02, 0.02) for a in self.q]
        pose = self.cell.written(q, base, tool)
        return self.target_at(q, pose)

    def target_of_part(self):
        q = [a + self.rng.uniform(-0.02, 0.02) for a in self.q]
        return self.target_at(q, programs.inverse(self.cell.written(q, self.room, self.held)))

    def target_at(self, q, pose):
        pose = programs.abb_pose(pose)
        cfx = 4 * (programs.wrist(self.cell.nominal, q)[0] < 0) + 2 * (not programs.is_elbow_up(self.cell.nominal, q)) + (q[4] < 0)
        return f"[{pose},[{','.join(map(str, programs.quadrants(q)))},{cfx}],[9E9,9E9,9E9,9E9,9E9,9E9]]"

    def number(self):
        return self.rng.choice((f"{self.rng.uniform(-15, 15):.2f}", "0", "nUp", "-nUp", "2*nUp", "nUp+1.5", "(nUp-2)/2", "nStep"))

    def displaced(self, depth=2):
        name = self.rng.choice(("p1", "p2", "p3", "pV", self.target()))
        if depth and self.rng.random() < 0.3:
            name = self.displaced(depth - 1)
        shift = ",".join(self.number() for _ in range(3))
        turn = "".join(f"\\R{axis}:={self.rng.uniform(-4, 4):.1f}" for axis in "xyz" if self.rng.random() < 0.3)
        return self.rng.choice((f"Offs({name},{shift})", f"Offs({name}, {shift})", f"RelTool({name},{shift}{turn})"))

    def move(self):
        if self.rng.random() < 0.15:
            return self.move_of_part()
        frame = self.rng.choice((0, 0, 0, 0, 1, 2))
        tool, work_object, _, _ = self.frames[frame]
        end = f",v100,{self.rng.choice(('fine', 'z1'))},{tool}" + (f"\\WObj:={work_object}" if work_object != "wobj0" else "") + ";"
        own = {0: "p1", 1: "q1", 2: "r1"}[frame]
        if frame:
            target = self.rng.choice((own, f"Offs({own},{self.number()},0,{self.number()})", f"RelTool({own},0,0,{self.number()})"))
        else:
            target = self.rng.choice((self.displaced(), self.displaced(), "p1", "p2", "p3", "pV", self.target()))
        if self.rng.random() < 0.15:
            of = self.rng.choice((0, 0, frame))
            tool, work_object, _, _ = self.frames[of]
            calculated = f"{tool},{work_object}".replace(",wobj0", "").replace(",", "\\WObj:=")
            return f"MoveAbsJ CalcJointT({own if frame else target},{calculated}){end}"
        if self.rng.random() < 0.15 and frame == 0:
            return f"MoveC {self.displaced()},{target}{end}"
        return f"Move{self.rng.choice('JLL')} {target}{end}"

    def move_of_part(self):
        target = self.rng.choice(("h1", "h1", f"Offs(h1,{self.number()},0,{self.number()})", f"RelTool(h1,0,0,{self.number()}\\Rz:=3)",
                                  self.target_of_part()))
        return f"Move{self.rng.choice('JLL')} {target},v100,fine,{self.rng.choice(('tRoom', 'tRoom', 'tRoom', 'tMill'))}\\WObj:=wHeld;"

    def plain(self):
        if self.rng.random() < 0.9:
            return self.move()
        return self.rng.choice((f"pV:={self.displaced()};", "pV:=p2;", f"nStep:={self.rng.uniform(-9, 9):.1f};",
                                "pV:=Offs(p3,0,0,nUp);"))

    def block(self, depth):
        if depth == 0:
            return [self.plain() for _ in range(self.rng.randint(1, 4))]
        inner = lambda: self.block(depth - 1)
        kind = self.rng.randint(0, 5)
        if kind == 0:
            return ["IF di1=1 THEN", *inner(), "ENDIF"]
        if kind == 1:
            return ["IF di1=1 THEN", *inner(), "ELSE", *inner(), "ENDIF"]
        if kind == 2:
            return ["FOR i FROM 1 TO 2 DO", *inner(), f"MoveL Offs(p1,0,0,3*i),v100,fine,tMill\\WObj:=wPart;", "ENDFOR"]
        if kind == 3:
            return ["WHILE di1=1 DO", *inner(), "ENDWHILE"]
        if kind == 4:
            return ["rSub;"]
        return inner()

    def write(self):
        tools = [f"PERS tooldata {name}:=[TRUE,[{programs.abb_pose(motion)}],[1.5,[0,0,100],[1,0,0,0],0,0,0]];"
                 for name, motion in zip(("tMill", "tGrip"), self.cell.tools)]
        data = [f'PERS wobjdata wPart:=[FALSE,TRUE,"",[{programs.abb_pose(self.cell.bases[0])}],[[0,0,0],[1,0,0,0]]];', *tools,
                f'PERS wobjdata wHeld:=[TRUE,TRUE,"",[{programs.abb_pose(self.held)}],[[0,0,0],[1,0,0,0]]];',
                f"PERS tooldata tRoom:=[FALSE,[{programs.abb_pose(self.room)}],[1.5,[0,0,100],[1,0,0,0],0,0,0]];",
                f"{self.rng.choice(('CONST', 'PERS', 'VAR'))} robtarget h1:={self.target_of_part()};",
                "CONST num nUp:=7.5;", "VAR num nStep:=2;"]
        data += [f"{self.rng.choice(('CONST', 'PERS', 'VAR'))} robtarget {name}:={self.target(frame)};"
                 for name, frame in (("p1", 0), ("p2", 0), ("p3", 0), ("q1", 1), ("r1", 2))] + [f"VAR robtarget pV:={self.target()};"]
        start = ",".join(f"{math.degrees(a):.6f}" for a in self.q)
        body = [line for _ in range(self.rng.randint(3, 6)) for line in self.block(self.rng.randint(0, 2))]
        lines = ["MODULE part", *data, "PROC main()", f"MoveAbsJ [[{start}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tMill;", *body, "ENDPROC",
                 "PROC rSub()", *[line for line in self.block(0)], "ENDPROC", "ENDMODULE", ""]
        return ["\r\n".join(lines)]

    options = ()
    machine = staticmethod(lambda texts, inputs: RapidMachine(texts[0], inputs).moves)


# ---- FANUC ---------------------------------------------------------------------------------------------------------

class FanucMachine:
    """Runs a program with the registers and frames of listings."""

    def __init__(self, text, listing, frames, tools, inputs):
        self.moves = []
        values = lambda body: (lambda of: [of[k] for k in "XYZWPR"])({k: float(v) for k, v in re.findall(rf"\b([XYZWPR])\s*[=:]\s*({rp.NUMBER})", body)})
        joints = lambda body: {k: float(v) for k, v in re.findall(rf"\b(J\d)\s*=\s*({rp.NUMBER})", body)}
        text = text.replace("\r\n", "\n")
        bodies = [(n, body.partition("GP2")) for n, body in re.findall(r"P\[(\d+)[^\]]*\]\s*\{(.*?)\};", text, re.S)]
        positions = {n: (joints(body) or values(body)) for n, (body, _, _) in bodies}
        turns = {n: joints(others).get("J1", 0) for n, (_, _, others) in bodies}
        registers = {n: values(body) for n, body in re.findall(r"\[1,(\d)\] = (.*?)(?=\n    \[|\Z)", listing, re.S) if "Uninit" not in body}
        registers["6"] = [v + 1.1 for v in registers["1"]]  # of another program; not listed
        lines = [re.sub(r"^\s*\d+:\s*", "", line).strip(" ;") for line in text.partition("/MN\n")[2].partition("/POS")[0].splitlines()]
        at = steps = frame = tool = 0
        condition = {"Offset": "3", "Tool_Offset": "3"}  # of another program
        motion = lambda n: rp.abc_motion(n[0], n[1], n[2], n[5], n[4], n[3])
        while at < len(lines) and steps < MOST_STEPS:
            line, steps, at = lines[at], steps + 1, at + 1
            if found := re.match(r"U(FRAME|TOOL)_NUM=(\d)", line):
                frame, tool = (int(found[2]), tool) if found[1] == "FRAME" else (frame, int(found[2]))
            elif found := re.match(r"IF DI\[1\]=ON,JMP (LBL\[\d\])", line):
                at = lines.index(found[1]) if inputs() else at
            elif found := re.match(r"JMP (LBL\[\d\])", line):
                at = lines.index(found[1])
            elif found := re.match(r"(TOOL_)?OFFSET CONDITION PR\[(\d)", line):
                condition["Tool_Offset" if found[1] else "Offset"] = found[2]
            elif found := re.match(r"PR\[(\d),(\d)\]=(.*)", line):
                element = lambda of: str(registers[of[1]][int(of[2]) - 1])
                value = eval(re.sub(r"PR\[(\d),(\d)\]", element, found[3]), {"__builtins__": {}})
                registers[found[1]] = list(registers[found[1]])
                registers[found[1]][int(found[2]) - 1] = float(value)
            elif found := re.match(r"PR\[(\d)(?::\w+)?\]=(LPOS-LPOS|PR\[(\d)\](-PR\[\3\])?|P\[(\d)\])$", line):
                is_zero = found[2] == "LPOS-LPOS" or found[4]
                registers[found[1]] = [0.0] * 6 if is_zero else registers[found[3]] if found[3] else positions[found[5]]
            elif line == "CALL OTHER":  # whose text is not there; what this program assigns it may assign, too
                registers.update({n: [v + 1.7 for v in registers[n]] for n in set(re.findall(r"PR\[(\d)[^\]]*\]=", text))})
            elif found := re.match(r"[JL] (PR?)\[(\d+)[^\]]*\]", line):
                value = (registers if found[1] == "PR" else positions)[found[2]]
                base, tip = frames[frame], tools[tool]
                if line.endswith("COORD") and found[1] == "P":  # the positioner carries the frame from where it is known
                    base = vc.after(FanucWriter.positioner(turns[found[2]] - turns["1"]), base)
                if isinstance(value, dict):
                    q = [math.radians(value[f"J{k}"]) for k in range(1, 7)]
                    q[2] += q[1]
                    self.moves.append(Move(line, "joints", [math.degrees(a) for a in q], base, tip))
                    continue
                pose = motion(value)
                for word, register in re.findall(r"(Tool_Offset|(?<!_)Offset)(?:,PR\[(\d))?", line):
                    shift = registers[register or condition[word]]
                    # The offset moves the frame: it stands before the position, or behind it in the axes of the tool.
                    pose = vc.after(pose, motion(shift)) if word == "Tool_Offset" else self.offset(pose, shift)
                self.moves.append(Move(line, "pose", pose, base, tip))
            elif line and not line.startswith(("!", "LBL")):
                raise AssertionError(line)

    @staticmethod
    def offset(pose, shift):
        """How a register that turns counts is written nowhere; such moves are to stay."""
        turned = rp.abc_motion(0, 0, 0, shift[5], shift[4], shift[3])[0]
        return vc.after((turned, (0, 0, 0)), pose)[0], vc.add(pose[1], shift[:3])


class FanucWriter:
    dialect, files = "fanuc", ("part.ls",)
    forms, of_carried = ("Offset", "Tool_Offset", " PR["), "COORD"
    from_points = ("Offset",)

    def __init__(self, cell):
        self.cell, self.rng, self.q = cell, cell.rng, pc.posture_fanuc(cell)
        self.frames, self.tools = {0: vc.NONE, 1: cell.bases[0], 2: cell.bases[1]}, {1: cell.tools[0], 2: cell.tools[1]}
        # A positioner that stands, one that turns between P[2] and P[3], or none; does --frame say where its frame is?
        self.turns, self.is_given = self.rng.choice((None, None, (20, 20), (20, 20), (20, 25))), self.rng.random() < 0.8
        self.letters = ("F" if self.q[4] > 0 else "N") + " " + ("U" if programs.is_elbow_up(cell.nominal, self.q) else "D") + " "
        self.letters += "T" if programs.wrist(cell.nominal, self.q)[0] > 0 else "B"
        self.letters += ", " + ", ".join(str(round(self.q[j] / (2 * math.pi))) for j in (3, 4, 5))

    @staticmethod
    def positioner(degrees):
        there = (vc.NONE[0], (1500, 200, 300))
        return vc.after(vc.after(there, (vc.about(vc.Z, math.radians(degrees)), (0, 0, 0))), programs.inverse(there))

    @property
    def options(self):
        frames = [f"--frame=UF[{i}]=" + ",".join(map(repr, [*self.frames[i][1], *vc.kuka(self.frames[i][0])])) for i in (1, 2)]
        return ["--with", "listings", *(frames if self.turns and self.is_given else [])]

    def numbers(self, frame=1, tool=1):
        q = [a + self.rng.uniform(-0.02, 0.02) for a in self.q]
        pose = self.cell.written(q, self.frames[frame], self.tools[tool])
        a, b, c = vc.kuka(pose[0])
        return [f"{v:.3f}" for v in (*pose[1], c, b, a)]

    def position(self, number, frame, tool):
        n = self.numbers(frame, tool)
        return (f"P[{number}]{{\n   GP1:\n\tUF : {frame}, UT : {tool},\t\tCONFIG : '{self.letters}',\n\t" +
                ",\t".join(f"{name} = {value}  mm" for name, value in zip("XYZ", n)) + ",\n\t" +
                ",\t".join(f"{name} = {value} deg" for name, value in zip("WPR", n[3:])) + "\n" +
                (f"   GP2:\n\tUF : 1, UT : 2,\n\tJ1 = {self.turns[number > 2]:.3f} deg,\tJ2 = 0.000 deg\n" if self.turns else "") + "};\n")

    def move(self):
        speed = self.rng.choice(("100mm/sec FINE", "50cm/min CNT50"))
        by = self.rng.choice(("", "", " Offset,PR[2]", " Tool_Offset,PR[3:back]", " Offset,PR[4]", " Tool_Offset,PR[4]",
                              " Offset,PR[5]", " Tool_Offset,PR[5:set]", " Offset"))
        point = self.rng.choice(("P[1]", "P[2]", "P[2]", "P[3]", "PR[1:reg]", "PR[1]", "PR[6]"))
        if self.turns and self.rng.random() < 0.7:
            return f"L P[{self.rng.randint(1, 3)}] {speed}{by} COORD"
        return f"{self.rng.choice(('L', 'L', 'J'))} {point} {speed}{by}    ".replace("J " + point + " " + speed, f"J {point} 100% FINE")

    def plain(self):
        if self.rng.random() < 0.9:
            return self.move()
        return self.rng.choice(("  !L P[1] 10mm/sec FINE", *self.assignments()))

    def assignments(self):
        number = f"{self.rng.uniform(-9, 9):.1f}"
        return (f"  PR[5,3]={number}", f"  PR[5,{self.rng.randint(1, 3)}]=({number})", f"  PR[5,1]=PR[5,1]+{number}", "  PR[5]=PR[2]",
                "  PR[5:set]=LPOS-LPOS", "  PR[5]=PR[5]-PR[5]", f"  PR[5]=P[{self.rng.randint(1, 3)}]", "  PR[5,2]=PR[2,1]*2",
                f"  PR[6]=P[{self.rng.randint(1, 3)}]", "  PR[6]=PR[1]", f"  PR[6,3]=PR[6,3]-{number}",
                "  OFFSET CONDITION PR[5]", "  TOOL_OFFSET CONDITION PR[5]", "  CALL OTHER")

    def block(self, depth):
        if depth == 0:
            return [self.plain() for _ in range(self.rng.randint(1, 4))]
        inner = lambda: self.block(depth - 1)
        kind = self.rng.randint(0, 3)
        self.labels += 1
        label = f"LBL[{self.labels}]"
        if kind == 0 and self.labels < 10:
            return [f"  IF DI[1]=ON,JMP {label}", *inner(), f"  {label}"]
        if kind == 1 and self.labels < 10:
            return [f"  {label}", *inner(), f"  IF DI[1]=ON,JMP {label}"]
        if kind == 2:
            return [f"  UFRAME_NUM=2", f"  UTOOL_NUM=2", f"L P[4] 100mm/sec FINE{self.rng.choice(('', ' Offset,PR[2]'))}    ",
                    "  UFRAME_NUM=1", "  UTOOL_NUM=1"]
        return inner()

    def write(self):
        self.labels = 0
        body = [line for _ in range(self.rng.randint(3, 6)) for line in self.block(self.rng.randint(0, 2))]
        known = ["  PR[5:set]=LPOS-LPOS", f"  PR[5,3]={self.rng.uniform(-9, 9):.1f}", "  OFFSET CONDITION PR[5]", "  PR[6]=P[2]"]
        first = [line for line in (*known, self.rng.choice(self.assignments())) if self.rng.random() < 0.8]
        lines = ["  UFRAME_NUM=1", "  UTOOL_NUM=1", *first, "J P[1] 100% FINE    ", *body, "L P[5] 100mm/sec FINE Offset,PR[5]    "]
        numbered = "".join(f"{n:4}:{line} ;\n" for n, line in enumerate(lines, 1))
        positions = "".join(self.position(n, *((2, 2) if n == 4 else (1, 1))) for n in range(1, 6))
        registers = [self.numbers(), *([f"{self.rng.uniform(-15, 15):.3f}" for _ in range(3)] + ["0.000"] * 3 for _ in range(4))]
        entry = lambda i, n, head="": (f"    [1,{i}] = {head}\n  Group: 1   Config: {self.letters}\n  X: {n[0]:>9}   Y: {n[1]:>9}   Z: {n[2]:>9}\n"
                                       f"  W: {n[3]:>9}   P: {n[4]:>9}   R: {n[5]:>9}\n")
        self.listing = "[*POSREG*]$POSREG  Storage: SHADOW  Access: RW  : ARRAY[1,6] OF Position Reg\n" + "".join(
            entry(i, n, "  '' ") for i, n in enumerate(registers, 1)) + "    [1,6] =   '' Uninitialized\n"
        of = lambda motion: (lambda a, b, c: [f"{v:.6f}" for v in (*motion[1], c, b, a)])(*vc.kuka(motion[0]))
        frames = "[*SYSTEM*]$MNUFRAME  Storage: SHADOW  Access: RW  : ARRAY[1,2] OF POSITION\n" + "".join(
            entry(i, of(self.frames[i])) for i in (1, 2)) + "[*SYSTEM*]$MNUTOOL  Storage: SHADOW  Access: RW  : ARRAY[1,2] OF POSITION\n" + "".join(
            entry(i, of(self.tools[i])) for i in (1, 2))
        self.listings = {"posreg.va": self.listing, "sysframe.va": frames}
        group = "1,1,*,*,*" if self.turns else "1,*,*,*,*"
        return [f"/PROG  part\n/ATTR\nLINE_COUNT = {len(lines)};\nDEFAULT_GROUP = {group};\n/MN\n{numbered}/POS\n{positions}/END\n"]

    def machine(self, texts, inputs):
        return FanucMachine(texts[0], self.listing, self.frames, self.tools, inputs).moves


def inputs(seed):
    rng, count = random.Random(seed), 0

    def value():
        nonlocal count
        count += 1
        return count < 60 and rng.random() < 0.5
    return value


class ProgramsRun:
    """Runs random programs of a writer as they are and corrected."""

    def setUp(self):
        self.folder = pathlib.Path(KEEP or tempfile.mkdtemp())
        self.folder.mkdir(exist_ok=True)

    def corrected(self, writer, robot):
        out = self.folder / "new"
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir()
        run = subprocess.run([BIN / "compensate", "-q", "--robot", robot, "--controller", "nominal.yaml", "--program", writer.files[0],
                              "--program-out", f"new/{writer.files[0]}", "--max-mm", "50", *writer.options],
                             cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        return [(out / name).read_bytes().decode() for name in writer.files]

    def error_of(self, cell, programmed, commanded, start):
        """How far [mm] the true arm is from the programmed pose."""
        def flange(pose, move):
            return vc.after(vc.after(move.base, pose), programs.inverse(move.tool))
        if programmed.kind == "joints":
            q, wanted = [math.radians(a) for a in commanded.value], cell.nominal.pose([math.radians(a) for a in programmed.value])
        else:
            wanted = flange(programmed.value, programmed)
            try:
                q = programs.joints_at(cell.nominal, flange(commanded.value, commanded), start)
            except AssertionError:  # beyond the reach of the arm: such a move must have stayed
                return math.inf
        reached = cell.true.pose(q)
        return vc.length(vc.sub(vc.after(reached, programmed.tool)[1], vc.after(wanted, programmed.tool)[1]))

    def run_moves(self, kind):
        """The texts of the moves that are corrected, and how many are left alone."""
        hits, left = [], 0
        for number in range(PROGRAMS // 2):
            cell = programs.Cell(kind.dialect, f"{kind.dialect} {number}")
            writer = kind(cell)
            texts = writer.write()
            for name, text in zip(writer.files, texts):
                (self.folder / name).write_bytes(text.encode())
            (self.folder / "listings").mkdir(exist_ok=True)
            for name, text in getattr(writer, "listings", {}).items():
                (self.folder / "listings" / name).write_text(text)
            (self.folder / "nominal.yaml").write_text(cell.nominal_text)
            (self.folder / "true.yaml").write_text(cell.true_text)
            self.assertEqual(self.corrected(writer, "nominal.yaml"), texts, number)
            corrected = self.corrected(writer, "true.yaml")
            for seed in range(3):
                before, after = writer.machine(texts, inputs(seed)), writer.machine(corrected, inputs(seed))
                self.assertEqual(len(before), len(after), number)
                for programmed, commanded in zip(before, after):
                    if self.error_of(cell, programmed, commanded, writer.q) < NEAR_MM:
                        hits.append(programmed.text)
                        continue
                    left += 1
                    where = f"{kind.dialect} program {number}: {programmed.text} -> {commanded.text}"
                    self.assertEqual(programmed.kind, commanded.kind, where)
                    self.assertEqual(programmed.text, commanded.text, where)
                    # What is computed at run time starts from a point as it is corrected.
                    starts_there = any(word in programmed.text for word in kind.from_points)
                    moved = vc.length(vc.sub(programmed.value[1], commanded.value[1])) if programmed.kind == "pose" else 0
                    self.assertLess(moved, MOST_MM if starts_there else SAME_MM, where)
        return hits, left


class OffsetProgramsTest(ProgramsRun, unittest.TestCase):
    def run_programs(self, kind):
        hits, left = self.run_moves(kind)
        displaced = sum(any(form in text for form in kind.forms) for text in hits)
        carried = sum(kind.of_carried in text for text in hits)
        print(f"{kind.dialect}: {len(hits)} moves corrected, {displaced} of them displaced, {carried} of a part that is carried; {left} left alone")
        self.assertGreater(len(hits), 2 * left)
        self.assertGreater(displaced, PROGRAMS)
        self.assertGreater(carried, PROGRAMS // 2)
        return hits

    def test_displaced_targets_of_abb_are_reached_or_left_as_they_are(self):
        hits = self.run_programs(RapidWriter)
        self.assertGreater(sum("CalcJointT" in text for text in hits), PROGRAMS // 2)

    def test_displaced_positions_of_fanuc_are_reached_or_left_as_they_are(self):
        hits = self.run_programs(FanucWriter)
        for form in (r" PR\[6\]", r"ffset,PR\[5", r" Offset\b(?!,)"):  # that the program assigns, and OFFSET CONDITION
            self.assertGreater(sum(bool(re.search(form, text)) for text in hits), PROGRAMS // 4, form)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1])
