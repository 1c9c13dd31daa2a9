"""Hostile JSON is refused before it takes time or memory."""

import json

import pytest

from warehouse_core.files.json_text import MAX_BYTES, MAX_ITEMS, parse_object


def nested(depth: int) -> bytes:
    return b'{"x":' + b"[" * (depth - 1) + b"]" * (depth - 1) + b"}"


def test_an_object_is_read_with_brackets_in_its_texts() -> None:
    value = {"a": ["[" * 50, '"[\\"{', "]"], 'b"{': {"c": [1, 2.5, None]}}
    assert parse_object(b"\xef\xbb\xbf" + json.dumps(value).encode()) == value
    assert parse_object(nested(20)) != {}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b" " * (MAX_BYTES + 1), "8,388,609 bytes of JSON are more than MAX_BYTES = 8388608"),
        (b'{"x":[' + b"[]," * (MAX_ITEMS // 2), "1,000,002 values are more than MAX_ITEMS"),
        (b'{"x":"' + b"," * MAX_ITEMS + b'"}', "1,000,001 values are more than MAX_ITEMS"),
        (nested(21), "21 open brackets are more than MAX_DEPTH = 20"),
        (b'{"a":"]]]","b":' + b"[" * 20, "21 open brackets are more than MAX_DEPTH = 20"),
        (b"[" * 90_000, "90,000 open brackets"),
        (b'{"a":' + b"9" * 5000 + b"}", "not JSON: Exceeds the limit"),
        (b'{"a', "not JSON: Unterminated string"),
        (b"\xff", "can't decode byte 0xff"),
        (b"[]", "a JSON list where there must be an object"),
    ],
)
def test_what_is_beyond_a_limit_or_no_object_is_refused(data, message, little_memory) -> None:
    with little_memory(), pytest.raises(ValueError, match=message):
        parse_object(data)
