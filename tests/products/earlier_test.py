#!/usr/bin/env python3
"""Products that earlier versions wrote are read by this one, with the same figures.

    earlier_test.py BIN

A folder of tests/products/earlier holds the products of one version, and is never changed: calibrated.yaml, closed.json,
loop.yaml and ranking.json of nominal.yaml and readings.csv; summary.yaml, certificate.yaml of later.csv; corrected.src and
compensation.yaml of part.src.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import read_back  # noqa: E402

EARLIER = pathlib.Path(__file__).resolve().parent / "earlier"
BIN = pathlib.Path(sys.argv.pop(1)).resolve() if __name__ == "__main__" else None


def document(path):
    return yaml.safe_load(path.read_text())


class Earlier(unittest.TestCase):
    def each_version(self):
        versions = sorted(path for path in EARLIER.iterdir() if path.is_dir())
        self.assertTrue(versions)
        for version in versions:
            with self.subTest(version=version.name), tempfile.TemporaryDirectory() as folder:
                self.folder = pathlib.Path(folder)
                shutil.copytree(version, self.folder, dirs_exist_ok=True)
                yield

    def run_command(self, *words, codes=(0,)):
        done = subprocess.run([BIN / words[0], *words[1:]], cwd=self.folder, capture_output=True, text=True)
        self.assertIn(done.returncode, codes, f"{words}: {done.stderr}")
        return done.stdout

    def test_schemas_allow_them(self):
        for _ in self.each_version():
            products = [*self.folder.glob("*.yaml"), *self.folder.glob("*.json")]
            for path in products:
                if path.name != "about.yaml":  # which no command wrote
                    self.assertEqual(read_back.schema_mistakes(document(path)), [], path.name)

    def test_an_arm_predicts_what_it_did(self):
        for _ in self.each_version():
            self.run_command("evaluate-poses", "-q", "--robot", "closed.json", "later.csv", "-o", "now.yaml")
            now, then = document(self.folder / "now.yaml"), document(self.folder / "summary.yaml")
            for key, value in then["position_mm"].items():
                self.assertAlmostEqual(now["position_mm"][key], value, delta=1e-3 * value, msg=key)

    def test_a_program_is_corrected_as_it_was_and_not_twice(self):
        numbers = lambda path: [float(text) for text in re.findall(r"-?\d+\.\d+", path.read_text())]
        for _ in self.each_version():
            self.run_command("compensate", "-q", "--robot", "closed.json", "--controller", "nominal.yaml", "--program", "part.src",
                             "--program-out", "now.src")
            now, then = numbers(self.folder / "now.src"), numbers(self.folder / "corrected.src")
            self.assertEqual(len(now), len(then))
            for a, b in zip(now, then):
                self.assertAlmostEqual(a, b, delta=1e-3)  # mm and deg
            self.run_command("compensate", "-q", "--robot", "closed.json", "--controller", "nominal.yaml", "--program", "corrected.src",
                             "--program-out", "twice.src", codes=(1,))

    def test_findings_are_inputs(self):
        for _ in self.each_version():
            self.run_command("trace-residual", "-q", "--since", "calibrated.yaml", "later.csv", "-o", "since.yaml")
            self.run_command("compare-runs", "-q", "--before", "calibrated.yaml", "closed.json", "-o", "comparison.yaml")
            self.run_command("calibrate", "-q", "--robot", "calibrated.yaml", "--identify", "A3.theta", "later.csv", "-o", "again.yaml",
                             codes=(0, 3))
            self.run_command("certify", "-q", "--robot", "closed.json", "--about", "about.yaml", "--refit", "base,tool", "--against",
                             "certificate.yaml", "later.csv", "-o", "certificate-now.yaml", codes=(0, 3))
            for finding in ("loop.yaml", "ranking.json"):
                self.run_command("plan-poses", "-q", "--robot", "closed.json", "--separate", finding, "--count", "3", "-o", "plan.csv",
                                 codes=(0, 3))


if __name__ == "__main__":
    unittest.main()
