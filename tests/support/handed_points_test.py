#!/usr/bin/env python3
"""Random programs of ABB and Universal Robots whose routines drive to points that their calls hand over: declared ones,
displaced ones, ones that are written out or given several values; to copies of them that they change, displace, read or hand on,
with tools that are handed over, too, or differ. A controller of its own runs each of them as it is and corrected, as in
offset_programs_test.py. Nothing here shares code with armtrue.

    handed_points_test.py BIN [--programs N] [--keep FOLDER]
"""

import pathlib
import re
import sys
import unittest

sys.dont_write_bytecode = True

import offset_programs_test as offsets
import robot_programs as rp
import robot_programs_test as programs
import virtual_cell as vc


class RapidWriter(offsets.RapidWriter):
    def body(self, name):
        """What a procedure does with p."""
        end = ",v100,fine,tMill\\WObj:=wPart;"
        move = f"Move{self.rng.choice('JL')} p{end}"
        others = [f"MoveL Offs(p,0,0,{self.number()}){end}", "p.trans.z:=p.trans.z+5;", "nStep:=p.trans.x/900;", f"MoveC p2,p{end}",
                  "MoveL p,v100,fine,tGrip\\WObj:=wPart;", "ConfL\\Off;", "pV:=p;", *([] if name == "rA" else ["rA p;"])]
        lines = [self.rng.choice((move, move, others[0])) for _ in range(self.rng.randint(1, 2))]
        if self.rng.random() < 0.3:
            lines.insert(self.rng.randint(0, len(lines)), self.rng.choice(others))
        return self.rng.choice((lines, lines, ["IF di1=1 THEN", *lines, "ENDIF"]))

    def write(self):
        self.heads = {"rA": "robtarget p", "rB": "robtarget p,num h", "rC": self.rng.choice(("num h,robtarget p", "INOUT robtarget p")),
                      "rD": "PERS tooldata t,robtarget p"}
        text, = super().write()
        procedures = [line for name, head in self.heads.items() for line in (f"PROC {name}({head})", *(
            self.body(name) if name != "rD" else ["MoveL p,v100,fine,t\\WObj:=wPart;"]), "ENDPROC")]
        procedures = [re.sub(r"^ConfL.*", "nStep:=1;", line) for line in procedures]
        return [text.replace("ENDMODULE", "\r\n".join([*procedures, "ENDMODULE"]))]

    def plain(self):
        if self.rng.random() < 0.4:
            return super().plain()
        name = self.rng.choice("ABCD")
        head = self.heads["r" + name]
        point = self.rng.choice(("p1", "p2", "p3", "pV", self.target(), "Offs(p3,0,nUp,2)", "Offs(pV,1,2,3)"))
        of = {"num h": str(self.rng.randint(1, 9)), "robtarget p": point, "INOUT robtarget p": "pV", "PERS tooldata t": "tMill"}
        if name == "D" and self.rng.random() < 0.4:
            of.update({"robtarget p": "q1", "PERS tooldata t": "tGrip"})
        return f"r{name} {','.join(of[part] for part in head.split(','))};"


class UrMachine:
    """Runs the function part of a program with functions in it."""

    def __init__(self, text, inputs):
        self.inputs, self.moves, self.tool, self.globals, self.locals = inputs, [], vc.NONE, {}, {}
        lines = [line.split("#")[0].strip() for line in text.splitlines()]
        self.functions = {}
        self.run([line for line in lines[1:-1] if line])

    def value(self, text):
        text = re.sub(r"\bp\[(?=[^\]]*,)", "pose[", text)
        pose = type("", (), {"__getitem__": lambda _, numbers: list(numbers)})()
        known = {"pose": pose, "get_inverse_kin": lambda pose, qnear: pose, "pose_trans": self.trans, "pose_add": self.add,
                 "height": lambda pose: self.motion(pose)[1][2] / 1000}
        text = re.sub(r"\bp\[2\]", "height(p)", text)
        return eval(text, {"__builtins__": {}}, {**known, **self.globals, **self.locals})

    @staticmethod
    def motion(value):
        return value if isinstance(value, tuple) else rp.vector_motion(value)

    def trans(self, frame, pose):
        return vc.after(self.motion(frame), self.motion(pose))

    def add(self, pose, shift):
        rotation, place = self.motion(pose)
        return rotation, tuple(a + 1000 * b for a, b in zip(place, shift))

    def run(self, lines):
        at = 0
        while at < len(lines):
            line, end = lines[at], self.end_of(lines, at)
            inner = lines[at + 1:end]
            if found := re.match(r"def (\w+)\((.*)\):", line):
                self.functions[found[1]] = [name for name in found[2].split(", ") if name], inner
            elif line.startswith("if"):
                if self.inputs():
                    self.run(inner)
            elif found := re.match(r"set_tcp\((.*)\)$", line):
                self.tool = self.motion(self.value(found[1]))
            elif found := re.match(r"move(\w)\((.*), a=1\)$", line):
                value = self.value(found[2])
                is_joints = found[2].startswith("[")
                self.moves.append(offsets.Move(line, "joints" if is_joints else "pose", [57.29577951308232 * a for a in value] if is_joints else
                                               self.motion(value), vc.NONE, self.tool))
            elif found := re.match(r"(?:global )?(\w+)(\[2\])? = (.*)", line):
                of = self.locals if found[1] in self.locals else self.globals
                if found[2]:
                    rotation, place = self.motion(of[found[1]])
                    of[found[1]] = rotation, (*place[:2], 1000 * self.value(found[3]))
                else:
                    of[found[1]] = self.value(found[3])
            elif found := re.match(r"(\w+)\((.*)\)$", line):
                names, body = self.functions[found[1]]
                values = self.value(f"[{found[2]}]")
                outside, self.locals = self.locals, dict(zip(names, values))
                self.run(body)
                self.locals = outside
            else:
                raise AssertionError(line)
            at = end + 1

    @staticmethod
    def end_of(lines, at):
        depth = 0
        for k in range(at, len(lines)):
            depth += lines[k].startswith(("def ", "if ")) - (lines[k] == "end")
            if depth == 0:
                return k


class UrWriter:
    dialect, files = "urscript", ("part.script",)
    options = ()
    from_points = ("pose_add(p,",)
    machine = staticmethod(lambda texts, inputs: UrMachine(texts[0], inputs).moves)

    def __init__(self, cell):
        self.cell, self.rng = cell, cell.rng
        self.q = cell.posture((-150, 150), (-80, -40), (50, 100), (-150, 150), (60, 100), (-150, 150))

    def pose(self, base=vc.NONE):
        q = [a + self.rng.uniform(-0.02, 0.02) for a in self.q]
        return programs.ur_pose(self.cell.written(q, base, self.cell.tools[0]))

    def body(self, name):
        near = "[" + ",".join(f"{a:.6f}" for a in self.q) + "]"
        lines = {"go": ["movel(p, a=1)"], "up": ["movel(pose_add(p, p[0,0,0.01,0,0,0]), a=1)", "movel(p, a=1)"],
                 "plane": ["movel(pose_trans(Plane_1, p), a=1)"], "near": [f"movej(get_inverse_kin(p, qnear={near}), a=1)"],
                 "twice": ["movel(p, a=1)", "movel(p, a=1)"]}[name]
        if self.rng.random() < 0.2:
            lines = [*lines, self.rng.choice(("p[2] = p[2]+0.005", "x = p[2]", "p = pose_add(p, p[0,0,0.01,0,0,0])", "a3 = p",
                                              *([] if name == "go" else ["go(p)"]))), "movel(p, a=1)" if name != "plane" else lines[0]]
        return self.rng.choice((lines, lines, ["if di(1):", *lines, "end"]))

    def plain(self):
        kind = self.rng.randint(0, 9)
        if kind == 0:
            return f"movel({self.rng.choice(('a1', 'a2', 'a3', self.pose()))}, a=1)"
        if kind == 1:
            return f"a3 = {self.rng.choice(('a1', self.pose()))}"
        if kind < 4:
            return f"plane({self.rng.choice(('b1', 'b2', self.pose(self.cell.bases[0])))})"
        point = self.rng.choice(("a1", "a2", "a3", self.pose(), "pose_add(a2, p[0.004,0,0.01,0,0,0])"))
        return f"{self.rng.choice(('go', 'up', 'near', 'twice'))}({point})"

    def write(self):
        body = [line for _ in range(self.rng.randint(6, 12)) for line in self.rng.choice(([self.plain()], ["if di(1):", self.plain(), "end"]))]
        if self.rng.random() < 0.3:
            body[3:3] = ["if di(1):", f"set_tcp({programs.ur_pose(self.cell.tools[1])})", f"set_tcp({programs.ur_pose(self.cell.tools[0])})", "end"]
        functions = [line for name in ("go", "up", "plane", "near", "twice") for line in (f"def {name}(p):", *self.body(name), "end")]
        lines = ["def part():", f"global Plane_1 = {programs.ur_pose(self.cell.bases[0])}",
                 *(f"global {name} = {self.pose(self.cell.bases[0] if name[0] == 'b' else vc.NONE)}" for name in ("a1", "a2", "a3", "b1", "b2")),
                 *functions, f"set_tcp({programs.ur_pose(self.cell.tools[0])})",
                 "movej([" + ",".join(f"{a:.9f}" for a in self.q) + "], a=1)", *body, "end", ""]
        return ["\n".join(lines)]


class HandedPointsTest(offsets.ProgramsRun, unittest.TestCase):
    def run_handed(self, kind, to_handed, least):
        hits, left = self.run_moves(kind)
        handed = sum(bool(re.search(to_handed, text)) for text in hits)
        print(f"{kind.dialect}: {len(hits)} moves corrected, {handed} of them to points that are handed over; {left} left alone")
        self.assertGreater(handed, least * offsets.PROGRAMS)

    def test_abb(self):
        self.run_handed(RapidWriter, r"^Move\w p,", 2)

    def test_universal_robots(self):
        self.run_handed(UrWriter, r"\bp[,)]", 4)


if __name__ == "__main__":
    offsets.BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1])
