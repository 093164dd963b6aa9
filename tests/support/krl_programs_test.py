#!/usr/bin/env python3
"""Random programs of KUKA whose points are computed from constants, or relative to where the arm stands, behind branches,
loops, jumps and subprograms. A controller of its own runs each of them as it is and corrected, with the same inputs; the
true arm goes where the controller's model says. Each move ends at its programmed pose, or the program says the same of it
as before. Nothing here shares code with armtrue.

    krl_programs_test.py BIN [--programs N] [--keep FOLDER]
"""

import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import krl_machine
import robot_programs as rp
import robot_programs_test as programs
import virtual_cell as vc

BIN = None
PROGRAMS = int(sys.argv[sys.argv.index("--programs") + 1]) if "--programs" in sys.argv else 60
KEEP = pathlib.Path(sys.argv[sys.argv.index("--keep") + 1]) if "--keep" in sys.argv else None
NEAR_MM = 0.02   # what rounding may leave
SAME_MM = 1e-6
MOST_MM = 10     # of a correction: of these arms


class Writer:
    """Writes one program, statement by statement; all points are some cm around one posture."""

    def __init__(self, cell):
        self.cell, self.rng = cell, cell.rng
        self.base, self.tool = cell.bases[0], cell.tools[0]
        while True:
            self.q = cell.posture((20, 120), (-100, -50), (50, 110), (20, 150), (35, 80), (20, 150))
            if programs.wrist(cell.nominal, self.q)[0] > 500:
                break
        self.points = [f"XP{k}" for k in range(1, 5)]
        self.dat = [f"DECL E6POS {name}={self.point()}" for name in self.points]
        self.dat += [f"DECL E6POS PA={self.point()}", "DECL REAL HEIGHT=12.5"]
        self.labels = 0

    def point(self, with_status=True):
        return programs.kuka_frame(self.cell, [a + self.rng.uniform(-0.02, 0.02) for a in self.q], self.base, self.tool,
                                   with_status)

    def number(self):
        return self.rng.choice((f"{self.rng.uniform(-20, 20):.2f}", "HEIGHT", "K", "2*HEIGHT", "XP1.Z-XP1.Z+5"))

    def assignment(self):
        name, c = self.rng.choice(("PA", "PB", "PC")), self.rng.choice("XYZ")
        return self.rng.choice((f"{name}={self.rng.choice(self.points)}", f"{name}={self.point()}", f"{name}=XP2",
                                f"{name}.{c}={name}.{c}+{self.number()}", f"{name}.{c}={name}.{c}-HEIGHT",
                                f"{name}={self.rng.choice(('PA', 'PB', 'PC'))}", f"K={self.rng.uniform(-9, 9):.1f}",
                                f"{name}=$POS_ACT"))

    def move(self):
        end = self.rng.choice(("", " C_DIS"))
        by = ",".join(f"{c} {self.rng.uniform(-15, 15):.1f}" for c in self.rng.sample("XYZ", self.rng.randint(1, 3)))
        named = self.rng.choice(self.points + ["PA", "PB", "PC"] * 2)
        return self.rng.choice((f"LIN {named}{end}", f"PTP {named}", f"SLIN {named}", f"LIN {self.point(False)}{end}",
                                f"LIN_REL {{{by}}}{end}", f"LIN_REL{{{by}}}{end} #TOOL", f"SLIN_REL {{{by}}} #BASE",
                                f"PTP_REL {{{by}}}", f"LIN {named}", "PTP $POS_ACT",
                                "PTP {" + ",".join(f"A{j} {math.degrees(a):.4f}" for j, a in enumerate(self.q, 1)) + "}"))

    def plain(self):
        return self.rng.choice((self.assignment, self.move, self.move))()

    def block(self, depth):
        if depth == 0:
            return [self.plain() for _ in range(self.rng.randint(1, 4))]
        inner = lambda: self.block(depth - 1)
        k = self.rng.randint(0, 8)
        if k == 0:
            return ["IF $IN[1] THEN", *inner(), "ENDIF"]
        if k == 1:
            return ["IF $IN[1] THEN", *inner(), "ELSE", *inner(), "ENDIF"]
        if k == 2:
            return ["FOR I=1 TO 2", *inner(), "ENDFOR"]
        if k == 3:
            return ["LOOP", *inner(), "IF $IN[1] THEN", *self.block(0), "EXIT", "ENDIF", *self.block(0), "ENDLOOP"]
        if k == 4:
            self.labels += 1
            jump = f"GOTO L{self.labels}"
            return ["IF $IN[1] THEN", *self.block(0), jump, "ENDIF", *inner(), f"L{self.labels}:"]
        if k == 5:
            return ["WHILE $IN[1]", *inner(), "ENDWHILE"]
        if k == 6:
            return ["REPEAT", *inner(), "UNTIL $IN[1]"]
        if k == 7:
            return self.call()
        return inner()

    def call(self):
        """SUB is called with several tools and bases, of which each call may state one, both or none."""
        near = rp.abc_motion(4, -6, 8, 1, -2, 1)
        state = lambda base, tool: [programs.kuka_setting("BASE", base), programs.kuka_setting("TOOL", tool)]
        now, other = state(self.base, self.tool), state(vc.after(self.base, near), vc.after(self.tool, near))
        k = self.rng.randint(0, 4)
        if k == 4:  # KEPT holds the base of the moment, or that of before
            return self.rng.choice((["KEPT=$BASE"], [])) + other + ["SUB()", "$BASE=KEPT", now[1]]
        return [[], other[:1], other[1:], other][k] + ["SUB()", *now]

    def write(self):
        setting = [programs.kuka_setting("BASE", self.base), programs.kuka_setting("TOOL", self.tool)]
        blocks = [self.block(self.rng.randint(0, 2)) for _ in range(self.rng.randint(3, 7))]
        body = [line for block in blocks for line in block + (self.call() if self.rng.random() < 0.5 else [])]
        sub = self.block(self.rng.randint(0, 1))
        if self.rng.random() < 0.2:
            sub.insert(self.rng.randint(0, len(sub)), "RETURN")
        inner = [line for _ in range(3) for line in self.block(0)]
        sub.insert(self.rng.randint(0, len(sub)), "INNER()")
        lines = ["&ACCESS RVP", "DEF part( )", "DECL E6POS PB,PC", "DECL REAL K", "K=3.5", "DECL FRAME KEPT", *setting, "KEPT=$BASE", "PB=XP3",
                 f"PC={self.point()}", f"PTP {self.point()}", *body, "LIN XP1", "END", "DEF SUB()", *sub, "END", "DEF INNER()", *inner, "END", ""]
        lines = [line for line in lines if "PB" not in line and "PC" not in line] if self.rng.random() < 0.1 else lines
        # PB, PC and K are of the main program alone.
        own = lambda line: not any(word in line for word in ("PB", "PC", "K"))
        first = lines.index("DEF SUB()")
        lines = lines[:first] + [line for line in lines[first:] if own(line)]
        return "\r\n".join(lines), "\r\n".join(["DEFDAT PART", *self.dat, "ENDDAT", ""])


def inputs(seed):
    rng, count = random.Random(seed), 0

    def value():
        nonlocal count
        count += 1
        return rng.random() < (0.5 if count < 200 else 1.0)
    return value


def moves(src, dat, seed):
    try:
        return krl_machine.Machine(src, dat, inputs(seed)).moves
    except (KeyError, AssertionError, RecursionError):  # a variable without a value: a controller stops there
        return None


class KrlProgramsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(KEEP or tempfile.mkdtemp())
        self.folder.mkdir(exist_ok=True)

    def corrected(self, robot):
        """The two texts that come out."""
        out = self.folder / "new"
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir()
        run = subprocess.run([BIN / "compensate", "-q", "--robot", robot, "--controller", "nominal.yaml", "--program", "part.src",
                              "--program-out", "new/part.src", "--max-mm", "50"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        return [(self.folder / name).read_bytes().decode() if (self.folder / name).exists()
                else (self.folder / pathlib.Path(name).name).read_bytes().decode() for name in ("new/part.src", "new/part.dat")]

    def error_of(self, cell, programmed, commanded, start):
        """How far [mm] the true arm is from the programmed pose."""
        def flange(pose, move):
            return vc.after(vc.after(move.base, pose), programs.inverse(move.tool))
        if programmed.kind == "joints":
            q, wanted = [math.radians(a) for a in commanded.value], cell.nominal.pose([math.radians(a) for a in programmed.value])
        else:
            q = programs.joints_at(cell.nominal, flange(commanded.value, commanded), start)
            wanted = flange(programmed.value, programmed)
        reached = cell.true.pose(q)
        return vc.length(vc.sub(vc.after(reached, programmed.tool)[1], vc.after(wanted, programmed.tool)[1]))

    def test_each_move_ends_where_it_is_programmed_or_is_left_as_it_is(self):
        hits, left, relative, computed, copied = 0, 0, 0, 0, 0
        for number in range(PROGRAMS):
            cell = programs.Cell("krl", 1000 + number)
            writer = Writer(cell)
            src, dat = writer.write()
            (self.folder / "part.src").write_bytes(src.encode())
            (self.folder / "part.dat").write_bytes(dat.encode())
            (self.folder / "nominal.yaml").write_text(cell.nominal_text)
            (self.folder / "true.yaml").write_text(cell.true_text)
            self.assertEqual(self.corrected("nominal.yaml"), [src, dat], number)
            corrected = self.corrected("true.yaml")
            copied += "DEF SUB_2(" in corrected[0]
            for seed in range(3):
                before, after = moves(src, dat, seed), moves(*corrected, seed)
                if before is None:
                    continue
                self.assertEqual(len(before), len(after), number)
                for programmed, commanded in zip(before, after):
                    where = f"program {number}: {programmed.line}: {programmed.text} -> {commanded.text}"
                    if self.error_of(cell, programmed, commanded, writer.q) < NEAR_MM:
                        hits += 1
                        relative += "_REL" in programmed.text
                        computed += any(name in programmed.text for name in (" PA", " PB", " PC"))
                        continue
                    left += 1
                    self.assertEqual(programmed.text, commanded.text, where)
                    if programmed.kind == "joints":
                        self.assertEqual(programmed.value, commanded.value, where)
                    else:  # a relative move may start from a corrected point
                        is_from_there = "_REL" in programmed.text or "$POS_ACT" in src
                        self.assertLess(vc.length(vc.sub(programmed.value[1], commanded.value[1])),
                                        MOST_MM if is_from_there else SAME_MM, where)
        print(f"{hits} moves corrected, {relative} of them relative and {computed} to computed points; {left} left alone; "
              f"{copied} programs with copies")
        self.assertGreater(hits, 2 * left)
        self.assertGreater(min(relative, computed), PROGRAMS)
        self.assertGreater(copied, PROGRAMS / 4)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1])
