"""Small interpreters of robot programs: what a controller would be told by a text. They share no code with armtrue, and
know just the statements of the programs that robot_programs_test.py writes.

Each gives a list of targets: line, kind ("joints" or "pose"), six joint angles of the model in rad or the motion base from
TCP, the base and the tool as motions, and what the text says of the configuration. Lengths are mm. A motion is (rotation
of three rows, translation), as in virtual_cell.
"""

import collections
import math
import re

import virtual_cell as vc

Target = collections.namedtuple("Target", "line kind value base tool configuration")
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def abc_motion(x, y, z, a, b, c):
    return vc.placed({"x_mm": x, "y_mm": y, "z_mm": z, "a_deg": a, "b_deg": b, "c_deg": c})


def quaternion_motion(position, q):
    w, x, y, z = (value / math.sqrt(sum(v * v for v in q)) for value in q)
    return ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))), tuple(position)


def vector_motion(numbers):
    vector = tuple(numbers[3:])
    angle = vc.length(vector)
    rotation = vc.about(vc.scaled(vector, 1 / angle), angle) if angle > 0 else vc.NONE[0]
    return rotation, tuple(1000 * v for v in numbers[:3])


def without_mark(text):
    """A corrected program without the one line of comment that says so; of FANUC it is counted in LINE_COUNT."""
    found = re.findall(r"(?m)^(?: *(\d+):  )?[;!#]corrected by armtrue (?:compensate|mirror)(?: ;)?\r?\n", text)
    if len(found) != 1:
        return text
    text = re.sub(r"(?m)^.*corrected by armtrue .*\n", "", text)
    return re.sub(r"(LINE_COUNT\s*= )(\d+)", lambda m: m[1] + str(int(m[2]) - 1), text) if found[0] else text


def krl(src, dat=""):
    entries = lambda text: {name.upper(): float(value) for name, value in re.findall(rf"([A-Za-z]\d?)\s+({NUMBER})", text)}
    motion = lambda of: abc_motion(*(of[name] for name in "XYZABC"))
    names = {name.upper(): entries(text) for name, text in re.findall(r"(\w+)\s*=\s*\{([^}]*)\}", dat)}
    base = tool = vc.NONE
    targets = []
    for number, line in enumerate(src.splitlines(), 1):
        line = line.split(";")[0]
        if setting := re.match(r"\s*\$(BASE|TOOL)\s*=\s*\{([^}]*)\}", line, re.I):
            frame = motion(entries(setting[2]))
            base, tool = (frame, tool) if setting[1].upper() == "BASE" else (base, frame)
        if not (move := re.match(r"\s*S?(PTP|LIN|CIRC)\s+(.*)", line, re.I)):
            continue
        for braces, name in re.findall(r"\{([^}]*)\}|(?<![\w.])(X\w+)", move[2]):
            of = entries(braces) if braces else names[name.upper()]
            if "A1" in of:
                value = [math.radians(of[f"A{j}"]) for j in range(1, 7)]
                targets.append(Target(number, "joints", value, base, tool, None))
            else:
                targets.append(Target(number, "pose", motion(of), base, tool, of.get("T")))
    return targets


def rapid(text):
    text = re.sub(r"!.*", "", text)
    numbers = lambda part: [float(n) for n in re.findall(NUMBER, part)]
    data = {}
    for kind, name, value in re.findall(r"(robtarget|jointtarget|tooldata|wobjdata)\s+(\w+)\s*:=(.*?);", text, re.S):
        data[name] = value
    tools, work_objects = {"tool0": vc.NONE}, {"wobj0": vc.NONE}
    for name, value in data.items():
        n = numbers(value)
        if "TRUE,[[" in value:
            tools[name] = quaternion_motion(n[:3], n[3:7])
        if "FALSE,TRUE" in value:
            work_objects[name] = vc.after(quaternion_motion(n[:3], n[3:7]), quaternion_motion(n[7:10], n[10:14]))
    targets = []
    for number, line in enumerate(text.splitlines(), 1):
        if not (move := re.match(r"\s*Move(J|L|C|AbsJ)\s+(.*?),v\d+,\w+,(\w+)(?:\\WObj:=(\w+))?;", line)):
            continue
        base, tool = work_objects[move[4] or "wobj0"], tools[move[3]]
        for inline, name in re.findall(r"(\[\[.*?\]\])|(\w+)", move[2]):
            n = numbers(inline or data[name])
            if move[1] == "AbsJ":
                targets.append(Target(number, "joints", [math.radians(v) for v in n[:6]], base, tool, None))
            else:
                targets.append(Target(number, "pose", quaternion_motion(n[:3], n[3:7]), base, tool, tuple(n[7:11])))
    return targets


def urscript(text):
    values, tool, targets = {}, vc.NONE, []
    for number, line in enumerate(text.splitlines(), 1):
        line = line.split("#")[0]
        if given := re.match(r"\s*(?:global |local )?(\w+)\s*=\s*(p?\[[^\]]*\])", line):
            values[given[1]] = given[2]
            continue
        literals = re.sub(r"\b(\w+)\b(?=\s*[,)])", lambda name: values.get(name[1], name[1]), line)
        lists = [(p, [float(n) for n in re.findall(NUMBER, body)]) for p, body in re.findall(r"(p?)\[([^\]]*)\]", literals)]
        if "set_tcp" in line:
            tool = vector_motion(lists[0][1])
        if not (move := re.match(r"\s*move(j|l|p|c)\(", line)):
            continue
        base = vc.NONE
        if "pose_trans" in line:
            base = vector_motion(lists.pop(0)[1])
        if "pose_add" in line:  # the shift turns nothing
            base = vector_motion(lists.pop(1)[1])
        for p, numbers in lists[:2 if move[1] == "c" else 1]:
            if p:
                targets.append(Target(number, "pose", vector_motion(numbers), base, tool, None))
            else:
                targets.append(Target(number, "joints", numbers, base, tool, None))
    return targets


def fanuc(text, frames, tools):
    positions = {}
    for name, body in re.findall(r"^P\[(\d+)[^\]]*\]\{(.*?)\};", text, re.S | re.M):
        of = {key: float(value) for key, value in re.findall(rf"\b([XYZWPR]|J\d|UF|UT)\s*[=:]\s*({NUMBER})", body)}
        positions[name] = of, (re.search(r"CONFIG : '([^']*)'", body) or [None, None])[1]
    targets = []
    program = text[:text.index("/POS")]
    for number, line in enumerate(program.splitlines(), 1):
        if not re.match(r"\s*\d*:\s*([JLCA]\s|\s*P\[)", line):
            continue
        for name in re.findall(r"P\[(\d+)[^\]]*\]", line):
            of, configuration = positions[name]
            base, tool = frames[of["UF"]], tools[of["UT"]]
            if "J1" in of:
                j = [math.radians(of[f"J{k}"]) for k in range(1, 7)]
                j[2] += j[1]  # from the horizontal to the upper arm
                targets.append(Target(number, "joints", j, base, tool, None))
            else:
                pose = abc_motion(of["X"], of["Y"], of["Z"], of["R"], of["P"], of["W"])
                targets.append(Target(number, "pose", pose, base, tool, configuration))
    return targets
