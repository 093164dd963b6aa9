#!/usr/bin/env python3
"""Recordings of ROS 2, written by tests/support/ros_bag.py, through import-readings. An arm stands still at
each pose for 3 s and moves for 2 s; joint states come at 50 Hz, poses of the tool at 20 Hz.

    bag_test.py BIN
"""

import csv
import io
import math
import pathlib
import random
import re
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import ros_bag as bag  # noqa: E402

BIN = None
ROBOT = pathlib.Path(__file__).resolve().parents[2] / "config/robots/kr360-spindle.yaml"
BEGIN = 1_700_000_000 * bag.SECOND
NAMES = ["joint_1", "joint_3", "joint_2", "joint_6", "joint_5", "joint_4"]
STATES, POSES, TF = "/joint_states", "/mocap/tool", "/tf"
POSE_TYPE = "geometry_msgs/msg/PoseStamped"


def run(*arguments, cwd):
    return subprocess.run(list(map(str, arguments)), cwd=cwd, capture_output=True, text=True)


def stops(count):
    """Of each stop the joint angles, rad, in the order of NAMES, and a pose: m, quaternion x y z w."""
    rng = random.Random(3)
    found = []
    for _ in range(count):
        q = [rng.uniform(-1, 1) for _ in NAMES]
        turn = [rng.gauss(0, 1) for _ in range(4)]
        size = math.sqrt(sum(x * x for x in turn))
        found.append((q, [rng.uniform(-1, 1) for _ in range(3)] + [x / size for x in turn]))
    return found


def matrix(x, y, z, w):
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def matrix_of_angles(row):
    """Rz(A) Ry(B) Rx(C)."""
    (ca, sa), (cb, sb), (cc, sc) = ((math.cos(math.radians(float(row[k]))), math.sin(math.radians(float(row[k]))))
                                    for k in ("a_deg", "b_deg", "c_deg"))
    return [[ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
            [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
            [-sb, cb * sc, cb * cc]]


def recording(found, poses=(POSES, POSE_TYPE, bag.pose), stamps=True, big=False):
    """The messages of a walk through stops, in the order in which they are recorded."""
    topic, kind, make = poses
    messages = []
    t = BEGIN
    for k, (q, numbers) in enumerate(found):
        after = found[min(k + 1, len(found) - 1)]
        for tick in range(500):
            share = max(0.0, (tick - 300) / 200)
            between = [(a * (1 - share) + b * share) for a, b in zip(q, after[0])]
            place = [(a * (1 - share) + b * share) for a, b in zip(numbers[:3], after[1][:3])] + numbers[3:]
            if tick % 2 == 0:
                messages.append((STATES, "sensor_msgs/msg/JointState", t,
                                 bag.joint_state(t if stamps else 0, NAMES, between, big)))
            if tick % 5 == 0:
                messages.append((topic, kind, t, make(t if stamps else 0, place, big=big)))
            t += bag.SECOND // 100
    return messages


class Bags(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        self.stops = stops(6)

    def read(self, *arguments, code=0):
        done = run(BIN / "import-readings", *arguments, "--join", "time", cwd=self.path)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def check(self, done, has_orientation=True):
        """Each stop is a pose with the angles and the place that were recorded there."""
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        means = {}
        for row in rows:
            means.setdefault(row["pose"], row)
        self.assertEqual(len(means), len(self.stops), done.stderr)
        for row, (q, numbers) in zip(means.values(), self.stops):
            by_name = dict(zip(NAMES, q))
            for j in range(6):
                name = next(name for name in NAMES if name.endswith(str(j + 1)))
                self.assertAlmostEqual(float(row[f"q{j + 1}_deg"]), math.degrees(by_name[name]), 9)
            for axis, value in zip("xyz", numbers):
                self.assertAlmostEqual(float(row[f"{axis}_mm"]), 1000 * value, 9)
            if has_orientation:
                for given, read in zip(sum(matrix(*numbers[3:]), []), sum(matrix_of_angles(row), [])):
                    self.assertAlmostEqual(read, given, 9)

    def test_containers_hold_the_same(self):
        messages = recording(self.stops)
        bag.write_db3(self.path / "a.db3", messages)
        bag.write_mcap(self.path / "a.mcap", messages)
        bag.write_mcap(self.path / "zstd.mcap", messages, ("zstd", bag.zstd))
        bag.write_mcap(self.path / "lz4.mcap", messages, ("lz4", bag.lz4))
        bag.write_mcap(self.path / "plain.mcap", messages, chunks=0)
        bag.write_mcap(self.path / "big.mcap", recording(self.stops, big=True))
        folder = self.path / "run"
        folder.mkdir()
        half = len(messages) // 2  # the later half first, by name
        bag.write_db3(folder / "run_0.db3", messages[half:])
        bag.write_db3(folder / "run_1.db3", messages[:half])
        (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
        first = None
        for name in ("a.db3", "a.mcap", "zstd.mcap", "lz4.mcap", "plain.mcap", "big.mcap", "run"):
            done = self.read("--points", name, "--joints", name)
            self.check(done)
            first = first or done.stdout
            self.assertEqual(done.stdout, first, name)
        left = sorted(path.name for path in self.path.rglob("*"))
        self.assertEqual([name for name in left if name.endswith(("-wal", "-shm"))], [])

    def test_kinds_of_poses(self):
        covariance = [0.0] * 36
        for k in range(6):
            covariance[7 * k] = (1e-4 * (k + 1)) ** 2
        kinds = {
            "PointStamped": lambda ns, numbers, big: bag.pose(ns, numbers[:3]),
            "PoseWithCovarianceStamped": lambda ns, numbers, big: bag.pose(ns, numbers, covariance=covariance),
        }
        for kind, make in kinds.items():
            bag.write_mcap(self.path / "a.mcap", recording(self.stops, (POSES, "geometry_msgs/msg/" + kind, make)))
            done = self.read("--points", "a.mcap", "--joints", "a.mcap")
            self.check(done, kind != "PointStamped")
            row = next(csv.DictReader(io.StringIO(done.stdout)))
            self.assertEqual("cov_xx_mm2" in row, "Covariance" in kind)
            if "Covariance" in kind:
                self.assertAlmostEqual(float(row["cov_yy_mm2"]), 0.04, 9)

    def test_transforms(self):
        other = [9, 9, 9, 0, 0, 0, 1]
        make = lambda ns, numbers, big: bag.transforms(ns, {"tool": numbers, "table": other})  # noqa: E731
        bag.write_mcap(self.path / "a.mcap", recording(self.stops, (TF, "tf2_msgs/msg/TFMessage", make)))
        self.check(self.read("--points", "a.mcap", "--joints", "a.mcap", "--body", "tool"))
        for body, words in (([], "'table', 'tool'"), (["--body", "wrist"], "no transform to 'wrist'")):
            self.assertIn(words, self.read("--points", "a.mcap", "--joints", "a.mcap", *body, code=1).stderr)

    def test_times_of_the_recorder(self):
        bag.write_db3(self.path / "a.db3", recording(self.stops, stamps=False))
        done = self.read("--points", "a.db3", "--joints", "a.db3")
        self.check(done)
        self.assertIn("times of the recorder", done.stderr)

    def test_topics_are_chosen(self):
        messages = recording(self.stops)
        messages += [("/other", POSE_TYPE, BEGIN + k * bag.SECOND // 10, bag.pose(BEGIN + k, [0] * 6 + [1]))
                     for k in range(9)]
        bag.write_mcap(self.path / "a.mcap", messages)
        both = self.read("--points", "a.mcap", "--joints", "a.mcap", code=1).stderr
        self.assertIn("'/mocap/tool', '/other'", both)
        self.check(self.read("--points", "a.mcap", "--joints", "a.mcap", "--points-topic", POSES))
        wrong = self.read("--points", "a.mcap", "--joints", "a.mcap", "--points-topic", "/mocap/tol", code=1).stderr
        self.assertIn("/mocap/tool (geometry_msgs/msg/PoseStamped)", wrong)

    def split(self, messages, topics):
        """The joint states as of two drivers: of joint_1 and, 3 ms later, of the others. `topics`: of the two."""
        (self.path / "robot.yaml").write_text(re.sub(r"\bA(\d)\b", r"joint_\1", ROBOT.read_text()))
        found = []
        for topic, kind, t, data in messages:
            if topic != STATES:
                found.append((topic, kind, t, data))
                continue
            angles = struct.unpack("<6d", data[-56:-8])
            found.append((topics[0], kind, t, bag.joint_state(t, NAMES[:1], angles[:1])))
            found.append((topics[1], kind, t, bag.joint_state(t + 3_000_000, NAMES[1:], angles[1:])))
        return found

    def read_split(self, messages, code=0, more=()):
        bag.write_mcap(self.path / "a.mcap", messages)
        return self.read("--points", "a.mcap", "--joints", "a.mcap", "--robot", "robot.yaml", *more, code=code)

    def test_joints_of_several_drivers_are_gathered(self):
        whole = recording(self.stops)
        rail, arm = "/rail/joint_states", "/arm/joint_states"
        for topics in ((STATES, STATES), (rail, arm)):
            done = self.read_split(self.split(whole, topics))
            self.check(done)
            self.assertIn("at each time the latest of each, at most 0.017 s old", done.stderr)
        both = self.split(whole, (rail, arm))
        self.check(self.read_split(both + [m for m in whole if m[0] == STATES]))  # one topic has all
        again = [("/again", *m[1:]) for m in both if m[0] == arm]
        self.assertIn("'/again', '/arm/joint_states', '/rail/joint_states' hold joint states",
                      self.read_split(both + again, code=1).stderr)
        self.assertIn("the robot's joint_1 is none of them; leave out --joints-topic",
                      self.read_split(both, 1, ("--joints-topic", arm)).stderr)

    def test_an_old_value_of_a_joint_is_none(self):
        """One driver is silent at the second stop: there is no stop, rather than one with an angle from elsewhere."""
        rail = "/rail/joint_states"
        messages = self.split(recording(self.stops), (rail, STATES))
        done = self.read_split([m for m in messages if m[0] != rail or not 3 < (m[2] - BEGIN) / bag.SECOND < 12])
        self.assertRegex(done.stderr, r"4\d\d rows left out, where one is older \(--max-gap-s\)")
        del self.stops[1]
        self.check(done)

    def test_a_recording_beside_a_table(self):
        bag.write_mcap(self.path / "a.mcap", recording(self.stops))
        with open(self.path / "points.csv", "w") as file:
            file.write("t [s],X [m],Y [m],Z [m]\n")
            for k, (_, numbers) in enumerate(self.stops):
                for tick in range(5, 250):
                    t = BEGIN // bag.SECOND + 5 * k + tick / 100
                    file.write(f"{t:.3f},{numbers[0]},{numbers[1]},{numbers[2]}\n")
        self.check(self.read("--points", "points.csv", "--joints", "a.mcap"), False)

    def test_bad_recordings_are_named(self):
        messages = recording(self.stops[:2])
        bag.write_mcap(self.path / "a.mcap", messages)
        whole = (self.path / "a.mcap").read_bytes()
        bag.write_mcap(self.path / "ros1.mcap", messages, encoding="ros1")
        bag.write_mcap(self.path / "how.mcap", messages, ("bz2", bytes))
        bag.write_mcap(self.path / "lies.mcap", messages, ("zstd", bytes))
        bag.write_mcap(self.path / "only.mcap", [m for m in messages if m[0] != STATES])
        short = [(topic, kind, ns, data[:-20]) for topic, kind, ns, data in messages]
        bag.write_mcap(self.path / "short.mcap", short)
        (self.path / "cut.mcap").write_bytes(whole[:len(whole) // 2])
        (self.path / "text.mcap").write_text("Point,X,Y,Z\n")
        (self.path / "text.db3").write_text("Point,X,Y,Z\n")
        (self.path / "empty").mkdir()
        (self.path / "packed").mkdir()
        (self.path / "packed/run.db3.zstd").write_bytes(b"")
        for name, words in (("ros1.mcap", "rostopic echo"), ("how.mcap", "'bz2'"), ("lies.mcap", "does not unpack"),
                            ("only.mcap", "no topic holds joint states"), ("short.mcap", "message 1 of"),
                            ("cut.mcap", "ends within a record"), ("text.mcap", "no recording in MCAP"),
                            ("text.db3", "no recording of ROS 2"), ("empty", "without a recording"),
                            ("packed", "zstd -d"), ("missing.mcap", "cannot be read"), ("missing.db3", "cannot be read")):
            self.assertIn(words, self.read("--points", "a.mcap", "--joints", name, code=1).stderr, name)

    def test_a_recording_stays(self):
        (self.path / "run").mkdir()
        bag.write_db3(self.path / "run/a.db3", recording(self.stops))
        before = (self.path / "run/a.db3").read_bytes()
        done = self.read("--points", "run", "--joints", "run", "-o", "run/a.db3", code=2)
        self.assertIn("run/a.db3", done.stderr)
        self.assertEqual((self.path / "run/a.db3").read_bytes(), before)

    def test_damaged_recordings(self):
        """No damage makes a crash."""
        messages = recording(self.stops[:2])
        for name, write in (("a.mcap", lambda path: bag.write_mcap(path, messages, ("zstd", bag.zstd))),
                            ("a.db3", lambda path: bag.write_db3(path, messages))):
            write(self.path / name)
            whole = (self.path / name).read_bytes()
            rng = random.Random(5)
            for _ in range(60):
                bad = bytearray(whole)
                for _ in range(rng.randint(1, 4)):
                    bad[rng.randrange(len(bad)) if rng.random() < 0.5 else rng.randrange(2000)] = rng.randrange(256)
                (self.path / name).write_bytes(bad[:len(bad) if rng.random() < 0.7 else rng.randrange(len(bad))])
                done = run(BIN / "import-readings", "--points", name, "--joints", name, "--join", "time", cwd=self.path)
                self.assertIn(done.returncode, (0, 1), done.stderr)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
