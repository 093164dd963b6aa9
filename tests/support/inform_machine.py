"""A controller of its own for INFORM: it runs a job of Yaskawa, with jumps, branches, variables, shifts and relative moves,
and says where each move that runs ends. It knows just the statements that inform_programs_test.py writes, and shares no code
with armtrue.

Lengths are mm, angles deg. A motion is (rotation of three rows, translation), as in virtual_cell.
"""

import collections
import re

import robot_programs as rp
import virtual_cell as vc

# kind: pose (base from TCP), joints, or other with the numbers as they stand. `shift`: that is on, of xyz.
Move = collections.namedtuple("Move", "line kind value base tool shift text")


def pose(numbers):
    x, y, z, rx, ry, rz = numbers[:6]
    return rp.abc_motion(x, y, z, rz, ry, rx)


class Job:
    """The positions of //POS by their names, C1 or P1, and the instructions."""

    def __init__(self, text):
        self.positions, self.counted, heads = {}, None, {}
        head, body = text.replace("\r", "").split("//INST\n")
        for line in head.split("\n"):
            if line.startswith("///NPOS"):
                self.counted = [int(n) for n in line.split()[1].split(",")]
            elif line.startswith("///"):
                word, _, value = line[3:].strip().partition(" ")
                heads["DATA" if word in ("RECTAN", "PULSE", "ANGLE") else word] = value or word
            elif found := re.match(r"([A-Z]+)(\d+)=(.*)", line):
                numbers = [float(n) for n in found[3].split(",")]
                assert found[1] + str(int(found[2])) not in self.positions
                self.positions[found[1] + str(int(found[2]))] = numbers, dict(heads)
        first = text.replace("\r", "").split("\n").index("//INST") + 2
        self.lines = [(first + k, line.strip()) for k, line in enumerate(body.split("\n"))]
        self.lines = [(k, line) for k, line in self.lines if line and line[0] not in "/'"]

    def count(self, kind):
        return sum(re.fullmatch(rf"{kind}\d+", name) is not None for name in self.positions)


class Machine(Job):
    """`inputs`: the next value of IN#(..), true or false. `others`: jobs that it may call, by their names. `pulses`: per deg
    of each axis, if they are known."""

    def __init__(self, text, inputs, users, tools, others=(), pulses=None):
        super().__init__(text)
        self.pulses = pulses
        self.others = {name: Job(other).lines for name, other in dict(others).items()}
        self.inputs, self.users, self.tools, self.moves = inputs, users, tools, []
        self.variables = {name: value for name, value in self.positions.items() if name[0] == "P"}
        self.shift = None
        self.run(self.lines)

    def run(self, lines):
        at = 0
        labels = {line[1:]: i for i, (_, line) in enumerate(lines) if line[0] == "*"}
        while at < len(lines):
            assert len(self.moves) < 400
            number, line = lines[at]
            word = line.split()[0]
            at += 1
            if word in ("MOVJ", "MOVL", "MOVC", "MOVS", "IMOV"):
                self.move(number, word, line)
            elif word == "JUMP":
                if " IF " not in line or self.inputs():
                    at = labels[line.split()[1][1:]]
            elif word in ("RET", "END"):
                if " IF " not in line or self.inputs():
                    return
            elif word == "IFTHENEXP":
                if not self.inputs():
                    at = self.past(at, ("ELSE", "ENDIF"))
            elif word == "ELSE":
                at = self.past(at, ("ENDIF",))
            elif word == "SFTON":
                self.shift = tuple(self.variables[self.name(line.split()[1])][0][:3])
            elif word == "SFTOF":
                self.shift = None
            elif word in ("SET", "ADD"):
                to, value = (self.name(name) for name in line.split()[1:])
                numbers, heads = self.variables[value]
                if word == "ADD":
                    held, heads = self.variables[to]
                    numbers = [a + b for a, b in zip(held, numbers)]
                self.variables[to] = numbers, heads
            elif word == "CALL":
                if " IF " not in line or self.inputs():
                    self.run(self.others[line.split()[1][4:]])

    def past(self, at, words):
        depth = 0
        for i in range(at, len(self.lines)):
            word = self.lines[i][1].split()[0]
            depth += word == "IFTHENEXP"
            if depth == 0 and word in words:
                return i + 1
            depth -= word == "ENDIF"
        raise AssertionError("a branch has no end")

    @staticmethod
    def name(text):
        return text[0] + str(int(text[1:]))

    def move(self, number, word, line):
        name = self.name(line.split()[1])
        numbers, heads = self.variables[name] if name[0] == "P" else self.positions[name]
        data = heads.get("DATA")
        if word == "IMOV" or data == "PULSE" and not self.pulses:
            return self.moves.append(Move(number, "other", numbers, None, None, self.shift, line))
        tool = self.tools[int(heads["TOOL"])]
        if data == "PULSE":
            numbers = [number / per_deg for number, per_deg in zip(numbers, self.pulses)]
        if data in ("ANGLE", "PULSE"):
            return self.moves.append(Move(number, "joints", numbers, vc.NONE, tool, self.shift, line))
        base = self.users[int(heads["USER"])] if heads["POSTYPE"] == "USER" else vc.NONE
        self.moves.append(Move(number, "pose", pose(numbers), base, tool, self.shift, line))
