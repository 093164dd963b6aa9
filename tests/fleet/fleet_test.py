#!/usr/bin/env python3
"""config/fleet on fifteen simulated arms, of which two were hit, one warms up and one has a wrong file.

    fleet_test.py BIN

The arms are those of tests/support/virtual_cell.py, which shares no code with armtrue. The steps run through `fleet run`
and, where Snakemake is installed, through the Snakefile as well, with the same result.
"""

import contextlib
import csv
import html.parser
import json
import math
import os
import pathlib
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[2]
FLEET, SNAKEFILE = SOURCES / "config/fleet/fleet", SOURCES / "config/fleet/Snakefile"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCES / "tests/support"))
import virtual_cell  # noqa: E402

NOMINAL = (SOURCES / "config/robots/kr360-spindle.yaml").read_text()
NOISE_MM, NOISE_DEG = 0.05, math.degrees(0.1e-3)
FIRST, NIGHTS = "2026-11-01", ("2026-11-25", "2026-11-26", "2026-11-27")
HIT_JOINT, HIT_TOOL, WARM, WRONG = "arm-04", "arm-11", "arm-07", "arm-15"
ARMS = [f"arm-{k:02}" for k in range(1, 16)]


def altered(text, link, key, change):
    """A robot file whose link has another value of this key."""
    number = rf"(\{{name: {link}\b.*?\b{key}: )(-?[\d.]+)"
    return re.sub(number, lambda found: f"{found[1]}{float(found[2]) + change:.9f}", text, count=1)


def real_arm(name):
    """The nominal arm with errors of manufacture of its own, as a robot file."""
    draw, text = random.Random(name), NOMINAL
    for link in ("A1", "A2", "A3", "A4", "A5", "A6"):
        for key, sigma in (("d_mm", 0.3), ("r_mm", 0.3), ("theta_deg", 0.02), ("alpha_deg", 0.01)):
            text = altered(text, link, key, draw.gauss(0, sigma))
    return text


def write_readings(path, arm_at, poses, seed):
    """Random poses of a working zone, each visited twice; `arm_at(share)` is the arm after this share of the visits."""
    draw = random.Random(seed)
    targets = [[draw.uniform(*limits) for limits in ((-60, 60), (-120, -50), (40, 130), (-90, 90), (-80, 80), (-120, 120))]
               for _ in range(poses)]
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["pose", "repeat", *(f"q{j}_deg" for j in range(1, 7)), "x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg", "t_s"])
        for k in range(2 * poses):
            q = targets[k % poses]
            rotation, place = arm_at(k / (2 * poses - 1)).pose([math.radians(angle) for angle in q])
            table.writerow([k % poses + 1, 1 + k // poses, *(f"{angle:.6f}" for angle in q),
                            *(f"{value + draw.gauss(0, NOISE_MM):.5f}" for value in place),
                            *(f"{value + draw.gauss(0, NOISE_DEG):.6f}" for value in virtual_cell.kuka(rotation)), 60 * k])


def warm(text, kelvin):
    """Every length of the arm grown by 12 um/(m K), joint 2 tilted by 20 urad/K."""
    grow = lambda found: f"{found[1]}{float(found[2]) * (1 + 12e-6 * kelvin):.9f}"
    return altered(re.sub(r"(\b[dr]_mm: )(-?[\d.]+)", grow, text), "A2", "theta_deg", math.degrees(20e-6) * kelvin)


def make_fleet(folder, arms=ARMS, nights=NIGHTS):
    for name in arms:
        text, home = real_arm(name), folder / "arms" / name
        home.mkdir(parents=True)
        (home / "robot.yaml").write_text(NOMINAL)
        cold = virtual_cell.Arm(text)
        write_readings(home / f"calibration-{FIRST}.csv", lambda share: cold, 30, name)
        for night in nights:
            arm_at = lambda share: cold
            if night > nights[0] and name == HIT_JOINT:
                hit = virtual_cell.Arm(altered(text, "A2", "theta_deg", 0.02))
                arm_at = lambda share: hit
            if night == nights[-1] and name == HIT_TOOL:
                bent = virtual_cell.Arm(re.sub(r"(?m)^tool: .*$", "tool: {x_mm: 0.5, y_mm: 0, z_mm: 0.2, a_deg: 0, b_deg: 0, c_deg: 0}", text))
                arm_at = lambda share: bent
            if night == nights[-1] and name == WARM:
                steps = [virtual_cell.Arm(warm(text, kelvin)) for kelvin in range(16)]
                arm_at = lambda share: steps[round(15 * share)]
            write_readings(home / f"check-{night}.csv", arm_at, 12, name + night)
    if WRONG in arms:
        shutil.copy(folder / "arms/arm-02" / f"check-{nights[-1]}.csv", folder / "arms" / WRONG / f"check-{nights[-1]}.csv")


def fleet(folder, *words):
    if words[0] in ("run", "page"):
        words = (words[0], "--today", NIGHTS[-1], *words[1:])
    return subprocess.run([sys.executable, "-B", FLEET, "-C", folder, *words], capture_output=True, text=True)


def history(folder):
    with contextlib.closing(sqlite3.connect(folder / "history.sqlite")) as base:
        base.row_factory = sqlite3.Row
        return {(row["arm"], row["night"], row["kind"]): dict(row) for row in base.execute("SELECT * FROM nights")}


class Page(html.parser.HTMLParser):
    """Order of the arms, text, and whatever would be fetched."""

    def __init__(self, text):
        super().__init__()
        self.arms, self.fetched, self.open, self.words = [], [], [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        if tag == "section":
            self.arms.append(named["id"])
        self.fetched += [value for key, value in named.items() if key in ("src", "href")]
        if tag not in ("meta", "circle", "line", "polyline"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in ("circle", "line", "polyline"):
            assert self.open.pop() == tag, tag

    def handle_data(self, text):
        self.words += text


class Twenty(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.hold = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.hold.name, "whole")
        make_fleet(cls.folder)
        shutil.copytree(cls.folder, pathlib.Path(cls.hold.name, "killed"))
        cls.done = fleet(cls.folder, "run", "-j", "2", "--only-catalogue")

    @classmethod
    def tearDownClass(cls):
        cls.hold.cleanup()

    def test_what_happened_is_found_and_nothing_else(self):
        self.assertEqual(self.done.returncode, 3, self.done.stderr)
        rows = history(self.folder)
        self.assertEqual(len(rows), len(ARMS) * (1 + len(NIGHTS)))
        checks = {key: row["verdict"] for key, row in rows.items() if key[2] == "check" and row["verdict"] != "holds"}
        self.assertEqual(checks, {(HIT_JOINT, NIGHTS[1], "check"): "moved", (HIT_JOINT, NIGHTS[2], "check"): "moved",
                                  (HIT_TOOL, NIGHTS[2], "check"): "moved", (WARM, NIGHTS[2], "check"): "drifts",
                                  (WRONG, NIGHTS[2], "check"): "not-read"})
        joint = json.loads(rows[HIT_JOINT, NIGHTS[2], "check"]["moved"])
        self.assertEqual([move["parameter"] for move in joint], ["A2.theta"])
        self.assertAlmostEqual(joint[0]["change_deg"], 0.02, delta=0.004)
        self.assertEqual([move["parameter"] for move in json.loads(rows[HIT_TOOL, NIGHTS[2], "check"]["moved"])], ["tool"])
        self.assertRegex(rows[HIT_TOOL, NIGHTS[2], "check"]["message"], r"^tool: tool\.x \+0\.\d+ mm, tool\.z \+0\.\d+ mm$")
        self.assertEqual(rows[WRONG, NIGHTS[2], "check"]["same_as"], f"arm-02, {NIGHTS[2]}")
        self.assertIn(f"{HIT_JOINT}: Moved between {NIGHTS[0]} and {NIGHTS[1]}: A2.theta +0.0", self.done.stdout)
        self.assertEqual(len(self.done.stdout.splitlines()), 4)

    def test_one_query_tells_moves_and_drifts(self):
        with contextlib.closing(sqlite3.connect(self.folder / "history.sqlite")) as base:
            found = base.execute("SELECT arm, json_extract(m.value, '$.parameter'), json_extract(m.value, '$.driver') "
                                 "FROM nights, json_each(moved) AS m WHERE night = ?", NIGHTS[-1:]).fetchall()
        self.assertEqual({arm for arm, _, _ in found}, {HIT_JOINT, HIT_TOOL, WARM})
        self.assertIn((HIT_JOINT, "A2.theta", None), found)
        for arm, parameter, driver in found:
            self.assertRegex(parameter, r"^\w+(\.\w+)?$")
            self.assertEqual(driver, "time" if arm == WARM else None)

    def test_rows_say_how_good_an_arm_is(self):
        for (arm, night, kind), row in history(self.folder).items():
            with self.subTest(arm=arm, night=night):
                if row["verdict"] == "not-read":
                    self.assertIsNone(row["result_mm"])  # of another arm
                    continue
                if row["verdict"] != "drifts":  # the floor is from repeats, which a drift pulls apart
                    self.assertGreater(row["nominal_mm"], 3 * row["floor_mm"])
                if kind == "calibration":
                    self.assertLess(row["result_mm"], 2 * row["floor_mm"])
                    values = {entry["parameter"]: entry for entry in json.loads(row["parameters"])}
                    truth = float(re.search(r"name: A2\b.*?d_mm: (-?[\d.]+)", real_arm(arm))[1])
                    found = values["A2.d"]
                    self.assertLess(abs(float(found["value"]) - truth), 4.5 * float(found["std"]))
                else:
                    self.assertEqual(row["since"], FIRST)

    def test_the_page_begins_with_the_worst_and_needs_no_network(self):
        text = (self.folder / "index.html").read_text()
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assertEqual(sorted(page.arms), ARMS)
        self.assertEqual(set(page.arms[:2]), {HIT_JOINT, HIT_TOOL})
        self.assertEqual(page.arms[2:4], [WRONG, WARM])
        self.assertEqual(page.fetched, [])
        self.assertNotRegex(text.replace("http-equiv", ""), r"url\(|@import|https?:")
        self.assertIn(f"last good {NIGHTS[1]}", page.words)
        self.assertIn(f"the same readings as arm-02, {NIGHTS[2]}", page.words)
        self.assertRegex(text, r"<text[^>]*>\d\.\d{3} mm</text>")  # no length without its unit

    def test_colours_are_those_of_the_other_pages(self):
        colours = lambda text: {name: set(re.findall(rf"--{name}:(#\w+)", text)) for name in
                                ("paper", "ink", "quiet", "grid", "card", "nominal", "before", "after", "good", "warn", "bad")}
        self.assertEqual(colours(FLEET.read_text()), colours((SOURCES / "src/report/picture_style.cc").read_text()))

    def test_a_second_run_repeats_nothing(self):
        before = {path: path.stat().st_mtime_ns for path in self.folder.glob("results/*/*.json")}
        made = {name: (self.folder / name).read_bytes() for name in ("index.html", "history.sqlite")}
        again = fleet(self.folder, "run", "--only-catalogue")
        self.assertEqual(again.stdout, self.done.stdout)
        self.assertEqual(before, {path: path.stat().st_mtime_ns for path in self.folder.glob("results/*/*.json")})
        self.assertEqual(made, {name: (self.folder / name).read_bytes() for name in made})

    def test_a_kill_loses_nothing(self):
        """Killed while it works, it leaves whole results alone; a restart takes these and ends with the same bytes."""
        folder = pathlib.Path(self.hold.name, "killed")
        for name in ARMS[5:]:  # five arms are enough, the first that was hit among them
            shutil.rmtree(folder / "arms" / name)
        process = subprocess.Popen([sys.executable, "-B", FLEET, "-C", folder, "run", "-j", "1", "--only-catalogue"],
                                   stdout=subprocess.DEVNULL, start_new_session=True)
        while process.poll() is None and len(list(folder.glob("results/*/*.json"))) < 2:
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGKILL)
        self.assertEqual(process.wait(), -signal.SIGKILL, "it ended before the kill")
        kept = {path: path.stat().st_mtime_ns for path in folder.glob("results/*/*.json")}
        for path in kept:
            json.loads(path.read_text())
        self.assertFalse((folder / "index.html").exists())
        self.assertEqual(fleet(folder, "run", "--only-catalogue").returncode, 3)
        self.assertEqual({path: path.stat().st_mtime_ns for path in kept}, kept)
        for path in folder.glob("results/*/*.json"):
            self.assertEqual(path.read_bytes(), (self.folder / path.relative_to(folder)).read_bytes())
        whole = {key: row for key, row in history(self.folder).items() if key[0] in ARMS[:5]}
        self.assertEqual(history(folder), whole)

    @unittest.skipUnless(shutil.which("snakemake"), "Snakemake is not installed: the Snakefile does not run here")
    def test_snakemake_does_the_same(self):
        folder = pathlib.Path(self.hold.name, "snakemake")
        shutil.copytree(self.folder / "arms", folder / "arms")
        for name in ARMS[5:]:
            shutil.rmtree(folder / "arms" / name)
        make = lambda: subprocess.run(
            ["snakemake", "-s", SNAKEFILE, "--directory", folder, "--cores", "2", "--config", "only_catalogue=true",
             f"today={NIGHTS[-1]}"], capture_output=True, text=True)
        for _ in range(2):  # what is made again says the same, and makes nothing but the page
            done = make()
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertRegex(done.stdout, f"(?m)^{HIT_JOINT}: Moved between {NIGHTS[0]} and {NIGHTS[1]}: A2.theta")
            self.assertEqual(history(folder), {key: row for key, row in history(self.folder).items() if key[0] in ARMS[:5]})
            self.assertEqual(Page((folder / "index.html").read_text()).arms[0], HIT_JOINT)
        self.assertNotRegex(done.stderr, "rule (calibrate|check|record):")
        for path in folder.glob(f"arms/{HIT_JOINT}/check-*.csv"):
            if path.name != f"check-{NIGHTS[0]}.csv":
                path.unlink()
        done = make()
        self.assertEqual(done.returncode, 0, done.stderr)


class OneArm(unittest.TestCase):
    """Files that are not as they should be."""

    def setUp(self):
        self.hold = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.hold.name)
        self.home = self.folder / "arms/arm-01"
        self.home.mkdir(parents=True)
        (self.home / "robot.yaml").write_text(NOMINAL)
        self.arm = virtual_cell.Arm(real_arm("arm-01"))
        write_readings(self.home / "check-2026-11-25.csv", lambda share: self.arm, 12, "x")

    def tearDown(self):
        self.hold.cleanup()

    def test_a_table_given_twice_counts_once(self):
        shutil.copy(self.home / "check-2026-11-25.csv", self.home / "check-2026-11-26.csv")
        fleet(self.folder, "run")
        rows = history(self.folder)
        self.assertIsNone(rows["arm-01", "2026-11-25", "check"]["same_as"])
        self.assertEqual(rows["arm-01", "2026-11-26", "check"]["verdict"], "not-read")
        self.assertEqual(rows["arm-01", "2026-11-26", "check"]["message"], 
                         "the same readings as arm-01, 2026-11-25; one of the two is a copy: put the right table in its place, or delete it")

    def test_what_one_of_many_arms_shows_by_chance_is_no_alarm(self):
        """Twenty arms in one night: the limit is 0.01 / 20. Results as `check` writes them, numbers chosen here."""
        fleet(self.folder, "check", "arm-01", "2026-11-25")
        written = json.loads((self.folder / "results/arm-01/check-2026-11-25.json").read_text())
        shutil.rmtree(self.folder / "results")
        for k in range(20):
            p = {3: 0.0004, 4: 0.0006}.get(k, 0.5)
            written["row"].update(arm=f"arm-{k:02}", readings_sha256=str(k), p_value=p, verdict="moved" if p < 0.01 else "holds",
                                  message="A2.theta +0.01 deg")
            path = self.folder / f"results/arm-{k:02}/check-2026-11-25.json"
            path.parent.mkdir(parents=True)
            path.write_text(json.dumps(written))
            (self.folder / f"arms/arm-{k:02}").mkdir(exist_ok=True)
            (self.folder / f"arms/arm-{k:02}/check-2026-11-25.csv").touch()
        for _ in range(2):  # a second time changes nothing
            self.assertEqual(fleet(self.folder, "record").returncode, 0)
            verdicts = {key[0]: row["verdict"] for key, row in history(self.folder).items() if row["verdict"] != "holds"}
            self.assertEqual(verdicts, {"arm-03": "moved", "arm-04": "suspect"})
        self.assertEqual(fleet(self.folder, "page").returncode, 3)
        page = Page((self.folder / "index.html").read_text())
        self.assertEqual(page.arms[:2], ["arm-03", "arm-04"])
        self.assertIn("May have moved, or chance (p = 0.0006)", page.words)

    def test_a_damaged_table_is_named_with_its_line(self):
        table = self.home / "check-2026-11-25.csv"
        lines = table.read_text().splitlines(keepends=True)
        table.write_text("".join(lines[:7]) + lines[7].replace(",", ";", 1) + "".join(lines[8:]))
        done = fleet(self.folder, "run")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("check-2026-11-25.csv:8", done.stdout)
        self.assertIn("not read", (self.folder / "index.html").read_text())

    def test_a_check_without_a_calibration_says_so(self):
        done = fleet(self.folder, "run")
        self.assertEqual(done.stdout, "arm-01: No calibration of this arm before this night; put its readings into "
                                      "arms/arm-01/calibration-YYYY-MM-DD.csv\n")
        self.assertEqual(history(self.folder)["arm-01", "2026-11-25", "check"]["verdict"], "not-calibrated")

    def test_new_readings_under_an_old_name_replace_the_row(self):
        fleet(self.folder, "run")
        before = history(self.folder)["arm-01", "2026-11-25", "check"]
        write_readings(self.home / "check-2026-11-25.csv", lambda share: self.arm, 11, "y")
        later = time.time() + 5
        os.utime(self.home / "check-2026-11-25.csv", (later, later))
        fleet(self.folder, "run")
        rows = history(self.folder)
        self.assertEqual(len(rows), 1)
        self.assertNotEqual(rows["arm-01", "2026-11-25", "check"]["readings_sha256"], before["readings_sha256"])
        self.assertEqual(rows["arm-01", "2026-11-25", "check"]["poses"], 11)

    def test_a_misnamed_file_is_reported_and_the_others_are_checked(self):
        for name in ("check-2026-11-27 (1).csv", "check-2026-13-45.csv", "check-2026-11-26.CSV", "check-2026-11-26.txt",
                     "check-2027-11-25.csv"):
            with self.subTest(name=name):
                shutil.copy(self.home / "check-2026-11-25.csv", self.home / name)
                done = fleet(self.folder, "run")
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertIn(f"arm-01: {name}: the name is neither", done.stdout)
                self.assertIn(name, Page((self.folder / "index.html").read_text()).words)
                self.assertEqual(list(history(self.folder)), [("arm-01", "2026-11-25", "check")])
                (self.home / name).unlink()

    def alone(self, script, *words):
        """Runs a copy of the script, with no packages of this machine in reach, and the commands of the test."""
        return subprocess.run([sys.executable, "-BIS", script, "-C", self.folder, *words], capture_output=True, text=True)

    def test_an_installed_script_finds_its_module(self):
        share = self.folder / "share/armtrue"
        shutil.copytree(FLEET.parent, share / "fleet")
        done = self.alone(share / "fleet/fleet", "--help")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("fleet run [-j N]", done.stdout)
        done = self.alone(share / "fleet/fleet", "run", "--today", NIGHTS[-1])
        self.assertEqual(done.returncode, 1)
        self.assertIn("the Python module of armtrue is missing", done.stderr)
        self.assertFalse((self.folder / "results").exists())
        shutil.copytree(SOURCES / "apps/python/armtrue", share / "python/armtrue")
        done = self.alone(share / "fleet/fleet", "run", "--today", NIGHTS[-1])
        self.assertEqual((done.returncode, done.stderr), (3, ""))
        self.assertIn("no calibration of this arm", done.stdout.lower())

    def test_an_arm_without_its_robot_is_named(self):
        (self.home / "robot.yaml").unlink()
        done = fleet(self.folder, "run")
        self.assertEqual((done.returncode, done.stderr), (3, ""))
        self.assertEqual(done.stdout, "arm-01: check-2026-11-25.csv: arms/arm-01/robot.yaml is missing: put the nominal robot of "
                                      "this arm there\n")

    def test_an_axis_that_does_not_repeat_has_no_move(self):
        """Joint 2 stands up to 0.05 deg off, elsewhere at each pose; both visits of a pose agree."""
        write_readings(self.home / "calibration-2026-11-01.csv", lambda share: self.arm, 30, "c")
        draw = random.Random(3)
        loose = [virtual_cell.Arm(altered(real_arm("arm-01"), "A2", "theta_deg", draw.uniform(-0.05, 0.05))) for _ in range(12)]
        write_readings(self.home / "check-2026-11-25.csv", lambda share: loose[round(23 * share) % 12], 12, "x")
        done = fleet(self.folder, "run", "--only-catalogue")
        self.assertEqual((done.returncode, done.stderr), (3, ""))
        self.assertEqual(done.stdout, "arm-01: Changed between 2026-11-01 and 2026-11-25, but no single parameter explains it: "
                                      "another arm, or an axis that does not repeat?\n")

    def test_missing_commands_are_one_error_and_no_result(self):
        places = {"PATH": "/usr/bin:/bin", "ARMTRUE_BIN": str(self.folder)}
        done = subprocess.run([sys.executable, "-B", FLEET, "-C", self.folder, "run"], env=places, capture_output=True,
                              text=True)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(done.stderr.splitlines()), 1)
        self.assertRegex(done.stderr, "the command .* into PATH")
        self.assertEqual(os.listdir(self.folder), ["arms"])

    def test_a_folder_without_arms_is_an_error(self):
        shutil.rmtree(self.home)
        for folder, message in ((self.folder, "holds no folder of an arm"), (self.folder / "none", "No such file")):
            done = fleet(folder, "run")
            self.assertEqual(done.returncode, 1)
            self.assertIn(message, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_an_arm_that_is_not_measured_is_named(self):
        write_readings(self.home / "calibration-2026-11-01.csv", lambda share: self.arm, 30, "c")
        (self.folder / "arms/arm-02").mkdir()
        home = self.folder / "arms/arm-03"
        home.mkdir()
        (home / "robot.yaml").write_text(NOMINAL)
        write_readings(home / "calibration-2026-11-01.csv", lambda share: self.arm, 30, "d")
        done = fleet(self.folder, "run", "--only-catalogue")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertEqual(done.stdout.splitlines(), [
            "arm-02: no table of this arm was recorded yet",
            "arm-03: Not measured since 2026-11-01, 24 nights before the newest night of the fleet"])
        self.assertEqual(Page((self.folder / "index.html").read_text()).arms, ["arm-02", "arm-03", "arm-01"])
        done = fleet(self.folder, "run", "--only-catalogue", "--unmeasured-nights", "24")
        self.assertEqual(len(done.stdout.splitlines()), 1)

    def test_a_fleet_that_nobody_measures_any_more_is_named(self):
        write_readings(self.home / "calibration-2026-11-01.csv", lambda share: self.arm, 30, "c")
        for today, code in (("2026-12-02", 0), ("2026-12-03", 3), ("2026-11-25", 0)):
            done = fleet(self.folder, "run", "--only-catalogue", "--today", today)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertEqual(done.stdout, "No arm of the fleet was measured since 2026-11-25, 8 nights ago\n" if code else "")
        self.assertEqual(fleet(self.folder, "run", "--today", "2026-12-03", "--unmeasured-nights", "8").returncode, 0)

    def test_a_table_that_is_deleted_is_taken_back(self):
        """A check and a calibration of another arm: without them all is as before, the check compared anew."""
        write_readings(self.home / "calibration-2026-11-01.csv", lambda share: self.arm, 30, "c")
        self.assertEqual(fleet(self.folder, "run", "--only-catalogue").returncode, 0)
        before = history(self.folder)
        other = virtual_cell.Arm(real_arm("arm-02"))
        write_readings(self.home / "calibration-2026-11-24.csv", lambda share: other, 30, "d")
        write_readings(self.home / "check-2026-11-26.csv", lambda share: self.arm, 12, "e")
        self.assertEqual(fleet(self.folder, "run", "--only-catalogue").returncode, 3)
        self.assertEqual(history(self.folder)["arm-01", "2026-11-25", "check"]["verdict"], "moved")
        for name in ("calibration-2026-11-24.csv", "check-2026-11-26.csv"):
            (self.home / name).unlink()
        done = fleet(self.folder, "run", "--only-catalogue")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.splitlines(), [
            "arm-01: calibration-2026-11-24.csv is gone: withdrawn from the history",
            "arm-01: check-2026-11-26.csv is gone: withdrawn from the history"])
        self.assertEqual(history(self.folder), before)
        self.assertEqual(sorted(os.listdir(self.folder / "results/arm-01")),
                         ["calibration-2026-11-01.json", "check-2026-11-25.json"])


if __name__ == "__main__":
    os.environ["ARMTRUE_BIN"] = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
