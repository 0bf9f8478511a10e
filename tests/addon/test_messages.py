# SPDX-License-Identifier: GPL-3.0-or-later
import json
import struct

import pytest
from transformables.core import messages
from transformables.core.messages import BadFrame, FrameReader


def framed(message, arrays=None):
    return b"".join(bytes(piece) for piece in messages.encode(message, arrays))


def raw(header, body=b""):
    data = header if isinstance(header, bytes) else json.dumps(header).encode()
    return struct.pack("<4sI", b"TFM1", len(data)) + data + body


def test_a_frame_comes_back_as_it_was_sent_whatever_the_pieces_it_arrives_in():
    message = {"kind": "x", "text": "Gelenk – ±90°", "numbers": [0.1, 1e-300, -3]}
    arrays = {"points": ("d", struct.pack("<4d", 0.1, float("nan"), float("inf"), -0.0)), "none": ("i", b""), "raw": ("B", b"\0TFM1\n")}
    data = framed(message, arrays) + framed({"kind": "y"})
    for size in (1, 3, 7, 64, len(data)):
        reader, frames = FrameReader(), []
        for at in range(0, len(data), size):
            frames += reader.feed(data[at:at + size])
        assert [m["kind"] for m, _ in frames] == ["x", "y"]
        assert frames[0] == (message, arrays)
        assert reader.empty


def test_arrays_of_any_buffer_are_sent_by_their_bytes():
    from array import array
    (_, arrays), = FrameReader().feed(framed({}, {"a": ("d", array("d", [1.5, 2.5]))}))
    assert arrays["a"] == ("d", struct.pack("<2d", 1.5, 2.5))


def test_noise_before_the_first_frame_is_skipped_only_where_it_is_allowed():
    noise = b"Blender 3.4.1\nTFM TF"
    with pytest.raises(BadFrame):
        FrameReader().feed(noise)
    for size in (1, 2, 5, 100):
        reader, frames, data = FrameReader(skip_noise=True), [], noise + framed({"kind": "hello"})
        for at in range(0, len(data), size):
            frames += reader.feed(data[at:at + size])
        assert [m["kind"] for m, _ in frames] == ["hello"]
    with pytest.raises(BadFrame):
        reader.feed(b"noise after it")


@pytest.mark.parametrize("data", [
    b"GARBAGE!", raw(b"{not json"), raw(b"[1]"), raw({"message": 3, "arrays": []}), raw({"message": {}}),
    raw({"message": {}, "arrays": [["a", "d", -1]]}), raw({"message": {}, "arrays": [["a", "x", 1]]}),
    raw({"message": {}, "arrays": [["a", "d", 1.5]]}), raw({"message": {}, "arrays": [["a", "d"]]}),
    raw({"message": {}, "arrays": [["a", "d", 1], ["a", "d", 1]]}), raw({"message": {}, "arrays": [["a", "d", 1 << 60]]}),
    struct.pack("<4sI", b"TFM1", messages.LARGEST_HEADER + 1)])
def test_bytes_that_are_no_frame_are_refused(data):
    with pytest.raises(BadFrame):
        FrameReader().feed(data)


def test_arrays_that_are_not_whole_items_or_of_unknown_type_are_refused_when_sent():
    with pytest.raises(BadFrame):
        messages.encode({}, {"a": ("d", b"1234567")})
    with pytest.raises(BadFrame):
        messages.encode({}, {"a": ("u", b"1234")})


def test_a_header_over_the_limit_is_refused_when_sent():
    with pytest.raises(BadFrame):
        messages.encode({"text": "x" * (messages.LARGEST_HEADER + 1)})
