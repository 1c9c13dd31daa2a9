"""Reports of agents that take long."""

import time
from typing import Any

from agents.lab.console import watch
from agents.lab.trials.task import Task


def test_each_step_that_takes_long_is_reported_once_with_its_line(capsys, monkeypatch) -> None:
    monkeypatch.setattr(watch, "SLOW_SECONDS", 0.05)
    monkeypatch.setattr(watch, "LOOK_SECONDS", 0.01)

    class Slow:
        def reset(self) -> None:
            self.count = 0

        def act(self, observation: Any) -> str:
            self.count += 1
            if self.count in (2, 4):
                time.sleep(0.4)
            return "N"

    line = Slow.act.__code__.co_firstlineno + 3
    assert Task(max_steps=5).run("slow", 1, lambda *_: Slow()).steps == 5
    assert capsys.readouterr().err.splitlines() == [
        f"warehouse: step {step}, agent slow takes more than 0.05 s (test_watch.py, line {line}); "
        "Ctrl-C stops it"
        for step in (2, 4)
    ]
