"""Checks the rules between the rooms from the include lines: which room may see which, and which third party."""

import pathlib
import re
import sys

# Bottom to top. A room sees what it names here, and what those see.
USES = {
    "text": [],
    "linear_algebra": [],
    "statistics": ["linear_algebra"],
    "kinematics": [],
    "effects": ["kinematics"],
    "campaign": ["effects", "statistics", "text"],
    "observation": ["campaign"],
    "calibration": ["observation"],
    "compensation": ["calibration", "programs"],
    "certification": ["calibration", "path/registration"],
    "search": ["calibration"],
    "tracing": ["diagnosis", "search"],
    "diagnosis": ["calibration"],
    "planning": ["tracing"],
    "path": ["effects", "statistics"],
    "path/registration": ["path"],
    "path/samples": ["path"],
    "path/mirror": ["path/registration", "path/samples"],
    "programs": ["path", "text"],
    "io": ["campaign", "path", "programs"],
    "io/products": ["certification", "compensation", "diagnosis", "io", "tracing", "path/mirror"],
    "images": ["kinematics", "text"],
    "import": ["calibration", "images", "io", "path/registration"],
    "urdf": ["io"],
    "report": ["certification", "compensation", "io", "planning", "path/mirror"],
}
# Third-party headers, by how their names begin, and the folders that may include them.
THIRD_PARTY = {
    "ceres/": ["src/calibration/", "tests/"],
    "Suite": ["src/calibration/"],
    "yaml-cpp/": ["src/io/", "src/urdf/", "tests/"],
    "urdf_": ["src/urdf/", "tests/"],
    "tinyxml": ["src/urdf/", "tests/"],
    "console_bridge/": ["src/urdf/"],
    "openssl/": ["src/io/"],
    "archive": ["src/io/", "src/import/bag_mcap.cc"],
    "CLI/": ["apps/command_line.cc", "apps/options.cc", "tests/bench/"],  # some 10 s to compile
    "kdl/": ["src/urdf/", "tests/"],
    "opencv2/": ["src/images/"],
    "sqlite3": ["src/import/bag_db3.cc"],
    "boost/": ["src/statistics/", "tests/bench/"],
    # Decompositions are compiled once, in linear_algebra; small ones of fixed size may stand elsewhere.
    "Eigen/SVD": ["src/linear_algebra/", "src/observation/registration.cc", "tests/"],
}
# Rooms whose private headers others use: numbers without a word of the field.
OPEN = {"linear_algebra", "statistics"}
# Private headers that still cross a wall.
CROSSING = {
    "calibration/pose_influence.h", "search/candidates.h", "search/scan.h", "io/yaml/yaml_map.h",
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def seen_by(room):
    seen = {room}
    for other in USES[room]:
        seen |= seen_by(other)
    return seen


def room_of(parts):
    """The room of a file or header, from its folders: `path/mirror` before `path`."""
    return next(("/".join(parts[:n]) for n in (2, 1) if "/".join(parts[:n]) in USES), None)


def broken_rule(path, header):
    """The rule that `header` breaks in the file `path`, or None."""
    for begin, allowed in THIRD_PARTY.items():
        if header.startswith(begin) and not any(path.startswith(folder) for folder in allowed):
            return f"{begin}* belongs to {', '.join(allowed)} only"
    folders = pathlib.PurePosixPath(path).parts[:-1]
    if path.startswith("tests/support/") and header.startswith("armtrue/"):
        return "the oracle shares no code with the product"
    if path.startswith("include/armtrue/"):
        if "/" in header and not header.startswith(("armtrue/", "Eigen/")):
            return "no third party but Eigen, and no private header, in a public header"
    room = room_of(folders[2:]) if folders[0] == "include" else room_of(folders[1:]) if folders[0] == "src" else None
    other = room_of(pathlib.PurePosixPath(header.removeprefix("armtrue/")).parts[:-1])
    if room and other and other not in seen_by(room):
        return f"the room {room} may not see {other}"
    is_private = not header.startswith("armtrue/")
    if room and other and is_private and other.split("/")[0] != room.split("/")[0]:
        if other not in OPEN and header not in CROSSING:
            return f"{header} is private to {other}; a header that others use stands in include/armtrue"
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
    assert broken_rule("src/io/robot_io.cc", "armtrue/calibration/calibration.h")
    assert broken_rule("include/armtrue/tracing/loop.h", "search/scan.h")
    assert broken_rule("src/tracing/loop.cc", "armtrue/io/output.h")
    assert broken_rule("src/observation/fold.cc", "search/scan.h")
    assert broken_rule("src/compensation/compensation.cc", "armtrue/search/search.h")
    assert broken_rule("src/diagnosis/change.cc", "armtrue/planning/planning.h")
    assert broken_rule("src/path/samples/frozen_readings.cc", "path/mirror/trend.h")
    assert broken_rule("src/programs/krl.cc", "armtrue/io/source.h")
    assert broken_rule("tests/support/oracle.cc", "armtrue/kinematics/chain.h")
    assert not broken_rule("src/io/robot_io.cc", "yaml-cpp/yaml.h")
    assert not broken_rule("include/armtrue/effects/robot.h", "Eigen/Core")
    assert not broken_rule("src/path/mirror/mirror.cc", "armtrue/path/samples/bad_samples.h")
    assert not broken_rule("src/planning/separation.cc", "armtrue/observation/session_models.h")
    assert broken_rule("src/planning/separation.cc", "calibration/covariance.h")
    assert not broken_rule("src/calibration/covariance.cc", "calibration/covariance.h")
    assert not broken_rule("src/search/scan.cc", "statistics/rounding.h")


if __name__ == "__main__":
    if "--self-test" in sys.argv:
        self_test()
        sys.exit(0)
    found = list(violations(pathlib.Path(sys.argv[1])))
    print("\n".join(found))
    sys.exit(1 if found else 0)
