"""Runs a command: `python -m armtrue close-loop ...`, or by the name under which a script was installed."""

import os
import pathlib
import sys

from armtrue import program


def main() -> None:
    words = [pathlib.Path(sys.argv[0]).name, *sys.argv[1:]]
    if words[0] == "__main__.py":
        words = words[1:]
    if not words:
        sys.exit("python -m armtrue COMMAND ..., such as close-loop")
    os.execv(program(words[0]), words)


if __name__ == "__main__":
    main()
