"""The reason of an agent's failure, with the place in its file."""

import json
from pathlib import Path

import pytest

from agents.errors import reason_of

FILE = Path(__file__)


class BrokenError(Exception):
    def __str__(self) -> str:
        raise RuntimeError


def caught(error: BaseException) -> BaseException:
    with pytest.raises(type(error)) as found:
        raise error
    return found.value


def test_a_reason_has_the_error_and_the_place() -> None:
    line = caught.__code__.co_firstlineno + 2
    reason = reason_of(caught(ValueError("too\nlate")))
    assert reason == f"ValueError: too\nlate (test_errors.py, line {line})"


def test_the_place_is_in_the_given_file() -> None:
    with pytest.raises(ValueError, match="Expecting value") as found:
        json.loads("?")
    assert "decoder.py" in reason_of(found.value)
    for file in (FILE, Path("nowhere/../") / FILE):
        assert "(test_errors.py, line " in reason_of(found.value, file)
    assert reason_of(found.value, Path("other.py")).endswith("(char 0)")


def test_an_exception_without_a_message_and_a_place_is_its_name() -> None:
    assert reason_of(KeyboardInterrupt()) == "KeyboardInterrupt"
    assert reason_of(BrokenError()) == "BrokenError"
