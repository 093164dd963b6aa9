"""Runs command tests, called cases. A case is a folder <command>/<case> with

    cmd              shell lines, run in a fresh folder; $CASE is the case's folder, $CONFIG the shipped config
    exit             expected exit code of cmd (0 if absent)
    stdout           expected output, token by token; numbers may differ by 1e-6 of themselves
    stdout.contains  lines, each of which must stand somewhere in the output
    stderr.contains  the same for stderr
    needs            a target of CMake, a library, without which the case is left out

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

Then the case runs once more with each of some stubs in the place of its command, and must fail each time: a case that
passes sees nothing. The other commands stay as they are. What comes before the first line that names the command runs
once for all of them.

    run_case.py CASE... BIN CONFIG KEPT    runs cases with the commands in BIN. What each command made, and what stood on
                                           stderr, is kept in the folder KEPT/<command>/<case>; tests/products reads it
    run_case.py --self-test                checks this file
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

TOLERANCE = 1e-6
STDERR = "stderr"  # of a case, among its products
MOST_BYTES = 3_000_000  # of a product that is kept; larger ones hold more of the same

PRELUDE = """
shopt -s inherit_errexit
export CASE_SHELL=$$
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
STUB_START = """#!{sh}
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


# What each command made is copied to $STORE: files that an argument names, what it added to a file behind its standard
# output, and what it wrote to the output of the case.
WRAPPER = """#!{bash}
files() {{
  local argument existing=()
  for argument in "${{@#*=}}"; do
    if [ -f "$argument" ]; then existing+=("$argument"); fi
  done
  if (( ${{#existing[@]}} )); then {stat} -c '%i %y %s %n' -- "${{existing[@]}}"; fi
}}
length() {{ {stat} -L -c %s /proc/$$/fd/1; }}
before=$(files "$@")
if [ -f /proc/$$/fd/1 ]; then written=$(length); fi
if [ -p /proc/$$/fd/1 ] && [ /proc/$$/fd/1 -ef /proc/$CASE_SHELL/fd/1 ]; then  # no file of a function's output
  {real} "$@" | {tee} "$STORE/{command}.$$.printed"
  code=${{PIPESTATUS[0]}}
else
  {real} "$@"
  code=$?
fi
while read -r inode day time zone size name; do
  case "$before" in *"$inode $day $time $zone $size $name"*) continue ;; esac
  if (( 0 < size && size <= {most} )); then {cp} -- "$name" "$STORE/{command}.$$.$((++number))"; fi
done < <(files "$@")
if [ "$written" ]; then
  added=$(( $(length) - written ))
  if (( 0 < added && added <= {most} )); then {tail} -c +$((written + 1)) /proc/$$/fd/1 > "$STORE/{command}.$$.added"; fi
fi
exit $code
"""
# What the lines of a beginning must not do, because its variables and functions alone are carried over.
CARRIED_BY_NOTHING = re.compile(r"\b(cd|pushd|exec|trap|shopt|set|ulimit|umask|PATH|wait|mkfifo|readonly)\b|&\s*$", re.M)
SAVE = """
{ declare -p | grep -vE '^declare -[a-zA-Z]*r|^declare -[-a-zA-Z]+ (_|PATH|PWD|OLDPWD|SHLVL|S?RANDOM|SECONDS|STORE|(BASH|EPOCH|FUNC|PIPE|GROUPS|DIR|LINENO|COMP_|HIST|OPT)[A-Z_]*)(=|$)'
  declare -f; } > "$VARIABLES"
"""


def is_whole(lines):
    """Whether lines are whole commands of bash."""
    parsed = subprocess.run(["bash", "-n"], input=lines, capture_output=True, text=True)
    return not lines.endswith("\\\n") and parsed.returncode == 0 and not parsed.stderr


def split(cmd, command, slow):
    """The beginning of shell lines that does not name the command, and the rest. Without one of the slow commands it is
    empty: nothing is gained by running it apart."""
    lines = cmd.splitlines(keepends=True)
    named = re.compile(rf"(?<![\w-]){re.escape(command)}(?![\w-])")
    count = next((k for k, line in enumerate(lines) if named.search(line) and not line.startswith("#")), 0)
    while count > 0:
        beginning = "".join(lines[:count])
        done = re.sub(r"(?m)^#.*", "", beginning)
        if CARRIED_BY_NOTHING.search(done) or not any(name in done for name in slow):
            break
        if is_whole(beginning):
            return beginning, "".join(lines[count:])
        count -= 1
    return "", cmd


def copy(folder, other):
    subprocess.run(["cp", "-a", folder, other], check=True)  # links of both kinds stay links


class Run:
    """A case in a folder, which has the same path each time."""

    def __init__(self, case, binaries, config, scratch, kept=None):
        self.case, self.binaries, self.scratch = case, binaries, pathlib.Path(scratch)
        self.folder, self.kept = self.scratch / "folder", kept or self.scratch / "kept"
        self.kept.mkdir(parents=True)
        self.variables = dict(os.environ, CASE=str(case), CONFIG=str(config), EXPECTED_EXIT=str(expected_exit(case)),
                              STORE=str(self.kept), VARIABLES=str(self.scratch / "variables"))
        self.folder.mkdir()
        commands = [path.name for path in pathlib.Path(binaries).iterdir()]
        self.beginning, self.rest = split((case / "cmd").read_text(), case.parent.name, [*commands, "python3"])
        write_wrappers(binaries, self.scratch / "wrappers")
        self.begun = (0, "", "")
        if self.beginning:
            self.begun = self.bash(PRELUDE + self.beginning + SAVE, self.scratch / "wrappers")
            copy(self.folder, self.scratch / "start")

    def bash(self, lines, path):
        """Exit code, output and errors of lines; `path` has the commands, before those in BIN."""
        python = os.path.dirname(sys.executable)
        environment = dict(self.variables, PATH=f"{path}:{self.binaries}:{python}:{os.environ['PATH']}")
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", lines], cwd=self.folder, env=environment,
                              capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL)
        return done.returncode if done.returncode >= 0 else 128 - done.returncode, done.stdout, done.stderr

    def with_commands(self, path):
        """What is wrong with the case, its output and errors."""
        code, out, err = self.begun
        if code == 0:
            shutil.rmtree(self.folder)
            if self.beginning:
                copy(self.scratch / "start", self.folder)
            else:
                self.folder.mkdir()
            start = 'source "$VARIABLES"\n' if self.beginning else ""
            code, more_out, more_err = self.bash(start + PRELUDE + self.rest, path)
            out, err = out + more_out, err + more_err
        return check(self.case, code, out, err), out, err


def run_and_report(case, binaries, config, kept=None):
    with tempfile.TemporaryDirectory() as scratch:
        if kept:
            shutil.rmtree(kept, ignore_errors=True)
        run = Run(case, binaries, config, scratch, kept)
        wrong, out, err = run.with_commands(run.scratch / "wrappers")
        (run.kept / STDERR).write_text(err)
        if wrong:
            print(f"{case.parent.name}/{case.name}:", "\n".join(wrong), f"\n--- stdout\n{out[:4000]}\n--- stderr\n{err[:4000]}")
            return False
        passed = stubs_that_pass(run)
        for stub in passed:
            print(f"{case.parent.name}/{case.name} cannot fail: with a stub that gives {stub} in the place of "
                  f"{case.parent.name} it passes")
        return not passed


def tools(*names):
    return {name: shutil.which(name) for name in names}  # a case may change PATH


def write_wrappers(binaries, folder):
    folder.mkdir()
    called = tools("bash", "stat", "cp", "tail", "tee")
    for real in sorted(pathlib.Path(binaries).iterdir()):
        if os.access(real, os.X_OK) and real.is_file():
            (folder / real.name).write_text(WRAPPER.format(real=real, command=real.name, most=MOST_BYTES, **called))
            (folder / real.name).chmod(0o755)


def stubs_that_pass(run):
    """Names of stubs with which a case passes that passes with its command."""
    passed, called = [], tools("sh", "cat", "head")
    for stub, action in STUBS.items():
        path = run.scratch / stub / run.case.parent.name
        path.parent.mkdir()
        path.write_text((STUB_START + action + "\n").format(**called))
        path.chmod(0o755)
        if not run.with_commands(path.parent)[0]:
            passed.append(stub)
    return passed


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
    self_test_of_split()
    self_test_of_stubs()


def self_test_of_shell():
    """A failure inside the shell lines must end the case, unless `fails` expects it."""
    with tempfile.TemporaryDirectory() as folder:
        case = pathlib.Path(folder)

        def passes(cmd):
            (case / "cmd").write_text(cmd)
            with tempfile.TemporaryDirectory() as scratch:
                return not Run(case, case, folder, scratch).with_commands(folder)[0]

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
    """A case that cannot fail is named."""
    with tempfile.TemporaryDirectory() as folder:
        binaries = pathlib.Path(folder, "bin")
        binaries.mkdir()
        for name, word in (("say", "yes"), ("other", "no")):
            (binaries / name).write_text(f"#!/bin/sh\necho {word} | tee -a {folder}/runs.{name}\n")
            (binaries / name).chmod(0o755)
        blind = ["random bytes", "the same line", "silence"]
        for name, cmd, passing in (("sees", "test $(say) = yes", []), ("blind", "say > a || true", blind),
                                   ("half-blind", "say > a", blind),
                                   ("begins", "word=$(other)\nit() { echo it; }\ntest $(say) = yes\ntest $word$(it) = noit", []),
                                   ("goes-on-blind", "word=$(other)\nsay > a; test $word = no", blind)):
            case = pathlib.Path(folder, "say", name)
            case.mkdir(parents=True)
            (case / "cmd").write_text(cmd)
            with tempfile.TemporaryDirectory() as scratch:
                run = Run(case, binaries, folder, scratch)
                wrong, _, _ = run.with_commands(run.scratch / "wrappers")
                assert not wrong, (name, wrong)
                assert stubs_that_pass(run) == passing, name
            assert run_and_report(case, binaries, folder, pathlib.Path(folder, "kept")) == (not passing), name
            kept = [path.read_text() for path in pathlib.Path(folder, "kept").glob("say.*")]
            assert kept == ([] if "$(say)" in cmd else ["yes\n"]), (name, kept)
        # Twice for each of two cases, not once more for each stub.
        assert pathlib.Path(folder, "runs.other").read_text() == 4 * "no\n"


def self_test_of_split():
    """A beginning holds whole commands only, and one of those that take time."""
    def beginning(cmd):
        return split(cmd, "say", ["other"])[0]

    assert beginning("other\nsay\n") == "other\n"
    assert beginning("# say\nother\nx=1\nsay\nother\n") == "# say\nother\nx=1\n"
    assert beginning("# set\nother\nsay\n") == "# set\nother\n"
    assert beginning("x=1\nsay\n") == ""
    assert beginning("for i in 1 2; do\n  other\n  say\ndone\n") == ""
    assert beginning("other\nfor i in 1 2; do\n  say\ndone\n") == "other\n"
    assert beginning("other\ncat > x <<E\nsay\nE\n") == "other\n"
    assert beginning("other\nother | \\\n  say\n") == "other\n"
    assert beginning("other\nother |\n  say\n") == "other\n"
    assert beginning("cd x\nother\nsay\n") == beginning("other &\nsay\n") == ""
    assert beginning("other\nessay-say\nsay") == "other\nessay-say\n"


if __name__ == "__main__":
    if sys.argv[1] == "--self-test":
        self_test()
    else:
        *cases, binaries, config, kept = (pathlib.Path(name).absolute() for name in sys.argv[1:])
        failed = [case for case in cases
                  if not run_and_report(case, binaries, config, kept / case.parent.name / case.name)]
        sys.exit(1 if failed else 0)
