"""Trainings with short exams, here and in a process of its own."""

import pytest

from agents.lab.commands import train
from agents.lab.training import exams

PROGRAM = """
from agents.__main__ import main
from agents.lab.commands import train
from agents.lab.training import exams
exams.EXAM_SEEDS, train.FINAL_SEEDS = exams.EXAM_SEEDS[:3], train.FINAL_SEEDS[:4]
main()
"""
"""The command line with short exams."""


def shorten_exams(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make exams as short as those of ``PROGRAM``."""
    monkeypatch.setattr(exams, "EXAM_SEEDS", exams.EXAM_SEEDS[:3])
    monkeypatch.setattr(train, "FINAL_SEEDS", train.FINAL_SEEDS[:4])
