import ctypes
import runpy
import threading
import warnings

import pytest

from agents.mapf import time_limit


@pytest.fixture(params=["threads", "functions of C"])
def lacking(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Disable threads, as in a browser, or their interruption."""

    def refuse(self: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    if request.param == "threads":
        monkeypatch.setattr(threading.Thread, "start", refuse)
    else:
        monkeypatch.delattr(ctypes, "pythonapi")


@pytest.mark.usefixtures("lacking")
def test_where_no_thread_can_be_interrupted_there_is_no_limit_and_a_warning_once() -> None:
    watcher, done = runpy.run_path(time_limit.__file__)["Watcher"](), 0
    with pytest.warns(RuntimeWarning, match=time_limit.NO_THREADS), watcher.time_limit(1e-9):
        done += 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with watcher.time_limit(1e-9):
            done += 1
    assert done == 2
