#!/usr/bin/env python3
"""Reads every product of every command test with other readers, and looks at what was said on stderr.

    read_back.py KEPT CASES BIN VALUES         what tests/cli/run_case.py kept in KEPT of the cases in CASES, the cases of
                                               one command; VALUES is the program of values.cc
    read_back.py --sources ROOT BIN            sentences in the sources
    read_back.py --names BIN CONFIG VALUES     products with names that look like something else
    read_back.py --json BIN CONFIG VALUES      each kind of document as YAML and as JSON, which the next command reads
    read_back.py --schemas CONFIG PAGE         config/schemas; PAGE is the source of armtrue-formats(5)
    read_back.py --self-test                   checks this file

YAML is read by yaml-cpp, as armtrue reads it, by PyYAML (YAML 1.1) and by ruamel.yaml (YAML 1.2). All must see the same:
a quoted scalar and a key are texts; a plain scalar is the same number, truth value, null or text for both. A text that
looks like a number stands only where a name does: elsewhere it is a number that was quoted. JSON is read by yaml-cpp and
by Python's json. Documents hold what the schema of their kind in config/schemas allows, and nothing else. CSV is read by
armtrue and by Python's csv. Pages are read by html.parser.

A sentence on stderr holds no nan and no inf that the user did not write, no words of a library, and no option that the
command that says it lacks.
"""

import csv
import functools
import html.parser
import io
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import jsonschema
import ruamel.yaml
import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import run_case

FILES_AT_ONCE = 200
# Keys under which a name stands, which may look like a number; under NAMED each key is a name.
NAMES = {"pose", "largest_pose", "name", "robot", "serial", "date", "calibrated_until", "date_before", "file", "link", "operator",
         "place", "type", "sessions", "outside_measured", "parameter", "figure", "instrument", "instead_of", "unit"}
# Columns of tables under which a name stands.
TABLE_NAMES = {"pose", "target", "session", "anchor", "split", "parameter", "unit", "notes"}
NAMED = {"targets", "anchors", "contacts", "beams", "sessions", "points", "faces", "balls"}

SCHEMAS = pathlib.Path(__file__).resolve().parents[2] / "config" / "schemas"

# Documents

def load_schemas():
    """By the formats that they describe; and all by their files, which refer to each other."""
    files = {file.as_uri(): json.loads(file.read_text()) for file in sorted(SCHEMAS.glob("*.json"))}
    by_format = {schema["properties"]["format"]["const"]:
                     jsonschema.Draft202012Validator(schema, resolver=jsonschema.RefResolver(uri, schema, files))
                 for uri, schema in files.items() if "properties" in schema}
    return by_format, files


VALIDATORS, SCHEMA_FILES = load_schemas()


# Files to fill in, which are refused as they are.
TEMPLATES = [yaml.safe_load(file.read_text()) for file in sorted((SCHEMAS.parent / "templates").glob("*.yaml"))]


def schema_mistakes(document):
    if json.loads(json.dumps(document, default=str)) in [json.loads(json.dumps(one, default=str)) for one in TEMPLATES]:
        return []
    if document["format"] not in VALIDATORS:
        return [f"{document['format']} has no schema"]
    return [f"{'/'.join(map(str, error.absolute_path))}: by the schema: {error.message:.200}"
            for error in VALIDATORS[document["format"]].iter_errors(document)]


def typed(text):
    """What a plain scalar of armtrue's documents is: it writes no other forms."""
    if text in ("true", "false"):
        return text == "true"
    if re.fullmatch(r"-?\d+", text):
        return int(text)
    if re.fullmatch(r"-?\d+(\.\d+)?(e[+-]\d+)?", text):
        return float(text)
    return text


def same_scalar(seen, expected):
    if isinstance(expected, bool) or isinstance(seen, bool) or isinstance(expected, str):
        return type(seen) is type(expected) and seen == expected
    return isinstance(seen, (int, float)) and seen == expected


def looks_like_another(text):
    return not isinstance(typed(text), str)


def differences(own, one_one, one_two, path=(), named=False):
    """Where the three readers differ, as sentences."""
    place = "/".join(map(str, path))
    if own is None:
        return [] if one_one is None and one_two is None else [f"{place}: null is {one_one!r}, {one_two!r}"]
    if isinstance(own, list):
        if not (isinstance(one_one, list) and isinstance(one_two, list) and len(own) == len(one_one) == len(one_two)):
            return [f"{place}: a list is {one_one!r:.60}, {one_two!r:.60}"]
        return [line for k, item in enumerate(own)
                for line in differences(item, one_one[k], one_two[k], (*path, k), named)]
    if "map" in own:
        wrong = []
        keys = [key["text"] for key, _ in own["map"]]
        for seen in (one_one, one_two):
            if not isinstance(seen, dict) or list(seen) != keys:
                return [f"{place}: the keys {keys} are {list(seen) if isinstance(seen, dict) else seen!r}"]
        for key, value in own["map"]:
            if looks_like_another(key["text"]) and not (path and path[-1] in NAMED):
                wrong.append(f"{place}: the key {key['text']} looks like a number")
            wrong += differences(value, one_one[key["text"]], one_two[key["text"]], (*path, key["text"]),
                                 key["text"] in NAMES)
        return wrong
    text = own["text"]
    expected = text if own["is_text"] else typed(text)
    wrong = [f"{place}: {text!r} is {seen!r} for {reader}"
             for seen, reader in ((one_one, "PyYAML"), (one_two, "ruamel.yaml")) if not same_scalar(seen, expected)]
    if own["is_text"] and looks_like_another(text) and not named:
        wrong.append(f"{place}: the number {text} is quoted")
    return wrong


@functools.cache  # it takes most of the time, and many cases make the same document
def by_ruamel(text):
    return ruamel.yaml.YAML(typ="safe", pure=True).load(text)


def document_mistakes(text, own):
    try:
        one_one = yaml.load(text, yaml.CSafeLoader if hasattr(yaml, "CSafeLoader") else yaml.SafeLoader)
        one_two = by_ruamel(text) if len(text) < 300_000 else one_one
    except (yaml.YAMLError, ruamel.yaml.error.YAMLError) as error:
        return [f"cannot be read: {error}"]
    return differences(own, one_one, one_two) or schema_mistakes(one_two)


def no_number(text):
    raise ValueError(f"{text} is no JSON")


def keys_once(entries):
    if len(entries) != len(dict(entries)):
        raise ValueError(f"a key stands twice among {[key for key, _ in entries]}")
    return dict(entries)


def read_json(text):
    return json.loads(text, parse_constant=no_number, object_pairs_hook=keys_once)


def json_mistakes(text, own):
    try:
        seen = read_json(text)
    except ValueError as error:
        return [f"cannot be read: {error}"]
    return differences(own, seen, seen) or schema_mistakes(seen)


def table_mistakes(text, own):
    separator = ";" if ";" in text.split("\n", 1)[0] else ","
    seen = [row for row in csv.reader(io.StringIO(text, newline=""), delimiter=separator) if row]
    if seen == own["rows"]:
        return []
    for line, (row, expected) in enumerate(zip(seen, own["rows"]), 1):
        if row != expected:
            return [f"row {line} is {row!r:.200} for csv and {expected!r:.200} for armtrue"]
    return [f"{len(seen)} rows for csv and {len(own['rows'])} for armtrue"]


TABLE_SCHEMA = jsonschema.Draft202012Validator(json.loads((SCHEMAS / "table.json").read_text()))


def rows_mistakes(text, own):
    """Of a table as JSON; `own` has its cells as texts."""
    try:
        seen = read_json(text)
    except ValueError as error:
        return [f"cannot be read: {error}"]
    wrong = [f"{'/'.join(map(str, error.absolute_path))}: by the schema: {error.message:.200}"
             for error in TABLE_SCHEMA.iter_errors(seen)]
    if len(seen) != len(own["rows"]) - 1:
        wrong.append(f"{len(seen)} rows for json and {len(own['rows']) - 1} for armtrue")
    for row, cells in zip(seen, own["rows"][1:]):
        expected = dict(zip(own["rows"][0], cells))
        for column, value in row.items():
            cell = expected.get(column, "")
            if not (value == cell if isinstance(value, str) else cell == "" if value is None else value == typed(cell)):
                wrong.append(f"column {column} is {value!r} for json and {cell!r} for armtrue")
    return wrong[:5]


class Page(html.parser.HTMLParser):
    """A page whose tags are those that armtrue writes."""
    TAGS = set("html head meta title style link body header footer main section h1 h2 h3 h4 p span strong em b i ul ol li dl "
               "dt dd div table thead tbody tr th td caption details summary figure figcaption svg g path rect circle line "
               "text tspan desc polyline polygon a br hr code clippath defs lineargradient stop use symbol pre small sub "
               "sup nav article button input label abbr time script".split())

    def __init__(self, text):
        super().__init__()
        self.wrong, self.scripts = [], 0
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        if tag not in self.TAGS:
            self.wrong.append(f"the tag <{tag}>, which armtrue does not write")
        if tag == "script":
            self.scripts += 1
            if self.scripts > 1 or attributes:
                self.wrong.append("a script beside that of the page")
        for name, _ in attributes:
            if name.startswith("on"):
                self.wrong.append(f"the attribute {name}")

    handle_startendtag = handle_starttag


def kind_of(text):
    if text.startswith("format: armtrue-"):
        return "document"
    if re.match(r'\{\s*"format": "armtrue-', text):
        return "json"
    if re.match(r'\[\s*(\{"|\]\s*$)', text):
        return "rows"
    if text.startswith("<!DOCTYPE html"):
        return "page"
    if text.startswith("<"):
        return "other"
    header = text.split("\n", 1)[0]
    return "table" if re.match(r"[A-Za-z_]\w*[,;]\w", header) else "other"


CHECKS = {"document": document_mistakes, "json": json_mistakes, "table": table_mistakes, "rows": rows_mistakes}


def product_mistakes(files, values):
    """Mistakes of products as 'command: sentence', and how many products of each kind were read."""
    texts = {}
    for file in files:
        try:
            text = file.read_bytes().decode()
        except UnicodeDecodeError as error:
            if file.read_bytes().startswith((b"format: armtrue-", b"<!DOCTYPE html")):
                texts[file] = ("other", "")
                yield file, f"is no UTF-8: {error}"
            continue
        texts[file] = (kind_of(text), text)
    read = [file for file, (kind, _) in texts.items() if kind in CHECKS]
    own = {}
    for begin in range(0, len(read), FILES_AT_ONCE):
        part = read[begin:begin + FILES_AT_ONCE]
        done = [subprocess.run([values, *part], capture_output=True, text=True)]
        if done[0].returncode != 0:  # which it is
            done = [subprocess.run([values, file], capture_output=True, text=True) for file in part]
            for file, one in zip(part, done):
                if one.returncode != 0:
                    yield file, f"the readers of armtrue refuse a product: {one.stderr}"
            part = [file for file, one in zip(part, done) if one.returncode == 0]
        lines = [line for one in done if one.returncode == 0 for line in one.stdout.split("\n") if line]
        own.update(zip(part, map(json.loads, lines)))
    for file, (kind, text) in texts.items():
        if kind == "page":
            yield from ((file, line) for line in Page(text).wrong)
        elif file in own:
            yield from ((file, line) for line in CHECKS[kind](text, own[file]))


# Sentences

LIBRARIES = re.compile(
    r"\b(std::|boost::|YAML::|CLI::|Eigen|ceres|bad_alloc|basic_string|vector::|_M_\w+|stoi|stod|stoul|terminate called|"
    r"bad conversion|yaml-cpp|bad file|filesystem error|regex_error|Error in function|tgamma|iostream error|"
    r"what\(\)|unspecified|The following argument|Could not convert|not in range|required but received)\b|\w+::\w+\(")
NOT_FINITE = re.compile(r"(?<![\w.'\"/-])[-+]?(nan|inf|NaN|Infinity|1\.#\w+)(?![\w.'\"/-])")
OPTION = re.compile(r"(?<![\w(-])--[a-z][a-z0-9-]*[a-z0-9](?![a-z0-9-])")
OTHERS_OPTIONS = {"apps/launcher.cc"}  # those of the dynamic linker
SENTENCE_END = re.compile(r"(?<=[.;:])\s+")


def options_of(binaries):
    """The options of each command, from --help."""
    return {real.name: set(OPTION.findall(subprocess.run([real, "--help"], capture_output=True, text=True).stdout))
            for real in sorted(pathlib.Path(binaries).iterdir()) if os.access(real, os.X_OK) and real.is_file()}


def line_mistakes(line, options, unknown=()):
    """Of a line on stderr that a command of `options` says. `unknown`: options that the user typed."""
    wrong = []
    spoken = re.sub(r"'[^']*'", "''", line)  # without what is quoted from the user
    if found := NOT_FINITE.search(spoken):
        wrong.append(f"says {found.group()}: {line}")
    if found := LIBRARIES.search(spoken):
        wrong.append(f"in the words of a library, {found.group()}: {line}")
    speaker = re.match(r"([a-z-]+): ", line)
    speaker = speaker.group(1) if speaker and speaker.group(1) in options else None
    for found in OPTION.finditer(spoken):
        named = [name for name in options if re.search(rf"(?<![\w-]){name}(?![\w-])(?!:)", spoken[:found.start()])]
        able = [*named, speaker] if speaker or named else list(options)
        if not any(name and found.group() in options[name] for name in able):
            wrong.append(f"names {found.group()}, which {speaker or 'no command'} has not: {line}")
    return wrong


# What stands beside the file of a command, and is of it alone.
PARTS = {"calibration_inputs": "calibrate", "certificate_inputs": "certify", "comparison_inputs": "compare-runs",
         "conversion_inputs": "convert-robot", "conversion_outputs": "convert-robot",
         "correction_inputs": "compensate", "target_correction": "compensate",
         "import_inputs": "import-readings", "loop_inputs": "close-loop", "map_inputs": "map-errors",
         "mirror_inputs": "mirror-correct", "pass_inputs": "simulate-path", "plan_inputs": "plan-poses",
         "simulation_inputs": "simulate-poses"}


def source_mistakes(root, options):
    """Options in the texts of the sources: a command names its own, or another command before them. And functions that
    throw std::invalid_argument, the class of our own sentences, in words of the library."""
    wrong = []
    for file in sorted([*root.glob("apps/*.cc"), *root.glob("apps/*.h"), *root.glob("src/**/*.cc"), *root.glob("src/**/*.h")]):
        own = options.get(PARTS.get(file.stem, file.stem))
        text = re.sub(r'"\s*\n\s*"', "", file.read_text())  # one literal over several lines
        text = re.sub(r"//[^\n]*", "", text)
        wrong += [f"{file.relative_to(root)}: {call} throws in the words of the library; take read_number()"
                  for call in re.findall(r"std::sto[a-z]+\(", text)]
        for literal in re.findall(r'"((?:[^"\\\n]|\\.)*)"', text):
            if str(file.relative_to(root)) in OTHERS_OPTIONS or re.search(r"var\(--|[{;]--", literal):
                continue  # of a style sheet
            for found in OPTION.finditer(literal):
                named = [name for name in options if re.search(rf"(?<![\w-]){name}(?![\w-])", literal[:found.start()])]
                able = [options[name] for name in named] + ([own] if own else list(options.values()))
                if not any(found.group() in known for known in able):
                    wrong.append(f"{file.relative_to(root)}: {found.group()}: {literal[:160]}")
    return wrong


# Cases

def check_cases(kept, cases, binaries, values):
    options = options_of(binaries)
    wrong, lines = [], 0
    for case in sorted(path.parent for path in cases.glob("*/cmd")):
        needs = case / "needs"  # a library that is not built everywhere
        if needs.exists() and not (pathlib.Path(binaries).parent / "src" / f"lib{needs.read_text().strip()}.so").exists():
            continue
        err = kept / case.name / run_case.STDERR
        if not err.exists():
            wrong.append(f"{case.name}: nothing is kept; run the tests cli/{cases.name}")
            continue
        for line in filter(None, err.read_text().splitlines()):
            lines += 1
            wrong += [f"{case.name}: {mistake}" for mistake in line_mistakes(line, options)]
    files = sorted(path for path in kept.rglob("*") if path.is_file() and path.name != run_case.STDERR)
    for file, mistake in product_mistakes(files, values):
        wrong.append(f"{file.relative_to(kept)}: {mistake}")
    if not any(file.name.startswith(cases.name) for file in files):
        wrong.append(f"no product of {cases.name} is kept")
    print("\n".join(wrong + [f"{len(files)} products, {lines} lines on stderr: {len(wrong)} mistakes"]))
    return not wrong


def check_sources(root, binaries):
    wrong = source_mistakes(root, options_of(binaries))
    print("\n".join(wrong))
    return not wrong


# Names

NAMES_TO_KEEP = [
    "0032", "032", "08", "0o17", "0x1F", "0b101", "1_000", "1e3", "1E3", "-1", "+1", "+1.5", "1.", ".5", "-.5", "12", "12.50",
    "1:30", "12:30", "190:20:30.15", "-1:30", ".inf", "-.INF", "+.inf", ".nan", ".NaN", "nan", "inf", "NaN", "1.5e-05",
    "y", "Y", "n", "N", "yes", "Yes", "no", "NO", "on", "off", "OFF", "true", "True", "FALSE", "null", "Null", "~",
    "<<", "=", "2026-11-27", "2026-1-1", "2026-11-27 12:30:00", "2026-11-27T12:30:00Z", "2026-11-27t12:30:00.5+01:00",
    "a: b", "a :b", "a:", ":a", "::", "a #b", "#a", "-", "- a", "-a", "--", "---", "--- a", "...", "... a", "?", "? a", "?a",
    "!a", "!!str a", "&a", "*a", "%a", "@a", "`a", "|", ">", "> a", "{a}", "[a]", "{}", "[", "a]", "a, b", ",", ";a;b",
    "'a'", "it's", '"a"', '5" plate', 'a "b" c', '"', "\\", "a\\nb", " a", "a ", "\ta", "a\tb", "\u00e4\u00f6\u00fc\u00df",
    "\u4f4d\u7f6e", "\U0001F916", "\U0001F468\u200d\U0001F527", "\x85", "a\x85b", "a\u2028b", "a\u2029b", "a\ufeffb", "\ufeff",
    "a\x07b", "a\x1bb", "\x7f", "a\x9fb", "\u202egnp", "a\u200bb", "\u00a0a", "a\u00a0",
    "n" * 200, "\u4f4d" * 200, "x" * 1500, "<b>", "</script><script>alert(1)</script>", "a&amp;b", "A1", "E1",
]


def csv_text(rows):
    """Blanks at an end belong to a name in quotes only, and a row that begins with # is a comment."""
    def cell(text):
        quoted = text != text.strip(" \t") or text[:1] in ("#", '"') or "," in text
        return '"' + text.replace('"', '""') + '"' if quoted else text

    return "".join(",".join(map(cell, row)) + "\n" for row in rows)


def yaml_text(name):
    """The name between double quotes, with an escape for each character that is no letter, digit or common sign."""
    return '"' + "".join(c if re.match(r"[\w .:;/<>()-]", c) and c < "\ud800" else f"\\U{ord(c):08x}" for c in name) + '"'


def scalars_under(document, key):
    """All texts under a key, and the keys of maps under it."""
    found = []
    if isinstance(document, dict):
        for name, value in document.items():
            if name == key:
                found += value if isinstance(value, list) else list(value) if isinstance(value, dict) else [value]
            found += scalars_under(value, key)
    if isinstance(document, list):
        for item in document:
            found += scalars_under(item, key)
    return found


def check_names(binaries, config, values):
    """A campaign whose poses, targets, sessions, robot and serials have these names, through the commands."""
    names = NAMES_TO_KEEP
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def run(command, *arguments, codes=(0,)):
            done = subprocess.run([f"{binaries}/{command}", *arguments], cwd=folder, capture_output=True)
            if done.returncode not in codes:
                wrong.append(f"{command}: exit {done.returncode}: {done.stderr.decode(errors='replace')}")
            for line in done.stderr.decode(errors="replace").splitlines():
                if re.search("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff]", line):
                    wrong.append(f"{command}: a hidden character stands in a message: {line!r}")
            return done

        nominal = f"{config}/robots/kr360-spindle.yaml"
        run("simulate-poses", "--robot", nominal, "--truth", f"{config}/robots/kr360-table4.yaml", "--count",
            str(len(names)), "--repeats", "3", "--seed", "5", "-o", "plain.csv")
        rows = list(csv.reader(open(folder / "plain.csv")))
        poses = list(dict.fromkeys(row[0] for row in rows[1:]))
        half = len(poses) // 2
        for number, (target, session, name) in enumerate(zip(names, names[1:] + names[:1], names[2:] + names[:2])):
            if number % 9:  # every ninth in the other places; all as poses
                continue
            text = pathlib.Path(nominal).read_text()
            text = re.sub(r"(?m)^name: .*", lambda _: "name: " + yaml_text(name), text)
            text += f"targets: {{{yaml_text(target)}: [0, 0, 0]}}\n"
            (folder / "robot.yaml").write_text(text, newline="")
            table = [["pose", *rows[0][1:], "target", "session"]]
            table += [[names[poses.index(row[0])], *row[1:], target, session if poses.index(row[0]) < half else "other"]
                      for row in rows[1:]]
            (folder / "m.csv").write_text(csv_text(table), newline="")
            about = (pathlib.Path(config).parent / "tests/cli/certify/about.yaml").read_text()
            about = re.sub(r"serial: [^,}\n]*", lambda _: "serial: " + yaml_text(name), about)
            (folder / "about.yaml").write_text(about)
            run("calibrate", "--robot", "robot.yaml", "--residuals", "residuals.csv", "--report", "page.html", "m.csv", "-o",
                "calibrated.yaml", codes=(0, 3))
            run("evaluate-poses", "--robot", "calibrated.yaml", "m.csv", "-o", "evaluated.yaml")
            run("convert-robot", "--to", "yaml", "calibrated.yaml", "-o", "converted.yaml")
            run("convert-robot", "--to", "yaml", "calibrated.yaml", "-o", "converted.json")
            run("convert-robot", "--to", "yaml", "converted.json", "-o", "back.yaml")
            if (folder / "back.yaml").read_bytes() != (folder / "converted.yaml").read_bytes():
                wrong.append(f"{name!r}, {target!r}, {session!r}: a robot is another one when it was JSON")
            run("certify", "--robot", "calibrated.yaml", "--about", "about.yaml", "--refit", "base", "m.csv", "-o",
                "certificate.json", codes=(0, 1, 3))
            if number == 0:
                run("close-loop", "--robot", "robot.yaml", "--report", "loop.html", "m.csv", "-o", "loop.yaml", codes=(0, 3))
                run("compensate", "--robot", "calibrated.yaml", "--nominal", "robot.yaml", "--controller", "rough", "m.csv", "-o",
                    "commands.csv", codes=(0, 1, 2, 3))
            files = [file for file in folder.iterdir() if file.suffix in (".yaml", ".json", ".csv", ".html")
                     and file.name not in ("robot.yaml", "about.yaml")]
            for file, mistake in product_mistakes(files, values):
                wrong.append(f"{name!r}, {target!r}, {session!r}: {file.name}: {mistake}")
            document = ruamel.yaml.YAML(typ="safe", pure=True).load((folder / "calibrated.yaml").read_text())
            for seen, expected in ((document.get("name"), name), (list(document.get("targets", [])), [target]),
                                   (sorted(document.get("sessions", [])), sorted([session, "other"]))):
                if seen != expected:
                    wrong.append(f"{expected!r} became {seen!r}")
            residuals = list(csv.DictReader(open(folder / "residuals.csv", newline="")))
            if {row["pose"] for row in residuals} != set(names):
                wrong.append(f"poses became {sorted({row['pose'] for row in residuals} ^ set(names))!r}")
    print("\n".join(wrong + [f"{len(names)} names: {len(wrong)} mistakes"]))
    return not wrong


# JSON

def check_json(binaries, config, values):
    """Each document once as YAML and once as JSON, and each that a command reads, read from both: the same products."""
    tests = pathlib.Path(__file__).resolve().parents[1]
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def run(line, codes=(0,)):
            done = subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True, text=True,
                                  env=dict(os.environ, PATH=f"{binaries}:{os.environ['PATH']}", CONFIG=config))
            if done.returncode not in codes:
                wrong.append(f"{line}: exit {done.returncode}: {done.stderr}")

        def both(line, *documents, codes=(0,)):
            """`line` with documents NAME.yaml, and with the same as NAME.json."""
            run(line, codes)
            as_json = re.sub(r"\b(\w+)\.yaml", lambda name: f"{name[1]}.json" if name[1] in (*documents, *made) else name[0], line)
            run(as_json, codes)
            for name in documents:
                if not all((folder / f"{name}.{ending}").exists() for ending in ("yaml", "json")):
                    wrong.append(f"{line}: makes no {name}")
                    continue
                text = (folder / f"{name}.json").read_text()
                seen = read_json(text)
                expected = ruamel.yaml.YAML(typ="safe", pure=True).load((folder / f"{name}.yaml").read_text())
                for document in (seen, expected):  # the names and sums of inputs are those of other files
                    document.pop("provenance", None)
                if json.dumps(seen).replace(".json", ".yaml") != json.dumps(expected):
                    wrong.append(f"{line}: JSON says something else: {json.dumps(seen):.400}, {json.dumps(expected):.400}")
                formats.add(expected["format"])
            made.update(documents)

        def of_rows(rows):
            """Cells as JSON has them: names are texts, others numbers where they look so."""
            return [{column: None if cell == "" else cell if column in TABLE_NAMES else typed(cell) for column, cell in row.items()}
                    for row in rows]

        def table(line, name, *inputs, codes=(0,)):
            """`line` makes NAME.csv and, of the inputs as JSON, the same as NAME.json."""
            run(line, codes)
            run(re.sub(r"\b(\w+)\.csv", lambda file: f"{file[1]}.json" if file[1] in (name, *inputs) else file[0], line), codes)
            as_csv, as_json = folder / f"{name}.csv", folder / f"{name}.json"
            if not (as_csv.exists() and as_json.exists()):
                wrong.append(f"{line}: makes no {name}")
                return
            expected = of_rows(csv.DictReader(as_csv.open(newline="")))
            if read_json(as_json.read_text()) != expected:
                wrong.append(f"{line}: JSON says something else: {as_json.read_text():.300}, {as_csv.read_text():.300}")

        made, formats = set(), set()
        (folder / "about.yaml").write_text((tests / "cli/certify/about.yaml").read_text())
        about = yaml.load((tests / "cli/certify/about.yaml").read_text(), yaml.SafeLoader)
        (folder / "about.json").write_text(json.dumps(about, default=str, indent="\t"))
        made.add("about")
        catalogue = ruamel.yaml.YAML(typ="safe", pure=True).load(pathlib.Path(config, "effects/catalogue.yaml").read_text())
        (folder / "catalogue.json").write_text(json.dumps(catalogue))
        (folder / "catalogue.yaml").write_text(pathlib.Path(config, "effects/catalogue.yaml").read_text())
        made.add("catalogue")
        both("convert-robot --to yaml $CONFIG/robots/kr360-spindle.yaml -o robot.yaml", "robot")
        both("check-robot robot.yaml --at 0,-90,90,0,0,0 --pose 1949.277,12.533,2289.209,90,3.6094,-90 -o check.yaml", "check")
        table("simulate-poses --robot robot.yaml --truth $CONFIG/robots/kr360-table4.yaml --count 30 --repeats 2 --noise-mm 0.05 "
              "--noise-mrad 0.1 -o m.csv", "m")
        for name in ("residuals", "parameters", "correlations"):
            table(f"calibrate -q --robot robot.yaml m.csv --{name} {name}.csv -o x.yaml", name, "m")
            table(f"close-loop -q --robot robot.yaml --catalogue catalogue.yaml --only-catalogue m.csv --{name} {name}.csv -o x.yaml",
                  name, "m", codes=(0, 3))
        table("import-readings -q m.csv -o imported.csv", "imported")
        run("head -31 m.csv > other.csv")
        both("calibrate -q --robot robot.yaml m.csv -o calibrated.yaml", "calibrated")
        both("close-loop -q --robot robot.yaml --catalogue catalogue.yaml --only-catalogue m.csv --robot-out closed.yaml -o loop.yaml",
             "loop", "closed", codes=(0, 3))
        both("trace-residual -q --robot robot.yaml --only-catalogue m.csv -o ranking.yaml", "ranking")
        both("trace-residual -q --since calibrated.yaml other.csv -o change.yaml", "change")
        both("evaluate-poses -q --robot closed.yaml --against robot.yaml other.csv -o summary.yaml", "summary")
        both("certify -q --robot calibrated.yaml --about about.yaml --refit base,tool m.csv -o certificate.yaml", "certificate")
        both("certify -q --robot calibrated.yaml --about about.yaml --refit base,tool --against certificate.yaml m.csv -o second.yaml",
             "second")
        both("compare-runs -q --before calibrated.yaml closed.yaml -o comparison.yaml", "comparison")
        both("map-errors -q --robot calibrated.yaml --controller robot.yaml --box-mm 1400,2200,-400,400,300,1100 "
             "--grid 2,2,2 --start 0,-60,90,0,60,0 --summary map.yaml -o map.csv", "map")
        table("map-errors -q --robot calibrated.yaml --controller robot.yaml --box-mm 1400,2200,-400,400,300,1100 "
              "--grid 2,2,2 --start 0,-60,90,0,60,0 -o errors.csv", "errors")
        table("evaluate-poses -q --robot closed.yaml other.csv --residuals errors.csv -o x.yaml", "errors")
        table("plan-poses --robot robot.yaml --count 12 -q -o targets.csv", "targets")
        table("compensate -q --robot calibrated.yaml --controller robot.yaml targets.csv -o commands.csv", "commands", "targets")
        both("compensate -q --robot calibrated.yaml --controller robot.yaml targets.csv --summary compensation.yaml -o c.csv",
             "compensation")
        table("simulate-path --robot $CONFIG/robots/kr360-roughing.yaml --noise-mm 0.095 $CONFIG/paths/line300.csv -o pass.csv", "pass")
        table("mirror-correct -q --programmed $CONFIG/paths/line300.csv --measured pass.csv -o corrected.csv", "corrected", "pass")
        for name in ("poses", "deviation"):
            table("mirror-correct -q --programmed $CONFIG/paths/line300.csv --measured pass.csv --robot "
                  f"$CONFIG/robots/kr360-roughing.yaml --{name} {name}.csv -o x.csv", name, "pass")
        both("mirror-correct -q --programmed $CONFIG/paths/line300.csv --measured pass.csv --summary mirror.yaml -o x.csv", "mirror")
        for name in ("loop", "ranking"):  # which these read
            for ending in ("yaml", "json"):
                run(f"plan-poses --robot calibrated.{ending} --separate {name}.{ending} --count 3 -q -o {name}-{ending}.csv", (0, 1, 3))
            plans = [folder / f"{name}-{ending}.csv" for ending in ("yaml", "json")]
            if len({plan.read_bytes() if plan.exists() else None for plan in plans}) != 1:
                wrong.append(f"plan-poses --separate plans other poses by {name}.json")
        files = [file for file in folder.iterdir() if file.suffix == ".json" and file.stem not in ("about", "catalogue")]
        wrong += [f"{file.name}: {mistake}" for file, mistake in product_mistakes(files, values)]
        written_by_users = {"armtrue-about/1", "armtrue-catalogue/1", "armtrue-preset/1"}
        missing = set(VALIDATORS) - formats - written_by_users
        if missing:
            wrong.append(f"no document of {sorted(missing)} was written")
    print("\n".join(wrong + [f"{len(formats)} kinds of documents: {len(wrong)} mistakes"]))
    return not wrong


def schema_keys(schema):
    """The names of all keys that a schema knows."""
    if isinstance(schema, list):
        return set().union(*map(schema_keys, schema), set())
    if not isinstance(schema, dict):
        return set()
    own = set(schema["properties"]) if isinstance(schema.get("properties"), dict) else set()
    return own.union(*map(schema_keys, schema.values()))


def check_schemas(config, page):
    """Schemas are schemas, describe each kind of document of the page and no key that it does not describe, and allow
    what is shipped."""
    text = page.read_text()
    wrong = []
    for uri, schema in SCHEMA_FILES.items():
        name = uri.rpartition("/")[2]
        try:
            jsonschema.Draft202012Validator.check_schema(schema)
        except jsonschema.exceptions.SchemaError as error:
            wrong.append(f"{name}: {error.message}")
        wrong += [f"{name}: the page describes no key `{key}`" for key in sorted(schema_keys(schema))
                  if not re.search(rf"`{key}`", text)]
    described = set(re.findall(r"^# (armtrue-[a-z-]+/\d)$", text, re.M))
    wrong += [f"{kind}: has no schema, or no section of the page" for kind in described ^ set(VALIDATORS)]
    shipped = [file for folder in ("robots", "effects", "presets") for file in config.glob(f"{folder}/*.yaml")]
    for file in shipped:
        document = ruamel.yaml.YAML(typ="safe", pure=True).load(file.read_text())
        wrong += [f"{file.name}: {mistake}" for mistake in schema_mistakes(document)]
    print("\n".join(wrong + [f"{len(SCHEMA_FILES)} schemas, {len(shipped)} files: {len(wrong)} mistakes"]))
    return not wrong and len(shipped) > 1


def self_test():
    """The checks must fail where they should."""
    def scalar(text, is_text=False):
        return {"text": text, "is_text": is_text}

    def mistakes(text, *entries):
        global schema_mistakes
        kept, schema_mistakes = schema_mistakes, lambda _: []
        try:
            return document_mistakes(text, {"map": [[scalar(key), value] for key, value in entries]})
        finally:
            schema_mistakes = kept

    error = {"mean": 1, "rms": 1, "p95": 1, "max": 1}
    summary = {"format": "armtrue-summary/1", "provenance": {"command": "c", "version": "v"}, "robot": "r", "poses": 1, "rows": 1,
               "skipped_rows": 0, "noise_floor": {"source": "none", "position_mm": 0}, "floor_mm": 0, "position_mm": error,
               "axes_mm": {}}
    assert not schema_mistakes(summary)
    for key, value in (("robot", 12), ("poses", "1"), ("position_mm", {**error, "mean": None}), ("new_key", 1),
                       ("position_mm", {**error, "new_key": 1}), ("format", "armtrue-loop/2")):
        assert schema_mistakes({**summary, key: value}), key
    assert schema_mistakes({key: value for key, value in summary.items() if key != "rows"})
    for text in ('{"a": NaN}', '{"a": -Infinity}', '{"a": 1, "a": 2}', '{"a": 1,}', "a: 1"):
        try:
            read_json(text)
        except ValueError:
            continue
        raise AssertionError(text)
    assert json_mistakes('{"pose": 32}', {"map": [[scalar("pose", True), scalar("0032", True)]]})
    assert not mistakes('pose: "0032"\n', ("pose", scalar("0032", True)))
    for name in ("0032", "no", "12:30", "1_000", "2026-11-27", "~", "y: 1", "0o17", "1e3"):
        assert mistakes(f"pose: {name}\n", ("pose", scalar(name, True))), name
    assert mistakes("pose: no\n", ("pose", scalar("no")))
    assert mistakes('rms_mm: "0.5"\n', ("rms_mm", scalar("0.5", True)))
    assert not mistakes("rms_mm: 1.0e-05\n", ("rms_mm", scalar("1.0e-05")))
    assert mistakes("rms_mm: 1e-05\n", ("rms_mm", scalar("1e-05")))
    assert mistakes("rms_mm: .nan\n", ("rms_mm", scalar(".nan")))
    assert mistakes("0032: 1\n", ("0032", scalar("1")))
    assert not table_mistakes('pose,x\n"a,b",1\n', {"rows": [["pose", "x"], ["a,b", "1"]]})
    assert table_mistakes("pose,x\na,b,1\n", {"rows": [["pose", "x"], ["a,b", "1"]]})
    assert Page("<p><b>A</b></p>").wrong == [] and Page("<script></script><script>alert(1)</script>").wrong
    assert Page("<script></script>").wrong == [] and Page("<script src='a.js'></script>").wrong
    options = {"calibrate": {"--zone", "--report"}, "close-loop": {"--robot-out"}}
    assert not line_mistakes("calibrate: give --zone, or close-loop --robot-out", options)
    assert line_mistakes("calibrate: give --robot-out", options)
    assert line_mistakes("give --nothing", options)
    assert line_mistakes("calibrate: the mean is nan mm", options)
    assert line_mistakes("calibrate: from -inf to 3", options)
    assert not line_mistakes("calibrate: m.csv:3: column 'q1_deg': 'nan' is not finite; take nan.csv", options)
    for words in ("stoi", "vector::_M_range_check: __n", "basic_string::substr: __pos", "std::bad_alloc", "bad conversion",
                  "Error in function boost::math::tgamma<double>(double)", "filesystem error: cannot get current path"):
        assert line_mistakes("calibrate: " + words, options), words


if __name__ == "__main__":
    if sys.argv[1] == "--self-test":
        self_test()
    elif sys.argv[1] == "--sources":
        sys.exit(0 if check_sources(*map(pathlib.Path, sys.argv[2:])) else 1)
    elif sys.argv[1] == "--json":
        sys.exit(0 if check_json(*sys.argv[2:]) else 1)
    elif sys.argv[1] == "--schemas":
        sys.exit(0 if check_schemas(*map(pathlib.Path, sys.argv[2:])) else 1)
    elif sys.argv[1] == "--names":
        sys.exit(0 if check_names(*sys.argv[2:]) else 1)
    else:
        sys.exit(0 if check_cases(*map(pathlib.Path, sys.argv[1:])) else 1)
