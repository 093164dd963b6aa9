"""Archives that no backup of a controller is."""

import io
import struct
import tarfile
import zipfile

SRC = b"DEF one( )\nEND\n"


def tar(name, *members, mode="w"):
    with tarfile.open(name, mode) as archive:
        for path, kind, content in members:
            info = tarfile.TarInfo(path)
            info.type, info.size = kind, len(content) if kind == tarfile.REGTYPE else 0
            info.linkname = "/etc/passwd" if kind != tarfile.REGTYPE else ""
            archive.addfile(info, io.BytesIO(content))


def zipped(name, *members):
    with zipfile.ZipFile(name, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in members:
            archive.writestr(path, content)


zipped("climbs.zip", ("a/../../out.src", SRC))
zipped("absolute.zip", ("/tmp/out.src", SRC))
zipped("windows.zip", ("C:\\KRC\\out.src", SRC))
zipped("backslash.zip", ("a\\..\\..\\out.src", SRC))
tar("link.tar", ("one.src", tarfile.SYMTYPE, b""))
tar("hard.tar", ("one.src", tarfile.REGTYPE, SRC), ("two.src", tarfile.LNKTYPE, b""))
tar("device.tgz", ("one.src", tarfile.FIFOTYPE, b""), mode="w:gz")
tar("twice.tar", ("one.src", tarfile.REGTYPE, SRC), ("./one.src", tarfile.REGTYPE, SRC))
zipped("nothing.zip")
zipped("no-program.zip", ("readme.txt", b"x"))
open("empty.zip", "wb").close()
open("text.zip", "w").write("no archive\n")
zipped("whole.zip", ("one.src", SRC * 500))
open("cut.zip", "wb").write(open("whole.zip", "rb").read()[:60])
damaged = bytearray(open("whole.zip", "rb").read())
damaged[60] ^= 0xFF
open("damaged.zip", "wb").write(damaged)
locked = bytearray(open("whole.zip", "rb").read())
locked[6] |= 1  # encrypted, in the header of the member and in the directory
locked[locked.index(b"PK\x01\x02") + 8] |= 1
open("locked.zip", "wb").write(locked)
# 270 MB of zeros in less than one.
with zipfile.ZipFile("bomb.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive, archive.open("one.src", "w") as member:
    for _ in range(260):
        member.write(bytes(1 << 20))
