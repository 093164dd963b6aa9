#!/usr/bin/env python3
"""Random URScript programs whose numbers are sums, products, d2r(..) and names, whose points get other elements or stand in frames
within frames, and in which a function sets a tool and restores the one before. An interpreter of its own runs them before and after the correction, and the true
arm goes there. Nothing here shares code with armtrue.

    ur_numbers_test.py BIN [--programs N]
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
import robot_programs_test as programs
import virtual_cell as vc

BIN = None
PROGRAMS = int(sys.argv[sys.argv.index("--programs") + 1]) if "--programs" in sys.argv else 10
NEAR_MM, NEAR_RAD = 6e-3, 8e-6  # check digits move a number by up to 3.2e-6 m or rad


SHIFT, LIFT = [0.03, -0.02, 0.05, 0.1, 0.2, -0.3], [0.01, 0.02, -0.04, 0, 0, 0]


def text_of(numbers):
    return f"p[{', '.join(f'{n:.9f}' for n in numbers)}]"


def numbers_of(motion):
    return [*(v / 1000 for v in motion[1]), *programs.rotation_vector(motion[0])]


class Writer:
    def __init__(self, cell):
        self.cell, self.rng, self.lines, self.moves = cell, cell.rng, [], 0
        self.tool = cell.tools[0]
        self.q = cell.posture((-150, 150), (-80, -50), (60, 100), (-100, 100), (50, 110), (-150, 150))

    def number(self, value):
        """An expression of it, exact but for rounding."""
        part, kind = round(self.rng.uniform(-1, 1), 3), self.rng.randint(0, 6)
        return (f"{value:.9f}", f"{part}+{value - part:.9f}", f"{value * 1000:.6f}/1000", f"2*({value / 2:.9f})", f"-({-value:.9f})",
                f"half*{2 * value:.9f}", f"{value + 0.25:.9f} - parts[1]*step")[kind]

    def angle(self, value):
        return f"d2r({math.degrees(value):.7f})" if self.rng.random() < 0.6 else self.number(value)

    def step(self, base=vc.NONE):
        """The numbers of a pose near the last one."""
        self.q = self.cell.near(self.q, 0.15)
        position = self.cell.written(self.q, base, self.tool)
        return numbers_of(position)

    def add(self, *lines):
        self.lines += lines

    def move(self, point):
        self.add(f"movel({point}, a=1.2, v=0.25)")
        self.moves += 1

    def statements(self):
        kind = self.rng.randint(0, 6)
        if kind == 0:
            self.q = self.cell.near(self.q, 0.15)
            self.add(f"movej([{', '.join(self.angle(v) for v in self.q)}], a=1.4)")
            self.moves += 1
        elif kind == 1:
            self.move(f"p[{', '.join(self.number(v) for v in self.step())}]")
        elif kind == 2:
            numbers, wanted = self.step(), self.step()
            self.add(f"wp = p[{', '.join(self.number(v) for v in numbers)}]")
            self.move("wp")
            self.add(*(f"wp[{i}] = {self.number(v)}" for i, v in enumerate(wanted)))
            self.move("wp")
        elif kind == 3:
            self.add(f"low = p[{', '.join(self.number(v) for v in self.step())}]")
            self.move("low")
            for _ in range(2):
                self.add(f"low[2] = low[2] + {self.number(0.01)}")
                self.move("low")
        elif kind == 4:
            base = vc.after(self.cell.bases[0], rp.vector_motion(SHIFT))
            self.move(f"pose_trans(plane, pose_trans({text_of(SHIFT)}, {text_of(self.step(base))}))")
        elif kind == 5:
            base = vc.after(rp.vector_motion(LIFT), self.cell.bases[0])
            self.move(f"pose_add(pose_trans(plane, {text_of(self.step(base))}), {text_of(LIFT)})")
        else:
            self.add("look()")

    def write(self):
        tools = [programs.ur_pose(tool) for tool in self.cell.tools]
        first = programs.ur_pose(self.cell.written(self.q, vc.NONE, self.tool))
        near = "[" + ",".join(f"{a:.9f}" for a in self.q) + "]"
        self.add("half = 1/2", "parts = [0,1,0,0,0,0]", "step = half/2", f"plane = {programs.ur_pose(self.cell.bases[0])}", f"set_tcp({tools[0]})", f"movej(get_inverse_kin({first}, qnear={near}))")
        self.moves += 1
        for _ in range(10):
            self.statements()
        look = ["def look():", "  old = get_tcp_offset()", f"  set_tcp({tools[1]})", "  sync()", "  set_tcp(old)", "end"]
        return "\n".join(["def part():"] + ["  " + line for line in look + self.lines] + ["end", ""])


def run(text):
    """The moves: kind, numbers, tool."""
    body = [line.split("#")[0].strip() for line in text.splitlines()]
    at = body.index("def look():")
    functions = {"look": body[at + 1:body.index("end", at)]}
    names, moves, tool = {"d2r": math.radians, "__builtins__": {}}, [], [vc.NONE]
    names["p"] = None
    names["pose_trans"] = lambda a, b: numbers_of(vc.after(rp.vector_motion(a), rp.vector_motion(b)))
    names["pose_add"] = lambda a, b: [x + y for x, y in zip(a[:3], b)] + a[3:]  # LIFT turns nothing

    def value(expression):
        return eval(re.sub(r"p\[([^\[\]]*(?:\[\d\][^\[\]]*)*)\](?!\s*=)", r"[\1]", expression), names)

    def do(lines):
        for line in lines:
            if call := re.fullmatch(r"look\(\)", line):
                do(functions["look"])
            elif line == "old = get_tcp_offset()":
                names["old"] = tool[0]
            elif given := re.fullmatch(r"set_tcp\((.*)\)", line):
                tool[0] = names["old"] if given[1] == "old" else rp.vector_motion(value(given[1]))
            elif move := re.fullmatch(r"move([jl])\((.*)\)", line):
                point = re.sub(r",\s*(a|v)=[\d.]+", "", move[2])
                if inverse := re.fullmatch(r"get_inverse_kin\((p\[.*?\]), qnear=(.*)\)", point):
                    moves.append(("pose", value(inverse[1]), tool[0], value(inverse[2])))
                else:
                    moves.append(("joints" if point[0] == "[" else "pose", list(value(point)), tool[0], None))
            elif given := re.fullmatch(r"(\w+)(?:\[(\d)\])? = (.*)", line):
                if given[2]:
                    names[given[1]] = list(names[given[1]])
                    names[given[1]][int(given[2])] = value(given[3])
                else:
                    names[given[1]] = value(given[3])

    do(body[body.index("end", at) + 1:-1])
    return moves


class UrNumbersTest(unittest.TestCase):
    def compensate(self, folder, robot):
        done = subprocess.run([BIN / "compensate", "-v", "--robot", robot, "--controller", "nominal.yaml", "--max-mm", "50", "--program",
                               "part.script", "--program-out", "new.script"], cwd=folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return (folder / "new.script").read_text(), done.stderr

    def test_the_true_arm_goes_to_each_point(self):
        corrected = 0
        for seed in range(PROGRAMS):
            cell = programs.Cell("urscript", 900 + seed)
            writer = Writer(cell)
            text = writer.write()
            with tempfile.TemporaryDirectory() as folder:
                folder = pathlib.Path(folder)
                for name, content in (("nominal.yaml", cell.nominal_text), ("true.yaml", cell.true_text), ("part.script", text)):
                    (folder / name).write_text(content)
                self.assertEqual(self.compensate(folder, "nominal.yaml")[0], text, seed)
                now, said = self.compensate(folder, "true.yaml")
            before, after = run(text), run(rp.without_mark(now))
            self.assertEqual(len(before), writer.moves)
            self.assertIn(f"{writer.moves} of {writer.moves} moves are corrected", said, f"program {seed}")
            self.assertEqual(len(after), len(before))
            q = None
            for number, ((kind, numbers, tool, near), (_, command, tool_now, _)) in enumerate(zip(before, after)):
                self.assertEqual(tool, tool_now)
                if kind == "joints":
                    q, commanded = numbers, command
                else:
                    flange = lambda of: vc.after(rp.vector_motion(of), programs.inverse(tool))
                    q = programs.joints_at(cell.nominal, flange(numbers), near or q)
                    commanded = programs.joints_at(cell.nominal, flange(command), q)
                error = programs.difference(cell.nominal.pose(q), cell.true.pose(commanded))
                self.assertLess(vc.length(error[:3]), NEAR_MM, f"program {seed}, move {number}")
                self.assertLess(vc.length(error[3:]), NEAR_RAD, f"program {seed}, move {number}")
                corrected += numbers != command
        print(f"{corrected} points corrected")
        self.assertGreater(corrected, 8 * PROGRAMS)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    if "--programs" in sys.argv:
        at = sys.argv.index("--programs")
        del sys.argv[at:at + 2]
    del sys.argv[1]
    unittest.main()
