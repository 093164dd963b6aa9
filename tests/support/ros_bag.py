"""Writes recordings as ROS 2 does, without ROS and without code of armtrue: messages as CDR (DDSI-RTPS 2.3, 10.2), in an
SQLite database (rosbag2_storage_sqlite3) or in MCAP (mcap.dev/spec). For tests."""

import sqlite3
import struct

SECOND = 10**9


class Cdr:
    """A message, little-endian unless `big`."""

    def __init__(self, big=False):
        self.order = ">" if big else "<"
        self.bytes = b""
        self.head = b"\x00\x00\x00\x00" if big else b"\x00\x01\x00\x00"

    def put(self, code, *values):
        size = struct.calcsize("=" + code)
        for value in values:
            self.bytes += b"\0" * (-len(self.bytes) % size) + struct.pack(self.order + code, value)
        return self

    def text(self, text):
        data = text.encode() + b"\0"
        self.put("I", len(data))
        self.bytes += data
        return self

    def header(self, ns, frame):
        return self.put("i", ns // SECOND).put("I", ns % SECOND).text(frame)

    def message(self):
        return self.head + self.bytes


def joint_state(ns, names, positions, big=False):
    cdr = Cdr(big).header(ns, "")
    cdr.put("I", len(names))
    for name in names:
        cdr.text(name)
    cdr.put("I", len(positions)).put("d", *positions)
    return cdr.put("I", 0).put("I", 0).message()  # no velocities, no efforts


def pose(ns, numbers, frame="world", covariance=None, big=False):
    """Position and, with seven numbers, quaternion x y z w; with three a point."""
    cdr = Cdr(big).header(ns, frame).put("d", *numbers)
    return (cdr.put("d", *covariance) if covariance else cdr).message()


def transforms(ns, numbers_of_child, frame="world", big=False):
    cdr = Cdr(big).put("I", len(numbers_of_child))
    for child, numbers in numbers_of_child.items():
        cdr.header(ns, frame).text(child).put("d", *numbers)
    return cdr.message()


def write_db3(path, messages):
    """`messages`: (topic, type, ns, bytes)."""
    base = sqlite3.connect(path)
    base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
                 "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)")
    base.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
                 "data BLOB NOT NULL)")
    known = {}
    for topic, kind, ns, data in messages:
        if topic not in known:
            known[topic] = len(known) + 1
            base.execute("INSERT INTO topics VALUES(?,?,?,'cdr','')", (known[topic], topic, kind))
        base.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", (known[topic], ns, data))
    base.commit()
    base.close()


def record(op, content):
    return struct.pack("<BQ", op, len(content)) + content


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def write_mcap(path, messages, pack=None, chunks=3, encoding="cdr"):
    """`pack`: None, or ("zstd" or "lz4", function of bytes). Without chunks the records stand alone."""
    known, records = {}, []
    for topic, kind, ns, data in messages:
        content = b""
        if topic not in known:
            known[topic] = len(known) + 1
            content += record(3, struct.pack("<H", known[topic]) + text(kind) + text("ros2msg") + struct.pack("<I", 0))
            content += record(4, struct.pack("<HH", known[topic], known[topic]) + text(topic) + text(encoding) +
                              struct.pack("<I", 0))
        content += record(5, struct.pack("<HIQQ", known[topic], 0, ns, ns) + data)
        records.append(content)
    out = b"\x89MCAP0\r\n" + record(1, text("ros2") + text("test"))
    if not chunks:
        out += b"".join(records)
    else:
        name, function = pack or ("", bytes)
        size = -(-len(records) // chunks)
        for k in range(0, len(records), size):
            plain = b"".join(records[k:k + size])
            packed = function(plain)
            out += record(6, struct.pack("<QQQI", 0, 0, len(plain), 0) + text(name) + struct.pack("<Q", len(packed)) +
                          packed)
    out += record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0)) + b"\x89MCAP0\r\n"
    with open(path, "wb") as file:
        file.write(out)


def zstd(data):
    """A frame of Zstandard (RFC 8878) whose blocks are stored as they are."""
    out = b"\x28\xb5\x2f\xfd\xa0" + struct.pack("<I", len(data))
    blocks = [data[k:k + 0x10000] for k in range(0, len(data), 0x10000)] or [b""]
    for k, block in enumerate(blocks):
        out += struct.pack("<I", len(block) << 3 | (k + 1 == len(blocks)))[:3] + block
    return out


def lz4(data):
    """A frame of LZ4 (lz4_Frame_format.md 1.6) whose blocks are stored as they are."""
    out = b"\x04\x22\x4d\x18\x60\x40\x82"  # blocks of 64 kB by themselves, and the check of these two bytes
    for k in range(0, len(data), 0x10000):
        block = data[k:k + 0x10000]
        out += struct.pack("<I", len(block) | 1 << 31) + block
    return out + struct.pack("<I", 0)
