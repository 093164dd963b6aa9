#!/usr/bin/env python3
"""Programs of each of four makers, sixty if no number is given: the same bytes without a correction; with one nothing but numbers and a comment
differs, and a controller of its own, given these numbers, drives a true arm to the programmed targets. The corrected program
is refused, also without its comments, in other letters, with other blanks, line ends and another name, and if its poses are
saved with three decimals (quaternions and joint angles as they are).

    program_corpus_test.py BIN [--files N] [--from NUMBER] [--keep FOLDER]
"""

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
FILES = int(sys.argv[sys.argv.index("--files") + 1]) if "--files" in sys.argv else 60
FIRST = int(sys.argv[sys.argv.index("--from") + 1]) if "--from" in sys.argv else 0
KEEP = pathlib.Path(sys.argv[sys.argv.index("--keep") + 1]) if "--keep" in sys.argv else None
# What rounding leaves [mm], of poses and of joint angles. Check digits move each coordinate of a pose by up to 3.2 um.
LEFT_MM = {"krl": (6e-3, 1e-2), "rapid": (6e-3, 1e-3), "urscript": (6e-3, 1e-3), "fanuc": (6e-3, 0.1)}


def reformatted(dialect, text):
    """The same program for its controller, without a comment."""
    text = text.replace("corpus", "other").replace("CORPUS", "OTHER")
    if dialect == "fanuc":
        return rp.without_mark(text)
    lines = re.sub(r"\r?\n", "\n", text).split("\n")
    comment = {"krl": ";", "rapid": "!", "urscript": "#"}[dialect]
    lines = [line for line in lines if not line.lstrip().startswith(comment) or "FOLD" in line]
    if dialect != "urscript":
        lines = [" " + line.lower() + " " if '"' not in line else line for line in lines]
    return re.sub(r" ?, ?", " ,  ", "\r\n".join(lines))


def with_three_decimals(dialect, text):
    """Rounds the coordinates of poses, of UR in m to six, of KRL and FANUC all numbers."""
    most = 6 if dialect == "urscript" else 3
    short = lambda number: number[0] if len(number[0].split(".")[1]) <= most else f"{float(number[0]):.{most}f}"
    if dialect == "rapid":
        return re.sub(r"(\[\[)([-\d., ]+)(\])", lambda m: m[1] + re.sub(r"-?\d+\.\d+", short, m[2]) + m[3], text)
    return re.sub(r"-?\d+\.\d+", short, text)


# Numbers of poses: twelve show it, a tenth ends with 0 and says nothing, and a point may leave some out.
ENOUGH = 20


class Corpus(unittest.TestCase):
    def run_dialect(self, dialect):
        kinds, left_alone = set(), 0
        for number in range(FIRST, FIRST + FILES):
            file = pc.corpus_file(dialect, number)
            with self.subTest(dialect=dialect, number=number), tempfile.TemporaryDirectory() as folder:
                self.run_file(dialect, file, pathlib.Path(folder))
            kinds |= {target.kind for target in file.targets}
            left_alone += file.left_alone
        self.assertEqual(kinds, {"pose", "joints"})
        self.assertGreater(left_alone, FILES // 10)

    def run_file(self, dialect, file, folder):
        extension = pc.MAKERS[dialect][1]
        texts = [file.plain(text) for text in file.texts]
        (folder / "nominal.yaml").write_text(file.cell.nominal_text)
        (folder / "true.yaml").write_text(file.cell.true_text)
        (folder / "new").mkdir()
        names = [file.name + extension, file.name + ".dat"][:len(texts)]
        for name, text in zip(names, texts):
            (folder / name).write_bytes(text.encode())
            if KEEP:
                KEEP.mkdir(parents=True, exist_ok=True)
                (KEEP / name).write_bytes(text.encode())
        frames = []
        for name, motion in file.frames:
            frames += ["--frame", f"{name}=" + ",".join(map(repr, [*motion[1], *vc.kuka(motion[0])]))]

        def run(robot, program):
            return subprocess.run([BIN / "compensate", "-v", "--robot", folder / robot, "--controller", folder / "nominal.yaml",
                                   "--program", program, "--program-out", folder / "new" / names[0], "--max-mm", "50",
                                   *frames], capture_output=True, text=True)

        def compensate(robot):
            done = run(robot, folder / names[0])
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(f" {file.left_alone} move{'' if file.left_alone == 1 else 's'} left alone", done.stderr)
            return [(folder / "new" / name).read_bytes().decode() for name in names]

        self.assertEqual(compensate("nominal.yaml"), texts)
        corrected = compensate("true.yaml")
        self.assertTrue(any(rp.without_mark(text) != text for text in corrected))
        found, added = file.read_back([rp.without_mark(text) for text in corrected])
        self.assertIsNotNone(found, "other bytes than numbers differ")
        self.judge(dialect, file, found, iter(added))
        (folder / "again").mkdir()
        plain = [reformatted(dialect, text) for text in corrected]
        versions = [(corrected, "this comment says"), (plain, "last digits")]
        if 6 * sum(target.kind == "pose" for target in file.targets) >= ENOUGH:
            versions.append(([with_three_decimals(dialect, text) for text in plain], "last digits"))
        for texts, word in versions:
            for name, text in zip(names, texts):
                (folder / "again" / name.replace("corpus", "other")).write_bytes(text.encode())
            done = run("true.yaml", folder / "again" / names[0].replace("corpus", "other"))
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(word, done.stderr)

    def judge(self, dialect, file, found, added):
        cell, moved, own = file.cell, 0.0, set()
        for target in file.targets:
            was = [float(file.values[i]) for i in target.numbers]
            now = [float(found[i]) for i in target.numbers]
            if own & set(target.numbers):  # left out, and added where the point before has changed
                more = next(added)
                now = now[:2] + [more.get(name, before) for name, before in zip("ZABC", now[2:])]
            own |= set(target.numbers)
            if target.kind == "joints":
                intended = vc.after(cell.nominal.pose(pc.joints_of(dialect, was)), target.tool)
                commanded = pc.joints_of(dialect, now)
            else:
                intended = vc.after(target.base, pc.pose_of(dialect, was))
                flange = vc.after(vc.after(target.base, pc.pose_of(dialect, now)), programs.inverse(target.tool))
                commanded = programs.joints_at(cell.nominal, flange, target.q)
            error = lambda q: programs.difference(intended, vc.after(cell.true.pose(q), target.tool))
            moved += vc.length(error(target.q)[:3])
            left = error(commanded)
            self.assertLess(vc.length(left[:3]), LEFT_MM[dialect][target.kind == "joints"])
            self.assertLess(vc.length(left[3:]), 2e-4)
        self.assertGreater(moved / len(file.targets), 0.1)

    def test_krl(self):
        self.run_dialect("krl")

    def test_rapid(self):
        self.run_dialect("rapid")

    def test_urscript(self):
        self.run_dialect("urscript")

    def test_fanuc(self):
        self.run_dialect("fanuc")


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=sys.argv[:1], verbosity=0)
