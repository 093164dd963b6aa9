"""Arms, instruments and hidden physics of applied_arm_study.py: one campaign for each seed.

It shares no code with armtrue, and was written from the man pages alone. The arm is a chain of modified Denavit-Hartenberg
rows with beta. What hides in a campaign is a family of FAMILIES, of sizes that the literature of robots, gears, bearings,
trackers and cameras gives, or two or three of them. A family says who owns its error: the arm, the tool or the station. The
truth of a judge is the arm with its tool, as it is at the end of the campaign, without what the station owns.

Lengths are mm, angles rad, masses kg, torques N m, times s.
"""

import csv
import json
import math
import pathlib
import random
import re

from virtual_cell import (NONE, X, Y, Z, about, add, after, cross, dot, fields, kuka, length, moved, placed, scaled,
                          small_motion, sub, transposed, turned)

ROOT = pathlib.Path(__file__).resolve().parents[2]
G = 9.81
MRAD = 1e-3
TARGETS = 60                   # independent poses on which the arm is judged; the first shows no direction of arrival
STEP_S = (12.0, 45.0)          # from visit to visit: the arm drives, settles, is measured
AMBIENT_C = 21.0
NOWHERE = (0.0, 0.0, 0.0)

# ---- arms --------------------------------------------------------------------------------------------------------
# Own structures, of six and seven joints (compensate corrects no arm of fewer): name, joint (R, P, or F for fixed), alpha_deg, d_mm, theta_deg, r_mm, min, max of each link.
# `kg` is the mass of all that moves, `reach` the horizontal reach; both set the sizes of the physics.
OWN = {
    "mill-rail": {"kg": 2100, "masses": True, "links": [
        ("E1", "P", -90, 0, 0, 0, 0, 6000), ("A1", "R", 90, 0, 0, 905, -180, 180), ("A2", "R", -90, 480, 0, 0, -135, 5),
        ("A3", "R", 0, 1350, -90, 0, -60, 150), ("A4", "R", -90, -60, 0, 1420, -350, 350), ("A5", "R", 90, 0, 0, 0, -120, 120),
        ("A6", "R", -90, 0, 0, 0, -350, 350), ("mount", "F", 0, 0, 0, 310)]},
    "mill-2400": {"kg": 950, "masses": False, "links": [
        ("A1", "R", 0, 0, 0, 740, -175, 175), ("A2", "R", -90, 325, -90, 0, -60, 80), ("A3", "R", 0, 1080, 0, 0, -150, 70),
        ("A4", "R", -90, 240, 0, 1220, -200, 200), ("A5", "R", 90, 0, 0, 0, -120, 120), ("A6", "R", -90, 0, 0, 215, -350, 350),
        ("mount", "F", 0, 0, 0, 0)]},
    "pick-530": {"kg": 21, "masses": False, "links": [
        ("A1", "R", 0, 0, 0, 310, -165, 165), ("A2", "R", -90, 30, -90, 0, -95, 110), ("A3", "R", 0, 250, 0, 0, -110, 65),
        ("A4", "R", -90, 45, 0, 255, -180, 180), ("A5", "R", 90, 0, 0, 0, -115, 115), ("A6", "R", -90, 0, 0, 68, -350, 350),
        ("mount", "F", 0, 0, 0, 0)]},
    "cobot-1150": {"kg": 24, "masses": False, "links": [
        ("S1", "R", 0, 0, 0, 150, -180, 180), ("S2", "R", 90, 0, 0, 138, -170, -10), ("S3", "R", 0, -540, 0, -115, -150, 150),
        ("W1", "R", 0, -490, 0, 120, -180, 180), ("W2", "R", 90, 0, 0, 105, -180, 180), ("W3", "R", -90, 0, 0, 96, -180, 180),
        ("mount", "F", 0, 0, 0, 0)]},
    "seven-880": {"kg": 19, "masses": True, "links": [
        ("J1", "R", 0, 0, 0, 320, -160, 160), ("J2", "R", -90, 0, 0, 0, -100, 100), ("J3", "R", 90, 20, 0, 390, -160, 160),
        ("J4", "R", 90, 50, 0, 0, -20, 140), ("J5", "R", -90, -50, 0, 370, -160, 160), ("J6", "R", -90, 0, 0, 0, -110, 110),
        ("J7", "R", 90, 65, 0, 0, -170, 170), ("mount", "F", 0, 0, 0, 120)]},
    "offset-1700": {"kg": 240, "masses": True, "links": [
        ("A1", "R", 0, 0, 0, 550, -170, 170), ("A2", "R", -90, 160, -90, 90, -80, 120), ("A3", "R", 0, 760, 0, -60, -130, 80),
        ("A4", "R", -90, 170, 0, 770, -180, 180), ("A5", "R", 90, 0, 0, 85, -125, 125), ("A6", "R", -90, 0, 0, 150, -350, 350),
        ("mount", "F", 0, 0, 0, 0)]},
    "paint-2600": {"kg": 520, "masses": False, "links": [
        ("A1", "R", 0, 0, 0, 640, -150, 150), ("A2", "R", -90, 100, -90, 0, -70, 90), ("A3", "R", 0, 1200, 0, 0, -90, 90),
        ("A4", "R", -90, 0, 0, 1250, -350, 350), ("A5", "R", 55, 0, 0, 62, -350, 350), ("A6", "R", -55, 0, 0, 110, -350, 350),
        ("mount", "F", 0, 0, 0, 40)]},
}
# Arms of config/robots: kg of all that moves.
SHIPPED = {"kr360-spindle": 1850, "irb6700-200-260": 900, "kr360-rail": 1800, "ur10e": 26, "ur5e": 16, "irb120": 22,
           "kr10-r1100": 48, "iiwa7": 22, "m1013": 28, "gp25": 230, "panda": 17, "tx2-90": 105}
ARMS = list(OWN) + list(SHIPPED)
SHARE_OF_MASS = (0.30, 0.27, 0.20, 0.12, 0.06, 0.03, 0.02)


class Row:
    """One link; angles rad."""

    def __init__(self, name, joint, alpha, d, theta, r, beta=0.0, sign=1.0, low=None, high=None):
        self.name, self.joint, self.sign, self.low, self.high = name, joint, sign, low, high
        self.alpha, self.d, self.theta, self.r, self.beta = alpha, d, theta, r, beta

    def frame(self, value, change=None):
        """Rot(y, beta) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r), with the joint at the value."""
        alpha, d, theta, r, beta = self.alpha, self.d, self.theta, self.r, self.beta
        if self.joint == "R":
            theta += self.sign * value
        elif self.joint == "P":
            r += self.sign * value
        if change:
            alpha, d = alpha + change.get("alpha", 0.0), d + change.get("d", 0.0)
            theta, r, beta = theta + change.get("theta", 0.0), r + change.get("r", 0.0), beta + change.get("beta", 0.0)
        ca, sa, ct, st, cb, sb = (math.cos(alpha), math.sin(alpha), math.cos(theta), math.sin(theta), math.cos(beta),
                                  math.sin(beta))
        # Rot(y, beta) Rot(x, alpha) has the columns x, y, z below; theta turns x and y.
        x, y, z = (cb, 0.0, -sb), (sb * sa, ca, cb * sa), (sb * ca, -sa, cb * ca)
        u = tuple(ct * a + st * b for a, b in zip(x, y))
        v = tuple(ct * b - st * a for a, b in zip(x, y))
        return ((u[0], v[0], z[0]), (u[1], v[1], z[1]), (u[2], v[2], z[2])), tuple(d * a + r * c for a, c in zip(x, z))


def rows_of_text(text):
    """Links of a robot file, and its masses; rows of the standard convention become modified ones."""
    text = re.sub(r"\s+#.*", "", text)
    block = lambda name: re.search(rf"^{name}:(.*(?:\n +.*)*)", text, re.M)
    links = [fields(line) for line in re.findall(r"\{.*\}", block("links")[1])]
    standard, rows, behind = bool(re.search(r"^convention: standard$", text, re.M)), [], (0.0, 0.0)
    for link in links:
        kind = {"revolute": "R", "prismatic": "P", "fixed": "F"}[link["joint"]]
        limits = [link.get(f"{end}_{'mm' if kind == 'P' else 'deg'}") for end in ("min", "max")]
        if kind == "R":
            limits = [math.radians(-180 if limit is None and i == 0 else 180 if limit is None else limit)
                      for i, limit in enumerate(limits)]
        alpha, d = math.radians(link["alpha_deg"]), link["d_mm"]
        now = behind if standard else (alpha, d)
        rows.append(Row(link["name"], kind, now[0], now[1], math.radians(link["theta_deg"]), link["r_mm"],
                        math.radians(link.get("beta_deg", 0.0)), link.get("sign", 1.0), *limits))
        behind = (alpha, d)
    if standard and (abs(behind[0]) > 1e-9 or abs(behind[1]) > 1e-9):
        rows.append(Row(links[-1]["name"] + "_flange", "F", *behind, 0.0, 0.0))
    masses = []
    if block("masses"):
        for line in re.findall(r"\{.*\}", block("masses")[1]):
            mass = fields(line)
            masses.append(([row.name for row in rows].index(mass["link"]), mass["mass_kg"], mass["com_mm"]))
    return rows, masses


class Arm:
    """The nominal arm: rows, travel, masses as they are roughly, and the text of its robot file."""

    def __init__(self, name):
        self.name = name
        if name in OWN:
            entry = OWN[name]
            self.rows = [Row(n, kind, math.radians(alpha), d, math.radians(theta), r, 0.0, 1.0,
                             *(limits if kind == "P" else [math.radians(limit) for limit in limits]))
                         for n, kind, alpha, d, theta, r, *limits in entry["links"]]
            self.masses, self.kg, self.text = [], entry["kg"], None
            self.states_masses = entry["masses"]
        else:
            self.text = (ROOT / "config" / "robots" / f"{name}.yaml").read_text()
            self.rows, self.masses = rows_of_text(self.text)
            self.kg, self.states_masses = SHIPPED[name], bool(self.masses)
        self.driven = [i for i, row in enumerate(self.rows) if row.joint != "F"]
        self.slides = [self.rows[i].joint == "P" for i in self.driven]
        self.names = [self.rows[i].name for i in self.driven]
        self.travel = [(self.rows[i].low, self.rows[i].high) for i in self.driven]
        revolute = [i for i in self.driven if self.rows[i].joint == "R"]
        self.reach = sum(abs(row.d) + abs(row.r) for row in self.rows[revolute[1]:])
        if not self.masses:
            self.masses = self.rough_masses(revolute)

    def rough_masses(self, revolute):
        """Masses half-way to the next axis that lies elsewhere; little of them in the wrist."""
        return [(i, self.kg * SHARE_OF_MASS[min(k, 6)], scaled(self.way_to_next(i), 0.45))
                for k, i in enumerate(revolute)]

    def way_to_next(self, i):
        """From the origin of a link to that of the next one that lies elsewhere, in its axes."""
        here = NONE
        for row in self.rows[i + 1:]:
            here = after(here, row.frame(row.low if row.joint == "P" else 0.0))
            if length(here[1]) > 0.05 * self.reach:
                return here[1]
        return 0.0, 0.0, 0.0

    def columns(self):
        result, count = [], 0
        for name, slides in zip(self.names, self.slides):
            external = re.fullmatch(r"E[1-6]", name)
            count += 0 if external else 1
            result.append((f"e{name[1]}" if external else f"q{count}") + ("_mm" if slides else "_deg"))
        return result

    def values(self, q):
        return [value if slides else math.radians(value) for value, slides in zip(q, self.slides)]

    def file_values(self, q):
        return [value if slides else math.degrees(value) for value, slides in zip(q, self.slides)]

    def frames(self, q, rows=None):
        """Frames of all links in R_0."""
        here, result, joint = NONE, [], iter(q)
        for row in rows or self.rows:
            here = after(here, row.frame(next(joint) if row.joint != "F" else 0.0))
            result.append(here)
        return result

    def loads(self, q, masses, payload, tool):
        """Torque of gravity about each driven joint, N m (N of one that slides); the moment about its origin in the axes
        of its link; the moment about R_0; the direction of gravity in the axes of each link."""
        frames = self.frames(q)
        weights = [(i, kg, moved(frames[i], centre)) for i, kg, centre in masses]
        if payload:
            weights.append((len(self.rows) - 1, payload, moved(after(frames[-1], tool), NOWHERE)))
        torques, moments = [], []
        for i in self.driven:
            rotation, point = frames[i]
            total, pull = [0.0, 0.0, 0.0], 0.0
            for k, kg, place in weights:
                if k >= i:
                    lever = sub(place, point)
                    total[0] -= lever[1] * kg * G / 1000
                    total[1] += lever[0] * kg * G / 1000
                    pull -= kg * G
            moments.append(turned(transposed(rotation), total))
            torques.append(self.rows[i].sign * (rotation[2][2] * pull if self.rows[i].joint == "P" else moments[-1][2]))
        moment = [0.0, 0.0, 0.0]
        for _, kg, place in weights:
            moment[0] -= place[1] * kg * G / 1000
            moment[1] += place[0] * kg * G / 1000
        return torques, moments, moment, [turned(transposed(frame[0]), (0.0, 0.0, -1.0)) for frame in frames]


# ---- what hides --------------------------------------------------------------------------------------------------

class Effect:
    """One cause. Hooks take the sizes and the state of a visit; each is linear in the sizes.

    joint    {driven joint: change of its angle or travel}
    link     {index of a row: {alpha, d, theta, r or beta: change}}
    body     {index of a row: (rotation vector, shift) in the axes of this link, about its origin}
    tool     (rotation vector, shift) in the last frame
    foot     (rotation vector, shift) of R_0, of the arm
    station  (rotation vector, shift) of R_A about its origin
    reading  shift of a measured point in R_A
    wire     change of a measured length
    claims   what a finding may say: (owner, kind of driver, joints or None)
    """

    HOOKS = ("joint", "link", "body", "tool", "foot", "station", "reading", "wire")

    def __init__(self, owner, text, sizes, claims, **hooks):
        self.owner, self.text, self.sizes, self.claims = owner, text, list(sizes), claims
        for name in self.HOOKS:
            setattr(self, name, hooks.get(name))
        self.kind = None


def log_uniform(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def signed(rng, value):
    return value * rng.choice([-1, 1])


def smooth(x, width=1.0):
    return math.tanh(x / width)


FAMILIES = {}


def family(needs="", kind=None):
    """Registers a family. Needs: words that set up the campaign before the family is drawn."""
    def register(function):
        FAMILIES[function.__name__.replace("_", "-")] = (function, needs.split(), kind)
        return function
    return register


def turning(cell, most=3):
    """Some turning joints; seldom the last one, which hardly moves the point."""
    joints = [j for j, slides in enumerate(cell.arm.slides) if not slides]
    if cell.rng.random() < 0.75:
        joints.pop()
    return sorted(cell.rng.sample(joints, min(len(joints), cell.rng.randint(1, most))))


def loaded(cell):
    """Turning joints that gravity loads, strongest first, and the torque of each that few postures exceed."""
    joints = [j for j in range(len(cell.arm.driven)) if not cell.arm.slides[j]
              and cell.torque_scale[j] > 0.02 * max(t for t, s in zip(cell.torque_scale, cell.arm.slides) if not s)]
    return sorted(joints, key=lambda j: -cell.torque_scale[j])


def bending(rng):
    """Deflection at the largest torque: 0.1 to 0.9 mrad (1e6 to 5e6 N m/rad of large arms, 1e4 to 5e4 of cobots)."""
    return log_uniform(rng, 0.12, 0.9) * MRAD


@family(kind="load")
def compliant_joints(rng, cell):
    joints = loaded(cell)
    sizes = [bending(rng) * (1.0 if k < 2 else 0.5) / cell.torque_scale[j] for k, j in enumerate(joints)]
    return Effect("arm", "all joints give way under gravity", sizes, [("arm", "load", None)],
                  joint=lambda s, v: {j: c * v.torque[j] for c, j in zip(s, joints)})


@family(kind="load")
def one_soft_joint(rng, cell):
    j = rng.choice(loaded(cell)[:3])
    return Effect("arm", f"joint {j + 1} gives way", [1.3 * bending(rng) / cell.torque_scale[j]], [("arm", "load", [j])],
                  joint=lambda s, v: {j: s[0] * v.torque[j]})


@family(kind="load")
def two_slopes(rng, cell):
    """Gears are softer about zero torque: hysteresis curves of cycloidal and strain wave gears, 2 to 4 times below 10 to
    30 % of the load."""
    joints = loaded(cell)[:3]
    corner = {j: rng.uniform(0.1, 0.3) * cell.torque_scale[j] for j in joints}
    sizes = []
    for j in joints:
        c = bending(rng) / cell.torque_scale[j]
        sizes += [c, c * rng.uniform(1.0, 3.0)]
    return Effect("arm", "joints are softer about zero torque", sizes, [("arm", "load", None)],
                  joint=lambda s, v: {j: s[2 * k] * v.torque[j] + s[2 * k + 1] * max(-corner[j], min(corner[j], v.torque[j]))
                                      for k, j in enumerate(joints)})


@family(kind="load")
def bent_link(rng, cell):
    """A long link bends as a beam that is clamped at its joint: the end turns, and shifts by 2/3 of its length."""
    i, ahead = max(((i, cell.arm.way_to_next(i)) for i in cell.arm.driven[1:]), key=lambda entry: length(entry[1]))
    turn, along = log_uniform(rng, 0.08, 0.4) * MRAD, scaled(ahead, 1 / length(ahead))
    def motion(s, v):
        bend = scaled(cross(along, v.gravity[i]), s[0])
        return {i: (bend, scaled(cross(bend, ahead), -1 / 3))}     # turns about a third of the length
    return Effect("arm", f"the link behind {cell.arm.rows[i].name} bends by its weight", [turn], [("arm", "load", None)],
                  body=motion)


@family(kind="load")
def soft_bearing(rng, cell):
    """A bearing tilts under the moment across its axis."""
    j = rng.choice(turning(cell))
    i = cell.arm.driven[j]
    across = sorted(math.hypot(*v.moments[j][:2]) for v in cell.visits)
    c = log_uniform(rng, 0.08, 0.4) * MRAD / max(across[int(0.95 * (len(across) - 1))], 1e-6)
    return Effect("arm", f"the bearing of joint {j + 1} tilts under the load", [c], [("arm", "load", None)],
                  body=lambda s, v: {i: ((s[0] * v.moments[j][0], s[0] * v.moments[j][1], 0.0), NOWHERE)})


@family()
def gear_one_and_two(rng, cell):
    joints = turning(cell)
    sizes = []
    for _ in joints:
        for n in (1, 2):
            a, phase = log_uniform(rng, 0.05, 0.35) * MRAD / n, rng.uniform(0, 2 * math.pi)
            sizes += [a * math.cos(phase), a * math.sin(phase)]
    def motion(s, v):
        return {j: sum(s[4 * k + 2 * n] * math.cos((n + 1) * v.q[j]) + s[4 * k + 2 * n + 1] * math.sin((n + 1) * v.q[j])
                       for n in (0, 1)) for k, j in enumerate(joints)}
    return Effect("arm", f"gears of joints {[j + 1 for j in joints]} err once and twice a turn", sizes,
                  [("arm", "angle", joints)], joint=motion)


@family()
def strain_wave(rng, cell):
    """Two cycles for each turn of the wave generator, 10 to 40 arc seconds, and twice a turn of the joint."""
    joints, ratio = turning(cell), rng.choice([80, 100, 120, 160])
    sizes = []
    for _ in joints:
        for low, high in ((0.03, 0.15), (0.05, 0.3)):
            a, phase = log_uniform(rng, low, high) * MRAD, rng.uniform(0, 2 * math.pi)
            sizes += [a * math.cos(phase), a * math.sin(phase)]
    def motion(s, v):
        return {j: s[4 * k] * math.cos(2 * ratio * v.q[j]) + s[4 * k + 1] * math.sin(2 * ratio * v.q[j])
                + s[4 * k + 2] * math.cos(2 * v.q[j]) + s[4 * k + 3] * math.sin(2 * v.q[j]) for k, j in enumerate(joints)}
    return Effect("arm", f"strain wave gears of joints {[j + 1 for j in joints]}", sizes, [("arm", "angle", joints)],
                  joint=motion)


@family()
def resolver(rng, cell):
    """Resolver behind a low gear ratio: once and twice per turn of the motor, whose ratio is no whole number."""
    joints = turning(cell, 2)
    ratio = {j: rng.uniform(4, 18) for j in joints}
    sizes = []
    for j in joints:
        for n in (1, 2):
            a, phase = log_uniform(rng, 0.05, 0.25) * MRAD, rng.uniform(0, 2 * math.pi)
            sizes += [a * math.cos(phase), a * math.sin(phase)]
    def motion(s, v):
        return {j: sum(s[4 * k + 2 * n] * math.cos((n + 1) * ratio[j] * v.q[j])
                       + s[4 * k + 2 * n + 1] * math.sin((n + 1) * ratio[j] * v.q[j]) for n in (0, 1))
                for k, j in enumerate(joints)}
    return Effect("arm", f"resolvers of joints {[j + 1 for j in joints]}", sizes, [("arm", "angle", joints)], joint=motion)


@family()
def teeth(rng, cell):
    j, order = turning(cell, 1)[0], rng.randint(23, 127)
    a, phase = log_uniform(rng, 0.08, 0.35) * MRAD, rng.uniform(0, 2 * math.pi)
    return Effect("arm", f"teeth of joint {j + 1}: {order} cycles a turn", [a * math.cos(phase), a * math.sin(phase)],
                  [("arm", "angle", [j])],
                  joint=lambda s, v: {j: s[0] * math.cos(order * v.q[j]) + s[1] * math.sin(order * v.q[j])})


@family()
def uneven_transmission(rng, cell):
    """A smooth curve over the angle, as of a belt or a worn gear: cycles 1 to 6 whose amplitude falls."""
    j = turning(cell, 1)[0]
    sizes = []
    for n in range(1, 7):
        a, phase = log_uniform(rng, 0.1, 0.4) * MRAD / n, rng.uniform(0, 2 * math.pi)
        sizes += [a * math.cos(phase), a * math.sin(phase)]
    return Effect("arm", f"the transmission of joint {j + 1} is uneven", sizes, [("arm", "angle", [j])],
                  joint=lambda s, v: {j: sum(s[2 * n - 2] * math.cos(n * v.q[j]) + s[2 * n - 1] * math.sin(n * v.q[j])
                                             for n in range(1, 7))})


@family()
def worn_segment(rng, cell):
    """A bump where the arm works most, 10 to 30 deg wide."""
    j = turning(cell, 1)[0]
    low, high = cell.window[j]
    place, width = rng.uniform(low, high), math.radians(rng.uniform(10, 30))
    return Effect("arm", f"a worn segment of joint {j + 1}", [signed(rng, log_uniform(rng, 0.2, 0.8) * MRAD)],
                  [("arm", "angle", [j])],
                  joint=lambda s, v: {j: s[0] * math.exp(-((v.q[j] - place) / width) ** 2)})


@family(kind="backlash")
def backlash(rng, cell):
    joints = turning(cell)
    sizes = [signed(rng, log_uniform(rng, 0.06, 0.35) * MRAD) for _ in joints]
    return Effect("arm", f"joints {[j + 1 for j in joints]} have backlash", sizes, [("arm", "arrival", joints)],
                  joint=lambda s, v: {j: a * v.dir[j] for a, j in zip(s, joints)})


@family(kind="backlash")
def backlash_everywhere(rng, cell):
    joints = [j for j, slides in enumerate(cell.arm.slides) if not slides]
    sign = rng.choice([-1, 1])
    sizes = [sign * log_uniform(rng, 0.05, 0.25) * MRAD for _ in joints]
    return Effect("arm", "all joints have backlash", sizes, [("arm", "arrival", None)],
                  joint=lambda s, v: {j: a * v.dir[j] for a, j in zip(s, joints)})


@family()
def play_under_gravity(rng, cell):
    """A joint rests on the flank to which gravity pulls it."""
    joints = loaded(cell)[:rng.randint(1, 3)]
    sizes = [log_uniform(rng, 0.08, 0.4) * MRAD for _ in joints]
    return Effect("arm", f"play of joints {[j + 1 for j in joints]}; gravity decides the flank", sizes,
                  [("arm", "load", joints), ("arm", "angle", joints)],
                  joint=lambda s, v: {j: a * smooth(v.torque[j] / cell.torque_scale[j], 0.02) for a, j in zip(s, joints)})


@family(kind="backlash")
def friction_lag(rng, cell):
    """The wind-up of a gear turns round within some degrees after a reversal."""
    joints = turning(cell)
    sizes = [-log_uniform(rng, 0.06, 0.3) * MRAD for _ in joints]
    return Effect("arm", f"friction winds up joints {[j + 1 for j in joints]}", sizes, [("arm", "arrival", joints)],
                  joint=lambda s, v: {j: a * v.lag[j] for a, j in zip(s, joints)})


@family()
def torque_hysteresis(rng, cell):
    """Compliance whose loading branch differs from the unloading one."""
    joints = loaded(cell)[:2]
    sizes = []
    for j in joints:
        c = bending(rng) / cell.torque_scale[j]
        sizes += [c, rng.uniform(0.1, 0.3) * c * cell.torque_scale[j]]
    return Effect("arm", "compliance with hysteresis", sizes, [("arm", "load", None), ("arm", "arrival", joints)],
                  joint=lambda s, v: {j: s[2 * k] * v.torque[j] + s[2 * k + 1] * v.load_dir[j] for k, j in enumerate(joints)})


def on_circle(rng, low, high):
    a, phase = log_uniform(rng, low, high), rng.uniform(0, 2 * math.pi)
    return [a * math.cos(phase), a * math.sin(phase)]


def of_housing(cell, j, v, across):
    """A vector across the axis of joint j that stands with its housing, in the axes of the link that turns."""
    return turned(about(Z, -cell.arm.rows[cell.arm.driven[j]].sign * v.q[j]), (*across, 0.0))


def error_motion(s, angle):
    """Both components of a vector across the axis, each a cycle of its own."""
    c, d = math.cos(angle), math.sin(angle)
    return s[0] * c + s[1] * d, s[2] * c + s[3] * d


@family()
def radial_run_out(rng, cell):
    """The centre of a joint moves once a turn on an ellipse that stands with the housing."""
    j = turning(cell, 1)[0]
    i = cell.arm.driven[j]
    return Effect("arm", f"the axis of joint {j + 1} runs out radially",
                  on_circle(rng, 0.04, 0.3) + on_circle(rng, 0.04, 0.3), [("arm", "angle", [j])],
                  body=lambda s, v: {i: (NOWHERE, of_housing(cell, j, v, error_motion(s, v.q[j])))})


@family()
def axial_run_out(rng, cell):
    j, n = turning(cell, 1)[0], rng.choice([1, 2])
    a, phase = log_uniform(rng, 0.03, 0.15), rng.uniform(0, 2 * math.pi)
    i = cell.arm.driven[j]
    return Effect("arm", f"joint {j + 1} runs out axially", [a * math.cos(phase), a * math.sin(phase)],
                  [("arm", "angle", [j])],
                  link=lambda s, v: {i: {"r": s[0] * math.cos(n * v.q[j]) + s[1] * math.sin(n * v.q[j])}})


@family()
def bearing_wobble(rng, cell):
    """The axis tilts once or twice a turn."""
    j, n = turning(cell, 1)[0], rng.choice([1, 2])
    i = cell.arm.driven[j]
    sizes = on_circle(rng, 0.05 * MRAD, 0.3 * MRAD) + on_circle(rng, 0.05 * MRAD, 0.3 * MRAD)
    return Effect("arm", f"the axis of joint {j + 1} wobbles, {n} cycles a turn", sizes, [("arm", "angle", [j])],
                  body=lambda s, v: {i: (of_housing(cell, j, v, error_motion(s, n * v.q[j])), NOWHERE)})


def growing_lengths(cell):
    """Rows and parameters with a length that counts."""
    return [(i, key, getattr(row, key)) for i, row in enumerate(cell.arm.rows) for key in ("d", "r")
            if abs(getattr(row, key)) > 0.1 * cell.arm.reach and row.joint != "P"]


@family("temperature", kind="growth")
def growth_measured(rng, cell):
    lengths, expansion = growing_lengths(cell), rng.choice([11.5e-6, 12e-6, 23e-6, 23e-6])
    return Effect("arm", "links grow; a thermometer shows it", [expansion], [("arm", "temperature", None), ("arm", "time", None)],
                  link=lambda s, v: grown(lengths, s[0] * (v.temperature - cell.start_c)))


@family("clock no-thermometer", kind="growth")
def growth_by_the_clock(rng, cell):
    lengths, expansion = growing_lengths(cell), rng.choice([12e-6, 23e-6])
    return Effect("arm", "links grow; there is no thermometer", [expansion], [("arm", "time", None)],
                  link=lambda s, v: grown(lengths, s[0] * (v.temperature - cell.start_c)))


@family(kind="growth")
def growth_of_one_link(rng, cell):
    lengths, expansion = [rng.choice(growing_lengths(cell))], rng.choice([12e-6, 23e-6])
    return Effect("arm", f"link {cell.arm.rows[lengths[0][0]].name} grows", [1.5 * expansion],
                  [("arm", "time", None), ("arm", "temperature", None)],
                  link=lambda s, v: grown(lengths, s[0] * (v.temperature - cell.start_c)))


def grown(lengths, strain):
    changes = {}
    for i, key, value in lengths:
        changes.setdefault(i, {})[key] = strain * value
    return changes


@family("clock")
def warm_zeros(rng, cell):
    """Zeros drift as motors and gears warm up."""
    joints = turning(cell)
    sizes = [signed(rng, log_uniform(rng, 0.06, 0.4) * MRAD) for _ in joints]
    return Effect("arm", f"zeros of joints {[j + 1 for j in joints]} drift as the arm warms up", sizes,
                  [("arm", "time", joints), ("arm", "temperature", joints)],
                  joint=lambda s, v: {j: a * v.warm for a, j in zip(s, joints)})


@family("clock")
def wear(rng, cell):
    """A zero creeps with the way of the joint."""
    j = turning(cell, 1)[0]
    return Effect("arm", f"joint {j + 1} creeps", [signed(rng, log_uniform(rng, 0.1, 0.6) * MRAD)], [("arm", "time", [j])],
                  joint=lambda s, v: {j: s[0] * v.t / cell.duration})


@family("clock")
def slip(rng, cell):
    """A coupling slips once."""
    j, when = turning(cell, 1)[0], rng.uniform(0.2, 0.8)
    return Effect("arm", f"joint {j + 1} slips at {when:.2f} of the campaign",
                  [signed(rng, log_uniform(rng, 0.15, 1.2) * MRAD)], [("arm", "time", [j])],
                  joint=lambda s, v: {j: s[0] * (v.t > when * cell.duration)})


@family("sessions")
def mastered_anew(rng, cell):
    joints = turning(cell, 2)
    sizes = [signed(rng, log_uniform(rng, 0.2, 1.5) * MRAD) for _ in joints]
    return Effect("arm", f"joints {[j + 1 for j in joints]} are mastered anew between the sessions", sizes,
                  [("arm", "time", joints)], joint=lambda s, v: {j: a * (v.session > 0) for a, j in zip(s, joints)})


@family("sessions")
def crash(rng, cell):
    """A link is bent between the sessions: all its parameters step."""
    i = rng.choice(cell.arm.driven[1:])
    sizes = [signed(rng, rng.uniform(0.1, 0.5)), signed(rng, rng.uniform(0.1, 0.6)) * MRAD,
             signed(rng, rng.uniform(0.1, 0.6)) * MRAD, signed(rng, rng.uniform(0.1, 0.6)) * MRAD]
    joint = cell.arm.driven.index(i)
    return Effect("arm", f"a crash bends link {cell.arm.rows[i].name} between the sessions", sizes,
                  [("arm", "time", [joint])],
                  link=lambda s, v: {i: {"d": s[0], "alpha": s[1], "beta": s[2], "theta": s[3]}} if v.session > 0 else {})


@family()
def coupled_wrist(rng, cell):
    """The ratio of a wrist coupling, or of a belt between two joints, is not as the controller has it."""
    n = len(cell.arm.driven)
    a = rng.choice([n - 2, n - 3, 1])
    return Effect("arm", f"joint {a + 2} turns a little with joint {a + 1}", [signed(rng, log_uniform(rng, 0.1, 0.6) * MRAD)],
                  [("arm", "angle", [a, a + 1])], joint=lambda s, v: {a + 1: s[0] * v.q[a] * (0.01 if cell.arm.slides[a] else 1)})


@family()
def gear_ratio(rng, cell):
    j = turning(cell, 1)[0]
    return Effect("arm", f"joint {j + 1} turns too far by its ratio", [signed(rng, log_uniform(rng, 0.05, 0.4) * MRAD)],
                  [("arm", "angle", [j])], joint=lambda s, v: {j: s[0] * v.q[j]})


@family(kind="load")
def counterbalance(rng, cell):
    """A spring balances joint 2 with a force that is not a pure sine; the joint is compliant."""
    j = loaded(cell)[0]
    c, share, arm = 1.5 * bending(rng) / cell.torque_scale[j], rng.uniform(0.3, 0.7), rng.uniform(0.15, 0.4)
    zero = rng.uniform(-0.4, 0.4)
    def torque(v):
        angle = v.q[j] - sum(cell.window[j]) / 2 + zero
        stretch = math.sqrt(1 + arm * arm - 2 * arm * math.cos(angle))
        return -share * cell.torque_scale[j] * (stretch - 0.7) * math.sin(angle) / stretch
    return Effect("arm", f"a spring balances joint {j + 1}, which is compliant", [c],
                  [("arm", "load", [j]), ("arm", "angle", [j])], joint=lambda s, v: {j: s[0] * (v.torque[j] + torque(v))})


@family()
def cable_drag(rng, cell):
    """The hose pack pulls at the wrist."""
    j = len(cell.arm.driven) - rng.choice([1, 2, 3])
    low, high = cell.window[j]
    middle, width = (low + high) / 2 + rng.uniform(-0.3, 0.3), rng.uniform(0.4, 1.5) * (100 if cell.arm.slides[j] else 1)
    size = signed(rng, log_uniform(rng, 0.1, 0.5) * MRAD * (100 if cell.arm.slides[j] else 1))
    return Effect("arm", f"the hoses pull at joint {j + 1}", [size], [("arm", "angle", [j])],
                  joint=lambda s, v: {j: s[0] * smooth(v.q[j] - middle, width)})


@family("payload", kind="load")
def recorded_payload(rng, cell):
    """Compliant joints carry loads that the operator writes down."""
    joints = loaded(cell)[:4]
    sizes = [bending(rng) / cell.torque_scale[j] for j in joints]
    return Effect("arm", "compliant joints carry loads that are written down", sizes, [("arm", "load", None)],
                  joint=lambda s, v: {j: c * v.torque[j] for c, j in zip(s, joints)})


@family("clock hidden-payload", kind="load")
def payload_nobody_wrote_down(rng, cell):
    joints = loaded(cell)[:4]
    sizes = [bending(rng) / cell.torque_scale[j] for j in joints]
    return Effect("arm", f"from {cell.load_at:.2f} of the campaign on compliant joints carry {cell.load_kg:.0f} kg more",
                  sizes, [("arm", "load", None), ("arm", "time", None)],
                  joint=lambda s, v: {j: c * v.torque[j] for c, j in zip(s, joints)})


@family(kind="load")
def soft_floor(rng, cell):
    """The floor or the pedestal gives way under the moment of the arm."""
    return Effect("arm", "the foot tilts under the moment of the arm", [log_uniform(rng, 0.05, 0.35) * MRAD / cell.moment_scale],
                  [("arm", "load", None)], foot=lambda s, v: (scaled(v.moment, s[0]), NOWHERE))


@family()
def loose_foot(rng, cell):
    """A bolt of the foot is loose: the foot rests on one of two edges, by the side of the moment."""
    heading = rng.uniform(0, 2 * math.pi)
    axis = (math.cos(heading), math.sin(heading), 0.0)
    return Effect("arm", "the foot has free play", [log_uniform(rng, 0.05, 0.25) * MRAD], [("arm", "load", None)],
                  foot=lambda s, v: (scaled(axis, s[0] * smooth(dot(axis, v.moment) / cell.moment_scale, 0.03)), NOWHERE))


@family(kind="load")
def tool_droop(rng, cell):
    """The tool bends by its own weight: at a lever of 100 to 300 mm."""
    turn = log_uniform(rng, 0.15, 1.2) * MRAD
    return Effect("tool", "the tool droops", [turn], [("tool", "load", None)],
                  tool=lambda s, v: ((-s[0] * v.down[1], s[0] * v.down[0], 0.0),
                                     (80 * s[0] * v.down[0], 80 * s[0] * v.down[1], 0.0)))


@family()
def loose_tool(rng, cell):
    """A changer with play: the tool rests on the side to which gravity pulls it."""
    shift, turn = log_uniform(rng, 0.03, 0.2), log_uniform(rng, 0.1, 0.6) * MRAD
    return Effect("tool", "the tool is loose", [shift, turn], [("tool", "load", None)],
                  tool=lambda s, v: ((0.0, s[1] * smooth(v.down[0], 0.05), 0.0), (s[0] * smooth(v.down[0], 0.05), 0.0, 0.0)))


@family("clock")
def warm_spindle(rng, cell):
    return Effect("tool", "the spindle grows along its axis", [log_uniform(rng, 0.03, 0.2)],
                  [("tool", "time", None), ("tool", "temperature", None)],
                  tool=lambda s, v: (NOWHERE, (0.0, 0.0, s[0] * v.warm)))


@family("tracker clock")
def tracker_warms_up(rng, cell):
    tau = rng.uniform(1200, 4500)
    sizes = [rng.gauss(0, 0.03), rng.gauss(0, 0.03), rng.gauss(0, 0.04)] + [rng.gauss(0, 2.5e-5) for _ in range(3)]
    def motion(s, v):
        k = 1 - math.exp(-v.t / tau)
        return scaled(s[3:], k), scaled(s[:3], k)
    return Effect("station", "the tracker warms up", sizes, [("station", "time", None)], station=motion)


@family("clock")
def sinking_stand(rng, cell):
    total, lean = -log_uniform(rng, 0.05, 0.5), rng.gauss(0, 4e-5)
    return Effect("station", "the stand of the instrument sinks", [-total, lean], [("station", "time", None)],
                  station=lambda s, v: ((s[1] * v.t / cell.duration, 0.0, 0.0), (0.0, 0.0, s[0] * v.t / cell.duration)))


@family("clock")
def knocked_station(rng, cell):
    when = rng.uniform(0.2, 0.8)
    sizes = [signed(rng, log_uniform(rng, 0.1, 2.0)) for _ in range(3)] + [rng.gauss(0, 1.5e-4) for _ in range(3)]
    return Effect("station", f"the instrument is knocked at {when:.2f} of the campaign", sizes, [("station", "time", None)],
                  station=lambda s, v: (s[3:], s[:3]) if v.t > when * cell.duration else (NOWHERE, NOWHERE))


@family("sessions")
def two_stations(rng, cell):
    """Nothing but a tracker that stands elsewhere in each session, as the column says."""
    return Effect("none", "each session has its own station", [], [])


@family("tracker", kind="distortion")
def range_scale(rng, cell):
    return Effect("station", "ranges are too long", [signed(rng, log_uniform(rng, 2e-5, 1.5e-4))],
                  [("station", "space", None)], reading=lambda s, v, p: scaled(p, s[0]))


@family("tracker", kind="distortion")
def range_offset(rng, cell):
    return Effect("station", "ranges are off by a constant", [signed(rng, log_uniform(rng, 0.04, 0.3))],
                  [("station", "space", None)], reading=lambda s, v, p: scaled(p, s[0] / length(p)))


@family("tracker", kind="distortion")
def eccentric_circle(rng, cell):
    """The azimuth circle is eccentric: 10 to 70 microradians once a turn, some twice."""
    sizes = [rng.gauss(0, 4e-5) for _ in range(2)] + [rng.gauss(0, 2e-5) for _ in range(2)]
    def shift(s, v, p):
        a = math.atan2(p[1], p[0])
        turn = s[0] * math.cos(a) + s[1] * math.sin(a) + s[2] * math.cos(2 * a) + s[3] * math.sin(2 * a)
        return -turn * p[1], turn * p[0], 0.0
    return Effect("station", "the circle of the tracker is eccentric", sizes, [("station", "space", None)], reading=shift)


@family("tracker", kind="distortion")
def bent_sight(rng, cell):
    """Warm air above the floor bends the sight: 1 K/m gives 0.5 microradians for each m."""
    return Effect("station", "air bends the line of sight", [rng.uniform(1, 4) * 0.5e-9], [("station", "space", None)],
                  reading=lambda s, v, p: (0.0, 0.0, s[0] * dot(p, p)))


@family("camera", kind="distortion")
def distorted_volume(rng, cell):
    """A camera system: a smooth field of second and third degree over the volume."""
    sizes = [rng.gauss(0, 1) * log_uniform(rng, 0.05, 0.4) for _ in range(3 * 6)]
    def shift(s, v, p):
        u = scaled(sub(p, cell.centre), 1 / cell.spread)
        terms = (u[0] * u[0], u[0] * u[1], u[1] * u[2], u[2] * u[2], u[0] * u[0] * u[1], u[2] * u[0] * u[1])
        return tuple(sum(s[6 * i + k] * terms[k] for k in range(6)) for i in range(3))
    return Effect("station", "the measuring volume is distorted", sizes, [("station", "space", None)], reading=shift)


@family("camera", kind="distortion")
def stretched_volume(rng, cell):
    """Another scale in depth: cameras that were calibrated with a wand."""
    axis = scaled(cell.sight, 1.0)
    return Effect("station", "depth has another scale", [signed(rng, log_uniform(rng, 1e-4, 8e-4))],
                  [("station", "space", None)],
                  reading=lambda s, v, p: scaled(axis, s[0] * dot(axis, sub(p, cell.centre))))


@family("wires", kind="distortion")
def wire_drum(rng, cell):
    """The drum is eccentric: one cycle per circumference of 200 to 450 mm."""
    around = [rng.uniform(200, 450) for _ in cell.anchors]
    sizes = []
    for _ in around:
        a, phase = log_uniform(rng, 0.05, 0.25), rng.uniform(0, 2 * math.pi)
        sizes += [a * math.cos(phase), a * math.sin(phase)]
    return Effect("station", "drums of the wires are eccentric", sizes, [("station", "space", None)],
                  wire=lambda s, v, k, l: s[2 * k] * math.cos(2 * math.pi * l / around[k])
                  + s[2 * k + 1] * math.sin(2 * math.pi * l / around[k]))


@family("wires", kind="distortion")
def wire_scale(rng, cell):
    sizes = [signed(rng, log_uniform(rng, 5e-5, 5e-4)) for _ in cell.anchors]
    return Effect("station", "wires have another scale", sizes, [("station", "space", None)],
                  wire=lambda s, v, k, l: s[k] * l)


@family("wires", kind="distortion")
def wire_sag(rng, cell):
    """A wire hangs: its length grows by w^2 L^3 / (24 F^2), 3 to 20 micrometres at 2 m (0.015 N/m, 2 to 5 N)."""
    return Effect("station", "wires hang through", [rng.uniform(0.003, 0.02)], [("station", "space", None)],
                  wire=lambda s, v, k, l: s[0] * (l / 2000) ** 3)


NULL = ("nothing", "nothing-but-blunders", "nothing-but-heavy-tails", "two-stations")
SINGLES = [name for name in FAMILIES if name not in NULL]


# ---- a campaign --------------------------------------------------------------------------------------------------

class Visit:
    pass


class Cell:
    """One campaign, everything that is true in it, and its targets."""

    def __init__(self, seed, hidden=None):
        self.seed = seed
        rng = self.rng = random.Random(f"applied arm {seed}")
        self.hidden = hidden or self.draw_hidden(rng)
        needs = {word for name in self.hidden if name in FAMILIES for word in FAMILIES[name][1]}
        self.draw_arm(rng, needs)
        self.draw_set_up(rng, needs)
        self.draw_truth(rng)
        self.draw_poses(rng)
        self.draw_visits(rng, needs)
        self.place_station(rng)
        self.effects = []
        for name in self.hidden:
            if name in FAMILIES:
                function, _, kind = FAMILIES[name]
                effect = function(rng, self)
                effect.name, effect.kind = name, kind
                if effect.owner in ("arm", "tool") and kind not in ("growth", "load"):
                    effect.sizes = [self.age * size for size in effect.sizes]
                self.effects.append(effect)

    def draw_hidden(self, rng):
        """One campaign of eight has only geometry, three of eight two or three families, the others one."""
        turn = self.seed % 8
        first = SINGLES[(11 * self.seed + self.seed // len(SINGLES)) % len(SINGLES)]
        if turn == 3:
            return [NULL[(self.seed // 8) % len(NULL)]]
        if turn not in (1, 4, 6):
            return [first]
        chosen = [first]
        instruments = {"tracker", "camera", "wires"}
        own = lambda name: set(FAMILIES[name][1]) & instruments
        for _ in range(rng.choice([1, 1, 2])):
            while True:
                other = rng.choice(SINGLES)
                if other not in chosen and len(set().union(*map(own, chosen + [other]))) < 2:
                    break
            chosen.append(other)
        return chosen

    def draw_arm(self, rng, needs):
        # A wire of a rail would be longer than such wires are made.
        self.arm = Arm(rng.choice([name for name in ARMS if "wires" not in needs or "rail" not in name]))
        self.large = self.arm.reach > 1800

    def draw_set_up(self, rng, needs):
        for word in ("tracker", "camera", "wires"):
            if word in needs:
                self.instrument = word
                break
        else:
            self.instrument = rng.choice(["tracker"] * 6 + ["camera"] * 3
                                         + (["wires"] if "rail" not in self.arm.name else ["tracker"]))
        self.with_orientation = (self.instrument == "camera" or
                                 self.instrument == "tracker" and rng.random() < 0.35)
        self.count = rng.choice([20, 25, 30, 30, 35, 40, 40, 50, 50, 60, 60, 80, 80, 100, 150])
        self.repeats = rng.choice([1, 2, 2, 3])
        if self.count * self.repeats > 200:
            self.repeats = 1 + (self.count < 100)
        if self.instrument == "wires":
            self.count, self.repeats = max(self.count, 50), 2
        self.with_time = "clock" in needs and rng.random() < 0.85 or rng.random() < 0.65
        self.with_test = self.seed % 10 == 9 and self.instrument != "wires"
        self.with_directions = rng.random() < 0.35 or self.with_test
        self.with_temperature = "temperature" in needs or "no-thermometer" not in needs and rng.random() < 0.2
        self.sessions = 2 if "sessions" in needs or rng.random() < 0.08 else 1
        self.with_payload = "payload" in needs
        self.load_at, self.load_kg = 1.0, 0.0
        self.age = rng.choice([1.0, 1.0, 1.6, 2.5])         # wear of gears, bearings and bolts against those of a new arm
        scale = {"tracker": rng.uniform(0.02, 0.07), "camera": rng.uniform(0.04, 0.16),
                 "wires": rng.uniform(0.04, 0.12)}[self.instrument]
        self.noise_mm = scale * (1.3 if self.large else 1.0)
        self.noise_mrad = {"tracker": rng.uniform(0.08, 0.2), "camera": rng.uniform(0.2, 0.9), "wires": 0.0}[self.instrument]
        self.heavy_tails = "nothing-but-heavy-tails" in self.hidden or rng.random() < 0.12
        self.blunders = rng.uniform(0.01, 0.03) if "nothing-but-blunders" in self.hidden or rng.random() < 0.15 else 0.0
        self.states_noise = self.repeats == 1 or rng.random() < 0.7
        self.noise_claim = rng.choice([1.0, 1.0, rng.uniform(0.7, 1.4)]) if self.repeats > 1 else 1.0
        self.payload_of_arm = {True: rng.uniform(40, 180), False: rng.uniform(0.5, 4)}[self.large]
        if "hidden-payload" in needs:
            self.load_at, self.load_kg = rng.uniform(0.25, 0.75), self.payload_of_arm
        self.start_c = AMBIENT_C + rng.uniform(-2, 3)
        self.warming_c = rng.uniform(4, 18)

    def draw_truth(self, rng):
        """Geometry as arms are made: of some it was calibrated by the maker."""
        arm = self.arm
        self.made = rng.choice([1.0, 1.0, 1.0, 0.6, 0.25])
        turn = rng.uniform(0.2, 0.6) * MRAD * self.made
        zero = rng.uniform(0.4, 2.0) * MRAD * self.made
        shift = rng.uniform(1.0e-4, 2.5e-4) * arm.reach * self.made
        self.made_turn, self.made_zero, self.made_shift = turn, zero, shift
        self.rows = []
        for i, row in enumerate(arm.rows):
            is_parallel = abs(math.sin(row.alpha)) < 1e-3 and i > 0
            self.rows.append(Row(row.name, row.joint, row.alpha + rng.gauss(0, turn), row.d + rng.gauss(0, shift),
                                 row.theta + (rng.gauss(0, zero) if row.joint == "R" else rng.gauss(0, turn)),
                                 row.r + (rng.gauss(0, 3 * shift) if row.joint == "P" else rng.gauss(0, shift)),
                                 rng.gauss(0, turn) if is_parallel else 0.0, row.sign))
        reach = 300 if self.large else 120
        self.tool = (about(scaled((1, 1, 0.5), 1 / 1.5), rng.uniform(-0.6, 0.6)),
                     (rng.uniform(-0.4, 0.4) * reach, rng.uniform(-0.4, 0.4) * reach, rng.uniform(0.2, 1.0) * reach))
        self.masses = [(i, kg * rng.uniform(0.85, 1.15), add(centre, tuple(rng.gauss(0, 0.008 * arm.reach) for _ in range(3))))
                       for i, kg, centre in arm.masses]

    def draw_poses(self, rng):
        """Joint values in one window of the travel, above the floor and away from the column."""
        arm = self.arm
        share = rng.choice([0.35, 0.5, 0.7, 0.9])
        for _ in range(400):
            window = []
            for j, (low, high) in enumerate(arm.travel):
                if not arm.slides[j]:
                    low, high = max(low, -math.pi), min(high, math.pi)
                margin = 0.03 * (high - low)
                wide = (high - low - 2 * margin) * share
                if not arm.slides[j]:
                    wide = min(wide, math.radians(200))
                start = rng.uniform(low + margin, high - margin - wide)
                window.append((start, start + wide))
            self.window, chosen = window, []
            for _ in range(25 * (self.count + TARGETS)):
                q = self.rounded([rng.uniform(*limits) for limits in window])
                place = moved(after(arm.frames(q)[-1], self.tool), NOWHERE)
                away = math.hypot(place[0], place[1] if "P" != arm.rows[0].joint else 1e9)
                if place[2] > 0.04 * arm.reach and away > 0.25 * arm.reach:
                    chosen.append(q)
                if len(chosen) == self.count + TARGETS:
                    self.train, self.targets = chosen[:self.count], chosen[self.count:]
                    return
        raise RuntimeError(f"seed {self.seed}: no window of {arm.name} has enough poses")

    def rounded(self, q):
        return self.arm.values([round(value, 4) for value in self.arm.file_values(q)])

    def draw_visits(self, rng, needs):
        plan = [(k, r) for r in range(self.repeats) for k in range(self.count)]
        if rng.random() < 0.6:
            rng.shuffle(plan)
        else:
            plan = [(k, r) for r in range(self.repeats) for k in rng.sample(range(self.count), self.count)]
        self.visits, t, n = [], 0.0, len(self.arm.driven)
        direction, lag, last = [rng.choice([-1, 1]) for _ in range(n)], None, None
        kilograms = [0.0, round(0.5 * self.payload_of_arm, 1), round(self.payload_of_arm, 1)]
        self.turn_way = [math.radians(rng.uniform(1, 6)) for _ in range(n)]
        self.tau = rng.uniform(1500, 5000)
        border = rng.uniform(0.4, 0.6) * len(plan)
        load_of = {k: kilograms[k % 3] for k in range(self.count)}
        pause = rng.uniform(600, 3000)
        self.border_s = None
        for number, (k, r) in enumerate(plan):
            v = Visit()
            v.pose, v.repeat, v.q, v.t = k, r, self.train[k], t
            v.session = int(self.sessions > 1 and number >= border)
            if v.session and self.border_s is None:
                t += 4 * pause
                v.t, self.border_s = t, t
            v.payload = load_of[k] if self.with_payload else 0.0
            v.hidden_payload = 0.0
            self.visits.append(v)
            t += rng.uniform(*STEP_S) + (pause if rng.random() < 0.01 else 0.0)
        self.duration = t
        for v in self.visits:
            v.hidden_payload = self.load_kg if v.t > self.load_at * self.duration else 0.0
        self.judged = []
        for k, q in enumerate(self.targets):
            v = Visit()
            v.pose, v.repeat, v.q, v.t, v.session = k, 0, q, self.duration, self.sessions - 1
            v.payload = kilograms[k % 3] if self.with_payload else 0.0
            v.hidden_payload = self.load_kg
            v.temperature = self.start_c + self.warming_c * self.warmth(self.duration)
            self.judged.append(v)
        for v in self.visits:
            v.temperature = self.start_c + self.warming_c * self.warmth(v.t)
        self.first_direction = direction
        self.follow(self.visits)
        turning_torque = [[abs(v.torque[j]) for v in self.visits] for j in range(n)]
        self.torque_scale = [max(sorted(t)[int(0.95 * (len(t) - 1))], 1e-6) for t in turning_torque]
        self.moment_scale = max(sorted(math.hypot(*v.moment[:2]) for v in self.visits)[int(0.95 * (len(self.visits) - 1))], 1e-6)

    def warmth(self, t):
        return 1 - math.exp(-t / self.tau)

    def follow(self, visits, commanded=None):
        """Directions, wind-up and loads of visits in their order; of the commanded joints, if they are others."""
        n = len(self.arm.driven)
        direction, lag, load_direction, last, last_torque = list(self.first_direction), [0.0] * n, [1] * n, None, None
        for k, v in enumerate(visits):
            if commanded:
                v.q = commanded[k]
            v.torque, v.moments, v.moment, v.gravity = self.arm.loads(v.q, self.masses, v.payload + v.hidden_payload, self.tool)
            v.down = v.gravity[-1]
            v.warm = (v.temperature - self.start_c) / self.warming_c
            if last:
                for j in range(n):
                    way = v.q[j] - last[j]
                    if abs(way) > 1e-9:
                        direction[j] = 1 if way > 0 else -1
                        reach = self.turn_way[j] * (100 if self.arm.slides[j] else 1)
                        lag[j] = direction[j] + (lag[j] - direction[j]) * math.exp(-abs(way) / reach)
                    if abs(v.torque[j] - last_torque[j]) > 1e-9:
                        load_direction[j] = 1 if v.torque[j] > last_torque[j] else -1
            v.dir, v.lag, v.load_dir = list(direction), list(lag), list(load_direction)
            last, last_torque = v.q, v.torque

    def place_station(self, rng):
        """R_A is the frame of the instrument, 2 to 5 m off, or one at the foot of the arm."""
        places = [moved(after(self.arm.frames(q)[-1], self.tool), NOWHERE) for q in self.train]
        middle = scaled(tuple(map(sum, zip(*places))), 1 / len(places))
        self.bases, self.stations = [], []
        self.own_frame = self.instrument != "wires" and (self.instrument == "camera" or rng.random() < 0.7)
        common = small_motion(tuple(rng.gauss(0, 1.5e-3) for _ in range(3)), tuple(rng.gauss(0, 5.0) for _ in range(3)), NOWHERE)
        for session in range(self.sessions):
            heading = math.atan2(middle[1], middle[0]) + rng.uniform(-0.8, 0.8)
            away = rng.uniform(1500, 3500) + self.arm.reach
            station = (away * math.cos(heading), away * math.sin(heading), rng.uniform(500, 1700))
            if self.instrument == "wires" and session > 0:     # the rig stands a little elsewhere
                self.bases.append(after(small_motion(tuple(rng.gauss(0, 2e-3) for _ in range(3)),
                                                     tuple(rng.gauss(0, 8.0) for _ in range(3)), NOWHERE), common))
                self.stations.append(station)
            elif self.own_frame or session > 0:
                turn = about(Z, rng.uniform(-math.pi, math.pi))
                level = small_motion(tuple(rng.gauss(0, 1e-4) for _ in range(3)), NOWHERE, NOWHERE)
                self.bases.append(after(level, (turn, scaled(turned(turn, station), -1.0))))
                self.stations.append(NOWHERE)
            else:
                self.bases.append(common)
                self.stations.append(station)
        in_a = [moved(self.bases[0], p) for p in places]
        self.centre = scaled(tuple(map(sum, zip(*in_a))), 1 / len(in_a))
        self.spread = max(length(sub(p, self.centre)) for p in in_a)
        sight = sub(self.centre, self.stations[0])
        self.sight = scaled(sight, 1 / length(sight))
        self.anchors = []
        if self.instrument == "wires":
            for k in range(rng.choice([2, 3, 3])):
                angle = rng.uniform(0, 0.8) + 2.1 * k
                self.anchors.append(add(self.centre, (1.4 * self.spread * math.cos(angle), 1.4 * self.spread * math.sin(angle),
                                                      rng.uniform(-0.9, 0.9) * self.spread)))
            self.zeros = [rng.gauss(0, 2.0) for _ in self.anchors]

    # ---- the arm as it is

    def chain(self, v, sizes=None, rows=None, tool=None):
        """Pose of the measured frame in R_0, with what the arm and the tool own."""
        joint, link, body, foot, tool_motion = {}, {}, {}, None, None
        for effect, s in zip(self.effects, sizes or [effect.sizes for effect in self.effects]):
            if effect.joint:
                for j, change in effect.joint(s, v).items():
                    joint[j] = joint.get(j, 0.0) + change
            if effect.link:
                for i, changes in effect.link(s, v).items():
                    mine = link.setdefault(i, {})
                    for key, change in changes.items():
                        mine[key] = mine.get(key, 0.0) + change
            if effect.body:
                for i, motion in effect.body(s, v).items():
                    body[i] = after(body.get(i, NONE), small_motion(*motion, NOWHERE))
            if effect.foot:
                foot = after(foot or NONE, small_motion(*effect.foot(s, v), NOWHERE))
            if effect.tool:
                tool_motion = after(tool_motion or NONE, small_motion(*effect.tool(s, v), NOWHERE))
        here, number = foot or NONE, 0
        for i, row in enumerate(rows or self.rows):
            value = 0.0
            if row.joint != "F":
                value = v.q[number] + joint.get(number, 0.0)
                number += 1
            here = after(here, row.frame(value, link.get(i)))
            if i in body:
                here = after(here, body[i])
        if tool_motion:
            here = after(here, tool_motion)
        return after(here, tool or self.tool)

    def readings(self, v, sizes=None, rows=None, tool=None, base=None):
        """Pose in R_A as the instrument of the session reads it, without noise; with other numbers than the true ones."""
        sizes = sizes or [effect.sizes for effect in self.effects]
        frame = after(base or self.bases[v.session], self.chain(v, sizes, rows, tool))
        for effect, s in zip(self.effects, sizes):
            if effect.station:
                frame = after(small_motion(*effect.station(s, v), NOWHERE), frame)
        station = self.stations[v.session] if self.instrument == "tracker" else NOWHERE
        shift = NOWHERE
        for effect, s in zip(self.effects, sizes):
            if effect.reading:
                shift = add(shift, effect.reading(s, v, sub(frame[1], station)))
        return frame[0], add(frame[1], shift)

    def lengths(self, v, sizes=None, rows=None, tool=None, base=None, anchors=None):
        sizes = sizes or [effect.sizes for effect in self.effects]
        point, result = self.readings(v, sizes, rows, tool, base)[1], []
        for k, anchor in enumerate(anchors or self.anchors):
            l = length(sub(point, anchor))
            for effect, s in zip(self.effects, sizes):
                if effect.wire:
                    l += effect.wire(s, v, k, l)
            result.append(l + self.zeros[k])
        return result

    def execute(self, commanded):
        """Points in R_0 of the arm as it is that comes to commanded joint values one after the other, and its frames."""
        visits = self.judged
        self.follow(visits, commanded)
        return [self.chain(v)[1] for v in visits]

    # ---- files

    def noise(self, rng, size):
        if self.heavy_tails:
            size *= math.sqrt(4 / max(rng.gammavariate(2.0, 2.0), 1e-3)) * math.sqrt(0.5)
        return rng.gauss(0, size)

    def measured(self):
        """Header and rows of the campaign."""
        rng = random.Random(f"applied arm {self.seed} noise")
        header = ["pose", "repeat"] + (["t_s"] if self.with_time else []) + self.arm.columns()
        header += ["anchor", "l_mm"] if self.instrument == "wires" else ["x_mm", "y_mm", "z_mm"]
        header += ["a_deg", "b_deg", "c_deg"] if self.with_orientation else []
        header += ["session"] if self.sessions > 1 else []
        header += [f"dir{j + 1}" for j in range(len(self.arm.driven))] if self.with_directions else []
        header += ["temp_arm_c"] if self.with_temperature else []
        header += ["payload_kg"] if self.with_payload else []
        rows = []
        for v in self.visits:
            head = [v.pose + 1, v.repeat + 1] + ([f"{v.t:.1f}"] if self.with_time else [])
            head += [f"{value:.4f}" for value in self.arm.file_values(v.q)]
            tail = [f"day {v.session + 1}"] if self.sessions > 1 else []
            tail += v.dir if self.with_directions else []
            tail += [f"{v.temperature + rng.gauss(0, 0.1):.2f}"] if self.with_temperature else []
            tail += [f"{v.payload:.1f}"] if self.with_payload else []
            if self.instrument == "wires":
                for k, l in enumerate(self.lengths(v)):
                    l += self.noise(rng, self.noise_mm) + self.blunder(rng)
                    rows.append(head + [k + 1, f"{l:.4f}"] + tail)
                continue
            rotation, point = self.readings(v)
            gross = self.blunder(rng)
            point = add(point, tuple(self.noise(rng, self.noise_mm) for _ in range(3)))
            point = add(point, scaled((0.6, -0.48, 0.64), gross))
            turn = tuple(self.noise(rng, self.noise_mrad * MRAD) for _ in range(3))
            angles = []
            if self.with_orientation:
                angles = [f"{a:.6f}" for a in kuka(after(small_motion(turn, NOWHERE, NOWHERE), (rotation, point))[0])]
            rows.append(head + [f"{x:.4f}" for x in point] + angles + tail)
        return header, rows

    def blunder(self, rng):
        return signed(rng, rng.uniform(2, 20)) if rng.random() < self.blunders else 0.0

    def robot_text(self, truth=False):
        """The nominal robot file; with `truth` that of the real links, base and tool."""
        rng = random.Random(f"applied arm {self.seed} file")
        pose = lambda motion, digits: "{" + ", ".join(
            [f"{key}_mm: {x:.{digits}f}" for key, x in zip("xyz", motion[1])]
            + [f"{key}_deg: {a:.{digits + 2}f}" for key, a in zip("abc", kuka(motion[0]))]) + "}"
        base, tool = self.bases[0], self.tool
        if not truth:
            rough = 20.0 if self.own_frame else 3.0
            base = after(base, small_motion(tuple(rng.gauss(0, 3e-3) for _ in range(3)),
                                            tuple(rng.gauss(0, rough) for _ in range(3)), NOWHERE))
            tool = after(tool, small_motion(tuple(rng.gauss(0, 4e-3) for _ in range(3)),
                                            tuple(rng.gauss(0, 2.0) for _ in range(3)), NOWHERE))
        lines = ["format: armtrue-robot/1", f"name: {self.arm.name}", f"base: {pose(base, 6 if truth else 1)}", "links:"]
        number = lambda x: f"{x:.9f}".rstrip("0").rstrip(".") if abs(x) > 5e-10 else "0"
        for row, nominal in zip(self.rows if truth else self.arm.rows, self.arm.rows):
            kind = {"R": "revolute", "P": "prismatic", "F": "fixed"}[row.joint]
            line = (f"{{name: {row.name}, joint: {kind}, alpha_deg: {number(math.degrees(row.alpha))}, d_mm: {number(row.d)}, "
                    f"theta_deg: {number(math.degrees(row.theta))}, r_mm: {number(row.r)}, "
                    f"beta_deg: {number(math.degrees(row.beta))}")
            if row.joint == "R":
                line += (f", sign: {number(row.sign)}, min_deg: {number(math.degrees(nominal.low))}, "
                         f"max_deg: {number(math.degrees(nominal.high))}")
            elif row.joint == "P":
                line += f", sign: {number(row.sign)}, min_mm: {number(nominal.low)}, max_mm: {number(nominal.high)}"
            lines.append("  - " + line + "}")
        lines.append(f"tool: {pose(tool, 6 if truth else 1)}")
        if self.instrument == "wires":
            lines.append("anchors:")
            for k, anchor in enumerate(self.anchors):
                place = anchor if truth else add(anchor, tuple(rng.gauss(0, 1.0) for _ in range(3)))
                lines.append(f'  "{k + 1}": {{x_mm: {place[0]:.1f}, y_mm: {place[1]:.1f}, z_mm: {place[2]:.1f}}}')
        if self.arm.states_masses:
            lines.append("masses:")
            for i, kg, centre in self.arm.masses:
                lines.append(f"  - {{link: {self.arm.rows[i].name}, mass_kg: {number(kg)}, "
                             f"com_mm: [{', '.join(number(round(x, 1)) for x in centre)}]}}")
        if self.instrument == "tracker" and not self.own_frame and self.sessions == 1:
            lines.append("instrument_mm: [" + ", ".join(f"{x + rng.gauss(0, 30):.0f}" for x in self.stations[0]) + "]")
        if self.states_noise:
            orientation = f", orientation_mrad: {self.noise_mrad * self.noise_claim:.3f}" if self.with_orientation else ""
            lines.append(f"noise: {{position_mm: {self.noise_mm * self.noise_claim:.4f}{orientation}}}")
        return "\n".join(lines) + "\n"

    def target_rows(self):
        header = ["pose"] + self.arm.columns() + (["t_s"] if self.with_time else [])
        header += ["temp_arm_c"] if self.with_temperature else []
        header += ["payload_kg"] if self.with_payload else []
        rows = []
        for v, q in zip(self.judged, self.targets):
            rows.append([f"T{v.pose + 1}"] + [f"{value:.4f}" for value in self.arm.file_values(q)]
                        + ([f"{v.t:.1f}"] if self.with_time else [])
                        + ([f"{v.temperature:.2f}"] if self.with_temperature else [])
                        + ([f"{v.payload:.1f}"] if self.with_payload else []))
        return header, rows

    def answer(self):
        return {"seed": self.seed, "arm": self.arm.name, "hidden": self.hidden,
                "effects": [{"name": e.name, "owner": e.owner, "text": e.text, "sizes": e.sizes, "kind": e.kind,
                             "claims": e.claims} for e in self.effects],
                "instrument": self.instrument + (" with orientations" if self.with_orientation else ""),
                "poses": self.count, "repeats": self.repeats, "noise_mm": self.noise_mm, "noise_mrad": self.noise_mrad,
                "heavy_tails": self.heavy_tails, "blunders": self.blunders, "time": self.with_time,
                "directions": self.with_directions, "temperature": self.with_temperature, "sessions": self.sessions,
                "payload": self.with_payload, "made": self.made, "age": self.age, "noise_stated": self.states_noise,
                "floor_mm": self.floor_mm(), "duration_s": self.duration}

    def floor_mm(self):
        return self.noise_mm * (math.sqrt(2 / math.pi) if self.instrument == "wires" else math.sqrt(8 / math.pi))

    def write(self, folder):
        folder = pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "robot.yaml").write_text(self.robot_text())
        (folder / "true-geometry.yaml").write_text(self.robot_text(truth=True))
        header, rows = self.measured()
        is_test = lambda row: self.with_test and row[0] > 0.8 * self.count
        for name, (header, rows) in (("train", (header, [row for row in rows if not is_test(row)])),
                                     ("test", (header, [row for row in rows if is_test(row)])), ("targets", self.target_rows())):
            if not rows:
                continue
            with open(folder / f"{name}.csv", "w", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows([header] + rows)
        (folder / "answer.json").write_text(json.dumps(self.answer(), indent=1) + "\n")
