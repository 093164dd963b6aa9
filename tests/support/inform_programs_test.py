#!/usr/bin/env python3
"""Random jobs of Yaskawa, with positions of several kinds, frames and tools, jumps, branches, variables, shifts and relative
moves. A controller of its own runs each of them as it is and corrected, with the same inputs; the true arm goes where the
controller's model says. Each move ends at its programmed pose, or the job says the same of it as before. Nothing here shares
code with armtrue.

    inform_programs_test.py BIN [--programs N] [--keep FOLDER]
"""

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

import inform_machine
import robot_programs_test as programs
import virtual_cell as vc

BIN = None
PROGRAMS = int(sys.argv[sys.argv.index("--programs") + 1]) if "--programs" in sys.argv else 20
KEEP = pathlib.Path(sys.argv[sys.argv.index("--keep") + 1]) if "--keep" in sys.argv else None
NEAR_MM = 0.02      # what rounding may leave
PULSES_MM = 0.06    # the same of half a pulse of each axis
BETWEEN_MM = 0.002  # what is asked of the error between points


class Writer:
    """Writes one job; all joint angles are `spread` [rad] around one posture at most."""

    def __init__(self, cell, spread):
        self.cell, self.rng, self.spread = cell, cell.rng, spread
        while True:
            side = self.rng.choice((-1, 1))
            self.q = cell.posture((-100, 100), (-20, 40), (-40, 40), (-90, 90), (side * 35, side * 95), (-150, 150))
            if programs.wrist(cell.nominal, self.q)[0] > 400:
                break
        self.heads = {}
        self.positions, self.count = [], 0
        self.variables = [f"P{k:03}" for k in range(4)]
        self.labels = 0
        self.others = {}  # jobs that it calls, by their names
        self.pulses = None  # per deg of each axis, if positions in pulses are those of the posture
        self.kinds = (12, 1, 1)  # how often a step is a pose, joint angles, pulses
        self.frames = lambda: (self.rng.choice((None, 1, 2)), self.rng.choice((0, 1)))

    def head(self, **wanted):
        for name, value in wanted.items():
            if self.heads.get(name) != value or (name in ("DATA", "RCONF") and self.heads["new"]):
                self.positions.append(f"///{value}" if name == "DATA" else f"///{name} {value}")
            self.heads["new"] = name == "POSTYPE" and self.heads.get(name) != value or (self.heads.get("new") and name != "RCONF")
            self.heads[name] = value

    def position(self, name, kind, frames=None):
        q = [a + self.rng.uniform(-self.spread, self.spread) for a in self.q]
        user, tool = frames or self.frames()
        if kind == "pulses":
            self.head(TOOL=tool, POSTYPE="PULSE", DATA="PULSE")
            numbers = ",".join(str(round(math.degrees(a) * self.pulses[i]) if self.pulses else self.rng.randint(-90000, 90000))
                               for i, a in enumerate(q))
        elif kind == "joints":
            self.head(TOOL=tool, POSTYPE="ANGLE", DATA="ANGLE")
            numbers = ",".join(f"{math.degrees(a):.4f}" for a in q)
        else:
            if user:
                self.head(USER=user)
            flip, low = int(q[4] < 0), int(not programs.is_elbow_up(self.cell.nominal, q))
            self.head(TOOL=tool, POSTYPE="USER" if user else self.rng.choice(("ROBOT", "BASE")), DATA="RECTAN",
                      RCONF=f"{flip},{low},0,0,0,0,0,0")
            motion = self.cell.written(q, self.cell.bases[user - 1] if user else vc.NONE, self.cell.tools[tool])
            c, b, a = reversed(vc.kuka(motion[0]))
            numbers = "{:.3f},{:.3f},{:.3f},{:.4f},{:.4f},{:.4f}".format(*motion[1], c, b, a)
        self.positions.append(f"{name}={numbers}")

    def step(self, kind=None):
        """The name of a new position, or of an old one."""
        if self.count > 3 and self.rng.random() < 0.2 and not kind:
            return f"C{self.rng.randrange(self.count):05}"
        kind = kind or self.rng.choices(("pose", "joints", "pulses"), self.kinds)[0]
        name = f"C{self.count:05}"
        self.count += 1
        self.position(name, kind)
        return name

    def move(self):
        end = self.rng.choice(("", " PL=0", " PL=3", " CR=2.0", " ACC=60", " NWAIT"))
        k = self.rng.randint(0, 11)
        if k == 0:
            return [f"MOVC {self.step('pose')} V=50.0" for _ in range(self.rng.choice((3, 3, 5, 1)))]
        if k == 1:
            return [f"MOVL {self.rng.choice(self.variables)} V=80.0{end}"]
        if k == 2:
            return [f"IMOV {self.rng.choice(self.variables)} V=20.0 BF"]
        if k == 3:
            return [f"SET {self.rng.choice(self.variables[2:])} {self.rng.choice(self.variables)}"]
        if k == 4:
            return [f"SFTON {self.variables[0]}", *self.move(), "SFTOF"]
        if k == 5 and self.others:
            return [f"CALL JOB:{self.rng.choice(list(self.others))}" + self.rng.choice(("", " IF IN#(3)=ON"))]
        if k == 5:
            return ["DOUT OT#(1) ON", "'a comment with C00000"]
        if k == 6:
            return [f"MOVJ {self.step()} VJ=25.00{end}"]
        if k == 7:
            return [f"MOVS {self.step('pose')} V=30.0" for _ in range(3)]
        return [f"MOVL {self.step('pose' if k > 9 else None)} V=100.0{end}" for _ in range(2)]

    def block(self, depth):
        if depth == 0:
            return [line for _ in range(self.rng.randint(1, 4)) for line in self.move()]
        inner = lambda: self.block(depth - 1)
        k = self.rng.randint(0, 4)
        if k == 0:
            return ["IFTHENEXP IN#(1)=ON", *inner(), "ENDIF"]
        if k == 1:
            return ["IFTHENEXP IN#(1)=ON", *inner(), "ELSE", *inner(), "ENDIF"]
        if k == 2:
            self.labels += 1
            label = f"*L{self.labels}"
            return [f"JUMP {label} IF IN#(2)=ON", *inner(), label]
        if k == 3:
            self.labels += 1
            label = f"*L{self.labels}"
            return [label, *inner(), f"JUMP {label} IF IN#(2)=OFF"]
        return inner()

    def write_others(self):
        """Jobs that set variables, or call others that do."""
        setting = lambda: f"SET {self.rng.choice(self.variables[1:])} {self.rng.choice(self.variables)}"
        for name in ("LAST", "GRIP-1", "GRIP-2"):
            body = ["DOUT OT#(1) ON", *[setting() for _ in range(self.rng.choice((0, 0, 2)))]]
            body += [f"CALL JOB:{self.rng.choice(list(self.others))}"] if self.others and self.rng.random() < 0.5 else []
            self.others[name] = "\n".join(["/JOB", f"//NAME {name}", "//POS", "///NPOS 0,0,0,0,0,0", "//INST",
                                           "///DATE 2024/03/11 09:42", "NOP", *body, "END", ""])

    def write(self):
        body = [f"MOVJ {self.step('pose')} VJ=10.00"]
        body += [line for _ in range(self.rng.randint(3, 6)) for line in self.block(self.rng.randint(0, 2))]
        if self.rng.random() < 0.3:
            body.insert(self.rng.randrange(1, len(body)), "SFTON P000 UF#(1)")
        body.append(f"MOVL {self.step('pose')} V=100.0")
        steps = list(self.positions)
        self.positions = []
        for k, name in enumerate(self.variables):
            self.position(f"P{k:05}", "pose", (1, 0))
        eol = self.rng.choice(("\r\n", "\n"))
        return eol.join(["/JOB", "//NAME PART", "//POS", f"///NPOS {self.count},0,0,{len(self.variables)},0,0", *steps,
                         *self.positions, "//INST", "///DATE 2024/03/11 09:42", "///ATTR SC,RW,RJ", "///GROUP1 RB1", "NOP",
                         *body, "END", ""])


def parameters(rng, is_new):
    """RC.PRM of a controller of the newer or the older generation: the gear ratios and limits of two robots. Beside it the
    pulses per deg of the first one."""
    size, limits, denominators, numerators = (3000, 1030, 1090, 1100) if is_new else (1700, 924, 972, 980)
    text, first = "//RC YAS\r\n///RCD\r\n20,100,1\r\n", None
    for robot in (1, 2):
        numbers, pulses = [rng.randrange(100) for _ in range(size)], []
        for i in range(6):
            numbers[denominators + i], numbers[numerators + i] = rng.choice((-1, 1)) * rng.randint(1, 9), rng.randint(300, 900)
            pulses.append(4096 * numbers[numerators + i] / abs(numbers[denominators + i]) / 360)
            numbers[limits + i] = round(180 * pulses[i])
        numbers[denominators + 6] = numbers[numerators + 6] = 0
        text += f"///RC{robot}G\r\n" + "".join(",".join(map(str, numbers[k:k + 10])) + "\r\n" for k in range(0, size, 10))
        first = first or pulses
    return text, first


def inputs(seed):
    rng, count = random.Random(seed), 0

    def value():
        nonlocal count
        count += 1
        return rng.random() < (0.5 if count < 100 else 1.0)
    return value


class InformProgramsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(KEEP or tempfile.mkdtemp())
        self.folder.mkdir(exist_ok=True)

    def given(self, number, spread=0.03, with_others=False, pulses=None):
        cell = programs.Cell("inform", 500 + number)
        writer = Writer(cell, spread)
        if pulses:
            writer.pulses, writer.kinds = pulses, (2, 1, 6)
        if with_others:
            writer.write_others()
        text = writer.write()
        (self.folder / "part.jbi").write_bytes(text.encode())
        (self.folder / "nominal.yaml").write_text(cell.nominal_text)
        (self.folder / "true.yaml").write_text(cell.true_text)
        return cell, writer, text

    def corrected(self, cell, robot, *options):
        shutil.rmtree(self.folder / "new", ignore_errors=True)
        (self.folder / "new").mkdir()
        frames = []
        for name, first, motions in (("USER", 1, cell.bases), ("TOOL", 0, cell.tools)):
            for k, motion in enumerate(motions, first):
                frames += ["--frame", f"{name}[{k}]=" + ",".join(map(repr, [*motion[1], *vc.kuka(motion[0])]))]
        run = subprocess.run([BIN / "compensate", "-q", "--robot", robot, "--controller", "nominal.yaml", *(
            options if "--project" in options else ["--program", "part.jbi", "--program-out", "new/part.jbi", *options]),
                              "--max-mm", "50", *frames], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        return (self.folder / "new/part.jbi").read_bytes().decode()

    def run_job(self, cell, text, seed, others=(), pulses=None):
        users, tools = dict(enumerate(cell.bases, 1)), dict(enumerate(cell.tools))
        try:
            return inform_machine.Machine(text, inputs(seed), users, tools, others, pulses).moves
        except AssertionError:  # it goes on for ever
            return None

    def reached(self, cell, commanded, start):
        """Where the TCP of the true arm is; lengths in mm."""
        if commanded.kind == "joints":
            q = [math.radians(a) for a in commanded.value]
        else:
            q = programs.joints_at(cell.nominal, vc.after(vc.after(commanded.base, commanded.value),
                                                          programs.inverse(commanded.tool)), start)
        return vc.after(cell.true.pose(q), commanded.tool)[1]

    def wanted(self, cell, move, tool=None):
        """The programmed place of the TCP, or that of another tool there."""
        if move.kind == "joints":
            return vc.after(cell.nominal.pose([math.radians(a) for a in move.value]), tool or move.tool)[1]
        here = vc.after(move.base, move.value)
        return vc.after(vc.after(here, programs.inverse(move.tool)), tool)[1] if tool else here[1]

    def test_each_move_ends_where_it_is_programmed_or_is_left_as_it_is(self):
        hits, left, joints, variables = 0, 0, 0, 0
        for number in range(PROGRAMS):
            cell, writer, text = self.given(number)
            self.assertEqual(self.corrected(cell, "nominal.yaml"), text, number)
            corrected = self.corrected(cell, "true.yaml")
            job = inform_machine.Job(corrected)
            self.assertEqual(job.counted[0], job.count("C"), number)
            for seed in range(3):
                before, after = self.run_job(cell, text, seed), self.run_job(cell, corrected, seed)
                if before is None:
                    continue
                self.assertEqual(len(before), len(after), number)
                for programmed, commanded in zip(before, after):
                    where = f"job {number}: {programmed.line}: {programmed.text} -> {commanded.text}"
                    self.assertEqual((programmed.kind, programmed.shift), (commanded.kind, commanded.shift), where)
                    if programmed.kind != "other" and not programmed.shift:
                        off = vc.length(vc.sub(self.reached(cell, commanded, writer.q), self.wanted(cell, programmed)))
                        if off < NEAR_MM:
                            hits += 1
                            joints += programmed.kind == "joints"
                            variables += " P" in programmed.text[:9]
                            continue
                    left += 1
                    self.assertEqual(programmed, commanded._replace(line=programmed.line), where)
        print(f"{hits} moves corrected, {joints} of them joint angles and {variables} to variables; {left} left alone")
        self.assertGreater(hits, left)
        self.assertGreater(min(joints, variables), PROGRAMS // 4)

    def test_pulses_are_angles_by_the_files_of_the_controller(self):
        hits = 0
        for number in range(PROGRAMS):
            text_of_files, pulses = parameters(random.Random(number), number % 2)
            cell, writer, text = self.given(number, pulses=pulses)
            (self.folder / "RC.PRM").write_text(text_of_files)
            options = ["--with", "RC.PRM"]
            self.assertEqual(self.corrected(cell, "nominal.yaml", *options), text, number)
            corrected = self.corrected(cell, "true.yaml", *options)
            for seed in range(3):
                before, after = (self.run_job(cell, t, seed, pulses=pulses) for t in (text, corrected))
                if before is None:
                    continue
                self.assertEqual(len(before), len(after), number)
                for programmed, commanded in zip(before, after):
                    if programmed.kind != "joints" or programmed.shift:
                        continue
                    off = vc.length(vc.sub(self.reached(cell, commanded, writer.q), self.wanted(cell, programmed)))
                    if off > PULSES_MM:  # left alone, as another point of its arc is
                        self.assertEqual(programmed, commanded._replace(line=programmed.line), f"job {number}: {programmed.text}")
                    hits += off < PULSES_MM
        print(f"{hits} moves to joint angles and pulses corrected")
        self.assertGreater(hits, 3 * PROGRAMS)

    def test_a_job_of_a_folder_knows_what_the_jobs_that_it_calls_set(self):
        hits, left, calls = 0, 0, 0
        for number in range(PROGRAMS):
            cell, writer, text = self.given(number, with_others=True)
            jobs = self.folder / "jobs"
            jobs.mkdir(exist_ok=True)
            for name, job in {**writer.others, "part": text}.items():
                (jobs / f"{name}.jbi").write_bytes(job.encode())
            options = ["--project", "jobs", "--project-out", "new"]
            self.assertEqual(self.corrected(cell, "nominal.yaml", *options), text, number)
            corrected = self.corrected(cell, "true.yaml", *options)
            calls += "CALL" in text
            for seed in range(3):
                before, after = (self.run_job(cell, t, seed, writer.others) for t in (text, corrected))
                if before is None:
                    continue
                self.assertEqual(len(before), len(after), number)
                for programmed, commanded in zip(before, after):
                    if programmed.kind == "other" or programmed.shift or " P" not in programmed.text[:9]:
                        continue
                    off = vc.length(vc.sub(self.reached(cell, commanded, writer.q), self.wanted(cell, programmed)))
                    if off < NEAR_MM:
                        hits += "CALL" in text
                        continue
                    left += 1
                    self.assertEqual(programmed, commanded._replace(line=programmed.line), f"job {number}: {programmed.text}")
        print(f"{hits} moves to variables corrected in {calls} jobs that call others; {left} left alone")
        self.assertGreater(hits, PROGRAMS // 4)
        self.assertGreater(left, PROGRAMS // 2)

    def test_points_between_lie_on_the_way(self):
        inserted = 0
        for number in range(PROGRAMS // 3):
            cell, writer, text = self.given(number, 0.12)
            divided = self.corrected(cell, "true.yaml", "--spacing-mm", str(BETWEEN_MM))
            job = inform_machine.Job(divided)
            self.assertEqual(job.counted[0], job.count("C"), number)
            known = inform_machine.Job(text)
            before, after = self.run_job(cell, text, 1), self.run_job(cell, divided, 1)
            if before is None:
                continue
            # The moves of the job stay in their order; the others are new.
            place, start = 0, None
            for at, move in enumerate(after):
                programmed = before[place]
                is_here = move.text.split()[0] == programmed.text.split()[0] and (
                    move.text == programmed.text or not self.is_inserted(move, known)
                    or self.is_end(cell, move, programmed, writer))
                if is_here:
                    start, place = programmed, place + 1
                    continue
                inserted += 1
                self.assertTrue(move.text.startswith("MOVL ") and start, move.text)
                self.assertNotRegex(move.text, "PL=|CR=")
                a, b = self.wanted(cell, start, programmed.tool), self.wanted(cell, programmed)
                here = self.reached(cell, move, writer.q)
                along = vc.sub(b, a)
                t = vc.dot(vc.sub(here, a), along) / vc.dot(along, along)
                self.assertTrue(0 < t < 1, f"job {number}: {move.text}")
                off = vc.length(vc.sub(here, tuple(p + t * d for p, d in zip(a, along))))
                self.assertLess(off, NEAR_MM, f"job {number}: {move.text}")
            self.assertEqual(place, len(before), number)
        print(f"{inserted} moves inserted")
        self.assertGreater(inserted, PROGRAMS)

    @staticmethod
    def is_inserted(move, known):
        return inform_machine.Machine.name(move.text.split()[1]) not in known.positions

    def is_end(self, cell, move, programmed, writer):
        """A move that got a position of its own."""
        if move.kind == "other" or programmed.kind == "other" or move.shift or programmed.shift:
            return False
        return vc.length(vc.sub(self.reached(cell, move, writer.q), self.wanted(cell, programmed))) < NEAR_MM


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1])
