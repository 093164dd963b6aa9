"""A controller of its own for KRL: it runs a program, with variables, branches, loops, jumps and subprograms, and says where
each move that runs ends. It knows just the statements that krl_programs_test.py writes, and shares no code with armtrue.

Lengths are mm, angles deg. A motion is (rotation of three rows, translation), as in virtual_cell.
"""

import collections
import re

import robot_programs as rp
import virtual_cell as vc

Move = collections.namedtuple("Move", "line kind value base tool text")
POSE = ("X", "Y", "Z", "A", "B", "C")


def entries(text):
    return {name.upper(): float(value) for name, value in re.findall(rf"(\w+)\s+({rp.NUMBER})", text)}


class Machine:
    """`inputs`: the next value of $IN[..], true or false. Of several programs `src` and `dat` are theirs one behind the other,
    whose names differ, and `entry` is the routine that is started. `submit`: assignments that may run before any move."""

    def __init__(self, src, dat, inputs, entry=None, submit=()):
        self.inputs, self.moves, self.submit = inputs, [], submit
        self.shared = {}
        for name, body, number in re.findall(rf"(?:DECL (?:GLOBAL )?\w+ |(?=\b(?:BASE|TOOL)_DATA))(\w+(?:\[\d\])?)=(?:\{{([^}}]*)\}}|({rp.NUMBER}))", dat):
            self.shared[name.upper()] = entries(body) if body else float(number)
        self.lines = [(k, line.split(";")[0].strip()) for k, line in enumerate(src.replace("\r", "").split("\n"), 1)]
        self.lines = [(k, line) for k, line in self.lines if line and line[0] != "&"]
        self.routines = {m[1].upper(): i for i, (_, line) in enumerate(self.lines) if (m := re.match(r"(?:GLOBAL )?DEF (\w+)", line))}
        self.base, self.tool, self.here = vc.NONE, vc.NONE, {}
        self.call(entry or next(iter(self.routines)))

    def call(self, name):
        begin = self.routines[name] + 1
        end = next(i for i in range(begin, len(self.lines)) if self.lines[i][1] == "END")
        self.run(begin, end, {})

    def block(self, at, end):
        """The lines that divide the block that begins at a line, and its end."""
        depth, dividing = 0, []
        for i in range(at, end):
            word = re.match(r"\w+", self.lines[i][1])
            word = word[0] if word else ""
            depth += word in ("IF", "FOR", "WHILE", "LOOP", "REPEAT", "SWITCH")
            depth -= word in ("ENDIF", "ENDFOR", "ENDWHILE", "ENDLOOP", "UNTIL", "ENDSWITCH")
            if depth == 1 and word in ("ELSE", "CASE", "DEFAULT"):
                dividing.append(i)
            if depth == 0:
                return dividing, i
        raise AssertionError("a block has no end")

    def run(self, begin, end, own):
        """Runs lines; returns nothing, "EXIT", "RETURN", or the label of a jump that is not among them."""
        at = begin
        while at < end:
            assert len(self.moves) < 2000
            number, line = self.lines[at]
            word = re.match(r"\$?\w+", line)[0].upper()
            at += 1
            went = None
            if word in ("IF", "FOR", "WHILE", "LOOP", "REPEAT", "SWITCH"):
                dividing, last = self.block(at - 1, end)
                went = self.run_block(word, line, at, dividing, last, own)
                at = last + 1
            elif word == "GOTO":
                went = line.split()[1].upper()
            elif word in ("EXIT", "RETURN"):
                went = word
            elif re.fullmatch(r"\w+\(\)", line):
                self.call(word)
            elif "=" in line and not line.upper().startswith(("LIN", "PTP", "SLIN", "SPTP", "CIRC")):
                self.assign(line, own)
            elif word == "DECL":
                for name in line.split(None, 2)[2].split(","):
                    own[name.strip().upper()] = {}
            elif not line.endswith(":"):
                self.move(number, word, line, own)
            if went is None:
                continue
            labels = {self.lines[i][1][:-1].upper(): i for i in range(begin, end) if self.lines[i][1].endswith(":")}
            if went not in labels:
                return went
            at = labels[went]
        return None

    def run_block(self, word, line, at, dividing, last, own):
        if word == "IF":
            middle = dividing[0] if dividing else last
            return self.run(at, middle, own) if self.inputs() else self.run(middle + 1, last, own) if dividing else None
        if word == "SWITCH":
            value = self.number(line.split()[1], own)
            for k, i in enumerate(dividing):
                stop = dividing[k + 1] if k + 1 < len(dividing) else last
                if self.lines[i][1] == "DEFAULT" or float(self.lines[i][1].split()[1]) == value:
                    return self.run(i + 1, stop, own)
            return None
        turns = 0
        while True:
            turns += 1
            assert turns < 100
            if word == "WHILE" and not self.inputs():
                return None
            if word == "FOR" and turns > int(line.split()[-1]):
                return None
            went = self.run(at, last, own)
            if went == "EXIT":
                return None
            if went or (word == "REPEAT" and self.inputs()):
                return went

    def place(self, name, own):
        return own if name in own else self.shared

    def number(self, text, own):
        """Sums of products."""
        total = 0.0
        for sign, term in re.findall(r"([+-]?)([^+-]+)", re.sub(r"\s", "", text)):
            value = 1.0
            for factor in term.split("*"):
                if re.fullmatch(rp.NUMBER, factor):
                    value *= float(factor)
                else:
                    name, _, component = factor.upper().partition(".")
                    held = self.place(name, own)[name]
                    value *= held[component] if component else held
            total += -value if sign == "-" else value
        return total

    def assign(self, line, own):
        name, value = (part.strip() for part in line.split("=", 1))
        name = name.upper()
        if name in ("$BASE", "$TOOL"):
            kept = own.get(value.upper())
            of = kept or self.shared.get(value.upper()) or entries(value)
            setattr(self, name[1:].lower(), kept or rp.abc_motion(*(of[c] for c in POSE)))
            self.here = {}
            return
        name, _, component = name.partition(".")
        place = self.place(name, own)
        if component:
            place[name] = {**place[name], component: self.number(value, own)}
        elif value in ("$BASE", "$TOOL"):
            place[name] = getattr(self, value[1:].lower())
        elif value == "$POS_ACT":
            place[name] = dict(self.here)
        elif value.startswith("{"):
            place[name] = entries(value)
        elif isinstance(self.place(value.upper(), own).get(value.upper()), dict):
            place[name] = dict(self.place(value.upper(), own)[value.upper()])
        else:
            place[name] = self.number(value, own)

    def move(self, number, word, line, own):
        for assignment in self.submit:
            if self.inputs():
                self.assign(assignment, {})
        if word.endswith("_REL"):
            by = entries(re.search(r"\{(.*?)\}", line)[1])
            step = [by.get(c, 0.0) for c in "XYZ"]
            if "#TOOL" in line:
                step = vc.turned(rp.abc_motion(*(self.here[c] for c in POSE))[0], step)
            point = {**self.here, **{c: self.here[c] + s for c, s in zip("XYZ", step)}}
            point.pop("S", None)
            point.pop("T", None)
        else:
            text = line[len(word):].strip()
            name = re.match(r"\$?\w+", text)
            if name and name[0].upper() == "$POS_ACT":
                return
            point = self.place(name[0].upper(), own)[name[0].upper()] if name else entries(re.match(r"\{(.*?)\}", text)[1])
        if "A1" in point:
            self.here = {}
            self.moves.append(Move(number, "joints", [point[f"A{j}"] for j in range(1, 7)], self.base, self.tool, line))
            return
        self.here = {**self.here, **point}
        pose = rp.abc_motion(*(self.here[c] for c in POSE))
        self.moves.append(Move(number, "pose", pose, self.base, self.tool, line))
