#!/usr/bin/env python3
"""Random projects of KUKA: programs that call each other and state $BASE and $TOOL, or have those of their callers, and set
global points, which a submit program may set, too. A controller of its own starts each program that no other one calls, as it is and corrected, with the same inputs; the true
arm goes where the controller's model says. Each move ends at its programmed pose, or the program says the same of it as
before. Nothing here shares code with armtrue.

    krl_calls_test.py BIN [--projects N]
"""

import csv
import io
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

import krl_machine
import krl_programs_test as single
import robot_programs as rp
import robot_programs_test as programs
import virtual_cell as vc

BIN = None
PROJECTS = int(sys.argv[sys.argv.index("--projects") + 1]) if "--projects" in sys.argv else 15
FILES = 5


class Writer:
    """Programs F0 to F4, of which each one calls some behind it, their main routine or a global one."""

    def __init__(self, cell):
        self.cell, self.rng = cell, cell.rng
        self.q = single.Writer(cell).q
        near = lambda k: rp.abc_motion(4 * k, -6, 8 * k, k, -2, 1)
        self.bases = [vc.after(cell.bases[0], near(k)) for k in range(1, 4)]
        self.tools = [vc.after(cell.tools[0], near(k)) for k in range(1, 3)]
        text = lambda motion: programs.kuka_setting("BASE", motion).split("=", 1)[1]
        self.config = ["DEFDAT $CONFIG"] + [f"BASE_DATA[{k}]={text(m)}" for k, m in enumerate(self.bases, 1)]
        self.config += [f"TOOL_DATA[{k}]={text(m)}" for k, m in enumerate(self.tools, 1)] + ["ENDDAT", ""]
        self.called = set()
        self.texts = {"R1/System/$config.dat": "\n".join(self.config)}
        public = ["DEFDAT POINTS PUBLIC", *(f"DECL GLOBAL E6POS {name}={self.point()}" for name in ("CA", "CB", "GA", "GB", "GC")), "ENDDAT", ""]
        self.texts["R1/Program/points.dat"] = "\n".join(public)
        self.submit = [f"{name}=CA" for name in ("GA", "GB") if self.rng.random() < 0.2]
        self.texts["R1/System/sps.sub"] = "\n".join(["DEF SPS()", "LOOP", *self.submit, "ENDLOOP", "END", ""])
        for number in range(FILES):
            self.write(number)

    def point(self):
        return programs.kuka_frame(self.cell, [a + self.rng.uniform(-0.02, 0.02) for a in self.q], self.cell.bases[0],
                                   self.cell.tools[0], True)

    def state(self):
        which, text = self.rng.choice((("BASE", self.bases), ("TOOL", self.tools)))
        k = 0 if self.rng.random() < 0.8 else self.rng.randrange(len(text))
        return self.rng.choice((f"${which}={which}_DATA[{k + 1}]", programs.kuka_setting(which, text[k])))

    def plain(self, number):
        callees = [k for k in range(number + 1, FILES)]
        k = self.rng.randint(0, 9)
        if k == 0:
            return self.state()
        if k < 4 and callees:
            callee = self.rng.choice(callees)
            name = self.rng.choice((f"F{callee}", f"F{callee}", f"EXTRA{callee}"))
            self.called.add(name)
            return f"{name}()"
        if k == 5:
            return "SUB()"
        if k == 6:
            name = self.rng.choice(("GA", "GB", "GC"))
            return self.rng.choice((f"{name}=CA", f"{name}=CB", f"{name}=GA", f"{name}.Z={name}.Z+3"))
        if k == 7:
            return f"LIN {self.rng.choice(('GA', 'GB', 'GC', 'CA'))}"
        return f"LIN {self.rng.choice((f'X{number}A', f'X{number}B', self.point()))}"

    def block(self, number):
        lines = [self.plain(number) for _ in range(self.rng.randint(1, 4))]
        return self.rng.choice((lines, lines, ["IF $IN[1] THEN", *lines, "ENDIF"], ["FOR I=1 TO 2", *lines, "ENDFOR"],
                                ["IF $IN[1] THEN", *lines, "RETURN", "ENDIF"]))

    def write(self, number):
        states_all = f"F{number}" not in self.called or self.rng.random() < 0.2
        body = ["$BASE=BASE_DATA[1]", f"$TOOL=TOOL_DATA[{self.rng.randint(1, 2)}]"] if states_all else []
        body += [f"PTP X{number}A"] + [line for _ in range(self.rng.randint(1, 3)) for line in self.block(number)]
        part = lambda: [line for line in self.block(number) if line != "SUB()"]
        lines = [f"DEF F{number}( )", *body, "END"]
        if "SUB()" in body:
            lines += ["DEF SUB()", *part(), "END"]
        if f"EXTRA{number}" in self.called:
            lines += [f"GLOBAL DEF EXTRA{number}()", *part(), "END"]
        lines.append("")
        dat = [f"DEFDAT F{number}", f"DECL E6POS X{number}A={self.point()}", f"DECL E6POS X{number}B={self.point()}", "ENDDAT", ""]
        self.texts[f"R1/Program/f{number}.src"] = "\r\n".join(lines)
        self.texts[f"R1/Program/f{number}.dat"] = "\r\n".join(dat)

    def entries(self):
        """What an operator starts: all that no program calls."""
        return [f"F{number}" for number in range(FILES) if f"F{number}" not in self.called]


def moves(texts, seed, entry, submit):
    """SUB of each program is its own."""
    src = "\n".join(text.replace("SUB()", f"SUB{name[-5]}()") for name, text in texts.items() if name.endswith(".src"))
    dat = "\n".join(text for name, text in texts.items() if name.endswith(".dat"))
    return krl_machine.Machine(src, dat, single.inputs(seed), entry, submit).moves


class KrlCallsTest(unittest.TestCase):
    def corrected(self, folder, writer, robot):
        out = folder / robot.replace(".yaml", "-out")
        for path, text in writer.texts.items():
            (folder / "in" / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / "in" / path).write_bytes(text.encode())
        run = subprocess.run([BIN / "compensate", "--robot", folder / robot, "--controller", folder / "nominal.yaml", "--max-mm", "50",
                              "--project", folder / "in", "--project-out", out], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        rows = list(csv.DictReader(io.StringIO(run.stdout)))
        return {path: (out / path).read_bytes().decode() for path in writer.texts}, rows, run.stderr

    def test_each_move_ends_where_it_is_programmed_or_is_left_as_it_is(self):
        hits, left, of_callers, shared = 0, 0, 0, 0
        for number in range(PROJECTS):
            cell = programs.Cell("krl", 7000 + number)
            writer = Writer(cell)
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                (folder / "nominal.yaml").write_text(cell.nominal_text)
                (folder / "true.yaml").write_text(cell.true_text)
                same, _, _ = self.corrected(folder, writer, "nominal.yaml")
                self.assertEqual(same, writer.texts, number)
                texts, rows, said = self.corrected(folder, writer, "true.yaml")
            of_callers += "those with which other programs call this one" in said
            for entry in writer.entries():
                for seed in range(3):
                    try:
                        before = moves(writer.texts, seed, entry, writer.submit)
                    except AssertionError:  # too many moves
                        continue
                    after = moves(texts, seed, entry, writer.submit)
                    self.assertEqual(len(before), len(after), number)
                    for programmed, commanded in zip(before, after):
                        where = f"project {number}, {entry}: {programmed.line}: {programmed.text} -> {commanded.text}"
                        if single.KrlProgramsTest.error_of(self, cell, programmed, commanded, writer.q) < single.NEAR_MM:
                            hits += 1
                            shared += " G" in programmed.text
                            continue
                        left += 1
                        self.assertEqual(programmed.text, commanded.text, where)
                        self.assertLess(vc.length(vc.sub(programmed.value[1], commanded.value[1])), single.SAME_MM, where)
        print(f"{hits} moves corrected, {shared} of them to global points that programs set, {left} left alone; {of_callers} projects "
              "with frames of callers")
        self.assertGreater(shared, PROJECTS)
        self.assertGreater(hits, left / 5)
        self.assertGreater(of_callers, PROJECTS / 3)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1])
