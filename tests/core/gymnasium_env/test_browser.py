import importlib
import sys

import pytest

import warehouse_core.gymnasium_env.browser as browser


@pytest.mark.parametrize(("platform", "stands_in"), [("emscripten", True), ("linux", False)])
def test_what_pyodide_leaves_out_is_replaced_there_alone(
    platform: str, stands_in: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setitem(sys.modules, browser.NAME, None)
    monkeypatch.delitem(sys.modules, browser.NAME)
    importlib.reload(browser)
    assert (browser.NAME in sys.modules) is stands_in
    if stands_in:  # what multiprocessing.synchronize reads
        assert sys.modules[browser.NAME].SemLock.SEM_VALUE_MAX == 1
