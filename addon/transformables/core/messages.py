# SPDX-License-Identifier: GPL-3.0-or-later
"""Framed messages between Blender and its worker process: a JSON header and raw arrays, no pickle.

A frame: 4 bytes of magic, the header's length (uint32, little-endian), the header (JSON in UTF-8), then the arrays'
bytes one after the other. The header is {"message": ..., "arrays": [[name, typecode, count], ...]}; typecodes are
those of Python's `array`. Arrays are (typecode, bytes-like) pairs.
"""
import json
import struct

MAGIC = b"TFM1"
PREFIX = struct.Struct("<4sI")
LARGEST_HEADER = 16 * 1024 * 1024
LARGEST_BODY = 8 * 1024 ** 3
ITEM_SIZE = {"B": 1, "i": 4, "f": 4, "q": 8, "d": 8}


class BadFrame(Exception):
    """The bytes are not a frame; the other side is not ours, or its stream is broken."""


def encode(message, arrays=None):
    """The frame as a list of bytes-like pieces; arrays are not copied."""
    table, bodies = [], []
    for name, (typecode, data) in (arrays or {}).items():
        view = memoryview(data).cast("B")
        if typecode not in ITEM_SIZE:
            raise BadFrame(f"array {name!r} has unknown typecode {typecode!r}")
        count, rest = divmod(view.nbytes, ITEM_SIZE[typecode])
        if rest:
            raise BadFrame(f"array {name!r} is not a whole number of {typecode!r} items")
        table.append([name, typecode, count])
        bodies.append(view)
    header = json.dumps({"message": message, "arrays": table}, separators=(",", ":")).encode()
    if len(header) > LARGEST_HEADER:
        raise BadFrame(f"header of {len(header)} bytes is over the limit of {LARGEST_HEADER}")
    return [PREFIX.pack(MAGIC, len(header)) + header, *bodies]


class FrameReader:
    """Puts frames together from bytes as they arrive.

    Until the first frame, bytes that are not ours are skipped: a worker may be Blender itself, which greets on its
    standard output before our code runs. `skip_noise=False` forbids that.
    """

    def __init__(self, skip_noise=False):
        self._buffer = bytearray()
        self._skip_noise = skip_noise
        self._header = None
        self._body_bytes = 0

    def feed(self, data):
        """Takes bytes; gives the frames that are now whole, as (message, arrays). @raises BadFrame"""
        self._buffer += data
        frames = []
        while True:
            if self._header is None and not self._read_header():
                return frames
            if len(self._buffer) < self._body_bytes:
                return frames
            frames.append(self._take_frame())

    @property
    def empty(self):
        return self._header is None and not self._buffer

    def _read_header(self):
        if self._skip_noise:
            self._drop_noise()
        if len(self._buffer) < PREFIX.size:
            if not MAGIC.startswith(bytes(self._buffer[:len(MAGIC)])):
                raise BadFrame("the stream does not start with a frame")
            return False
        magic, length = PREFIX.unpack_from(self._buffer)
        if magic != MAGIC:
            raise BadFrame("the stream does not start with a frame")
        if length > LARGEST_HEADER:
            raise BadFrame(f"header of {length} bytes is over the limit of {LARGEST_HEADER}")
        end = PREFIX.size + length
        if len(self._buffer) < end:
            return False
        self._header = _parsed_header(bytes(self._buffer[PREFIX.size:end]))
        self._body_bytes = sum(ITEM_SIZE[typecode] * count for _, typecode, count in self._header["arrays"])
        del self._buffer[:end]
        self._skip_noise = False
        return True

    def _drop_noise(self):
        at = self._buffer.find(MAGIC)
        # The magic's first bytes may be the last ones here: keep as many as could be its beginning.
        del self._buffer[:at if at >= 0 else max(0, len(self._buffer) - len(MAGIC) + 1)]
        if at < 0:
            while self._buffer and not MAGIC.startswith(bytes(self._buffer)):
                del self._buffer[:1]

    def _take_frame(self):
        arrays, at = {}, 0
        with memoryview(self._buffer) as view:
            for name, typecode, count in self._header["arrays"]:
                end = at + ITEM_SIZE[typecode] * count
                arrays[name] = (typecode, bytes(view[at:end]))
                at = end
        del self._buffer[:at]
        message = self._header["message"]
        self._header = None
        return message, arrays


def _parsed_header(data):
    try:
        header = json.loads(data)
    except ValueError as error:
        raise BadFrame(f"the header is not JSON: {error}") from None
    if not isinstance(header, dict) or not isinstance(header.get("message"), dict):
        raise BadFrame("the header has no message")
    table = header.get("arrays")
    if not isinstance(table, list):
        raise BadFrame("the header has no table of arrays")
    total = 0
    for row in table:
        if not (isinstance(row, list) and len(row) == 3 and isinstance(row[0], str) and row[1] in ITEM_SIZE
                and isinstance(row[2], int) and not isinstance(row[2], bool) and row[2] >= 0):
            raise BadFrame(f"bad row in the table of arrays: {row!r}")
        total += ITEM_SIZE[row[1]] * row[2]
    if total > LARGEST_BODY:
        raise BadFrame(f"arrays of {total} bytes are over the limit of {LARGEST_BODY}")
    if len({row[0] for row in table}) != len(table):
        raise BadFrame("two arrays have the same name")
    return header
