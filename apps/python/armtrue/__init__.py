"""armtrue in Python: each command is a function, with files, dictionaries or tables going in and coming out.

    import armtrue
    closed = armtrue.close_loop("robot.yaml", "measured.csv")
    print(closed.product["verdict"], closed.product["before_after"]["after_mm"])
    commands = armtrue.compensate(closed, targets, controller="robot.yaml")
    commands.frame()                                    # pandas, if it is installed

The functions run the commands, which compute everything; help() of each is its manual page. The robot comes first, then what
the command calls FILE: calibrate(robot, readings); trace_residual(readings, robot) alone begins with the readings. Each may
be a path, a document as a dict, a table as a list of dicts or as a pandas frame, or the result of another function: its
robot, or else its table. Options are keywords: `held_out=0.3` is `--held-out 0.3`, True is a flag, a list of numbers is
one option with commas, a list of texts the option repeated. Names of files that a command writes (`report`, `residuals`)
are given as paths.
"""

from __future__ import annotations

import csv
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
from typing import Any, Mapping, Protocol, Sequence, Union


class Frame(Protocol):
    """What is asked of a pandas frame."""

    def to_csv(self, path: Any, /, *, index: bool) -> Any: ...


Table = Sequence[Mapping[str, Any]]
File = Union[str, "os.PathLike[str]", Mapping[str, Any], Table, Frame, "Result"]

_HERE = pathlib.Path(__file__).resolve().parent


class Failed(Exception):
    """A command ended with 1 (bad data) or 2 (wrong usage); the text is its message."""

    def __init__(self, command: str, code: int, message: str) -> None:
        super().__init__(message or f"{command} ended with {code}")
        self.command, self.code = command, code


class Result:
    """What a command made.

    product   the document as a dict, the table as a list of dicts with numbers, or the text; None if a corrected program,
              in the file program_out, is all that the command makes
    robot     the robot of close_loop() and calibrate(), a dict; None of others
    summary   the summary of compensate(), map_errors() and mirror_correct(), a dict; None of others
    warnings  the lines that the command said
    held      False if a criterion that was asked for failed (exit code 3)
    """

    def __init__(self, product: Any, robot: Any, summary: Any, warnings: list[str], held: bool) -> None:
        self.product, self.robot, self.summary = product, robot, summary
        self.warnings, self.held = warnings, held

    def frame(self) -> Any:
        """The table as a pandas frame. Raises TypeError if the product is no table, ImportError without pandas."""
        if not isinstance(self.product, list):
            raise TypeError("the product is no table")
        import pandas

        return pandas.DataFrame(self.product)

    def __repr__(self) -> str:
        kinds: dict[type, str] = {dict: "a document", list: "a table"}
        what = kinds.get(type(self.product), "text")
        return f"<armtrue result: {what}, {len(self.warnings)} warnings>"


def program(name: str) -> str:
    """The file that runs a command, if it is called by the command's name. Raises FileNotFoundError if there is none."""
    folder = os.environ.get("ARMTRUE_BIN")
    places = [pathlib.Path(folder) / name] if folder else [_HERE / "commands" / "lib" / "armtrue" / "launcher"]
    for place in places:
        if place.exists():
            return str(place)
    on_path = shutil.which(name)
    if not on_path:
        raise FileNotFoundError(f"the command {name} is neither {places[0]} nor on the PATH")
    return on_path


def shipped(name: str) -> pathlib.Path:
    """The path of a shipped file, such as robots/kr360-spindle.yaml or campaigns/tutorial.csv."""
    # Of pip, of the sources, of an installed tree.
    for folder in (_HERE / "commands" / "share" / "armtrue", _HERE.parents[2] / "config", _HERE.parents[1]):
        if (folder / name).exists():
            return folder / name
    raise FileNotFoundError(f"armtrue has no file {name}")


def _page(name: str) -> str:
    for folder in (_HERE / "pages", _HERE.parents[1], _HERE.parents[1] / "pages"):  # pip, sources, installed
        page = folder / f"{name}.1.md"
        if page.exists():
            return page.read_text(encoding="utf-8")
    return f"Runs {name}."


def _is_table(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(row, Mapping) for row in value) and bool(value)


# All text is quoted: the commands take a line that begins with # for a comment, and blanks at the ends of names away.
_QUOTING = csv.QUOTE_NONNUMERIC


def _write_table(rows: Table, path: str) -> None:
    columns = list(dict.fromkeys(column for row in rows for column in row))
    with open(path, "w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, columns, lineterminator="\n", quoting=_QUOTING)
        writer.writeheader()
        for row in rows:
            writer.writerow({column: "" if row.get(column) is None else row[column] for column in columns})


class _Run:
    """The files of one call, in a folder that is gone when it ends."""

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.names: dict[str, str] = {}

    def path(self, name: str, ending: str) -> str:
        path = os.path.join(self.folder, f"{len(self.names)}{ending}")
        self.names[path] = name
        return path

    def said(self, text: str) -> str:
        """What a command said, with the names of arguments in place of files that nobody else knows."""
        for path, name in self.names.items():
            text = text.replace(path, f"<{name}>")
        return text

    def file(self, name: str, given: File) -> str:
        value: Any = given
        if isinstance(value, Result):
            value = value.robot if value.robot is not None else value.product
        if isinstance(value, Mapping):
            path = self.path(name, ".json")
            with open(path, "w", encoding="utf-8") as out:
                json.dump(value, out)
        elif hasattr(value, "to_csv"):
            path = self.path(name, ".csv")
            value.to_csv(path, index=False, quoting=_QUOTING)
        elif _is_table(value):
            path = self.path(name, ".csv")
            _write_table(value, path)
        elif isinstance(value, (str, os.PathLike)):
            return os.fspath(value)
        else:
            raise TypeError(f"{type(value).__name__} is no file: give a path, a dict, a list of dicts or a frame")
        return path

    def words(self, option: str, value: Any) -> list[str]:
        name = "--" + option.replace("_", "-")
        if value is None or value is False:
            return []
        if value is True:
            return [name]
        if isinstance(value, (Result, Mapping)) or hasattr(value, "to_csv") or _is_table(value):
            return [name, self.file(option, value)]
        if isinstance(value, (list, tuple)):
            if all(isinstance(one, (int, float)) for one in value):
                return [name, ",".join(repr(one) for one in value)]
            return [word for one in value for word in self.words(option, one)]
        return [name, os.fspath(value) if isinstance(value, os.PathLike) else str(value)]


def _run(name: str, file: tuple[str, File | None], kind: str | None, options: dict[str, Any], robot_out: bool = False,
         has_summary: bool = False) -> Result:
    with tempfile.TemporaryDirectory(prefix="armtrue-") as folder:
        run = _Run(folder)
        product = run.path("product", ".out" if kind == "text" else ".json")
        words = [name, *(["-o", product] if kind else [])]
        files = {}
        for what, wanted in (("robot_out", robot_out), ("summary", has_summary)):
            if wanted:
                files[what] = run.path(what, ".json")
                words += ["--" + what.replace("_", "-"), files[what]]
        for option, value in options.items():
            if option in ("output", *files):
                raise TypeError(f"{option} is what the function returns")
            words += run.words(option, value)
        what_file, content = file
        if content is not None:
            words += ["--", run.file(what_file, content)]
        done = subprocess.run(words, executable=program(name), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True, encoding="utf-8", check=False)
        if done.returncode not in (0, 3):
            raise Failed(name, done.returncode, run.said(done.stderr.strip()))

        def read(path: str) -> Any:
            text = run.said(pathlib.Path(path).read_text(encoding="utf-8"))
            return json.loads(text) if path.endswith(".json") else text

        documents = {what: read(path) for what, path in files.items() if os.path.exists(path)}
        made = read(product) if kind else None
        robot = made if name == "calibrate" else documents.get("robot_out")
        return Result(made, robot, documents.get("summary"), run.said(done.stderr).splitlines(), done.returncode == 0)


def calibrate(robot: File, readings: File, **options: Any) -> Result:
    return _run("calibrate", ("readings", readings), "document", {"robot": robot, **options})


def certify(robot: File, readings: File, *, about: File, **options: Any) -> Result:
    return _run("certify", ("readings", readings), "document", {"robot": robot, "about": about, **options})


def check_robot(robot: File, *, at: Sequence[float], **options: Any) -> Result:
    return _run("check-robot", ("robot", robot), "document", {"at": list(at), **options})


def close_loop(robot: File, readings: File, **options: Any) -> Result:
    return _run("close-loop", ("readings", readings), "document", {"robot": robot, **options}, robot_out=True)


def compare_runs(before: File, after: File, **options: Any) -> Result:
    return _run("compare-runs", ("after", after), "document", {"before": before, **options})


def compensate(robot: File, targets: File | None = None, *, controller: File, **options: Any) -> Result:
    kind = None if options.get("program") else "table"
    return _run("compensate", ("targets", targets), kind, {"robot": robot, "controller": controller, **options},
                has_summary=not options.get("project"))


def convert_robot(robot: File, *, to: str, **options: Any) -> Result:
    return _run("convert-robot", ("robot", robot), "document" if to in ("yaml", "json") else "text", {"to": to, **options})


def evaluate_poses(robot: File, readings: File, **options: Any) -> Result:
    return _run("evaluate-poses", ("readings", readings), "document", {"robot": robot, **options})


def import_readings(table: File | None = None, **options: Any) -> Result:
    return _run("import-readings", ("table", table), "table", options)


def map_errors(robot: File, *, controller: File, **options: Any) -> Result:
    return _run("map-errors", ("", None), "table", {"robot": robot, "controller": controller, **options}, has_summary=True)


def mirror_correct(programmed: File, measured: File | None = None, **options: Any) -> Result:
    return _run("mirror-correct", ("", None), "table", {"programmed": programmed, "measured": measured, **options},
                has_summary=measured is not None)


def plan_poses(robot: File, count: int, **options: Any) -> Result:
    return _run("plan-poses", ("", None), "table", {"robot": robot, "count": count, **options})


def simulate_path(robot: File, path: File, **options: Any) -> Result:
    return _run("simulate-path", ("path", path), "table", {"robot": robot, **options})


def simulate_poses(robot: File, **options: Any) -> Result:
    return _run("simulate-poses", ("", None), "table", {"robot": robot, **options})


def trace_residual(readings: File, robot: File | None = None, **options: Any) -> Result:
    return _run("trace-residual", ("readings", readings), "document", {"robot": robot, **options})


_FUNCTIONS = (calibrate, certify, check_robot, close_loop, compare_runs, compensate, convert_robot, evaluate_poses,
              import_readings, map_errors, mirror_correct, plan_poses, simulate_path, simulate_poses, trace_residual)
for _function in _FUNCTIONS:
    _function.__doc__ = _page(_function.__name__.replace("_", "-"))

__all__ = ["Failed", "Result", "shipped", *(function.__name__ for function in _FUNCTIONS)]
