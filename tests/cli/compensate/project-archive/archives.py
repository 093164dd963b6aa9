"""archives.py make FOLDER NAME: an archive of a folder, by the ending of its name, with a member that is no text.
archives.py same OLD NEW CHANGED...: exit code 0 if two archives have the same members in the same order, each with the
same bytes but for those of CHANGED, which differ."""

import pathlib
import sys
import tarfile
import zipfile

BACKUP = bytes(range(256)) * 20


def contents(name):
    if name.endswith(".zip"):
        with zipfile.ZipFile(name) as archive:
            return [(i.filename.rstrip("/"), archive.read(i), i.date_time) for i in archive.infolist()]
    with tarfile.open(name) as archive:
        return [(m.name.removeprefix("./"), archive.extractfile(m).read() if m.isfile() else b"", (m.mtime, m.mode, m.uid))
                for m in archive.getmembers()]


if sys.argv[1] == "make":
    folder, name = pathlib.Path(sys.argv[2]), sys.argv[3]
    files = sorted(path for path in folder.rglob("*"))
    (folder / "am.bin").write_bytes(BACKUP)
    if name.endswith(".zip"):
        with zipfile.ZipFile(name, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in [*files, folder / "am.bin"]:
                archive.write(path, str(path.relative_to(folder)))
    else:
        kind = {".tar": "w", ".tgz": "w:gz", "r.gz": "w:gz", "r.xz": "w:xz"}[name[-4:]]
        with tarfile.open(name, kind) as archive:
            for path in [*files, folder / "am.bin"]:
                archive.add(path, "./" + str(path.relative_to(folder)), recursive=False)
    (folder / "am.bin").unlink()
else:
    old, new, changed = contents(sys.argv[2]), contents(sys.argv[3]), set(sys.argv[4:])
    assert [m[0] for m in old] == [m[0] for m in new], (old, new)
    for a, b in zip(old, new):
        assert a[2] == b[2] and (a[1] != b[1]) == (a[0] in changed), a[0]
    assert ("am.bin", BACKUP) in [m[:2] for m in new] and changed <= {m[0] for m in new}
