"""Robot programs of four makers as their manuals write them, each file another mixture of what the grammars allow: the same
number gives the same file. Of every number that a correction may change its place is known, and of every target what it
means, so that a corrected file can be read back without a parser: all other bytes are the same.

Written after: KUKA KSS 8.x, programming instructions for system integrators; ABB RAPID reference manual; FANUC R-30iB
operator's manual; Universal Robots, the URScript programming language. It shares no code with armtrue.
"""

import math
import re

import robot_programs as rp
import robot_programs_test as programs
import virtual_cell as vc

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
MARK = re.compile("\x01([^\x02]*)\x02")


class Target:
    """kind: pose or joints. `numbers`: their indices among the numbers of the file; None is inherited from the target
    before. `stays`: cannot be followed, so nothing of it changes."""

    def __init__(self, kind, numbers, base, tool, q):
        self.kind, self.numbers, self.base, self.tool, self.q = kind, numbers, base, tool, q


class File:
    """Text with marked numbers; `said`: what must be warned of, moves that are left alone."""

    def __init__(self, cell, name, number):
        self.cell, self.name, self.number, self.rng = cell, name, number, cell.rng
        self.texts, self.values, self.targets, self.frames, self.left_alone = [], [], [], [], 0

    def near(self, q):
        """Some degrees on, within the travel, with a bent wrist that does not stand above axis 1."""
        while True:
            found = self.cell.near(q)
            inside = all(low + 0.05 < a < high - 0.05 for a, (low, high) in zip(found, self.cell.nominal.travel))
            if inside and abs(math.sin(found[4])) > 0.4 and abs(programs.wrist(self.cell.nominal, found)[0]) > 80:
                return found

    def has(self, feature, of):
        """Every feature in one file of `of`, no two features in the same files."""
        return (self.number + feature) % of == 0 or self.rng.random() < 0.15

    def slot(self, value, decimals, odd=False):
        """A number in one of the ways in which it may be written."""
        text = f"{value:.{decimals}f}"
        if odd:
            style = self.rng.randrange(6)
            if style == 0 and text.startswith("0."):
                text = text[1:]
            elif style == 1 and value >= 0:
                text = "+" + text
            elif style == 2:
                text = f"{value:.{decimals + 3}E}"
            elif style == 3:
                text = f"{value:.{decimals}e}".replace("e+0", "e") if abs(value) >= 1 else text
            elif style == 4:
                text = text + "00"
        self.values.append(text)
        return f"\x01{len(self.values) - 1}\x02"

    def slots(self, values, decimals, odd=False):
        return [self.slot(value, decimals, odd) for value in values]

    def grows(self):
        """Where left out components are added."""
        return "\x01+\x02"

    def add(self, kind, slots, base, tool, q):
        index = lambda slot: None if slot is None else int(MARK.match(slot)[1])
        self.targets.append(Target(kind, [index(slot) for slot in slots], base, tool, q))

    def plain(self, text):
        return MARK.sub(lambda m: "" if m[1] == "+" else self.values[int(m[1])], text)

    def read_back(self, texts):
        """The numbers of corrected texts by their index; those that were added stand behind in `added`. Nothing if
        another byte differs."""
        found, added = {}, []
        for text, now in zip(self.texts, texts):
            pattern, at, order = "", 0, []
            for mark in MARK.finditer(text):
                pattern += re.escape(text[at:mark.start()])
                pattern += rf"((?:,[XYZABC] {NUMBER})*)" if mark[1] == "+" else f"({NUMBER})"
                order.append(mark[1])
                at = mark.end()
            whole = re.fullmatch(pattern + re.escape(text[at:]), now, re.S)
            if not whole:
                return None, None
            for mark, group in zip(order, whole.groups()):
                if mark == "+":
                    added.append({n: float(v) for n, v in re.findall(rf",([XYZABC]) ({NUMBER})", group)})
                else:
                    found[int(mark)] = group
        return found, added


def finished(file, texts, newline):
    file.texts = [text.replace("\n", newline) for text in texts]
    return file


def mixed(rng, word):
    return "".join(rng.choice((c.upper(), c.lower())) for c in word)


# ---- KUKA ----------------------------------------------------------------------------------------------------------

def krl(cell, number):
    file, rng = File(cell, f"corpus_{number}", number), cell.rng
    has = file.has
    word = (lambda w: mixed(rng, w)) if has(0, 5) else (lambda w: w)
    tab = "\t" if has(1, 6) else "  "
    bases, tools = [vc.NONE] + cell.bases, cell.tools
    base, tool, by_number = cell.bases[0], tools[0], has(2, 4)
    external = has(3, 4)
    src, dat, names = [], [], iter(range(1, 100))
    if has(4, 3):
        src += ["&ACCESS RVP", "&REL 3", "&PARAM TEMPLATE = C:\\KRC\\Roboter\\Template\\vorgabe"]
    src += [f"{word('DEF')}  {file.name}( )"]
    if has(5, 3):
        src += [";FOLD INI", f"{tab}{word('BAS')} (#INITMOV,0 ) ; {{X 1}}", ";ENDFOLD (INI)"]
    if has(6, 7):
        src += [f"{word('DECL')} INT i"]

    def set_frames():
        if by_number:
            b, t = 1 + cell.bases.index(base), 1 + tools.index(tool)
            file.frames[:] = sorted({*file.frames, (f"BASE_DATA[{b}]", base), (f"TOOL_DATA[{t}]", tool)}, key=lambda f: f[0])
            return [f"$BASE = BASE_DATA[{b}]", f"{word('BAS')}(#TOOL,{t})"]
        return [programs.kuka_setting("BASE", base), programs.kuka_setting("TOOL", tool).replace("$TOOL=", "$tool  = ")]

    src += set_frames()

    def frame(q, status, tail="", kind=""):
        pose = cell.written(q, base, tool)
        slots = file.slots([*pose[1], *vc.kuka(pose[0])], rng.choice((4, 5, 6)), has(7, 6))
        entries = [f"{n} {s}" for n, s in zip("XYZABC", slots)]
        if has(8, 8):
            entries = [entries[k] for k in (3, 4, 5, 0, 1, 2)]
        text = rng.choice((",", ", ", " , ")).join(entries)
        if status:
            bits = (wrist_bits(cell, q)) + (16 if has(9, 4) else 0)
            text += f",S {bits},T {file.slot(programs.kuka_turn(q) + (64 if has(10, 5) else 0), 0)}"
        text += "".join(f",E{k} {v}" for k, v in enumerate((12.5, 0.0, 0, 0, 0, 0), 1)) if external else ""
        file.add("pose", slots, base, tool, q)
        return "{" + kind + text + "}" + tail

    def axes(q, kind=""):
        slots = file.slots([math.degrees(a) for a in q], rng.choice((3, 4, 6)))
        file.add("joints", slots, base, tool, q)
        tail = "".join(f",E{k} 0.0" for k in range(1, 7)) if has(11, 3) else ""
        return "{" + kind + ",".join(f"A{j} {s}" for j, s in enumerate(slots, 1)) + tail + "}"

    def named(text, kind):
        name = f"X{rng.choice(('P', 'Q', 'place'))}{next(names)}"
        if has(12, 4):
            src.append(f"{tab}{name}={text}")
        else:
            dat.append(f"DECL {kind} {name}={text}")
        return name

    q = posture_krl(cell)
    start = axes(q, "E6AXIS: " if has(13, 9) else "")
    src.append(f"{word('PTP')} {named(start, 'E6AXIS') if has(14, 2) else start}{' C_PTP' if has(15, 4) else ''}")
    for k in range(4):
        q = file.near(q)
        inside = (number + k) % 5
        if inside == 0:
            src += ["; LIN {X 0,Y 0,Z 0,A 0,B 0,C 0}", "$OUT[3]=TRUE", f'MsgNotify("PTP {{A1 0}} ; no move")']
        if inside == 1:
            text = frame(q, True)
            src += [f";FOLD PTP P{k} Vel=100 % PDAT{k} Tool[1] Base[1];%{{PE}}%R 8.3.42", "$BWDSTART=FALSE", f"PDAT_ACT=PPDAT{k}",
                    f"PTP {named(text, 'E6POS')}", ";ENDFOLD"]
        elif inside == 2 and has(24, 2):
            # The frame leaves out what it has in common with the one before.
            first = frame(q, False)
            before = file.targets[-1].numbers
            x, y = file.slot(float(file.values[before[0]]) + 3.5, 3), file.slot(float(file.values[before[1]]) - 2, 1)
            file.add("pose", [x, y], base, tool, q)
            file.targets[-1].numbers += before[2:]
            src += [f"LIN {first}", f"LIN {{X {x},Y {y}{file.grows()}}} C_DIS"]
        elif inside == 2:
            src.append(f"{tab}{word('LIN')} {frame(q, has(16, 2))} {rng.choice(('C_DIS', 'C_VEL', 'C_ORI', ''))} ; approach")
        elif inside == 3:
            via = file.near(q)
            first = frame(via, False)
            q = file.near(q)
            text = frame(q, False)
            src.append(f"{word(rng.choice(('CIRC', 'SCIRC')))} {first}{rng.choice((',', ' , '))}{text}")
        else:
            src.append(f"{rng.choice(('SLIN', 'SPTP'))} {named(frame(q, True), 'E6POS')} WITH $VEL.CP=0.3")
        if has(17, 6):
            src += [f"{word('IF')} $IN[1] {word('THEN')}", f"{tab}WAIT SEC 0.1", f"{word('ENDIF')}"]
        if has(18, 8) and k == 1:
            base, tool = cell.bases[1], tools[1]
            src += set_frames()
    if has(19, 5):
        src.append(f"{tab}LIN_REL {{Z HEIGHT}} C_DIS")
        file.left_alone += 1
    if has(20, 6):
        src.append("LIN XNOWHERE")
        file.left_alone += 1
    if has(21, 7):
        src.append("LIN {X i, Y 0, Z 0}")
        file.left_alone += 1
    src.append(word("END"))
    if has(22, 6):
        src += ["", f"DEF helper(a :{word('in')})", f"{word('REAL')} a", "WAIT SEC a", "END"]
    texts = ["\n".join(src) + "\n"]
    if dat:
        texts.append("\n".join([f"DEFDAT  {file.name.upper()}", "EXT BAS (BAS_COMMAND :IN,REAL :IN )", ";FOLD points"] + dat +
                               ["DECL PDAT PPDAT1={VEL 100.0,ACC 100.0,APO_DIST 100.0}", ";ENDFOLD", "ENDDAT"]) + "\n")
    return finished(file, texts, "\r\n" if has(23, 2) else "\n")


def wrist_bits(cell, q):
    return (programs.wrist(cell.nominal, q)[0] < 0) + 2 * (math.degrees(q[2]) > -3.07) + 4 * (q[4] < 0)


def posture_krl(cell):
    sign = cell.rng.choice((-1, 1))
    return cell.posture((-150, 150), (-105, -40), (30, 115), (-170, 170), (sign * 35, sign * 95), (-170, 170))


# ---- ABB -----------------------------------------------------------------------------------------------------------

def rapid(cell, number):
    file, rng = File(cell, f"corpus_{number}", number), cell.rng
    has = file.has
    word = (lambda w: mixed(rng, w)) if has(0, 5) else (lambda w: w)
    tab = "\t" if has(1, 4) else "    "
    tools, bases = [("tool0", vc.NONE), ("tGrip", cell.tools[0]), ("tMill", cell.tools[1])], [("wobj0", vc.NONE), ("wPart", cell.bases[0])]
    data, body, names = [], [], iter(range(1, 100))
    used = set()
    gap = "\n" + tab if has(2, 4) else ""
    nine = "9E9" if has(3, 2) else "9E+09"

    def declared(name, motion, is_tool):
        if name in ("tool0", "wobj0") or name in used:
            return name
        used.add(name)
        pose = f"[{programs.abb_pose(motion)}]"
        if is_tool:
            data.append(f"{tab}{word('PERS')} tooldata {name}:=[TRUE,{pose},[1.5,[0,0,100],[1,0,0,0],0,0,0]];")
        else:
            data.append(f'{tab}{word("PERS")} wobjdata {name}:=[FALSE,TRUE,"",{pose},[[0,0,0],[1,0,0,0]]];')
        return name

    def target(q, base, tool):
        position, quaternion = re.findall(r"\[([^\]]*)\]", programs.abb_pose(cell.written(q, base, tool)))
        slots = file.slots([float(v) for v in position.split(",")], rng.choice((4, 5, 6)), has(4, 6))
        turned = file.slots([float(v) for v in quaternion.split(",")], 8, False)
        cfx = 4 * (programs.wrist(cell.nominal, q)[0] < 0) + 2 * (not programs.is_elbow_up(cell.nominal, q)) + (q[4] < 0)
        quads = file.slots(programs.quadrants(q), 0)
        comma = rng.choice((",", ", ", "," + gap))
        file.add("pose", slots + turned, base, tool, q)
        return f"[[{comma.join(slots)}]{comma}[{','.join(turned)}],[{','.join(quads)},{cfx}],[{','.join([nine] * 6)}]]"

    def joint_target(q, base, tool):
        slots = file.slots([math.degrees(a) for a in q], 6)
        file.add("joints", slots, base, tool, q)
        return f"[[{','.join(slots)}],[{','.join([nine] * 6)}]]"

    def place(text, kind):
        style = (number + len(data)) % 3
        if style == 0:
            return text
        name = f"{rng.choice(('p', 'Pos_', 'here'))}{next(names)}"
        if style == 1:
            data.append(f"{tab}{word(rng.choice(('CONST', 'PERS', 'VAR')))} {kind} {name}:={text};")
            return name
        data.append(f"{tab}{word('CONST')} {kind} {name}{{1}}:=[{text}];")
        return f"{name}{{1}}"

    q = posture_rapid(cell)
    tool_name, tool = rng.choice(tools)
    base_name, base = rng.choice(bases)
    for k in range(6):
        if has(5, 4):
            tool_name, tool = rng.choice(tools)
            base_name, base = rng.choice(bases)
        frames = declared(tool_name, tool, True)
        frames += "" if base_name == "wobj0" and has(6, 2) else f"\\WObj:={declared(base_name, base, False)}"
        zone, speed = rng.choice(("fine", "z1", "z50", "zMine")), rng.choice(("v100", "v1000", "[200,500,5000,1000]", "vMine"))
        style = 0 if k == 0 else (number + k) % 6
        q = q if k == 0 else file.near(q)
        if style == 0:
            body.append(f"{word('MoveAbsJ')} {place(joint_target(q, base, tool), 'jointtarget')},{gap}{speed},{zone},{frames};")
        elif style == 1:
            body.append(f"{word('MoveJ')} {place(target(q, base, tool), 'robtarget')}, {speed}, {zone}, {frames};")
        elif style == 2 and has(17, 3):
            point = place(target(q, base, tool), "robtarget")
            body.append(rng.choice((f"ArcLStart {point},{speed},seam1,weld1\\Weave:=weave1,fine,{frames};", f"ArcL\\On,{point},{speed},seam1,weld1,weave1,{zone},{frames};",
                                    f"{word('ArcLEnd')} {point}, {speed}, seam1, weld1, fine, {frames}\\SeamName:=\"a\";", f"DispL\\Off,{point},{speed},bead1,{zone},{frames};",
                                    f"SpotL {point},vmax,gun1,spot10,{frames};", f"PaintL {point},{speed},{zone},{frames};")))
        elif style == 2:
            body.append(f"{word('MoveL')} {place(target(q, base, tool), 'robtarget')},{speed}\\V:=150,{zone}\\Inpos:=inpos20,{frames}; ! MoveL p0,v1,fine,tool0;")
        elif style == 3:
            via = file.near(q)
            first = place(target(via, base, tool), "robtarget")
            q = file.near(q)
            point = place(target(q, base, tool), "robtarget")
            body.append(f"ArcC {first},{point},{speed},seam1,weld1,{zone},{frames};" if has(18, 5) else f"MoveC {first},{point},{speed},{zone},{frames};")
        elif style == 4:
            body.append(f"{rng.choice(('MoveLDO', 'MoveJDO'))} {place(target(q, base, tool), 'robtarget')},{speed},{zone},{frames},do1,1;")
        else:
            body += ["TriggIO gun,20\\DOp:=do2,1;", f"TriggL {place(target(q, base, tool), 'robtarget')},{speed},gun,{zone},{frames};"]
        if has(7, 5):
            body += [f'{word("TPWrite")} "MoveJ p1,v100,fine,tool0; \\ ! no comment";', f"reg{k}:=reg{k}+1;"]
        if has(8, 6):
            body += [f"{word('IF')} reg1>3 {word('THEN')}", f"{tab}WaitTime 0.2;", f"{word('ENDIF')}"]
    for feature, text in ((9, "MoveL Offs(pX,0,0,10),v100,fine,tool0;"), (10, "SearchL di1,pF,pX,v10,tool0;"), (11, "MoveJ pElsewhere,v100,z1,tool0;")):
        if has(feature, 6):
            body.append(text)
            file.left_alone += 1
    lines = ["%%%", "  VERSION:1", "  LANGUAGE:ENGLISH", "%%%", ""] if has(12, 4) else []
    lines += [f"{word('MODULE')} {file.name}{'(SYSMODULE)' if has(13, 9) else ''}"] + data
    if has(14, 3):
        lines += [f"{tab}{word('CONST')} num width:=1.5;", f"{tab}! a comment"]
    lines += [f"{tab}{word('PROC')} main()"] + [tab * 2 + line for line in body] + [f"{tab}{word('ENDPROC')}"]
    if has(15, 4):
        lines += ["", f"{tab}FUNC num twice(num x)", f"{tab}{tab}RETURN 2*x;", f"{tab}ENDFUNC"]
    return finished(file, ["\n".join(lines + [word("ENDMODULE"), ""])], "\r\n" if has(16, 2) else "\n")


def posture_rapid(cell):
    sign = cell.rng.choice((-1, 1))
    return cell.posture((-150, 150), (-30, 40), (-50, 30), (-140, 140), (sign * 40, sign * 80), (-280, 280))


# ---- Universal Robots ----------------------------------------------------------------------------------------------

def urscript(cell, number):
    file, rng = File(cell, f"corpus_{number}", number), cell.rng
    has = file.has
    tab = "\t" if has(0, 4) else "  "
    lines, names = [], iter(range(1, 100))
    in_def = not has(1, 5)
    tool = vc.NONE

    def pose_numbers(motion):
        return [float(v) for v in programs.ur_pose(motion)[2:-1].split(",")]

    def literal(q, base):
        slots = file.slots(pose_numbers(cell.written(q, base, tool)), 9, has(2, 6))
        file.add("pose", slots, base, tool, q)
        return f"p[{rng.choice((',', ', ', ' , ')).join(slots)}]"

    def joints(q):
        slots = file.slots(q, 9)
        file.add("joints", slots, vc.NONE, tool, q)
        return f"[{rng.choice((', ', ',')).join(slots)}]"

    def named(text):
        if has(3, 3):
            name = f"{rng.choice(('Waypoint_', 'q', 'P'))}{next(names)}"
            lines.append(f"{rng.choice(('global ', 'local ', ''))}{name} = {text}{rng.choice(('', '  # stored', ';'))}")
            return name
        return text

    if in_def:
        lines.append(f"def {file.name}():")
    if has(4, 2):
        tool = cell.tools[0]
        lines.append(f"set_tcp({programs.ur_pose(tool)})")
    plane = None
    if has(5, 3):
        plane = "Plane_1"
        lines.append(f"global {plane} = {programs.ur_pose(cell.bases[0])}")
    q = posture_ur(cell)
    options = lambda: rng.choice((", a=1.2, v=0.25", ", a = 1.2 ,v=0.25, t=0, r=0.01", ", 1.4, 1.05", ", 1.2, 0.25, 0, 0.005", ""))
    lines.append(f"movej({named(joints(q))}{options()})")
    for k in range(5):
        q = file.near(q)
        style = (number + k) % 6
        if style == 0:
            lines.append(f"movel({named(literal(q, vc.NONE))}{options()})")
        elif style == 1 and plane:
            lines.append(f"movel(pose_trans({plane}, {literal(q, cell.bases[0])}){options()})  # in the plane")
        elif style == 2:
            near = "[" + ",".join(f"{a + 0.05:.4f}" for a in q) + "]"
            lines.append(f"movej(get_inverse_kin({literal(q, vc.NONE)}, qnear={near}){options()})")
        elif style == 3:
            via = file.near(q)
            first = literal(via, vc.NONE)
            q = file.near(q)
            lines.append(f"movec({first}, {literal(q, vc.NONE)}, a=1.2, v=0.25, r=0.0, mode=0)")
        elif style == 4:
            lines.append(f"movep({named(literal(q, vc.NONE))}, a=1, v=0.1, r=0.02)")
        else:
            lines.append(f"movel({joints(q)}{options()})")
        if has(6, 4):
            lines += ['textmsg("movel(p[0,0,0,0,0,0])")', "set_digital_out(2, True)", "# movej([0,0,0,0,0,0])"]
        if has(7, 5):
            lines += ["if get_digital_in(1):", f"{tab}sleep(0.1)", "end"]
    if has(8, 6):
        lines += ["while True:", f"{tab}movel(pose_add(get_actual_tcp_pose(), p[0,0,0.01,0,0,0]), a=1, v=0.1)", "end"]
        file.left_alone += 1
    if has(9, 7):
        lines.append("servoj([0,-1,1,0,1,0], t=0.008)")
        file.left_alone += 1
    if has(10, 5):
        lines += ["thread watch():", f"{tab}sync()", "end", "run watch()"]
    if in_def:
        lines = [lines[0]] + [tab + line for line in lines[1:]] + ["end"]
    return finished(file, ["\n".join(lines) + ("" if has(11, 5) else "\n")], "\r\n" if has(12, 3) else "\n")


def posture_ur(cell):
    sign = cell.rng.choice((-1, 1))
    return cell.posture((-150, 150), (-80, -40), (50, 100), (-150, 150), (sign * 40, sign * 120), (-150, 150))


# ---- FANUC ---------------------------------------------------------------------------------------------------------

def fanuc(cell, number):
    file, rng = File(cell, f"CORPUS_{number}", number), cell.rng
    has = file.has
    positions, lines = [], []
    compact, second_group, external = has(0, 6), has(1, 5), has(2, 5)
    file.frames += [("UF[1]", cell.bases[0]), ("UF[2]", cell.bases[1]), ("UT[1]", cell.tools[0]), ("UT[3]", cell.tools[1])]
    numbers = rng.sample(range(1, 90), 12)

    def position(q, as_joints):
        p = numbers[len(positions)]
        uf = rng.choice((0, 1, 2)) if has(3, 2) else 1
        ut = rng.choice((0, 1, 3)) if has(4, 2) else 1
        base = {0: vc.NONE, 1: cell.bases[0], 2: cell.bases[1]}[uf]
        tool = {0: vc.NONE, 1: cell.tools[0], 3: cell.tools[1]}[ut]
        name = f':"{rng.choice(("start", "P[3] of part", "a{b}c"))}"' if has(5, 3) else ""
        decimals = rng.choice((3, 3, 4))
        if as_joints:
            j = [math.degrees(a) for a in q]
            j[2] -= j[1]
            slots = file.slots(j, decimals)
            file.add("joints", slots, base, tool, q)
            head, rows = "", [f"J{k}= {s:>9} deg" for k, s in enumerate(slots, 1)]
        else:
            pose = cell.written(q, base, tool)
            a, b, c = vc.kuka(pose[0])
            slots = file.slots([*pose[1], c, b, a], decimals)
            file.add("pose", slots, base, tool, q)
            turns = ", ".join(str(round(math.degrees(q[i]) / 360)) for i in (3, 4, 5))
            letters = ("N" if q[4] < 0 else "F") + " " + ("U" if programs.is_elbow_up(cell.nominal, q) else "D") + " "
            head = f"\t\tCONFIG : '{letters}{'T' if programs.wrist(cell.nominal, q)[0] > 0 else 'B'}, {turns}',"
            rows = [f"{n} = {s:>9}  mm" for n, s in zip("XYZ", slots)] + [f"{n} = {s:>9} deg" for n, s in zip("WPR", slots[3:])]
        if external:
            rows.append("E1=   500.000  mm")
        text = f"P[{p}{name}]{{\n   GP1:\n\tUF : {uf}, UT : {ut},{head}\n\t" + ",\t".join(rows[:3]) + ",\n\t" + ",\t".join(rows[3:])
        if second_group:
            text += "\n   GP2:\n\tUF : 0, UT : 0,\n\tJ1=     6.378 deg,\tJ2=     1.000 deg"
        text += "\n};\n"
        positions.append(text.replace("\n\t", " ").replace("\n   ", " ") if compact else text)
        return f"P[{p}{':' + name[2:-1].replace('P[3] of part', 'part') if name and has(6, 2) else ''}]"

    q = posture_fanuc(cell)
    lines.append(f"J {position(q, has(7, 2))} 100% FINE    ;")
    for k in range(5):
        q = file.near(q)
        style = (number + k) % 5
        ending = rng.choice(("FINE    ;", "CNT100    ;", "CNT50 ACC80    ;", "FINE PTH    ;"))
        speed = rng.choice(("250mm/sec", "50cm/min", "R[3]mm/sec", "2.5sec", "30deg/sec"))
        if style == 0:
            lines.append(f"L {position(q, False)} {speed} {ending}")
        elif style == 1:
            lines.append(f"J {position(q, has(8, 3))} R[2]% {ending}")
        elif style == 2:
            via = file.near(q)
            first = position(via, False)
            q = file.near(q)
            lines.append(f"C {first}    \n    :  {position(q, False)} {speed} {ending}")
        elif style == 3:
            lines.append(f"A {position(q, False)} 100mm/sec {ending}")
        else:
            lines.append(f"L {position(q, False)} {speed} FINE\n    :  TB    .10sec,CALL OTHER    ;")
        if has(9, 3):
            lines += ["  !L P[77] no move ;", "  DO[1]=ON ;", "  WAIT   .50(sec) ;"]
        if has(10, 4):
            lines += ["  IF DI[1]=ON,JMP LBL[1] ;", f"  LBL[{k + 1}] ;"]
    for feature, text in ((11, "L PR[1] 100mm/sec FINE    ;"), (12, "L P[91] 100mm/sec FINE Offset,PR[1]    ;"), (13, "L P[99] 10mm/sec FINE    ;")):
        if has(feature, 6):
            lines.append(text)
            file.left_alone += 1
    head = [f"/PROG  {file.name}", "/ATTR", "OWNER\t\t= MNEDITOR;", f'COMMENT\t\t= "{rng.choice(("", "part", "/POS"))}";',
            f"LINE_COUNT\t= {len(lines)};", "DEFAULT_GROUP\t= 1,*,*,*,*;"]
    if has(14, 2):
        head += ["TCD:  STACK_SIZE\t= 0,", "      TASK_PRIORITY\t= 50;"]
    if has(15, 5):
        head += ["/APPL", "/APPL"]
    body = [f"{n:4}:{line}" for n, line in enumerate(lines, 1)]
    text = "\n".join(head + ["/MN"] + body + ["/POS"]) + "\n" + "".join(positions) + "/END\n"
    return finished(file, [text], "\r\n" if has(16, 2) else "\n")


def posture_fanuc(cell):
    sign = cell.rng.choice((-1, 1))
    return cell.posture((-150, 150), (-5, 50), (-60, 40), (-150, 150), (sign * 40, sign * 90), (-150, 150))


MAKERS = {"krl": (krl, ".src"), "rapid": (rapid, ".mod"), "urscript": (urscript, ".script"), "fanuc": (fanuc, ".ls")}


def corpus_file(dialect, number):
    cell = programs.Cell(dialect, f"{dialect} {number}")
    return MAKERS[dialect][0](cell, number)


def pose_of(dialect, numbers):
    if dialect == "krl":
        return rp.abc_motion(*numbers)
    if dialect == "rapid":
        return rp.quaternion_motion(numbers[:3], numbers[3:])
    if dialect == "urscript":
        return rp.vector_motion(numbers)
    x, y, z, w, p, r = numbers
    return rp.abc_motion(x, y, z, r, p, w)


def joints_of(dialect, numbers):
    if dialect == "urscript":
        return list(numbers)
    q = [math.radians(v) for v in numbers]
    if dialect == "fanuc":
        q[2] += q[1]
    return q
