"""Compares a page with the product of the same run, and looks whether the page is whole.

    check_page.py PAGE PRODUCT LEAST [--bars PICTURE_ROW CSV COLUMN [SPLIT]] [--mean KEY CSV COLUMN] [--pictures N]
                  [--robot ROBOT] [--parameters CSV]

Every element with data-key must hold what the product has at that path: the same text, or a number that the product's
rounds to; a key that begins with parameters: is a row and a column of the table CSV, and is looked at with --parameters
only. At least LEAST elements must. A number with a decimal point that stands outside such elements, pictures and
captions is an error. --bars: the bars of this row of the histogram, from the bottom on (1 is the lowest), count the
rows of the CSV file. --mean: the value at KEY is the mean of that column.
"""

import argparse
import csv
import html.parser
import math
import pathlib
import re
import sys

VOID = {"meta", "link", "br"}
MOST_BYTES = 1_000_000


class Page(html.parser.HTMLParser):
    """Keyed values, other text, pictures as lists of bars, and what is wrong with the tags."""

    def __init__(self, text):
        super().__init__()
        self.keyed, self.loose, self.pictures, self.wrong, self.words = [], [], [], [], []
        self.stack, self.bars, self.seen = [], [], []
        self.feed(text)
        self.close()
        if self.stack:
            self.wrong.append(f"not closed: {self.stack}")

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if tag == "script" and any(tag == "script" for tag, _ in self.seen):
            self.wrong.append("a second script")
        self.seen.append((tag, attributes))
        for name in ("src", "href"):
            if attributes.get(name, "data:,") != "data:,":
                self.wrong.append(f"loads {attributes[name]}")
        if tag == "svg":
            self.pictures.append({"view": attributes.get("viewbox"), "role": attributes.get("role"), "rows": [],
                                  "title": "", "desc": ""})
        if tag == "g" and self.pictures:
            self.pictures[-1]["rows"].append([])
        if tag not in VOID:
            self.stack.append((tag, attributes))

    def handle_startendtag(self, tag, attributes):
        pass

    def handle_endtag(self, tag):
        if not self.stack or self.stack[-1][0] != tag:
            self.wrong.append(f"</{tag}> closes {self.stack[-1:]}")
        else:
            self.stack.pop()

    def in_tag(self, *tags):
        return any(tag in tags for tag, _ in self.stack)

    def handle_data(self, data):
        keys = [a for _, a in self.stack if "data-key" in a]
        if keys:
            self.keyed.append((keys[-1]["data-key"], data, keys[-1].get("data-unit")))
        elif self.in_tag("title", "desc") and self.in_tag("svg"):
            kind, above = self.stack[-1][0], self.stack[-2][0]
            if above == "rect":
                self.pictures[-1]["rows"][-1].append(data)
            elif above == "svg":
                self.pictures[-1][kind] = data
        elif not self.in_tag("svg", "style", "script", "title", "figcaption"):
            self.loose.append(data)
        self.words.append(data)


# ---- the YAML that products are written in

def scalar(text):
    text = text.strip()
    if text[:1] == '"':
        return re.sub(r'\\(.)', r"\1", text[1:-1])
    if text[:1] == "'":
        return text[1:-1].replace("''", "'")
    return None if text in ("~", "null") else text


class Flow:
    def __init__(self, text):
        self.text, self.at = text, 0

    def space(self):
        while self.at < len(self.text) and self.text[self.at] in " ,\n":
            self.at += 1

    def value(self, stops):
        self.space()
        if self.text[self.at] == "{":
            return self.items("}")
        if self.text[self.at] == "[":
            return self.items("]")
        if self.text[self.at] in "\"'":
            found = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\'\'|[^\'])*\'').match(self.text, self.at)
        else:
            found = re.compile(r"(?:(?!: |, |[%s]).)+" % re.escape(stops)).match(self.text, self.at)
        self.at = found.end()
        return scalar(found[0])

    def items(self, end):
        self.at += 1
        values = {} if end == "}" else []
        while True:
            self.space()
            if self.text[self.at] == end:
                self.at += 1
                return values
            first = self.value("}]")
            if end == "]":
                values.append(first)
            else:
                self.at = self.text.index(":", self.at) + 1
                values[first] = self.value("}]")


def inline(text):
    return Flow(text).value("") if text[:1] in "{[" else scalar(text)


def parse(lines, indent=0):
    """The block of lines at this indent or more; takes them from the list."""
    block = [] if lines[0].lstrip().startswith("- ") else {}
    while lines:
        line = lines[0]
        depth = len(line) - len(line.lstrip())
        body = line.strip()
        if depth < indent or isinstance(block, list) != body.startswith("- "):
            break
        if isinstance(block, list):
            rest = body[2:]
            if re.match(r"[^\"'{\[][^:]*:( |$)", rest):
                lines[0] = " " * (depth + 2) + rest
                block.append(parse(lines, depth + 2))
            else:
                lines.pop(0)
                block.append(inline(rest))
            continue
        lines.pop(0)
        key, _, rest = re.match(r'("(?:\\.|[^"\\])*"|.+?):( |$)(.*)', body).groups()
        if rest:
            block[scalar(key)] = inline(rest)
            continue
        below = len(lines[0]) - len(lines[0].lstrip()) if lines else -1
        is_list = bool(lines) and lines[0].lstrip().startswith("- ")
        block[scalar(key)] = parse(lines, below) if below > depth or (is_list and below == depth) else None
    return block


def read_yaml(path):
    return parse([line for line in pathlib.Path(path).read_text().splitlines() if line.strip()])


def at(product, key):
    for part in key.split("/"):
        if isinstance(product, list):
            product = product[int(part)]
        elif part in product:
            product = product[part]
        else:
            raise KeyError(part)
    return product


def agree(shown, value, unit):
    if value is None:
        return False
    if shown == value and unit is None:
        return True
    try:
        number, expected = float(shown), float(value) * (100 if unit == "%" else 1)
    except ValueError:
        return False
    mantissa, _, exponent = shown.partition("e")
    decimals = len(mantissa.partition(".")[2]) - int(exponent or 0)
    return abs(number - expected) <= 0.5001 * 10 ** -decimals


# ---- checks

def column(path, name, split=None):
    rows = csv.DictReader(open(path))
    return [float(row[name]) for row in rows if row[name] and split in (None, row.get("split"))]


def check_bars(page, row, errors):
    """The counts of the bars are those of the errors."""
    picture = next(p for p in page.pictures if p["title"].startswith("How large"))
    bars = [re.fullmatch(r"(\S+) to (\S+) mm: (\d+)", text).groups() for text in picture["rows"][-row]]
    if not bars or sum(int(count) for *_, count in bars) != len(errors):
        return [f"bars count {bars}, not {len(errors)} readings"]
    wrong = []
    for low, high, count in bars:
        low, high, count = float(low), float(high), int(count)
        margin = 0.02 * (high - low)  # the limits are rounded
        most = sum(low - margin <= e <= high + margin for e in errors)
        least = sum(low + margin <= e < high - margin for e in errors)
        if not least <= count <= most:
            wrong.append(f"bar {low} to {high}: {count}, not {least} to {most}")
    return wrong


def value_at(key, product, robot, parameters):
    if key.startswith("parameters:"):
        row, _, name = key[len("parameters:"):].rpartition("/")
        return parameters[row][name]
    return at(robot, key[6:]) if key.startswith("robot:") else at(product, key)


def check(page, product, least, robot=None, parameters=None):
    wrong = list(page.wrong)
    seen = 0
    for key, shown, unit in page.keyed:
        if (key.startswith("parameters:") and parameters is None) or (key.startswith("robot:") and robot is None):
            continue
        try:
            value = value_at(key, product, robot, parameters)
        except (KeyError, IndexError, TypeError, ValueError):
            wrong.append(f"the product has no {key}")
            continue
        seen += 1
        if not agree(shown, value, unit):
            wrong.append(f"{key}: '{shown}' on the page, '{value}' in the product")
    if seen < least:
        wrong.append(f"{seen} values of the product on the page, not {least}")
    wrong += [f"a number without its key: '{text.strip()}'" for text in page.loose if re.search(r"\d\.\d", text)]
    for picture in page.pictures:
        if not (picture["view"] and picture["role"] == "img" and picture["title"] and picture["desc"]):
            wrong.append(f"a picture lacks size, title or description: {picture}")
    return wrong


def main():
    options = argparse.ArgumentParser()
    options.add_argument("page")
    options.add_argument("product")
    options.add_argument("least", type=int)
    options.add_argument("--bars", nargs="+", action="append", default=[])
    options.add_argument("--mean", nargs=3, action="append", default=[])
    options.add_argument("--pictures", type=int, default=1)
    options.add_argument("--robot", help="the robot file of keys that begin with robot:")
    options.add_argument("--parameters", help="the table of keys that begin with parameters:")
    given = options.parse_args()
    parameters = given.parameters and {row["parameter"]: row for row in csv.DictReader(open(given.parameters))}
    text = pathlib.Path(given.page).read_text()
    page, product = Page(text), read_yaml(given.product)
    wrong = check(page, product, given.least, given.robot and read_yaml(given.robot), parameters)
    if len(text.encode()) > MOST_BYTES:
        wrong.append(f"{len(text)} characters are too large a page")
    if len(page.pictures) != given.pictures:
        wrong.append(f"{len(page.pictures)} pictures, not {given.pictures}")
    for row, path, name, *split in given.bars:
        wrong += check_bars(page, int(row), column(path, name, *split))
    for key, path, name in given.mean:
        values = column(path, name)
        mean = math.fsum(values) / len(values)
        if abs(float(at(product, key)) - mean) > 6e-4 * abs(mean) + 1e-6:
            wrong.append(f"{key} is not the mean {mean} of {name}")
    print("\n".join(wrong) if wrong else f"{given.page}: as in the product")
    return bool(wrong)


def self_test():
    """The check must fail where it should."""
    product = parse(["a:", "  b: 0.1235", 'c: "x: <y>"', "d:", "  - name: n", "    e: {f: [1, 2], g: h (i)}"])
    assert product == {"a": {"b": "0.1235"}, "c": "x: <y>", "d": [{"name": "n", "e": {"f": ["1", "2"], "g": "h (i)"}}]}
    good = '<p><span data-key="a/b">0.1235</span> <span data-key="c">x: &lt;y&gt;</span></p>'
    assert not check(Page(good), product, 2)
    assert not check(Page(good.replace("0.1235", "0.124")), product, 2)
    assert not check(Page(good + "<script>1.5</script>"), product, 2)
    for bad in (good.replace("0.1235", "0.1236"), good.replace("0.1235", "0.125"), good.replace("a/b", "a/z"),
                good.replace("&lt;", ""), good + "<p>1.5</p>", good + "<script></script><script></script>",
                good + "<p>", good + "<script src='a.js'></script>",
                good + '<img src="http://x">', good + "<svg></svg>"):
        assert check(Page(bad), product, 2), bad
    assert check(Page(good), product, 3)
    of_table = '<p><span data-key="parameters:A2.d/change">0.12</span></p>'
    assert not check(Page(of_table), product, 1, parameters={"A2.d": {"change": "0.1234"}})
    assert check(Page(of_table), product, 1, parameters={"A2.d": {"change": "0.1334"}})
    assert check(Page(of_table), product, 1, parameters={})


if __name__ == "__main__":
    if "--self-test" in sys.argv:
        self_test()
        sys.exit(0)
    sys.exit(main())
