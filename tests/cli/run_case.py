"""Runs command tests, called cases. A case is a folder <command>/<case> with

    cmd              shell lines, run in a fresh folder; $CASE is the case's folder, $CONFIG the shipped config
    exit             expected exit code of cmd (0 if absent)
    stdout           expected output, token by token; numbers may differ by 1e-6 of themselves
    stdout.contains  lines, each of which must stand somewhere in the output
    stderr.contains  the same for stderr

Without stdout and stdout.contains, stdout must be empty. Without stderr.contains, stderr must be empty and the exit
code must be 0: a case that expects an error says which. A command that a signal n ends has the exit code 128 + n.

`bash -euo pipefail` runs cmd. The first command that fails ends the case, also inside a pipe. There are places where
bash does not see a failure. Do not use them for a check:

    first && second      write two lines
    ! command            write: fails 1 command
    command <(other)     write the output of other to a file first
    command $(other)     write: value=$(other), then: command $value

A pipe must read all that its command writes. For `head` and `grep -q`, write the output to a file first.

A command that must fail is written `fails CODE COMMAND...`. If the command ends with CODE, the case goes on. If not,
the case ends with 99. `fails 1 cmp -s a b` says that two files differ. `fails 1 grep -q x a` says that x is not in a.

    run_case.py CASE BIN CONFIG               runs one case with the commands in BIN
    run_case.py --self-test                   checks this file
    run_case.py --stub-test CASES BIN CONFIG  checks that no case in the folder CASES passes if a stub stands in for its
                                              command; the other commands in BIN stay as they are
"""

import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

TOLERANCE = 1e-6
WORKERS = 2

PRELUDE = """
shopt -s inherit_errexit
fails() {
  local expected=$1 code=0
  shift
  "$@" || code=$?
  if [ $code != $expected ]; then
    echo "exit code $code, expected $expected: $*" >&2
    exit 99
  fi
}
"""

# What a stub does after it has read its input. $product is the file after -o, or standard output.
STUBS = {
    "random bytes": '{head} -c 2000 /dev/urandom > "$product"',
    "the same line": 'echo "pose: 1, 2, 3" > "$product"',
    "silence": "exit $EXPECTED_EXIT",
    "a signal": "kill -SEGV $$",
}
STUB_START = """#!{bash}
ulimit -c 0
product=/dev/stdout
while [ $# -gt 0 ]; do
  if [ "$1" = -o ]; then product=$2; shift; fi
  shift
done
{cat} > /dev/null
"""


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


def text(case, name):
    path = case / name
    return path.read_text() if path.exists() else None


def lines(case, name):
    return [line for line in (text(case, name) or "").splitlines() if line]


def expected_exit(case):
    return int(text(case, "exit") or 0)


def check(case, exit_code, out, err):
    """What is wrong with the result of a case, line by line."""
    wrong = []
    if exit_code != expected_exit(case):
        signal = f" (signal {exit_code - 128})" if exit_code > 128 else ""
        wrong.append(f"exit code {exit_code}{signal}, expected {expected_exit(case)}")
    if (expected := text(case, "stdout")) is not None:
        got, want = tokens(out), tokens(expected)
        if len(got) != len(want) or not all(map(same_token, got, want)):
            wrong.append(f"stdout differs; expected:\n{expected}")
    for name, stream in (("stdout.contains", out), ("stderr.contains", err)):
        for line in lines(case, name):
            if line not in stream:
                wrong.append(f"{name[:6]} lacks: {line}")
    if expected is None and not lines(case, "stdout.contains") and out:
        wrong.append("stdout is not empty")
    if not lines(case, "stderr.contains"):
        if expected_exit(case) != 0:
            wrong.append("the case has no stderr.contains and does not say which error it expects")
        elif err:
            wrong.append("stderr is not empty")
    return wrong


def run(case, path, config):
    """What is wrong with a case, and what it printed. `path` has the commands, the first folder counts first."""
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, CASE=str(case), CONFIG=config, PATH=f"{path}:{os.environ['PATH']}",
                           EXPECTED_EXIT=str(expected_exit(case)))
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", PRELUDE + (case / "cmd").read_text()], cwd=folder,
                              env=environment, capture_output=True, text=True, errors="replace",
                              stdin=subprocess.DEVNULL)
    exit_code = done.returncode if done.returncode >= 0 else 128 - done.returncode
    return check(case, exit_code, done.stdout, done.stderr), done.stdout, done.stderr


def run_and_report(case, binaries, config):
    wrong, out, err = run(case, binaries, config)
    if wrong:
        print("\n".join(wrong), f"\n--- stdout\n{out[:4000]}\n--- stderr\n{err[:4000]}")
    return not wrong


def write_stub(action, path):
    tools = {name: shutil.which(name) for name in ("bash", "cat", "head")}  # a case may change PATH
    path.parent.mkdir(parents=True)
    path.write_text((STUB_START + action + "\n").format(**tools))
    path.chmod(0o755)


def passes_with_stub(cases, binaries, config):
    """The number of runs, and the cases that pass with a stub as '<command>/<case>: <stub>'."""
    folders = sorted(path.parent for path in cases.glob("*/*/cmd"))
    with tempfile.TemporaryDirectory() as stubs:
        for stub, action in STUBS.items():
            for command in {folder.parent.name for folder in folders}:
                write_stub(action, pathlib.Path(stubs, stub, command, command))

        def passes(job):
            folder, stub = job
            wrong, _, _ = run(folder, f"{stubs}/{stub}/{folder.parent.name}:{binaries}", config)
            return not wrong

        jobs = [(folder, stub) for folder in folders for stub in STUBS]
        with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
            passed = list(pool.map(passes, jobs))
    return len(jobs), [f"{folder.parent.name}/{folder.name}: {stub}" for (folder, stub), ok in zip(jobs, passed) if ok]


def stub_test(cases, binaries, config):
    count, passed = passes_with_stub(cases, binaries, config)
    print(f"{count} runs with a stub, {len(passed)} passed")
    for line in passed:
        print(f"cannot fail: {line}")
    return count > 0 and not passed


def self_test():
    """The runner must fail where it should."""
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder)
        assert not check(case, 0, "", "")
        assert check(case, 0, "a word on stdout", "")
        assert check(case, 0, "", "a word on stderr")
        assert check(case, 139, "", "")
        (case / "stdout").write_text("a: 1.0000001\n")
        assert not check(case, 0, "a: 1\n", "")
        assert check(case, 0, "a: 1.1\n", "")
        assert check(case, 0, "a: 1 b\n", "")
        assert check(case, 1, "a: 1\n", "")
        assert check(case, 0, "a: 1\n", "a word on stderr")
        (case / "stderr.contains").write_text("remedy\n")
        assert check(case, 0, "a: 1\n", "nothing useful")
        assert not check(case, 0, "a: 1\n", "the remedy is")
        (case / "stdout").unlink()
        (case / "exit").write_text("1\n")
        assert not check(case, 1, "", "the remedy is")
        assert check(case, 1, "a: 1\n", "the remedy is")
        assert check(case, 0, "", "the remedy is")
        assert check(case, 139, "", "the remedy is")
        (case / "exit").write_text("139\n")
        assert not check(case, 139, "", "the remedy is")
        (case / "stderr.contains").unlink()
        assert check(case, 139, "", "the remedy is")
    self_test_of_shell()
    self_test_of_stubs()


def self_test_of_shell():
    """A failure inside the shell lines must end the case, unless `fails` expects it."""
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder)

        def passes(cmd):
            (case / "cmd").write_text(cmd)
            return not run(case, folder, folder)[0]

        assert passes("true")
        assert not passes("false")
        assert not passes("false; true")
        assert not passes("false | true")
        assert not passes("x=$(false; true); true")
        assert not passes("true \"$unset\"")
        assert not passes("kill -SEGV $$")
        assert not passes("sh -c 'kill -SEGV $$'; true")
        assert not passes("sh -c 'kill -SEGV $$' | true")
        assert not passes("cmp -s a b")
        assert passes("echo 1 > a; echo 2 > b; fails 1 cmp -s a b")
        assert not passes("echo 1 > a; echo 1 > b; fails 1 cmp -s a b; true")
        assert not passes("fails 1 cmp -s a b")
        assert not passes("fails 1 true | true")
        assert not passes("fails 1 sh -c 'kill -SEGV $$'")


def self_test_of_stubs():
    """The stub test must name exactly the cases that cannot fail."""
    with tempfile.TemporaryDirectory() as folder:
        cases, binaries = pathlib.Path(folder, "cases"), pathlib.Path(folder, "bin")
        binaries.mkdir()
        (binaries / "say").write_text("#!/bin/sh\necho yes\n")
        (binaries / "say").chmod(0o755)
        for name, cmd in (("sees", "test $(say) = yes"), ("blind", "say > a || true"), ("half-blind", "say > a")):
            (cases / "say" / name).mkdir(parents=True)
            (cases / "say" / name / "cmd").write_text(cmd)
            assert not run(cases / "say" / name, binaries, folder)[0], name
        count, passed = passes_with_stub(cases, binaries, folder)
        assert count == 3 * len(STUBS)
        assert passed == [f"say/{name}: {stub}" for name in ("blind", "half-blind")
                          for stub in ("random bytes", "the same line", "silence")], passed


if __name__ == "__main__":
    if sys.argv[1] == "--self-test":
        self_test()
    elif sys.argv[1] == "--stub-test":
        sys.exit(0 if stub_test(pathlib.Path(sys.argv[2]), sys.argv[3], sys.argv[4]) else 1)
    else:
        sys.exit(0 if run_and_report(pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]) else 1)
