"""Programs of a palletiser of four axes, from its joint angles and the poses that the controller has there, and back.

    programs.py write LANGUAGE targets.csv poses.csv -o PROGRAM
    programs.py read LANGUAGE PROGRAM -o commands.csv

A joint move and a straight one for each target. Axes: KUKA and ABB call the last one 6, FANUC 4; KUKA shows axis 5, which the
rods move, too."""

import csv
import math
import re
import sys

NAMES = {"krl": ["A1", "A2", "A3", "A6"], "rapid": None, "fanuc": ["J1", "J2", "J3", "J4"]}


def quaternion(a, b, c):
    half = [math.radians(v) / 2 for v in (a, b, c)]
    (ca, cb, cc), (sa, sb, sc) = map(math.cos, half), map(math.sin, half)
    return [ca * cb * cc + sa * sb * sc, ca * cb * sc - sa * sb * cc, ca * sb * cc + sa * cb * sc, sa * cb * cc - ca * sb * sc]


def text_of(language, targets, poses):
    joints = [[float(row[f"q{k}_deg"]) for k in range(1, 5)] for row in targets]
    poses = [[float(row[name]) for name in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")] for row in poses]
    lines, positions = [], []
    for k, (q, pose) in enumerate(zip(joints, poses)):
        x, y, z, a, b, c = pose
        if language == "krl":
            passive = round(-90 - q[1] - q[2])
            lines.append(f"PTP {{A1 {q[0]:.6f},A2 {q[1]:.6f},A3 {q[2]:.6f},A4 0,A5 {passive},A6 {q[3]:.6f}}}")
            lines.append("LIN {" + ",".join(f"{n} {v:.6f}" for n, v in zip("XYZABC", pose)) + "}")
        elif language == "rapid":
            none = "[9E9,9E9,9E9,9E9,9E9,9E9]"
            angles = [*q[:3], 0, 0, q[3]]
            lines.append(f"MoveAbsJ [[{','.join(f'{v:.6f}' for v in angles)}],{none}],v500,fine,tProbe;")
            numbers = f"[[{x:.6f},{y:.6f},{z:.6f}],[{','.join(f'{v:.9f}' for v in quaternion(a, b, c))}]"
            quadrants = [math.floor(v / 90) for v in (q[0], 0, q[3])]
            lines.append(f"MoveL {numbers},[{','.join(map(str, quadrants))},0],{none}],v500,fine,tProbe;")
        else:
            lines.append(f"{2 * k + 1:4}:J P[{2 * k + 1}] 100% FINE    ;")
            lines.append(f"{2 * k + 2:4}:L P[{2 * k + 2}] 500mm/sec FINE    ;")
            angles = ",\t".join(f"J{j + 1}= {v:.6f} deg" for j, v in enumerate(q))
            positions.append(f"P[{2 * k + 1}]{{\n   GP1:\n\tUF : 0, UT : 1,\n\t{angles}\n}};")
            numbers = ",\t".join(f"{n} = {v:.6f} {'mm' if i < 3 else 'deg'}" for i, (n, v) in enumerate(zip("XYZWPR", (x, y, z, c, b, a))))
            turn = round(q[3] / 360)
            positions.append(f"P[{2 * k + 2}]{{\n   GP1:\n\tUF : 0, UT : 1,\tCONFIG : ', {turn}, 0, 0',\n\t{numbers}\n}};")
    if language == "krl":
        return "\n".join(["DEF part()", "$BASE=$NULLFRAME", "$TOOL=TOOL_DATA[1]", *lines, "END", ""])
    if language == "rapid":
        return "\n".join(["MODULE part", "PROC main()", *lines, "ENDPROC", "ENDMODULE", ""])
    head = ["/PROG  PART", "/ATTR", f"LINE_COUNT = {len(lines)};", "/MN"]
    return "\n".join([*head, *lines, "/POS", *positions, "/END", ""])


def joints_of(language, text):
    number = r"-?[0-9.]+"
    if language == "rapid":
        found = [[*numbers[:3], numbers[5]] for numbers in
                 ([float(v) for v in move.split(",")] for move in re.findall(r"MoveAbsJ \[\[([^\]]*)\]", text))]
    else:
        name = NAMES[language]
        blocks = re.findall(r"PTP \{(.*)\}" if language == "krl" else r"(?s)GP1:(?:(?!GP1:).)*?(J1.*?)\}", text)
        found = [[float(re.search(rf"{n} ?=? *({number})", block)[1]) for n in name] for block in blocks]
    return found


def main():
    do, language, *files = sys.argv[1:]
    if do == "write":
        targets, poses, _, out = files
        read = lambda path: list(csv.DictReader(open(path)))
        open(out, "w").write(text_of(language, read(targets), read(poses)))
    else:
        program, _, out = files
        with open(out, "w") as file:
            print("pose,q1_deg,q2_deg,q3_deg,q4_deg", file=file)
            for k, q in enumerate(joints_of(language, open(program).read())):
                print(k + 1, *q, sep=",", file=file)


main()
