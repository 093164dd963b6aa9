"""Builds the wheel of armtrue (PEP 517): the module, the manual pages, and the commands with every library that they
load, the C library and its loader included, as the tarball of apps/package has them. So one wheel runs on any Linux of
this kind of processor. The commands are taken from build/ where apps/set-up has built them, which takes seconds, and are
compiled elsewhere, which takes minutes. CMake, Ninja and the packages of apps/set-up must be there; nothing is downloaded."""

import base64
import hashlib
import os
import pathlib
import platform
import re
import subprocess
import tempfile
import zipfile

SOURCES = pathlib.Path(__file__).resolve().parents[2]


def version():
    project = (SOURCES / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"^project\(armtrue VERSION ([0-9.]+)", project, re.M).group(1)


def commands():
    return sorted(page.name.removesuffix(".1.md") for page in (SOURCES / "apps").glob("*.1.md"))


def entry_points():
    return "[console_scripts]\n" + "".join(f"{name} = armtrue.__main__:main\n" for name in commands())


def metadata():
    return (f"Metadata-Version: 2.1\nName: armtrue\nVersion: {version()}\n"
            "Summary: Calibrate machining robots and trace what their model lacks\n"
            "Requires-Python: >=3.9\nProvides-Extra: frames\nRequires-Dist: pandas; extra == 'frames'\n")


def build_of(sources):
    """The folder of apps/set-up, if it has an optimised build of these sources: nothing is compiled twice. Else None."""
    build = pathlib.Path(sources) / "build"
    try:
        cache = (build / "CMakeCache.txt").read_text(encoding="utf-8")
    except OSError:
        return None
    wanted = (f"CMAKE_HOME_DIRECTORY:INTERNAL={sources}", "CMAKE_BUILD_TYPE:STRING=Release", "ARMTRUE_DISPATCH:BOOL=OFF")
    return build if set(wanted) <= set(cache.splitlines()) else None


def build_commands(stage):
    """Builds the commands, and installs them below `stage` with their libraries."""
    build = build_of(SOURCES)
    if build is None:
        build = pathlib.Path(stage).parent / "build"
        subprocess.run(["cmake", "-S", str(SOURCES), "-B", str(build), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        "-DARMTRUE_BUILD_TESTS=OFF"], check=True)
    subprocess.run(["cmake", "--build", str(build), "--target", "commands", "launcher"], check=True)
    for component in ("commands", "wheel"):
        subprocess.run(["cmake", "--install", str(build), "--component", component, "--strip", "--prefix", str(stage)], check=True)
    subprocess.run([str(SOURCES / "apps" / "bring-libraries"), str(stage)], check=True)


def files_of(stage):
    """What the wheel holds: name in the wheel -> file. Of the installed tree the commands, with the launcher that runs
    them, and the shipped files; its other folders are links or of no use here."""
    module = SOURCES / "apps" / "python" / "armtrue"
    files = {f"armtrue/{name}": module / name for name in ("__init__.py", "__main__.py", "py.typed")}
    for page in sorted((SOURCES / "apps").glob("*.1.md")):
        files[f"armtrue/pages/{page.name}"] = page
    stage = pathlib.Path(stage)
    for path in sorted([*(stage / "lib" / "armtrue").rglob("*"), *(stage / "share" / "armtrue").rglob("*")]):
        # The module, and the file behind the link that is loaded.
        is_twice = stage / "share/armtrue/python" in path.parents or re.fullmatch(r"libarmtrue(_base)?\.so(\.\d+){3}", path.name)
        if path.is_file() and not is_twice:
            files[f"armtrue/commands/{path.relative_to(stage).as_posix()}"] = path
    return files


def write_wheel(stage, folder):
    """Returns the name of the wheel that it writes into `folder`. The same files give the same bytes."""
    tag = f"py3-none-linux_{platform.machine()}"
    name, info = f"armtrue-{version()}-{tag}.whl", f"armtrue-{version()}.dist-info"
    record = []
    with zipfile.ZipFile(pathlib.Path(folder) / name, "w", zipfile.ZIP_DEFLATED) as wheel:

        def add(where, content, mode=0o644):
            entry = zipfile.ZipInfo(where, (1980, 1, 1, 0, 0, 0))
            entry.external_attr, entry.compress_type = (0o100000 | mode) << 16, zipfile.ZIP_DEFLATED
            wheel.writestr(entry, content)
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
            record.append(f"{where},sha256={digest},{len(content)}")

        for where, path in files_of(stage).items():
            add(where, path.read_bytes(), 0o755 if os.access(path, os.X_OK) else 0o644)
        add(f"{info}/METADATA", metadata().encode())
        add(f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: armtrue\nRoot-Is-Purelib: false\nTag: {tag}\n".encode())
        add(f"{info}/entry_points.txt", entry_points().encode())
        record.append(f"{info}/RECORD,,")
        wheel.writestr(zipfile.ZipInfo(f"{info}/RECORD", (1980, 1, 1, 0, 0, 0)), "\n".join(record) + "\n")
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with tempfile.TemporaryDirectory() as folder:
        stage = pathlib.Path(folder) / "stage"
        build_commands(stage)
        return write_wheel(stage, wheel_directory)


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    info = pathlib.Path(metadata_directory) / f"armtrue-{version()}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(metadata(), encoding="utf-8")
    (info / "WHEEL").write_text("Wheel-Version: 1.0\n", encoding="utf-8")
    return info.name


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError("armtrue is built from its repository; there is no source distribution")
