import threading
import warnings

import pytest

from agents.mapf.time_limit import NO_THREADS, Watcher


def test_where_no_thread_can_be_started_there_is_no_limit_and_a_warning_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(self: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    watcher, done = Watcher(), 0
    with pytest.warns(RuntimeWarning, match=NO_THREADS), watcher.time_limit(1e-9):
        done += 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with watcher.time_limit(1e-9):
            done += 1
    assert done == 2
