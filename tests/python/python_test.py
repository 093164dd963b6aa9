"""The Python module against the commands, for pytest. ARMTRUE_BIN: the folder of the commands."""

import base64
import contextlib
import csv
import hashlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile

import yaml

SOURCES = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCES / "apps" / "python"))

import armtrue  # noqa: E402
import armtrue_wheel  # noqa: E402

BIN = pathlib.Path(os.environ["ARMTRUE_BIN"])
ROBOT = armtrue.shipped("robots/kr360-spindle.yaml")
TRUTH = armtrue.shipped("robots/kr360-undeclared.yaml")
TUTORIAL = armtrue.shipped("campaigns/tutorial.csv")


def command(*words):
    return subprocess.run([str(BIN / words[0]), *map(str, words[1:])], check=True, capture_output=True, text=True).stdout


def read(text):
    """A product of a command by other readers than the module's."""
    if text.startswith("format: "):
        return yaml.safe_load(text)
    if not re.match(r"\w+,\w", text):
        return text

    def cell(column, value):
        if value == "" or column in ("pose", "session", "notes"):
            return value or None
        try:
            return float(value)
        except ValueError:
            return value

    return [{column: cell(column, value) for column, value in row.items()} for row in csv.DictReader(io.StringIO(text))]


def without_provenance(product):
    return {key: value for key, value in product.items() if key != "provenance"} if isinstance(product, dict) else product


@contextlib.contextmanager
def in_new_folder():
    with tempfile.TemporaryDirectory() as folder:
        before = os.getcwd()
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


class Functions(unittest.TestCase):
    def test_a_function_gives_what_its_command_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            loop, closed = pathlib.Path(folder, "loop.json"), pathlib.Path(folder, "closed.json")
            command("close-loop", "-q", "--robot", ROBOT, TUTORIAL, "-o", loop, "--robot-out", closed)
            result = armtrue.close_loop(ROBOT, TUTORIAL)
            product = json.loads(loop.read_text())
            for document in (product, result.product):  # names of the files of this call
                document.pop("provenance", None)
            self.assertEqual(result.product, product)
            robot, expected = result.robot, json.loads(closed.read_text())
            for document in (robot, expected):
                document.pop("provenance", None)
            self.assertEqual(robot, expected)
            self.assertTrue(result.held)

    def test_results_are_inputs(self):
        readings = armtrue.simulate_poses(ROBOT, truth=TRUTH, count=40, repeats=2, noise_mm=0.05, noise_mrad=0.1, seed=7)
        self.assertEqual(len(readings.product), 80)
        self.assertIsInstance(readings.product[0]["x_mm"], float)
        by_result = armtrue.calibrate(ROBOT, readings)
        by_rows = armtrue.calibrate(json.loads(command("convert-robot", "--to", "json", ROBOT)), readings.product)
        self.assertEqual(by_result.product["links"], by_rows.product["links"])
        after = armtrue.evaluate_poses(by_result, readings).product["position_mm"]["mean"]
        before = armtrue.evaluate_poses(ROBOT, readings, refit="base,tool").product["position_mm"]["mean"]
        self.assertLess(after, before)
        targets = [{"pose": f"P{k}", **{f"q{j}_deg": angle for j, angle in enumerate((10 * k, -80, 90, 5, 40, 10), 1)}}
                   for k in range(3)]
        corrected = armtrue.compensate(by_result, targets, controller=ROBOT, max_mm=20)
        self.assertEqual([row["pose"] for row in corrected.product], ["P0", "P1", "P2"])
        self.assertEqual(corrected.summary["format"], "armtrue-compensation/1")

    def test_each_function_gives_the_product_of_its_command(self):
        """Documents as YAML and tables as CSV, as commands write them without a word of Python."""
        soft, path = armtrue.shipped("robots/kr360-roughing.yaml"), armtrue.shipped("paths/line300.csv")
        with in_new_folder():
            command("simulate-poses", "--robot", ROBOT, "--truth", TRUTH, "--count", 30, "--repeats", 2, "--noise-mm", 0.05,
                    "--noise-mrad", 0.1, "-o", "m.csv")
            command("calibrate", "-q", "--robot", ROBOT, "m.csv", "-o", "c.yaml")
            command("simulate-path", "--robot", soft, "--noise-mm", 0.095, path, "-o", "pass.csv")
            about = pathlib.Path(SOURCES / "tests/cli/certify/about.yaml")
            pathlib.Path("t.csv").write_text("pose,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n007,0,-80,90,5,40,10\n")
            box, at = "1400,2200,-400,400,300,1100", [0, -60, 90, 0, 60, 0]
            calls = {
                "calibrate": (lambda: armtrue.calibrate(ROBOT, "m.csv"), ("--robot", ROBOT, "m.csv")),
                "certify": (lambda: armtrue.certify("c.yaml", "m.csv", about=about, refit="base,tool"),
                            ("--robot", "c.yaml", "--about", about, "--refit", "base,tool", "m.csv")),
                "check-robot": (lambda: armtrue.check_robot(ROBOT, at=at), (ROBOT, "--at", "0,-60,90,0,60,0", "-o", "check.yaml")),
                "close-loop": (lambda: armtrue.close_loop(ROBOT, "m.csv", only_catalogue=True),
                               ("--robot", ROBOT, "--only-catalogue", "m.csv")),
                "compare-runs": (lambda: armtrue.compare_runs(ROBOT, "c.yaml"), ("--before", ROBOT, "c.yaml")),
                "compensate": (lambda: armtrue.compensate("c.yaml", "t.csv", controller=ROBOT),
                               ("--robot", "c.yaml", "--controller", ROBOT, "t.csv")),
                "convert-robot": (lambda: armtrue.convert_robot(ROBOT, to="yaml"), ("--to", "yaml", ROBOT)),
                "evaluate-poses": (lambda: armtrue.evaluate_poses("c.yaml", "m.csv"), ("--robot", "c.yaml", "m.csv")),
                "import-readings": (lambda: armtrue.import_readings("m.csv"), ("m.csv",)),
                "map-errors": (lambda: armtrue.map_errors("c.yaml", controller=ROBOT, box_mm=box, grid="2,2,2", start=at),
                               ("--robot", "c.yaml", "--controller", ROBOT, "--box-mm", box, "--grid", "2,2,2", "--start", "0,-60,90,0,60,0")),
                "mirror-correct": (lambda: armtrue.mirror_correct(path, "pass.csv"), ("--programmed", path, "--measured", "pass.csv")),
                "plan-poses": (lambda: armtrue.plan_poses(ROBOT, 6), ("--robot", ROBOT, "--count", "6")),
                "simulate-path": (lambda: armtrue.simulate_path(soft, path), ("--robot", soft, path)),
                "simulate-poses": (lambda: armtrue.simulate_poses(ROBOT, count=3), ("--robot", ROBOT, "--count", "3")),
                "trace-residual": (lambda: armtrue.trace_residual("m.csv", ROBOT, only_catalogue=True),
                                   ("--robot", ROBOT, "--only-catalogue", "m.csv")),
            }
            self.assertEqual(sorted(calls), sorted(armtrue_wheel.commands()))
            for name, (call, words) in calls.items():
                with self.subTest(command=name):
                    self.assertEqual(without_provenance(call().product), without_provenance(
                        read(command(name, *words) or pathlib.Path("check.yaml").read_text())))

    def test_programs_are_files(self):
        part = ["DEF part()", "$TOOL={X 0,Y 0,Z 150,A 0,B 0,C 0}", "PTP {A1 10,A2 -60,A3 80,A4 5,A5 40,A6 -10}", "END", ""]
        with tempfile.TemporaryDirectory() as place:
            cell = pathlib.Path(place, "cell")
            cell.mkdir()
            (cell / "part.src").write_text("\n".join(part))
            by_command, by_call, of_project = (pathlib.Path(place, name) for name in ("a.src", "b.src", "corrected"))
            words = ["compensate", "--robot", TRUTH, "--controller", ROBOT, "--program", cell / "part.src"]
            command(*words, "--program-out", by_command)
            result = armtrue.compensate(TRUTH, controller=ROBOT, program=cell / "part.src", program_out=by_call)
            self.assertEqual(by_call.read_text().replace("DEF b", "DEF a"), by_command.read_text())
            self.assertIsNone(result.product)
            self.assertEqual(result.summary["format"], "armtrue-compensation/1")
            result = armtrue.compensate(TRUTH, controller=ROBOT, project=cell, project_out=of_project)
            self.assertEqual([row["program"] for row in result.product], ["part.src"])
            self.assertTrue((of_project / "part.src").exists())

    def test_a_frame_is_read_like_a_table(self):
        class Frame:  # what a pandas frame is asked for
            def to_csv(self, path, index, quoting):
                pathlib.Path(path).write_text(TUTORIAL.read_text())

        self.assertEqual(armtrue.calibrate(ROBOT, Frame()).product["links"],
                         armtrue.calibrate(ROBOT, TUTORIAL).product["links"])

    def test_names_stay_text(self):
        rows = list(csv.DictReader(TUTORIAL.read_text().splitlines()))
        for row in rows:
            row["pose"] = "00" + row["pose"]
        result = armtrue.close_loop(ROBOT, rows)
        self.assertTrue(result.product["worst_held_out"]["pose"].startswith("00"))

    def test_a_name_that_begins_as_a_comment_does_is_no_comment(self):
        names = ["#1", "P2", " P3", "a,b", 'the "4th"']
        rows = [{"pose": name, **{f"q{j}_deg": angle for j, angle in enumerate((10 * k, -80, 90, 5, 40, 10), 1)}}
                for k, name in enumerate(names)]

        class Frame:  # what a pandas frame writes
            def to_csv(self, path, index, quoting):
                with open(path, "w", newline="") as out:
                    writer = csv.DictWriter(out, rows[0], quoting=quoting)
                    writer.writeheader()
                    writer.writerows(rows)

        for table in (rows, Frame()):
            corrected = armtrue.compensate(TRUTH, table, controller=ROBOT, max_mm=20)
            self.assertEqual([row["pose"] for row in corrected.product], names)

    def test_a_mistake_is_an_exception_with_the_message_of_the_command(self):
        with self.assertRaisesRegex(armtrue.Failed, "no-such.yaml") as caught:
            armtrue.calibrate("no-such.yaml", TUTORIAL)
        self.assertEqual(caught.exception.code, 1)
        with self.assertRaises(armtrue.Failed) as caught:
            armtrue.calibrate(ROBOT, TUTORIAL, no_such_option=1)
        self.assertEqual(caught.exception.code, 2)
        with self.assertRaisesRegex(armtrue.Failed, "<readings>"):
            armtrue.calibrate(ROBOT, [{"pose": "P1", "x_mm": 1}])
        with self.assertRaisesRegex(TypeError, "is no file"):
            armtrue.calibrate(ROBOT, 7)
        with self.assertRaisesRegex(TypeError, "what the function returns"):
            armtrue.close_loop(ROBOT, TUTORIAL, robot_out="x.yaml")
        with self.assertRaisesRegex(TypeError, "no table"):
            armtrue.calibrate(ROBOT, TUTORIAL).frame()

    def test_each_command_is_a_function_with_its_page(self):
        for name in armtrue_wheel.commands():
            function = getattr(armtrue, name.replace("-", "_"))
            self.assertIn(f"{name} - ", function.__doc__)


class Notebook(unittest.TestCase):
    def test_its_cells_run(self):
        notebook = json.loads(armtrue.shipped("notebooks/tutorial.ipynb").read_text())
        said, names = io.StringIO(), {}
        with contextlib.redirect_stdout(said):
            for cell in notebook["cells"]:
                if cell["cell_type"] == "code":
                    exec("".join(cell["source"]), names)  # pylint: disable=exec-used
        self.assertIn("A3.theta follows gravity-torque 3", said.getvalue())
        self.assertIn("12 poses", said.getvalue())


class Wheel(unittest.TestCase):
    def test_takes_the_commands_that_are_built(self):
        """Those of build/, if it is a whole build of these sources; the wheel is then made in seconds, not in minutes."""
        with tempfile.TemporaryDirectory() as folder:
            sources = pathlib.Path(folder)
            self.assertIsNone(armtrue_wheel.build_of(sources))
            (sources / "build").mkdir()
            cache = (f"CMAKE_HOME_DIRECTORY:INTERNAL={sources}\nCMAKE_BUILD_TYPE:STRING=Release\n"
                     "ARMTRUE_DISPATCH:BOOL=OFF\n")
            for text, fits in ((cache, True), (cache.replace("Release", "Debug"), False),
                               (cache.replace(f"={sources}", "=/elsewhere"), False), (cache.replace("OFF", "ON"), False)):
                (sources / "build/CMakeCache.txt").write_text(text)
                self.assertEqual(armtrue_wheel.build_of(sources), sources / "build" if fits else None)

    def test_holds_what_runs_and_the_hash_of_each_file(self):
        with tempfile.TemporaryDirectory() as folder:
            stage = pathlib.Path(folder, "stage")
            program = stage / "lib" / "armtrue" / "launcher"
            program.parent.mkdir(parents=True)
            program.write_text("#!/bin/sh\nexec \"$ARMTRUE_BIN/$(basename $0)\" \"$@\"\n")
            program.chmod(0o755)
            (program.parent / "libarmtrue.so.0.2.0").write_text("library")
            (program.parent / "libarmtrue.so.0.2").symlink_to("libarmtrue.so.0.2.0")
            module = stage / "share/armtrue/python/armtrue/__init__.py"  # for an installed tree
            module.parent.mkdir(parents=True)
            module.write_text("")
            names = [armtrue_wheel.write_wheel(stage, folder) for _ in range(2)]
            wheel = pathlib.Path(folder, names[0])
            first = wheel.read_bytes()
            armtrue_wheel.write_wheel(stage, folder)
            self.assertEqual(first, wheel.read_bytes())
            with zipfile.ZipFile(wheel) as archive:
                record = [line for name in archive.namelist() if name.endswith("RECORD")
                          for line in archive.read(name).decode().splitlines()]
                for line in record[:-1]:
                    name, digest, size = line.rsplit(",", 2)
                    content = archive.read(name)
                    self.assertEqual(int(size), len(content))
                    hashed = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                    self.assertEqual(digest, "sha256=" + hashed)
                self.assertEqual(sorted(archive.namelist()), sorted(line.rsplit(",", 2)[0] for line in record))
                self.assertNotIn("armtrue/commands/lib/armtrue/libarmtrue.so.0.2.0", archive.namelist())
                self.assertFalse([name for name in archive.namelist() if "share/armtrue/python" in name])
                archive.extractall(pathlib.Path(folder, "site"))
                mode = archive.getinfo("armtrue/commands/lib/armtrue/launcher").external_attr >> 16
                self.assertEqual(mode & 0o777, 0o755)
            # Imported from there, without the sources.
            found = subprocess.run([sys.executable, "-c", "import armtrue; print(armtrue.calibrate.__doc__[:40])"],
                                   cwd=pathlib.Path(folder, "site"), capture_output=True, text=True, check=True).stdout
            self.assertIn("calibrate", found)
