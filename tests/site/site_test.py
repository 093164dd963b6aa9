#!/usr/bin/env python3
"""apps/site makes a site whose links lead somewhere and that loads nothing from elsewhere. site_test.py BIN

What its guides tell users to type runs in the test man/pages, as the examples of every page.
"""

import html.parser
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCES = pathlib.Path(__file__).resolve().parents[2]
SITE = SOURCES / "apps/site"
BIN = pathlib.Path(sys.argv.pop(1)).resolve() if __name__ == "__main__" else SOURCES / "build/bin"


class Read(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.loaded, self.names, self.words = [], [], set(), ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        self.names |= {named[key] for key in ("id", "name") if key in named and tag not in ("meta", "input")}
        if tag == "a" and "href" in named:
            self.links.append(named["href"])
        if tag == "link" and "href" in named:
            self.loaded.append(named["href"])
        if "src" in named:
            self.loaded.append(named["src"])

    def handle_data(self, text):
        self.words += text


def broken(folder):
    """(page, link) of what leads nowhere or would be loaded from elsewhere."""
    read = {path.name: Read(path.read_text(encoding="utf-8")) for path in folder.glob("*.html")}
    wrong = []
    for name, page in read.items():
        for link in page.loaded:
            if not link.startswith("data:") and (":" in link or not (folder / link).is_file()):
                wrong.append((name, link))
        for link in page.links:
            if re.match(r"https?:|data:|mailto:", link):
                continue
            target, _, anchor = link.partition("#")
            if target and not (folder / target).is_file():
                wrong.append((name, link))
            elif anchor and (target or name) in read and anchor not in read[target or name].names:
                wrong.append((name, link))
    return wrong


class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.hold = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.hold.name, "site")
        cls.done = subprocess.run([SITE, "--bin", BIN, cls.folder], capture_output=True, text=True)

    @classmethod
    def tearDownClass(cls):
        cls.hold.cleanup()

    def test_every_link_leads_somewhere_and_nothing_is_loaded_from_elsewhere(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        self.assertEqual(broken(self.folder), [])

    def test_every_page_is_reached_from_the_first(self):
        seen, waiting = set(), ["index.html"]
        while waiting:
            name = waiting.pop()
            if name not in seen and name.endswith(".html"):
                seen.add(name)
                waiting += [link.partition("#")[0] for link in Read((self.folder / name).read_text()).links
                            if link.partition("#")[0] and ":" not in link]
        self.assertEqual(seen, {path.name for path in self.folder.glob("*.html")})
        pages = {f"{path.name.removesuffix('.md')}.html" for path in (SOURCES / "apps").glob("*.[1-9].md")}
        self.assertLessEqual(pages, seen)

    def test_names_of_pages_in_the_text_are_links(self):
        text = (self.folder / "trace-residual.1.html").read_text()
        self.assertIn('<a href="close-loop.1.html">close-loop(1)</a>', text)
        for page in self.folder.glob("*.html"):
            for example in re.findall(r"<pre>.*?</pre>", page.read_text(), re.S):
                self.assertNotIn("<a ", example)

    def test_a_second_time_makes_the_same_and_a_folder_of_somebody_is_refused(self):
        before = {path.relative_to(self.folder): path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}
        (self.folder / "left-over.html").write_text("old")
        again = subprocess.run([SITE, "--bin", BIN, self.folder], capture_output=True, text=True)
        self.assertEqual(again.returncode, 0, again.stderr)
        after = {path.relative_to(self.folder): path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}
        self.assertEqual(set(before), set(after))
        pages = {path for path in before if before[path] != after[path]}
        self.assertEqual(pages, set())
        mine = pathlib.Path(self.hold.name, "mine")
        mine.mkdir()
        (mine / "thesis.tex").write_text("x")
        refused = subprocess.run([SITE, "--bin", BIN, mine], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("name another folder", refused.stderr)
        self.assertEqual((mine / "thesis.tex").read_text(), "x")
        self.assertEqual(sorted(path.name for path in pathlib.Path(self.hold.name).iterdir()), ["mine", "site"])

    def test_the_check_finds_a_broken_link(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "a.html").write_text('<a href="b.html">b</a><a href="#c">c</a><a id="d" href="#d">d</a>'
                                           '<img src="https://example.com/e.png"><a href="https://example.com">f</a>')
            self.assertEqual(broken(folder), [("a.html", "https://example.com/e.png"), ("a.html", "b.html"), ("a.html", "#c")])


if __name__ == "__main__":
    unittest.main()
