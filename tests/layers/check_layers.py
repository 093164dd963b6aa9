"""Checks the layer rules from the include lines: which layer may see which, and which third party."""

import pathlib
import re
import sys

BELOW = {
    "statistics": set(),
    "kinematics": set(),
    "effects": {"kinematics"},
    "identification": {"statistics", "kinematics", "effects"},
    "path": {"statistics", "kinematics", "effects"},
    "io": {"statistics", "kinematics", "effects", "identification", "path"},
    "report": {"statistics", "kinematics", "effects", "identification", "path"},
}
# Third-party headers, by how their names begin, and the folders that may include them.
THIRD_PARTY = {
    "ceres/": ["src/identification/", "tests/"],
    "Suite": ["src/identification/"],
    "yaml-cpp/": ["src/io/", "tests/"],
    "urdf": ["src/io/"],
    "tinyxml": ["src/io/"],
    "console_bridge/": ["src/io/"],
    "openssl/": ["src/io/"],
    "CLI/": ["apps/", "tests/bench/"],
    "kdl/": ["tests/"],
    "boost/": ["src/statistics/", "src/identification/", "tests/bench/"],
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def broken_rule(path, header):
    """The rule that `header` breaks in the file `path`, or None."""
    for begin, allowed in THIRD_PARTY.items():
        if header.startswith(begin) and not any(path.startswith(folder) for folder in allowed):
            return f"{begin}* belongs to {', '.join(allowed)} only"
    parts = pathlib.PurePosixPath(path).parts
    if path.startswith("tests/support/") and header.startswith("armtrue/"):
        return "the oracle shares no code with the product"
    if path.startswith("include/armtrue/"):
        third_party = "/" in header and not header.startswith(("armtrue/", "Eigen/"))
        if third_party:
            return "no third party but Eigen in a public header"
    layer = parts[2] if parts[0] == "include" else parts[1] if parts[0] == "src" else None
    if layer in BELOW and header.startswith("armtrue/"):
        other = header.split("/")[1]
        if other != layer and other not in BELOW[layer]:
            return f"the layer {layer} may not see {other}"
    return None


def violations(root):
    for folder in ("include", "src", "apps", "tests"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cc"):
                continue
            name = path.relative_to(root).as_posix()
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = INCLUDE.match(line)
                rule = match and broken_rule(name, match.group(1))
                if rule:
                    yield f"{name}:{number}: {match.group(1)}: {rule}"


def self_test():
    assert broken_rule("src/kinematics/pose.cc", "armtrue/io/output.h")
    assert broken_rule("src/effects/shape.cc", "ceres/ceres.h")
    assert broken_rule("include/armtrue/io/robot_io.h", "yaml-cpp/yaml.h")
    assert broken_rule("src/identification/loop.cc", "armtrue/io/output.h")
    assert broken_rule("tests/support/oracle.cc", "armtrue/kinematics/chain.h")
    assert not broken_rule("src/io/robot_io.cc", "yaml-cpp/yaml.h")
    assert not broken_rule("include/armtrue/effects/robot.h", "Eigen/Core")


if __name__ == "__main__":
    if "--self-test" in sys.argv:
        self_test()
        sys.exit(0)
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    sys.exit(1 if found else 0)
