#!/usr/bin/env python3
"""Random programs of PolyScope 5 and 3: trees of folders, branches, threads and subprograms with waypoints that are fixed, variable
or relative, circular moves, nodes that are switched off, waypoints that expressions read or a second move refers to, and Script
nodes. Another reader of their XML says what each waypoint commands before and after the correction, and the true arm goes there.
Waypoints of PolyScope 3 state poses, too: of the same arm, or of another one. Nothing here shares code with armtrue.

    polyscope_programs_test.py BIN [--programs N] [--keep FOLDER]
"""

import gzip
import math
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ET

sys.dont_write_bytecode = True

import robot_programs as rp
import robot_programs_test as programs
import virtual_cell as vc

BIN = None
PROGRAMS = int(sys.argv[sys.argv.index("--programs") + 1]) if "--programs" in sys.argv else 40
KEEP = pathlib.Path(sys.argv[sys.argv.index("--keep") + 1]) if "--keep" in sys.argv else None
NEAR_MM = 1e-3  # what rounding to 0.1 microradian leaves
KINEMATICS = """<Kinematics status="LINEARIZED" validChecksum="true">
  <deltaTheta value="0.0, 0.98, 5.5, -0.2, 0.0, 0.0"/>
</Kinematics>"""


def pose_numbers(motion):
    return [*(v / 1000 for v in motion[1]), *programs.rotation_vector(motion[0])]


def rows_of(nominal_text):
    """The arm as PolyScope 3 states it: deltaTheta, a, d and alpha by rows, in m and rad."""
    links = [vc.fields(link) for link in re.findall(r"\{.*joint: .*\}", nominal_text)]
    a, alpha = [link["d_mm"] / 1000 for link in links], [math.radians(link["alpha_deg"]) for link in links]
    assert a[0] == alpha[0] == 0
    return {"deltaTheta": [math.radians(link["theta_deg"]) for link in links[:6]], "a": a[1:], "d": [link["r_mm"] / 1000 for link in links[:6]],
            "alpha": alpha[1:]}


class Writer:
    """Writes the tree of one program. `fixed`: (name, joint angles) of the waypoints that move the arm and can be corrected."""

    def __init__(self, cell, version=5):
        self.cell, self.rng, self.version = cell, cell.rng, version
        self.q = cell.posture((-150, 150), (-80, -40), (60, 110), (-120, -60), (-100, -60), (-150, 150))
        self.fixed, self.stays, self.left, self.count = [], [], 0, 0

    def numbers(self, values):
        odd = self.rng.random()
        return ", ".join(repr(v) if odd < 0.8 else f"{v:.12E}" for v in values)

    def waypoint(self, kind="Fixed", is_used=False, may_be_of_other_arm=False):
        self.count += 1
        name = f"Waypoint_{self.count}"
        q = self.cell.near(self.q, 0.3)
        if kind == "Fixed":
            (self.stays if is_used else self.fixed).append((name, q))
        blend = f' blendRadius="{self.rng.uniform(0, 0.05):.4f}"' if self.rng.random() < 0.3 else ""
        position = (f'<position>\n  <JointAngles angles="{self.numbers(q)}"/>\n  <TCPOffset pose="0.01, -0.02, 0.15, 0.1, 0.2, 0.3"/>\n'
                    f'{KINEMATICS}\n</position>\n<BaseToFeature pose="0.0, 0.0, 0.0, 0.0, 0.0, 0.0"/>')
        if self.version == 3:
            is_of_other_arm = may_be_of_other_arm and self.rng.random() < 0.2
            position = self.position_with_poses(q, is_of_other_arm)
            if is_of_other_arm:
                self.stays.append(self.fixed.pop())
                self.left += 1
        if kind == "Variable":
            position = '<variable reference="../../../../Assignment/variable"/>'
        if kind == "Relative":
            position = position.replace("position>", "relativeFromPosition>") + position
        return f'<Waypoint type="{kind}" name="{name}" kinematicsFlags="3">\n<motionParameters{blend}/>\n{position}\n</Waypoint>'

    def position_with_poses(self, q, is_of_other_arm):
        """Its poses: of the TCP, of the TCP in a feature, of the flange. Those of another arm miss by some tenths of a mm and more."""
        flange = (self.cell.true if is_of_other_arm else self.cell.nominal).pose(q)
        tcp = vc.after(flange, self.rng.choice(self.cell.tools))
        feature = vc.NONE if self.rng.random() < 0.5 else self.rng.choice(self.cell.bases)
        poses = [self.numbers(pose_numbers(motion)) for motion in (tcp, vc.after(programs.inverse(feature), tcp), flange)]
        return (f'<position joints="{self.numbers(q)}" pose="{poses[0]}"/>\n<poseInFeatureCoordinates pose="{poses[1]}"/>\n'
                f'<outputFlangePose pose="{poses[2]}"/>')

    def move(self):
        k = self.rng.randint(0, 9)
        motion = self.rng.choice(("MoveJ", "MoveL", "MoveP"))
        head = f'<Move motionType="{motion}" speed="0.25" acceleration="1.2" useActiveTCP="true" positionType="CartesianPose">'
        inner = [self.waypoint(may_be_of_other_arm=k != 4) for _ in range(self.rng.randint(1, 3))]
        if k == 0:
            inner.append(self.waypoint("Variable"))
            self.left += 1
        elif k == 1:
            inner.append(self.waypoint("Relative"))
            self.left += 1
        elif k == 2:
            inner.append(f'<CircleMove OrientationMode="FIXED"><children>{self.waypoint()}{self.waypoint()}</children></CircleMove>')
        elif k == 3:  # one move, of which an end is not known
            name = len(self.fixed)
            inner.append(f'<CircleMove><children>{self.waypoint()}{self.waypoint("Variable")}</children></CircleMove>')
            self.stays.append(self.fixed.pop(name))
            self.left += 1
        elif k == 4:  # an expression reads the first waypoint of this move
            inner = [self.waypoint(is_used=True), *inner[1:]]
            self.fixed = [f for f in self.fixed if f"\"{f[0]}\"" in "".join(inner)]  # the one that was not written
            self.left += 1
            return (f"{head}<children>{''.join(inner)}</children></Move><Assignment><expression><ExpressionWaypoint>"
                    f'<Waypoint referenceName="w" reference="../../../../MOVE/children/Waypoint"/>'
                    f"</ExpressionWaypoint></expression></Assignment>")
        elif k == 5:
            inner.append('<Comment comment="joints [1, 2, 3]"/><Wait type="Sleep"><timeout>1.0</timeout></Wait>' + self.waypoint())
        return f"{head}\n<children>\n{''.join(inner)}\n</children>\n</Move>"

    def script(self, text):
        return '<Script type="Line"><expression>' + "".join(f'<ExpressionChar character="{c}"/>' for c in text) + "</expression></Script>"

    def suppressed(self):
        """Never runs: its waypoints may change or stay."""
        before = list(self.fixed), list(self.stays), self.left
        text = f'<SuppressedNode><suppressedNode class="Folder" name="off"><children>{self.move().replace("MOVE", "Move")}</children></suppressedNode></SuppressedNode>'
        self.fixed, self.stays, self.left = before
        return text

    def nodes(self, depth):
        parts, moves = [], 0
        for _ in range(self.rng.randint(1, 4)):
            k = self.rng.randint(0, 8)
            if k == 0 and depth:
                parts.append(f"<Folder name=\"f\"><children>{self.nodes(depth - 1)}</children></Folder>")
            elif k == 1 and depth:
                parts.append(f'<If type="If"><expression><ExpressionChar character="1"/></expression><children>{self.nodes(depth - 1)}</children></If>')
            elif k == 2:
                self.left += 1
                parts.append(self.script("movel(p1)"))
            elif k == 3:
                parts.append(self.script("remove_j(1)"))
            elif k == 4:
                parts.append(self.suppressed())
            else:
                moves += 1
                parts.append(self.move().replace("MOVE", "Move" if moves == 1 else f"Move[{moves}]"))
        return "\n".join(parts)

    def kinematics(self):
        if self.version == 5:
            return '  <kinematics status="LINEARIZED" validChecksum="true"/>'
        rows = "".join(f'    <{name} value="{", ".join(map(repr, row))}"/>\n' for name, row in rows_of(self.cell.nominal_text).items())
        return f'  <kinematics status="LINEARIZED" validChecksum="true">\n{rows}  </kinematics>'

    def write(self):
        body = self.nodes(2)
        body += "\n" + f'<Move motionType="MoveJ"><children>{self.waypoint()}</children></Move>'
        return (f'<URProgram name="part" installation="default" createdIn="5.11.10" lastSavedIn="5.11.10" crcValue="1041004964">\n'
                f'{self.kinematics()}\n  <children>\n    <MainProgram runOnlyOnce="false">\n'
                f"      <children>\n        {body}\n      </children>\n    </MainProgram>\n"
                f"    <Thread><children>{self.nodes(1)}</children></Thread>\n  </children>\n</URProgram>\n")


def waypoints(text):
    """Joint angles by the name of each waypoint."""
    found = {}
    for waypoint in ET.fromstring(text).iter("Waypoint"):
        position = waypoint.find("position")
        if position is not None:
            angles = position.get("joints") or position.find("JointAngles").get("angles")
            found[waypoint.get("name")] = [float(v) for v in angles.split(",")]
    return found


def poses(text):
    """Of each waypoint of PolyScope 3: the TCP, the TCP in the feature and the flange."""
    found = {}
    for waypoint in ET.fromstring(text).iter("Waypoint"):
        stated = [waypoint.find(name) for name in ("position", "poseInFeatureCoordinates", "outputFlangePose")]
        if None not in stated:
            found[waypoint.get("name")] = [rp.vector_motion([float(v) for v in part.get("pose").split(",")]) for part in stated]
    return found


def without_angles(text):
    text = re.sub(r'\s*<Comment comment="corrected by armtrue compensate"/>', "", text, count=1)
    text = re.sub(r'(<(?:position|poseInFeatureCoordinates|outputFlangePose)\b[^>]*\bpose=)"[^"]*"', r'\1""', text)
    return re.sub(r'(angles|joints)="[^"]*"', r'\1=""', text)


class PolyscopeProgramsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(KEEP or tempfile.mkdtemp())
        self.folder.mkdir(exist_ok=True)

    def given(self, number, version=5):
        cell = programs.Cell("urscript", 700 + number)
        writer = Writer(cell, version)
        text = writer.write()
        ET.fromstring(text)
        packed = gzip.compress(text.encode(), mtime=number) if number % 3 else text.encode()
        (self.folder / "part.urp").write_bytes(packed)
        (self.folder / "nominal.yaml").write_text(cell.nominal_text)
        (self.folder / "true.yaml").write_text(cell.true_text)
        return cell, writer, text, packed

    def compensate(self, robot, *options):
        return subprocess.run([BIN / "compensate", "-v", "--robot", robot, "--controller", "nominal.yaml", "--max-mm", "50", *options],
                              cwd=self.folder, capture_output=True, text=True)

    def corrected(self, robot, *options):
        options = options or ("--program", "part.urp", "--program-out", "new.urp")
        run = self.compensate(robot, *options)
        self.assertEqual(run.returncode, 0, run.stderr)
        return (self.folder / "new.urp").read_bytes(), run.stderr

    def poses_belong_together(self, cell, text, now, number):
        """F(q) is the flange; TCP and feature are as before."""
        written, angles = poses(text), waypoints(now)
        for name, (tcp, in_feature, flange) in poses(now).items():
            tcp_before, in_feature_before, flange_before = written[name]
            if name in self.corrected_names:
                self.near(flange, cell.nominal.pose(angles[name]), number, name)
            elif name in self.names_that_stay:
                self.assertEqual([tcp, in_feature, flange], written[name], f"program {number}: {name}")
            together = lambda a, b: vc.after(programs.inverse(a), b)
            self.near(together(flange, tcp), together(flange_before, tcp_before), number, name)
            self.near(vc.after(tcp, programs.inverse(in_feature)), vc.after(tcp_before, programs.inverse(in_feature_before)), number, name)

    def near(self, reached, wanted, number, name):
        error = programs.difference(wanted, reached)
        self.assertLess(vc.length(error[:3]), NEAR_MM, f"program {number}: {name}")
        self.assertLess(vc.length(error[3:]), 1e-6, f"program {number}: {name}")

    def test_the_true_arm_goes_to_each_fixed_waypoint(self):
        corrected = 0
        for number in range(PROGRAMS):
            cell, writer, text, packed = self.given(number, 3 if number % 2 else 5)
            self.assertEqual(self.corrected("nominal.yaml")[0], packed, number)
            bytes_now, said = self.corrected("true.yaml")
            self.assertEqual(bytes_now[:2] == b"\x1f\x8b", packed[:2] == b"\x1f\x8b", number)
            self.assertEqual(self.corrected("true.yaml")[0], bytes_now, "the same bytes again")
            now = (gzip.decompress(bytes_now) if packed[:2] == b"\x1f\x8b" else bytes_now).decode()
            self.assertEqual(without_angles(now), without_angles(text), number)
            angles, written = waypoints(now), waypoints(text)
            for name, q in writer.fixed:
                self.near(cell.true.pose(angles[name]), cell.nominal.pose(q), number, name)
                before = programs.difference(cell.nominal.pose(q), cell.true.pose(q))
                corrected += vc.length(before[:3]) > 0.2
            for name, _ in writer.stays:
                self.assertEqual(angles[name], written[name], f"program {number}: {name}")
            self.corrected_names, self.names_that_stay = ({name for name, _ in of} for of in (writer.fixed, writer.stays))
            if writer.version == 3:
                self.poses_belong_together(cell, text, now, number)
            self.assertIn(f"{writer.left} move{'' if writer.left == 1 else 's'} left alone", said, number)
            (self.folder / "part.urp").write_bytes(bytes_now)
            again = self.compensate("true.yaml", "--program", "part.urp", "--program-out", "new.urp")
            self.assertEqual(again.returncode, 1, again.stderr)
            self.assertIn("corrected", again.stderr)
        print(f"{corrected} waypoints corrected")
        self.assertGreater(corrected, 3 * PROGRAMS)

    def test_a_waypoint_of_polyscope_3_stays_if_its_poses_are_not_its_own(self):
        cell = programs.Cell("urscript", 799)
        writer = Writer(cell, 3)
        (self.folder / "nominal.yaml").write_text(cell.nominal_text)
        (self.folder / "true.yaml").write_text(cell.true_text)
        first, second, third = (writer.waypoint() for _ in range(3))
        shared = re.sub(r'(<poseInFeatureCoordinates) pose="[^"]*"', r'\1 reference="../../Waypoint/poseInFeatureCoordinates"', second)
        sets_tcp = '<Set type="NoAction"><tcp referencedName="TCP_2"/></Set>'
        lacks = re.sub("<outputFlangePose[^>]*>", "", second)
        for move, is_active, stays in (
                (first + shared + third, "false", {"Waypoint_1", "Waypoint_2"}), (first + second + third, "true", set()),
                (first + sets_tcp + second + third, "true", {"Waypoint_1", "Waypoint_2", "Waypoint_3"}),
                (first + sets_tcp + second + third, "false", set()), (first + lacks + third, "false", {"Waypoint_2"})):
            head = f'<Move motionType="MoveL" useActiveTCP="{is_active}"><children>'
            text = (f'<URProgram name="part">{writer.kinematics()}<children><MainProgram><children>{head}{move}</children></Move>'
                    "</children></MainProgram></children></URProgram>")
            (self.folder / "part.urp").write_text(text)
            run = self.compensate("true.yaml", "--program", "part.urp", "--program-out", "new.urp")
            if len(stays) == 3:
                self.assertEqual(run.returncode, 1)
                self.assertIn("its TCP is not certain", run.stderr)
                continue
            self.assertEqual(run.returncode, 0, run.stderr)
            before, after = waypoints(text), waypoints((self.folder / "new.urp").read_text())
            self.assertEqual({name for name in before if before[name] == after[name]}, stays, run.stderr)

    def test_a_packed_program_that_is_cut_off_is_an_error(self):
        _, _, text, packed = self.given(1)
        for damaged in (packed[:len(packed) // 2], packed[:-9], gzip.compress(text[:len(text) // 2].encode()), packed[:40]):
            (self.folder / "part.urp").write_bytes(damaged)
            run = self.compensate("true.yaml", "--program", "part.urp", "--program-out", "new.urp")
            self.assertEqual(run.returncode, 1, run.stderr)
            self.assertIn("cut off", run.stderr)

    def test_a_project_keeps_the_bytes_of_what_is_not_corrected(self):
        cell, writer, text, packed = self.given(2)
        project, new = self.folder / "programs", self.folder / "out"
        for folder in (project, new):
            shutil.rmtree(folder, ignore_errors=True)
        project.mkdir()
        (project / "part.urp").write_bytes(packed)
        still = gzip.compress(b'<URProgram name="still"><children><MainProgram><children/></MainProgram></children></URProgram>', mtime=7)
        (project / "still.urp").write_bytes(still)
        run = self.compensate("true.yaml", "--project", "programs", "--project-out", "out")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual((new / "still.urp").read_bytes(), still)
        self.assertEqual((new / "part.urp").read_bytes(), self.corrected("true.yaml")[0])


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1])
    for option in ("--programs", "--keep"):
        if option in sys.argv:
            at = sys.argv.index(option)
            del sys.argv[at:at + 2]
    del sys.argv[1]
    unittest.main()
