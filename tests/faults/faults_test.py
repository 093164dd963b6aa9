#!/usr/bin/env python3
"""Walks through the system calls of each command: each one on a file of the folder fails once, and before each one that
changes the folder the process is killed once. A product is then the new one or the old one, whole; products that belong
together are of one run; inputs stay; the exit code is 1 with a sentence, or 0 with the whole product.

    faults_test.py INJECT BIN [COMMAND...]
"""

import collections
import errno
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config"
CERTIFY = pathlib.Path(__file__).resolve().parents[1] / "cli/certify"
INJECT = BIN = None
ERRORS = {"read": errno.EIO, "open": errno.EACCES}  # others: the disk is full
CHANGES = {"open", "write", "rename", "unlink", "mkdir", "rmdir"}
KILLED = 137
START = "10,-60,80,5,40,-10"

PROGRAM = """DEF  part( )
$TOOL={X 0,Y 0,Z 150,A 0,B 0,C 0}
PTP {A1 10,A2 -60,A3 80,A4 5,A5 40,A6 -10}
LIN XP1
END
"""
DATA = """DEFDAT PART
DECL E6POS XP1={X 2180.0,Y -470.0,Z 1440.0,A 73.0,B 1.5,C -28.5,S 18,T 34,E1 5.0}
ENDDAT
"""
LINE = """DEF line( )
PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}
LIN XP1 C_DIS
LIN XP2
END
"""
LINE_DATA = """DEFDAT LINE
DECL E6POS XP1={X -100,Y -1650,Z 850,A 0,B 0,C 0}
DECL E6POS XP2={X 200,Y -1650,Z 850,A 0,B 0,C 0}
ENDDAT
"""
# Little to look for, so that the search is short.
ONE_EFFECT = """format: armtrue-catalogue/1
effects:
  - {name: backlash, parameter: theta, driver: arrival own, shape: sign}
"""
TABLE = "Point;X (mm);Y (mm);Z (mm);A1;A2;A3;A4;A5;A6\nP1;1000;0;1500;0;-90;90;0;10;0\n"

# Of each command: its arguments, and the products that are of one run. The robot is r.yaml, closed.yaml a calibrated
# one, m.csv a campaign, pass.csv a recorded pass of path.csv.
COMMANDS = {
    "convert-robot": ("r.yaml --to urdf -o robot.urdf", ["robot.urdf"]),
    "check-robot": ("r.yaml --at 10,-80,100,20,30,-40 -o report", ["report"]),
    "simulate-poses": ("--robot r.yaml --count 5 --seed 7 -o p.csv", ["p.csv"]),
    "plan-poses": ("--robot r.yaml --count 9 -o targets.csv", ["targets.csv"]),
    "import-readings": ("table.csv --angle-unit deg -o imported.csv", ["imported.csv"]),
    "calibrate": ("--robot r.yaml m.csv -o calibrated.yaml --residuals residuals.csv",
                  ["calibrated.yaml"], ["residuals.csv"]),
    "evaluate-poses": ("--robot r.yaml m.csv --plots pictures -o summary.yaml", ["summary.yaml"], ["pictures"]),
    "trace-residual": ("--since closed.yaml m.csv -o change.yaml", ["change.yaml"]),
    "close-loop": ("--robot r.yaml m.csv --only-catalogue --catalogue few.yaml --held-out 0 --robot-out closed2.yaml "
                   "-o loop.yaml", ["closed2.yaml"], ["loop.yaml"]),
    "compare-runs": ("--before closed.yaml closed.yaml -o comparison.yaml", ["comparison.yaml"]),
    "compensate": ("--robot closed.yaml --controller r.yaml --program part.src --program-out fresh.src",
                   ["fresh.dat", "fresh.src"]),
    "map-errors": (f"--robot closed.yaml --controller r.yaml --box-mm 1500,1600,0,100,1000,1100 --grid 2,2,2 "
                   f"--start {START} -o map.csv --summary map.yaml", ["map.csv"], ["map.yaml"]),
    "simulate-path": ("--robot r.yaml --orientation-deg 0,0,0 --start-deg 0,-90,90,0,0,0 path.csv -o run.csv",
                      ["run.csv"]),
    "mirror-correct": ("--programmed path.csv --measured pass.csv --program line.src --program-out cut.src -o cut.csv",
                       ["cut.dat", "cut.src"], ["cut.csv"]),
    "certify": ("--robot r.yaml --about about.yaml five.csv -o certificate.yaml", ["certificate.yaml"]),
}


def run(*arguments, cwd):
    return subprocess.run(list(map(str, arguments)), cwd=cwd, capture_output=True, text=True, errors="replace")


def contents(folder):
    """What stands in a folder, by name."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def write_inputs(folder):
    def make(command, *arguments):
        done = run(BIN / command, *arguments, cwd=folder)
        assert done.returncode == 0, done.stderr
    shutil.copy(CONFIG / "robots/kr360-spindle.yaml", folder / "r.yaml")
    shutil.copy(CERTIFY / "about.yaml", folder / "about.yaml")
    (folder / "few.yaml").write_text(ONE_EFFECT)
    (folder / "table.csv").write_text(TABLE)
    for name, text in (("part.src", PROGRAM), ("part.dat", DATA), ("line.src", LINE), ("line.dat", LINE_DATA)):
        (folder / name).write_text(text)
    lines = (CONFIG / "paths/line300.csv").read_text().splitlines()
    (folder / "path.csv").write_text("\n".join(lines) + "\n")
    make("simulate-poses", "--robot", "r.yaml", "--count", 30, "--repeats", 2, "--noise-mm", 0.095, "--noise-mrad",
         0.15, "-o", "m.csv")
    make("simulate-poses", "--robot", "r.yaml", "--count", 5, "--repeats", 6, "--noise-mm", 0.02, "--points", "-o",
         "five.csv")
    make("calibrate", "--robot", "r.yaml", "m.csv", "-o", "closed.yaml")
    make("simulate-path", "--robot", CONFIG / "robots/kr360-roughing.yaml", "--noise-mm", 0.095, "path.csv", "-o",
         "pass.csv")


class Faults(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.inputs = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.inputs.cleanup)
        write_inputs(pathlib.Path(cls.inputs.name))

    def setUp(self):
        self.place = tempfile.TemporaryDirectory()
        self.addCleanup(self.place.cleanup)
        self.given = pathlib.Path(self.place.name) / "given"
        shutil.copytree(self.inputs.name, self.given)

    @staticmethod
    def is_of(path, product):
        return path == product or path.startswith(product + "/")

    def start(self, command, arguments, call, fault):
        """Runs in a copy of the folder; the exit code, stderr, the calls, and what the folder holds then."""
        folder = pathlib.Path(self.place.name) / "run"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.given, folder)
        report = pathlib.Path(self.place.name) / "report"
        done = run(INJECT, f"{folder}", call, fault, report, BIN / command, *arguments.split(), cwd=folder)
        return done.returncode, done.stderr, report.read_text().split(), contents(folder)

    def check(self, what, sets, new, old, inputs, code, error, now, killed=False,
              removal_failed=False):
        for name, content in inputs.items():
            self.assertEqual(now.get(name), content, f"{what}: the input {name} is changed")
        for products in sets:
            own = {name: content for name, content in now.items() if any(self.is_of(name, p) for p in products)}
            of_new = {name: content for name, content in new.items() if any(self.is_of(name, p) for p in products)}
            of_old = {name: content for name, content in old.items() if any(self.is_of(name, p) for p in products)}
            if killed and len(products) > 1 and own not in (of_new, of_old):  # old ones are set aside
                kept = list(now.values())
                self.assertTrue(all(text in kept for text in of_old.values()), f"{what}: {products} are lost")
                self.assertTrue(all(own[name] in (of_new[name], of_old[name]) for name in own), what)
                continue
            self.assertIn(own, (of_new, of_old), f"{what}: {products} are neither old nor new")
            if code == 0:
                self.assertEqual(own, of_new, f"{what}: exit 0 without {products}")
        if killed:
            return
        left = [name for name in now if ".part" in name or ".old" in name]
        if not removal_failed:
            self.assertEqual(left, [], f"{what}: temporary files are left")
        self.assertIn(code, (0, 1), f"{what}: {error}")
        if code == 1:
            self.assertRegex(error, r"\w+: .{10,}", f"{what}: no sentence")

    def walk(self, command):
        arguments, *sets = COMMANDS[command]
        before = contents(self.given)
        code, error, calls, after = self.start(command, arguments, 0, 0)
        self.assertEqual(code, 0, error)
        products = [product for products in sets for product in products]
        new = {name: text for name, text in after.items() if any(self.is_of(name, p) for p in products)}
        self.assertTrue(new)
        # From here on there are products of an earlier run.
        old = {}
        for name, text in new.items():
            old[name] = text + (b"<!-- old -->" if name.endswith(".svg") else b"# old\n")
            (self.given / name).parent.mkdir(exist_ok=True)
            (self.given / name).write_bytes(old[name])
        code, error, calls, after = self.start(command, arguments, 0, 0)
        self.assertEqual(code, 0, error)
        self.check(command, sets, new, old, before, code, error, after)
        faults = 0
        times = collections.Counter()
        for number, call in enumerate(calls, 1):
            # Of calls among the same others, one.
            beside = tuple(calls[max(0, number - 3):number + 2])
            times[beside] += 1
            if times[beside] > 1:
                continue
            code, error, _, now = self.start(command, arguments, number, ERRORS.get(call, errno.ENOSPC))
            # What cannot be removed stays.
            removal_failed = call in ("unlink", "rmdir") or set(calls[number:]) <= {"close", "unlink", "rmdir"}
            self.check(f"{command}: {call} {number} of {calls} fails", sets, new, old, before, code, error, now,
                       removal_failed=removal_failed)
            faults += 1
            if call in CHANGES and "read" not in calls[number:]:
                code, error, _, now = self.start(command, arguments, number, 0)
                self.assertEqual(code, KILLED, f"{command}: not killed at {call} {number}")
                self.check(f"{command}: killed before {call} {number} of {calls}", sets, new, old, before, code, error,
                           now, killed=True)
                faults += 1
        return faults


for name in COMMANDS:
    setattr(Faults, "test_" + name.replace("-", "_"), lambda self, name=name: self.assertGreater(self.walk(name), 10))


if __name__ == "__main__":
    INJECT, BIN = (pathlib.Path(name).resolve() for name in sys.argv[1:3])
    sys.argv[1:] = ["Faults.test_" + name.replace("-", "_") for name in sys.argv[3:]]
    unittest.main()
