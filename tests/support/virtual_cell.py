#!/usr/bin/env python3
"""A virtual cell: an arm, a tracker and one hidden effect, most of them outside the catalogue of armtrue.

    virtual_cell.py --seed N --out DIR [--effect NAME] [--robot NAME] [--poses N] [--visits N]
    virtual_cell.py --list

It shares no code with armtrue. The arm is a product of exponentials: six screws and a home pose, read off the robot
file.
DIR gets robot.yaml (nominal), train.csv, test.csv (held out, same region and time), truth_test.csv (where the arm truly
is in these poses: no noise, no error of the instrument) and answer.json. In one campaign of four nobody has entered the
reflector into robot.yaml: it stands up to 80 mm off. Most campaigns are in the frame of the tracker, whose place is the
origin, the others in a frame at the foot of the robot. The same seed gives the same files.

Lengths are mm, angles rad, masses kg, torques N m, times s.
"""

import argparse
import csv
import json
import math
import pathlib
import random
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
NOISE_MM = (0.03, 0.15)
ENTERED = 0.75                 # share of campaigns whose robot file has the reflector to some 3 mm, not as it was
SIZE = (1.0, 5.0)              # RMS of the effect at the point, about its mean, over the noise of an axis
TEST_POSES = 60
STEP_S = 20.0
OWN_FRAME = 0.7                # share of campaigns in the frame of the tracker

# Arms that config/robots does not have, by their data sheets: name, alpha, d, theta, r of each link; kg and centre of
# each mass. The masses are rough; they stand in the robot file only if `masses` is true.
DATA_SHEETS = {
    "cobot-1300": {"masses": False, "links": [
        ("A1", 0, 0, 0, 127.3), ("A2", 90, 0, 0, 0), ("A3", 0, -612, 0, 0), ("A4", 0, -572.3, 0, 163.9),
        ("A5", 90, 0, 0, 115.7), ("A6", -90, 0, 0, 92.2)],
        "kg": [("A1", 7.8, (0, 0, 0)), ("A2", 12.9, (-306, 0, 160)), ("A3", 3.9, (-286, 0, 50)), ("A4", 2, (0, 0, 0)),
               ("A5", 2, (0, 0, 0)), ("flange", 1.5, (0, 0, 20))],
        "travel": [(-180, 180), (-160, -20), (-150, 150), (-180, 180), (-180, 180), (-180, 180)]},
    "bench-580": {"masses": False, "links": [
        ("A1", 0, 0, 0, 290), ("A2", -90, 0, -90, 0), ("A3", 0, 270, 0, 0), ("A4", -90, 70, 0, 302),
        ("A5", 90, 0, 0, 0), ("A6", -90, 0, 180, 72)],
        "kg": [("A1", 6, (0, 0, 0)), ("A2", 4, (120, 0, 0)), ("A3", 4.5, (30, 0, 10)), ("A4", 3, (0, 0, -100)),
               ("A5", 0.7, (0, 0, 0)), ("flange", 1, (0, 0, 20))],
        "travel": [(-165, 165), (-110, 110), (-110, 70), (-160, 160), (-120, 120), (-400, 400)]},
    "heavy-2650": {"masses": True, "links": [
        ("A1", 0, 0, 0, 670), ("A2", -90, 312, -90, 0), ("A3", 0, 1075, 0, 0), ("A4", -90, 225, 0, 1280),
        ("A5", 90, 0, 0, 0), ("A6", -90, 0, 0, 215)],
        "kg": [("A1", 450, (150, 0, -200)), ("A2", 220, (500, 0, 0)), ("A3", 200, (150, 0, 100)),
               ("A4", 90, (0, 0, -400)), ("A5", 40, (0, 0, 0)), ("flange", 60, (0, 0, 80))],
        "travel": [(-185, 185), (-60, 76), (-120, 132), (-350, 350), (-120, 120), (-350, 350)]},
}
FROM_CONFIG = ["kr360", "kr360-spindle", "kr360-eq1-zero", "kr360-table4"]
ROBOTS = FROM_CONFIG + list(DATA_SHEETS)       # drawn by the seed
OTHERS = ["gp25", "irb120", "irb6700-200-260", "kr10-r1100", "kr210-r2700", "m1013", "r2000ic-165f", "tx2-90",
          "ur3e", "ur5e", "ur10e"]              # by name only


# ---- vectors and rigid motions -----------------------------------------------------------------------------------

def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def turned(rotation, v):
    """The rotation is three rows. Written out, as the products below: nearly all time of the simulations is spent here."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    x, y, z = v
    return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)


def transposed(rotation):
    return tuple(zip(*rotation))


def rotation_times(first, second):
    (a, b, c), (d, e, f), (g, h, i) = first
    (j, k, l), (m, n, o), (p, q, r) = second
    return ((a * j + b * m + c * p, a * k + b * n + c * q, a * l + b * o + c * r),
            (d * j + e * m + f * p, d * k + e * n + f * q, d * l + e * o + f * r),
            (g * j + h * m + i * p, g * k + h * n + i * q, g * l + h * o + i * r))


def about(axis, angle):
    """Rodrigues' formula; the axis has unit length."""
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    k = 1 - c
    return ((c + k * x * x, k * x * y - s * z, k * x * z + s * y),
            (k * x * y + s * z, c + k * y * y, k * y * z - s * x),
            (k * x * z - s * y, k * y * z + s * x, c + k * z * z))


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
NONE = ((X, Y, Z), (0.0, 0.0, 0.0))


def after(first, second):
    """The rigid motion `first * second`; a motion is (rotation, translation)."""
    ((a, b, c), (d, e, f), (g, h, i)), (s, t, u) = first
    ((j, k, l), (m, n, o), (p, q, r)), (x, y, z) = second
    return (((a * j + b * m + c * p, a * k + b * n + c * q, a * l + b * o + c * r),
             (d * j + e * m + f * p, d * k + e * n + f * q, d * l + e * o + f * r),
             (g * j + h * m + i * p, g * k + h * n + i * q, g * l + h * o + i * r)),
            (a * x + b * y + c * z + s, d * x + e * y + f * z + t, g * x + h * y + i * z + u))


def moved(motion, point):
    ((a, b, c), (d, e, f), (g, h, i)), (s, t, u) = motion
    x, y, z = point
    return (a * x + b * y + c * z + s, d * x + e * y + f * z + t, g * x + h * y + i * z + u)


def screw(axis, point, angle):
    rotation = about(axis, angle)
    return rotation, sub(point, turned(rotation, point))


def small_motion(vector, shift, centre):
    """Turns by a rotation vector about a centre, then shifts."""
    angle = length(vector)
    rotation = about(scaled(vector, 1 / angle), angle) if angle > 0 else NONE[0]
    return rotation, add(sub(centre, turned(rotation, centre)), shift)


def kuka(rotation):
    """A, B, C of Rz(A) Ry(B) Rx(C), in degrees."""
    b = math.atan2(-rotation[2][0], math.hypot(rotation[0][0], rotation[1][0]))
    return (math.degrees(math.atan2(rotation[1][0], rotation[0][0])), math.degrees(b),
            math.degrees(math.atan2(rotation[2][1], rotation[2][2])))


# ---- the arm -----------------------------------------------------------------------------------------------------

def fields(text):
    """The entries of one `{key: value, ...}` of a robot file."""
    result = {}
    for key, many, one in re.findall(r"(\w+): *(?:\[([^\]]*)\]|([^,{}]+))", text):
        if many:
            result[key] = tuple(float(number) for number in many.split(","))
        else:
            try:
                result[key] = float(one)
            except ValueError:
                result[key] = one.strip()
    return result


def placed(entry):
    """Pose {x_mm, y_mm, z_mm, a_deg, b_deg, c_deg} as a motion."""
    rotation = rotation_times(about(Z, math.radians(entry["a_deg"])), rotation_times(
        about(Y, math.radians(entry["b_deg"])), about(X, math.radians(entry["c_deg"]))))
    return rotation, (entry["x_mm"], entry["y_mm"], entry["z_mm"])


class Arm:
    """Screws, a home pose and masses, as they stand in R_0 when all encoders show zero; `slides` says which of the
    joints move along their axis."""

    def __init__(self, text):
        text = re.sub(r"\s+#.*", "", text)
        block = lambda name: re.search(rf"^{name}:(.*(?:\n +.*)*)", text, re.M)
        self.base = placed(fields(block("base")[1]))
        self.tool = placed(fields(block("tool")[1]))
        links = [fields(line) for line in re.findall(r"\{.*\}", block("links")[1])]
        self.axes, self.points, self.travel, self.square, self.slides, frames = [], [], [], [], [], {}
        self.names = [link["name"] for link in links if link["joint"] != "fixed"]
        here, square = NONE, False
        standard = bool(re.search(r"^convention: standard$", text, re.M))
        for link in links:
            bend = [(about(axis, math.radians(link.get(key, 0.0))), NONE[1])
                    for axis, key in ((Y, "beta_deg"), (X, "alpha_deg"))] + [(NONE[0], (link["d_mm"], 0.0, 0.0))]
            turn = [screw(Z, NONE[1], math.radians(link["theta_deg"])), (NONE[0], (0.0, 0.0, link["r_mm"]))]
            before, behind = (turn, bend) if standard else (bend + turn, [])
            is_square = abs(math.cos(math.radians(link["alpha_deg"]))) < 1e-3
            for step in before:
                here = after(here, step)
            if link["joint"] != "fixed":
                slides = link["joint"] == "prismatic"
                self.slides.append(slides)
                self.square.append(square if standard else is_square)
                self.axes.append(scaled(turned(here[0], Z), link.get("sign", 1.0)))
                self.points.append(here[1])
                self.travel.append((link["min_mm"], link["max_mm"]) if slides else
                                   tuple(math.radians(link.get(*limit)) for limit in
                                         (("min_deg", -180.0), ("max_deg", 180.0))))
            square = is_square
            for step in behind:
                here = after(here, step)
            frames[link["name"]] = (len(self.axes), here)
        self.home = here
        gravity = block("gravity_m_s2")
        self.gravity = fields("g: " + gravity[1])["g"] if gravity else (0.0, 0.0, -9.81)
        self.masses = []
        if block("masses"):
            for line in re.findall(r"\{.*\}", block("masses")[1]):
                mass = fields(line)
                joints, frame = frames[mass["link"]]
                self.masses.append((joints, mass["mass_kg"], moved(frame, mass["com_mm"])))

    def in_names_of_links(self, patterns):
        """Patterns that count joints, A1 to A6, in the names of this arm's links."""
        named = lambda found: (self.names[int(found[1]) - 1] if found[1] != "*" else "*") + "."
        return [(re.sub(r"^A([1-6*])\.", named, parameter), driver) for parameter, driver in patterns]

    def twins(self, patterns):
        """Patterns of beta where it is theta by another name: behind an alpha of 90 deg both turn about one axis."""
        result = []
        for j, square in enumerate(self.square, 1):
            drivers = [driver for parameter, driver in patterns if square and parameter == f"A{j}.theta"]
            result += [(f"A{j}.beta", "moment*" if "gravity" in driver else driver) for driver in drivers]
        return result

    def motion(self, j, value):
        """What joint j does to all behind it; the value is an angle in rad or a way in mm."""
        if self.slides[j]:
            return NONE[0], scaled(self.axes[j], value)
        return screw(self.axes[j], self.points[j], value)

    def pose(self, q, truth=None, effect=None, size=0.0, state=None):
        """The measured frame in R_A; with a truth the real arm, otherwise the nominal one."""
        here = truth["base"] if truth else self.base
        turns, links = {}, {}
        if effect and size:
            turns, links = effect.joints(state), effect.links(state)
            if effect.base:
                vector, shift = effect.base(state)
                here = after(small_motion(scaled(vector, size), scaled(shift, size), NONE[1]), here)
        joints = len(self.axes)
        for j in range(joints):
            angle = q[j]
            if truth:
                here = after(here, truth["links"][j])
                angle += truth["zeros"][j]
            if j in links:
                here = after(here, (NONE[0], scaled(links[j], size)))
            here = after(here, self.motion(j, angle + size * turns.get(j, 0.0)))
        if truth:
            here = after(here, truth["links"][joints])
        if joints in links:
            here = after(here, (NONE[0], scaled(links[joints], size)))
        return after(after(here, self.home), truth["tool"] if truth else self.tool)

    def torques(self, q, masses):
        """Torque of gravity about each joint, N m; of one that slides the force along it, N."""
        steps = []
        here = NONE
        for j in range(len(self.axes)):
            here = after(here, self.motion(j, q[j]))
            steps.append(here)
        centres = [(joints, kg, moved(steps[joints - 1], centre)) for joints, kg, centre in masses]
        result = []
        for j in range(len(self.axes)):
            axis, point = turned(steps[j][0], self.axes[j]), moved(steps[j], self.points[j])
            behind = [(kg, centre) for joints, kg, centre in centres if joints > j]
            if self.slides[j]:
                result.append(sum(kg * dot(axis, self.gravity) for kg, _ in behind))
                continue
            arm = cross(self.gravity, axis)  # axis * (lever x gravity) = lever * (gravity x axis)
            result.append(sum(kg * dot(sub(centre, point), arm) for kg, centre in behind) / 1000)
        return result


def data_sheet_yaml(name):
    sheet = DATA_SHEETS[name]
    lines = ["format: armtrue-robot/1", f"name: {name}",
             "base: {x_mm: 0, y_mm: 0, z_mm: 0, a_deg: 0, b_deg: 0, c_deg: 0}", "links:"]
    for (link, alpha, d, theta, r), (low, high) in zip(sheet["links"], sheet["travel"]):
        lines.append(f"  - {{name: {link}, joint: revolute, alpha_deg: {alpha}, d_mm: {d}, theta_deg: {theta}, "
                     f"r_mm: {r}, beta_deg: 0, sign: 1, min_deg: {low}, max_deg: {high}}}")
    lines += ["  - {name: flange, joint: fixed, alpha_deg: 0, d_mm: 0, theta_deg: 0, r_mm: 0, beta_deg: 0}",
              "tool: {x_mm: 0, y_mm: 0, z_mm: 0, a_deg: 0, b_deg: 0, c_deg: 0}"]
    masses = ["masses:"] + [f"  - {{link: {link}, mass_kg: {kg}, com_mm: [{x}, {y}, {z}]}}"
                            for link, kg, (x, y, z) in sheet["kg"]]
    end = ["gravity_m_s2: [0, 0, -9.81]", "identify: auto", "noise: {position_mm: 0.1, orientation_mrad: 0.15}",
           "effects: []"]
    both = lambda with_masses: "\n".join(lines + (masses if with_masses else []) + end) + "\n"
    return both(sheet["masses"]), both(True)


def rough_masses(arm):
    """Masses of an arm whose file has none: 30 kg times the fourth power of the reach in m, which is 20 kg at 0.9 m and
    some 2 t at 2.9 m; of that each link has its share by the square of the way from its joint to the end."""
    ends = arm.points + [arm.home[1]]
    ways = [sum(length(sub(b, a)) for a, b in zip(ends[j:], ends[j + 1:])) for j in range(6)]
    moving = 30.0 * (ways[1] / 1000) ** 4
    return [(j + 1, moving * way ** 2 / sum(w * w for w in ways), scaled(add(ends[j], ends[j + 1]), 0.5))
            for j, way in enumerate(ways)]


def robot_text(name):
    """The nominal file, and the same with masses, which the real arm has in any case."""
    if name in DATA_SHEETS:
        return data_sheet_yaml(name)
    text = (ROOT / "config" / "robots" / f"{name}.yaml").read_text()
    return text, text


# ---- hidden effects ----------------------------------------------------------------------------------------------

class Effect:
    """What is hidden, at unit size. Each part is a function of the state of a reading.

    joints: turns {joint 0 to 5: rad}; links: shifts {joint: vector in R_0 at encoder zero}; base: (turn, shift) in R_A;
    instrument: what the tracker adds to a point. `right` are the patterns of (parameter, driver) that describe the same
    physics, `stories` the names of the catalogue that tell it. `near` patterns have joint or time right, no more.
    law: the effect as a robot file declares it, where armtrue knows a law for it.
    """

    def __init__(self, family, text, right=(), stories=(), near=(), joints=None, links=None, base=None,
                 instrument=None, law=None):
        self.family, self.text, self.law = family, text, law
        self.right, self.stories, self.near = list(right), list(stories), list(near)
        self.joints = joints or (lambda state: {})
        self.links = links or (lambda state: {})
        self.base, self.instrument = base, instrument


class Reading:
    """State of one visit: angles, time, torques, direction and friction state of each joint."""

    __slots__ = ("pose", "repeat", "q", "t", "torque", "direction", "stroke", "temperature", "frame", "tool_torque")


THETA = "A{}.theta"
ANY_TIME = [("*", "time*")]
INSTRUMENT = [("instrument.*", "*")]
SAG = ["joint compliance", "link bending", "play under gravity", "another load"]
MOVED = ["tracker drift", "tracker knocked"]
BASE_TIME = [("base*", "time"), ("A1.alpha", "time"), ("A1.beta", "time")]


def from_station(cell, point):
    v = sub(point, cell["station"])
    return v, length(v)


def radial_offset(rng, cell):
    def shift(point, state):
        v, r = from_station(cell, point)
        return scaled(v, 1 / r)
    return Effect("instrument", "the tracker adds a constant to each range", INSTRUMENT,
                  ["radial offset", "distorted space"], instrument=shift,
                  law="{name: told, parameter: instrument.range, driver: position, shape: linear}")


def range_scale(rng, cell):
    return Effect("instrument", "the tracker scales each range", INSTRUMENT, ["instrument scale"],
                  instrument=lambda point, state: scaled(from_station(cell, point)[0], 1e-3))


def range_reset(rng, cell):
    when = rng.uniform(0.25, 0.75) * cell["duration"]

    def shift(point, state):
        v, r = from_station(cell, point)
        return scaled(v, (state.t >= when) / r)
    return Effect("instrument", f"the range of the tracker is zeroed anew at {when:.0f} s",
                  INSTRUMENT + [("base*", "time")], MOVED + ["instrument re-zeroed"], ANY_TIME, instrument=shift,
                  law=f"{{name: told, parameter: instrument.range, driver: time, shape: step, at_s: {when}}}")


def refraction(rng, cell):
    return Effect("instrument", "the beam bends: points sag with the square of the distance", INSTRUMENT,
                  ["refraction", "index error", "distorted space"],
                  instrument=lambda point, state: (0.0, 0.0, -(from_station(cell, point)[1] / 1000) ** 2),
                  law="{name: told, parameter: instrument.elevation, driver: range, shape: linear}")


def circle(rng, cell):
    cycles, phase, vertical = rng.choice([1, 2]), rng.uniform(0, 2 * math.pi), rng.random() < 0.4

    def shift(point, state):
        v, r = from_station(cell, point)
        flat = math.hypot(v[0], v[1])
        if vertical:
            turn = 1e-3 * math.sin(cycles * math.atan2(v[2], flat) + phase)
            return (-v[2] * v[0] / flat * turn, -v[2] * v[1] / flat * turn, flat * turn)
        turn = 1e-3 * math.sin(cycles * math.atan2(v[1], v[0]) + phase)
        return (-v[1] * turn, v[0] * turn, 0.0)
    name = "elevation" if vertical else "azimuth"
    return Effect("instrument", f"the {name} circle of the tracker has {cycles} cycles per turn", INSTRUMENT,
                  ["eccentric circle", "distorted space"], instrument=shift,
                  law=f"{{name: told, parameter: instrument.{name}, driver: {name}, shape: harmonic {cycles}}}")


def station_turns(rng, cell):
    axis = (rng.gauss(0, 0.3), rng.gauss(0, 0.3), 1.0)

    def shift(point, state):
        return scaled(cross(axis, from_station(cell, point)[0]), 1e-3 * state.t / cell["duration"])
    return Effect("instrument", "the station turns slowly", INSTRUMENT + BASE_TIME, MOVED + ["station turns"],
                  ANY_TIME, instrument=shift,
                  law="{name: told, parameter: instrument.azimuth, driver: time, shape: linear}")


def incidence(rng, cell):
    facing = cell["facing"]

    def shift(point, state):
        v, r = from_station(cell, point)
        c = -dot(turned(state.frame, facing), v) / r
        return scaled(v, (1 - c * c) / r)
    return Effect("instrument", "the range depends on the incidence on the reflector", INSTRUMENT,
                  ["incidence on the reflector"], instrument=shift)


def volumetric(rng, cell):
    powers = [(a, b, c) for a in range(4) for b in range(4) for c in range(4) if 2 <= a + b + c <= 3]
    factors = [[rng.gauss(0, 1) for _ in powers] for _ in range(3)]

    def shift(point, state):
        u = scaled(sub(point, cell["centre"]), 1 / cell["spread"])
        terms = [u[0] ** a * u[1] ** b * u[2] ** c for a, b, c in powers]
        return tuple(sum(f * t for f, t in zip(row, terms)) for row in factors)
    return Effect("instrument", "the tracker distorts space smoothly (terms of degree 2 and 3)", INSTRUMENT,
                  ["distorted space", "refraction", "index error", "eccentric circle", "radial offset",
                   "instrument scale"],
                  instrument=shift)


def of_joint(j):
    return [(THETA.format(j), "*")]


def own(j):
    """Patterns of joint j (from 1) as a function of its own angle."""
    return [(THETA.format(j), driver) for driver in
            (f"joint-angle {j}", f"joint-angle {j},*", f"joint-angle *,{j}", f"joint-angle {j} [*] *")]


def friction(rng, cell):
    j, stroke = rng.choice([1, 2, 3, 4, 5]), math.radians(rng.uniform(4, 25))
    cell["stroke"][j - 1] = stroke
    text = f"friction of axis {j}: its wind-up changes over {math.degrees(stroke):.0f} deg after a reversal"
    return Effect("hysteresis", text, [(THETA.format(j), f"*{driver} {j}*") for driver in ("arrival", "stroke")],
                  ["backlash", "friction hysteresis"], of_joint(j),
                  joints=lambda state: {j - 1: 1e-3 * state.stroke[j - 1]})


def gravity_play(rng, cell):
    able = []
    for j in (2, 3, 4, 5):
        up = sum(reading.torque[j - 1] > 0 for reading in cell["readings"]) / len(cell["readings"])
        if 0.15 < up < 0.85:
            able.append(j)
    j = rng.choice(able or [5])
    largest = max(abs(reading.torque[j - 1]) for reading in cell["readings"]) or 1.0
    return Effect("hysteresis", f"play of axis {j} is taken up by the torque of gravity",
                  [(THETA.format(j), f"gravity-torque {j}*"), (THETA.format(j), "moment*")], SAG, of_joint(j),
                  joints=lambda state: {j - 1: 1e-3 * math.tanh(40 * state.torque[j - 1] / largest)})


COMPLIANCE = (0.4, 0.3, 0.5, 2.0, 2.0, 4.0)


def tool_mass(rng, cell):
    when = rng.uniform(0.25, 0.75) * cell["duration"]
    soft = [c * rng.uniform(0.6, 1.6) for c in COMPLIANCE]
    right = [(THETA.format(j), f"*{driver} {j}*") for j in range(1, 7) for driver in ("gravity-torque", "tool-weight")]

    def turns(state):
        if state.t < when:
            return {}
        return {j: 1e-6 * soft[j] * state.tool_torque[j] for j in range(6)}
    return Effect("load", f"the tool changes its mass at {when:.0f} s; all joints sag", right, SAG,
                  ANY_TIME, joints=turns)


def hose(rng, cell):
    a, b = rng.choice([(4, 5), (5, 4), (3, 2), (1, 2), (5, 6)])
    at = [reading.q[a - 1] for reading in cell["readings"]]
    bt = [reading.q[b - 1] for reading in cell["readings"]]
    a0, b0 = rng.uniform(min(at), max(at)), rng.uniform(min(bt), max(bt))
    slack = rng.uniform(0.2, 0.6)

    def turns(state):
        u, v = state.q[a - 1] - a0, state.q[b - 1] - b0
        stretch = math.sqrt(2.2 - 2 * math.cos(u) * math.cos(v))
        return {a - 1: -1e-3 * max(0.0, stretch - slack) * math.sin(u) * math.cos(v) / stretch}
    right = [(THETA.format(a), f"joint-angle {a},{b}"), (THETA.format(a), f"joint-angle {b},{a}"),
             (THETA.format(a), f"joint-angle {a}"), (THETA.format(a), f"joint-angle {b}")]
    return Effect("load", f"a hose pulls on axis {a}, by the angles of axes {a} and {b}", right, near=of_joint(a),
                  joints=turns)


def cam(rng, cell, text, shape):
    j = rng.choice([1, 2, 3, 4, 5])
    angles = sorted(reading.q[j - 1] for reading in cell["readings"])
    q0 = angles[int(rng.uniform(0.2, 0.8) * len(angles))]
    return Effect("cam", text.format(j=j, at=math.degrees(q0)), own(j), near=of_joint(j),
                  joints=lambda state: {j - 1: 1e-3 * shape(state.q[j - 1] - q0)})


def bump(rng, cell):
    wide = math.radians(rng.uniform(5, 25)) / 2.355
    return cam(rng, cell, f"axis {{j}} has a bump of {math.degrees(2.355 * wide):.0f} deg at {{at:.0f}} deg",
               lambda x: math.exp(-x * x / (2 * wide * wide)))


def angle_step(rng, cell):
    return cam(rng, cell, "axis {j} has a step at {at:.0f} deg", lambda x: float(x > 0))


def kink(rng, cell):
    return cam(rng, cell, "axis {j} has a kink at {at:.0f} deg", lambda x: max(0.0, x))


def worn_segment(rng, cell):
    cycles, wide, phase = rng.uniform(12, 60), math.radians(rng.uniform(25, 60)) / 2.355, rng.uniform(0, 2 * math.pi)
    return cam(rng, cell, f"axis {{j}} has a worn segment at {{at:.0f}} deg with {cycles:.1f} cycles per turn",
               lambda x: math.exp(-x * x / (2 * wide * wide)) * math.sin(cycles * x + phase))


def warm(cell, t):
    return 1 - math.exp(-t / cell["tau"])


def gas_spring(rng, cell):
    phase, ratio, heat = rng.uniform(0, 2 * math.pi), rng.uniform(0.3, 0.7), rng.uniform(0.1, 0.4)

    def turns(state):
        x = state.q[1] - phase
        distance = math.sqrt(1 + ratio * ratio - 2 * ratio * math.cos(x))
        return {1: 1e-3 * (1 + heat * warm(cell, state.t)) * (distance - 0.2) * math.sin(x) / distance}
    return Effect("arm", "the gas spring of axis 2 is not in the model, and its force grows as it warms up", own(2),
                  ["eccentricity", "eccentricity, twice per turn"],
                  of_joint(2), joints=turns)


def parallelogram(rng, cell):
    phase = rng.uniform(0, 2 * math.pi)
    return Effect("arm", "a parallelogram turns axis 3 by the angle of axis 2",
                  [("A3.theta", driver) for driver in ("joint-angle 2", "joint-angle 2,*", "joint-angle *,2")],
                  near=of_joint(3),
                  joints=lambda state: {2: 1e-3 * (math.sin(state.q[1] + phase) + 0.4 * math.sin(2 * state.q[1]))})


def stiffening(rng, cell):
    j, power = rng.choice([2, 3, 5]), rng.choice([0.4, 0.5, 1.8])
    largest = max(abs(reading.torque[j - 1]) for reading in cell["readings"]) or 1.0

    def turns(state):
        part = state.torque[j - 1] / largest
        return {j - 1: 1e-3 * math.copysign(abs(part) ** power, part)}
    return Effect("arm", f"axis {j} sags with its torque of gravity to the power {power}",
                  [(THETA.format(j), f"gravity-torque {j}*"), (THETA.format(j), f"motor-torque {j}"),
                   (THETA.format(j), "moment*")], SAG, of_joint(j), joints=turns)


def two_time_constants(rng, cell):
    fast, slow = (rng.uniform(0.05, 0.2) * cell["duration"], rng.uniform(0.4, 1.0) * cell["duration"])
    over = rng.choice([-0.7, 0.6])
    arm = cell["arm"]
    ends = arm.points + [arm.home[1]]

    def shifts(state):
        grown = 1e-3 * (1 - math.exp(-state.t / fast) + over * (1 - math.exp(-state.t / slow)))
        here = (0.0, 0.0, 0.0)
        result = {}
        for j, end in enumerate(ends):
            result[j] = scaled(sub(end, here), grown)
            here = end
        return result
    right = [("A*.d", "time*"), ("A*.r", "time*"), ("A*.d", "temperature*"), ("A*.r", "temperature*"),
             ("flange.*", "time*"), ("spindle.*", "time*"), ("base.z", "time*"), ("instrument.scale", "time*")]
    return Effect("time", f"all links grow, with time constants of {fast:.0f} and {slow:.0f} s", right,
                  ["thermal growth", "tracker drift", "instrument scale"],
                  [("base.*", "temperature*")] + ANY_TIME, links=shifts)


def zero_drift(rng, cell):
    j, top = rng.choice([1, 2, 3, 4, 5]), rng.choice([0.0, 0.4, 0.5])
    right = [(THETA.format(j), "time*")] + ([("base.rz", "time*"), ("base", "time*")] if j == 1 else [])
    text = f"the zero of axis {j} drifts with the square of the time"
    return Effect("time", text, right, ["zero drift", "tracker drift"], of_joint(j) + ANY_TIME,
                  joints=lambda state: {j - 1: 1e-3 * (state.t / cell["duration"] - top) ** 2})


def base_tilt(rng, cell):
    when, tau = rng.uniform(0.2, 0.6) * cell["duration"], rng.uniform(0.1, 0.4) * cell["duration"]
    direction, rest = rng.uniform(0, 2 * math.pi), rng.uniform(0.1, 0.4)
    axis = (math.cos(direction), math.sin(direction), 0.0)

    def motion(state):
        if state.t < when:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        return scaled(axis, 1e-3 * (rest + (1 - rest) * math.exp(-(state.t - when) / tau))), (0.0, 0.0, 0.0)
    return Effect("time", f"the foot tilts at {when:.0f} s and relaxes", BASE_TIME, MOVED, ANY_TIME, base=motion)


def nothing(rng, cell):
    return Effect("nothing", "nothing is hidden")


EFFECTS = {f.__name__: f for f in (
    radial_offset, range_scale, range_reset, refraction, circle, station_turns, incidence, volumetric, friction,
    gravity_play, tool_mass, hose, bump, angle_step, kink, worn_segment, gas_spring, parallelogram, stiffening,
    two_time_constants, zero_drift, base_tilt, nothing)}
TURNS = list(EFFECTS) + ["nothing", "nothing"]      # seeds take turns


# ---- a campaign --------------------------------------------------------------------------------------------------

def true_arm(rng, arm):
    """Links, zeros, base and tool as they really are."""
    vector = lambda s: tuple(rng.gauss(0, s) for _ in range(3))
    links = [small_motion(vector(3e-4), vector(0.3), point) for point in arm.points + [arm.home[1]]]
    return {"base": after(small_motion(vector(1e-3), vector(3.0), NONE[1]), arm.base),
            "links": links, "zeros": [rng.gauss(0, 1.5e-3) for _ in arm.axes],
            "tool": after(arm.tool, small_motion(vector(5e-3), tuple(rng.uniform(-80, 80) for _ in range(3)), NONE[1]))}


def poses(rng, arm, count):
    """Joint angles in one region, and the tracker: it stands 2 to 6 m off and sees the points past the arm."""
    reach = length(sub(arm.home[1], arm.points[1])) + length(sub(arm.points[2], arm.points[1]))
    share = rng.choice([0.45, 0.7, 0.9])
    while True:
        limits = []
        for j, (low, high) in enumerate(arm.travel):
            low, high = (max(low, -math.pi), min(high, math.pi)) if j > 2 else (low, high)
            wide = min((high - low) * share, math.radians(200 if j == 0 else 360))
            start = rng.uniform(low, high - wide)
            limits.append((start, start + wide))
        chosen = []
        centre_q = [(low + high) / 2 for low, high in limits]
        seen = arm.pose(centre_q)[1]
        foot = arm.base[1]
        heading = math.atan2(seen[1] - foot[1], seen[0] - foot[0]) + rng.uniform(-0.9, 0.9)
        away = rng.uniform(2000, 6000) + 0.5 * reach
        station = add(foot, (away * math.cos(heading), away * math.sin(heading), rng.uniform(600, 1800)))
        for _ in range(30 * count):
            q = [rng.uniform(low, high) for low, high in limits]
            p = sub(arm.pose(q)[1], foot)
            on_side = p[0] * math.cos(heading) + p[1] * math.sin(heading)
            if p[2] > 100 and math.hypot(p[0], p[1]) > 0.15 * reach and on_side > -0.05 * reach \
                    and length(sub(add(p, foot), station)) > 900:
                chosen.append(q)
                if len(chosen) == count:
                    return chosen, station
        # Too few poses of this region are seen: another region.


def visits(rng, cell, chosen, train, repeats):
    """Visits in random order. Test poses are visited once, between the others."""
    plan = [(k, r) for k in range(len(chosen)) for r in range(repeats if k < train else 1)]
    rng.shuffle(plan)
    arm, readings, t, last = cell["arm"], [], 0.0, None
    for k, r in plan:
        reading = Reading()
        reading.pose, reading.repeat, reading.q, reading.t = k, r, chosen[k], t
        reading.torque = arm.torques(chosen[k], cell["masses"])
        reading.tool_torque = arm.torques(chosen[k], [(6, 50.0, moved(arm.home, (30.0, 0.0, 150.0)))])
        reading.direction = [0] * 6 if last is None else [
            (b > a + 1e-9) - (b < a - 1e-9) for a, b in zip(last, chosen[k])]
        reading.frame = arm.pose(chosen[k])[0]
        last = chosen[k]
        readings.append(reading)
        t += STEP_S * rng.uniform(0.8, 1.3)
        if rng.random() < 0.01:
            t += rng.uniform(200, 900)                   # a pause
    cell["duration"] = t
    return readings


def follow_friction(cell):
    """The wind-up z of a joint goes towards the sign of its motion within a stroke: dz = (sign - z) ds / stroke."""
    z, last = [0.0] * 6, None
    for reading in cell["readings"]:
        if last:
            for j in range(6):
                way = reading.q[j] - last[j]
                if way:
                    sign = math.copysign(1.0, way)
                    z[j] = sign + (z[j] - sign) * math.exp(-abs(way) / cell["stroke"][j])
        reading.stroke, last = list(z), reading.q


def observed(cell, reading, size, with_instrument=True):
    effect = cell["effect"]
    frame = cell["arm"].pose(reading.q, cell["truth"], effect, size, reading)
    if with_instrument and effect.instrument and size:
        shift = effect.instrument(frame[1], reading)
        return frame[0], add(frame[1], scaled(shift, size))
    return frame


def spread_rms(shifts):
    """RMS length about the mean."""
    n = len(shifts)
    mean = [sum(s[i] for s in shifts) / n for i in range(3)]
    return math.sqrt(sum((s[i] - mean[i]) ** 2 for s in shifts for i in range(3)) / n)


def shifts_by(cell, size):
    return [sub(observed(cell, r, size)[1], observed(cell, r, 0.0)[1]) for r in cell["readings"]]


def left_after_refit(cell, shifts):
    """RMS length of what base, links and tool cannot imitate, by Gram-Schmidt on all small motions of the chain."""
    arm, truth = cell["arm"], cell["truth"]
    step = max(1, len(cell["readings"]) // 150)
    chosen = range(0, len(cell["readings"]), step)
    columns = []
    for k in chosen:
        q = cell["readings"][k].q
        tip = arm.pose(q, truth)[1]
        here, row = truth["base"], [[], [], []]
        for j in range(7):
            centre = arm.points[j] if j < 6 else arm.home[1]
            lever = sub(tip, moved(here, centre))
            for axis in transposed(here[0]):
                turn = cross(axis, lever)
                for i in range(3):
                    row[i] += [axis[i], turn[i] / 1000]
            if j < 6:
                turn = screw(arm.axes[j], arm.points[j], q[j] + truth["zeros"][j])
                here = after(after(here, truth["links"][j]), turn)
        last = after(after(here, truth["links"][6]), after(arm.home, truth["tool"]))
        for axis in transposed(last[0]):
            for i in range(3):
                row[i].append(axis[i])
        columns += row
    columns = [list(c) for c in zip(*columns)]
    rest = [shifts[k][i] for k in chosen for i in range(3)]
    basis = []
    for column in columns:
        before = math.sqrt(sum(x * x for x in column))
        for _ in range(2):
            for b in basis:
                s = sum(x * y for x, y in zip(column, b))
                column = [x - s * y for x, y in zip(column, b)]
        norm = math.sqrt(sum(x * x for x in column))
        if norm > 1e-5 * before:
            basis.append([x / norm for x in column])
    for b in basis:
        s = sum(x * y for x, y in zip(rest, b))
        rest = [x - s * y for x, y in zip(rest, b)]
    return math.sqrt(sum(x * x for x in rest) / len(chosen))


def set_frame(cell):
    """R_A of the files. The frame of the tracker stands upright; the robot file has the base in it roughly."""
    rng = random.Random(f"frame {cell['seed']}")
    cell["own_frame"], cell["frame"] = rng.random() < OWN_FRAME, NONE
    if not cell["own_frame"]:
        return
    turn = about(Z, rng.uniform(-math.pi, math.pi))
    cell["frame"] = (turn, scaled(turned(turn, cell["station"]), -1.0))
    rotation, place = after(cell["frame"], cell["arm"].base)
    angles = [f"{key}_deg: {angle + rng.gauss(0, 0.3):.2f}" for key, angle in zip("abc", kuka(rotation))]
    place = [f"{key}_mm: {x + rng.gauss(0, 20):.0f}" for key, x in zip("xyz", place)]
    cell["robot_text"] = re.sub(r"^base: .*", f"base: {{{', '.join(place + angles)}}}", cell["robot_text"], flags=re.M)


def campaign(seed, effect=None, robot=None, count=None, repeats=None, hidden_in_it=True):
    """One campaign: everything that is true in it, and its readings. Without the effect `hidden_in_it` it is the same
    campaign, noise included."""
    rng = random.Random(f"virtual cell {seed}")
    effect = effect or TURNS[seed % len(TURNS)]
    robot = robot or rng.choice(ROBOTS)
    nominal, with_masses = robot_text(robot)
    arm = Arm(with_masses)
    train = count or rng.choice([25, 40, 60, 80, 120, 200])
    repeats = repeats or rng.choice([1, 2, 3])
    cell = {"seed": seed, "robot": robot, "robot_text": nominal, "arm": arm, "name": effect, "train": train,
            "repeats": repeats, "points_only": rng.random() < 0.4, "noise_mm": rng.uniform(*NOISE_MM),
            "noise_mrad": rng.uniform(0.08, 0.2), "with_temperature": rng.random() < 0.3,
            "stroke": [math.radians(5)] * 6}
    cell["truth"] = true_arm(rng, arm)
    cell["entered"] = rng.random() < ENTERED
    if cell["entered"]:
        reflector = ", ".join(f"{axis}_mm: {x + rng.gauss(0, 3):.0f}"
                              for axis, x in zip("xyz", cell["truth"]["tool"][1]))
        cell["robot_text"] = re.sub(r"^tool: \{x_mm: [^,]*, y_mm: [^,]*, z_mm: [^,]*", f"tool: {{{reflector}", nominal,
                                    flags=re.M)
    cell["masses"] = [(joints, kg * rng.uniform(0.85, 1.15), add(centre, tuple(rng.gauss(0, 15) for _ in range(3))))
                      for joints, kg, centre in arm.masses or rough_masses(arm)]
    chosen, cell["station"] = poses(rng, arm, train + TEST_POSES)
    set_frame(cell)
    cell["readings"] = visits(rng, cell, chosen, train, repeats)
    cell["tau"] = rng.uniform(0.1, 0.5) * cell["duration"]
    cell["facing"] = scaled(Z, rng.choice([-1.0, 1.0])) if rng.random() < 0.5 else X
    places = [arm.pose(reading.q)[1] for reading in cell["readings"]]
    cell["centre"] = tuple(sum(p[i] for p in places) / len(places) for i in range(3))
    cell["spread"] = max(length(sub(p, cell["centre"])) for p in places)
    for reading in cell["readings"]:
        reading.temperature = 22 + 12 * warm(cell, reading.t)
    hidden = cell["effect"] = EFFECTS[effect](rng, cell)
    for patterns in (hidden.right, hidden.near):
        patterns += arm.twins(patterns)
        patterns[:] = arm.in_names_of_links(patterns)
    follow_friction(cell)
    cell["size"] = 0.0
    if hidden_in_it and effect != "nothing":
        goal = cell["noise_mm"] * rng.uniform(*SIZE)
        cell["goal_mm"], cell["size"] = goal, 1e-3
        for _ in range(3):                               # large turns are not quite linear
            cell["size"] *= goal / spread_rms(shifts_by(cell, cell["size"]))
    shifts = shifts_by(cell, cell["size"]) if cell["size"] else []
    cell["effect_rms_mm"] = spread_rms(shifts) if shifts else 0.0
    cell["left_rms_mm"] = left_after_refit(cell, shifts) if shifts else 0.0
    return cell


def rows(cell, rng, keep, noise=True, with_instrument=True):
    header = ["pose", "repeat", "t_s"] + [f"q{j}_deg" for j in range(1, 7)] + ["x_mm", "y_mm", "z_mm"]
    header += [] if cell["points_only"] else ["a_deg", "b_deg", "c_deg"]
    header += [f"dir{j}" for j in range(1, 7)] + (["temp_arm_c"] if cell["with_temperature"] else [])
    header += ["sigma_mm"] if cell["repeats"] == 1 else []
    header += ["sigma_deg"] if cell["repeats"] == 1 and not cell["points_only"] else []
    yield header
    for reading in cell["readings"]:
        rotation, point = after(cell["frame"], observed(cell, reading, cell["size"], with_instrument))
        wobble = tuple(rng.gauss(0, cell["noise_mm"]) for _ in range(3))
        turn = tuple(rng.gauss(0, 1e-3 * cell["noise_mrad"]) for _ in range(3))
        warmth = reading.temperature + rng.gauss(0, 0.1)
        if not keep(reading.pose):
            continue
        if noise:
            point = add(point, wobble)
            rotation = rotation_times(small_motion(turn, NONE[1], NONE[1])[0], rotation)
        row = [reading.pose + 1, reading.repeat + 1, f"{reading.t:.3f}"] + [repr(math.degrees(a)) for a in reading.q]
        row += [f"{x:.7f}" for x in point] + ([] if cell["points_only"] else [f"{a:.9f}" for a in kuka(rotation)])
        row += reading.direction + ([f"{warmth:.3f}"] if cell["with_temperature"] else [])
        row += [f"{cell['noise_mm']:.5f}"] if cell["repeats"] == 1 else []
        row += [f"{math.degrees(1e-3 * cell['noise_mrad']):.7f}"] if "sigma_deg" in header else []
        yield row


def write(cell, folder):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(cell["robot_text"])
    train, test = (lambda pose: pose < cell["train"]), (lambda pose: pose >= cell["train"])
    for name, keep, noise, instrument in (("train", train, True, True), ("test", test, True, True),
                                          ("truth_test", test, False, False)):
        with open(folder / f"{name}.csv", "w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(
                rows(cell, random.Random(f"noise {cell['seed']}"), keep, noise, instrument))
    effect = cell["effect"]
    answer = {"seed": cell["seed"], "effect": cell["name"], "family": effect.family, "description": effect.text,
              "law": effect.law, "right": effect.right, "stories": effect.stories, "near": effect.near,
              "robot": cell["robot"],
              "poses": cell["train"], "visits": cell["repeats"], "points_only": cell["points_only"],
              "noise_mm": cell["noise_mm"],
              "floor_mean_mm": cell["noise_mm"] * math.sqrt(8 / math.pi), "size": cell["size"],
              "effect_rms_mm": cell["effect_rms_mm"], "left_after_refit_rms_mm": cell["left_rms_mm"],
              "temperature_recorded": cell["with_temperature"],
              "reflector_entered": cell["entered"], "own_frame": cell["own_frame"]}
    (folder / "answer.json").write_text(json.dumps(answer, indent=1) + "\n")
    return answer


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path)
    parser.add_argument("--effect", choices=EFFECTS)
    parser.add_argument("--robot", choices=ROBOTS + OTHERS)
    parser.add_argument("--poses", type=int)
    parser.add_argument("--visits", type=int)
    parser.add_argument("--list", action="store_true", help="names of effects and robots")
    options = parser.parse_args()
    if options.list:
        print("effects:", *EFFECTS, "\nrobots:", *ROBOTS, *OTHERS)
        return 0
    if not options.out:
        parser.error("--out is required")
    write(campaign(options.seed, options.effect, options.robot, options.poses, options.visits), options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
