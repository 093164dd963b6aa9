"""Runs one command test: a folder with

    cmd              shell lines, run in a fresh folder; $CASE is the test's folder, $CONFIG the shipped config
    exit             expected exit code (0 if absent)
    stdout           expected output, token by token; numbers may differ by 1e-6 of themselves
    stdout.contains  lines, each of which must stand somewhere in the output
    stderr.contains  the same for stderr; without it, stderr must be empty when the exit code is 0
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

TOLERANCE = 1e-6


def same_token(got, expected):
    if got == expected:
        return True
    try:
        a, b = float(got), float(expected)
    except ValueError:
        return False
    return abs(a - b) <= TOLERANCE * max(abs(a), abs(b), 1e-9)


def tokens(text):
    return re.findall(r"[^\s,{}\[\]:]+|[,{}\[\]:]", text)


def check(case, exit_code, out, err):
    """What is wrong with the result of a case, line by line."""
    def text(name):
        path = case / name
        return path.read_text() if path.exists() else None

    wrong = []
    expected_exit = int(text("exit") or 0)
    if exit_code != expected_exit:
        wrong.append(f"exit code {exit_code}, expected {expected_exit}")
    if (expected := text("stdout")) is not None:
        got, want = tokens(out), tokens(expected)
        if len(got) != len(want) or not all(map(same_token, got, want)):
            wrong.append(f"stdout differs; expected:\n{expected}")
    for name, stream in (("stdout.contains", out), ("stderr.contains", err)):
        for line in (text(name) or "").splitlines():
            if line and line not in stream:
                wrong.append(f"{name[:6]} lacks: {line}")
    if expected_exit == 0 and text("stderr.contains") is None and err:
        wrong.append("stderr is not empty")
    return wrong


def run(case, binaries, config):
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, CASE=str(case), CONFIG=config, PATH=f"{binaries}:{os.environ['PATH']}")
        done = subprocess.run(["bash", "-c", (case / "cmd").read_text()], cwd=folder, env=environment,
                              capture_output=True, text=True, stdin=subprocess.DEVNULL)
    wrong = check(case, done.returncode, done.stdout, done.stderr)
    if wrong:
        print("\n".join(wrong), f"\n--- stdout\n{done.stdout[:4000]}\n--- stderr\n{done.stderr[:4000]}")
    return not wrong


def self_test():
    """The runner must fail where it should."""
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder)
        (case / "stdout").write_text("a: 1.0000001\n")
        assert not check(case, 0, "a: 1\n", "")
        assert check(case, 0, "a: 1.1\n", "")
        assert check(case, 0, "a: 1 b\n", "")
        assert check(case, 1, "a: 1\n", "")
        assert check(case, 0, "a: 1\n", "a word on stderr")
        (case / "stderr.contains").write_text("remedy\n")
        assert check(case, 0, "a: 1\n", "nothing useful")
        assert not check(case, 0, "a: 1\n", "the remedy is")


if __name__ == "__main__":
    if sys.argv[1] == "--self-test":
        self_test()
    else:
        sys.exit(0 if run(pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]) else 1)
