"""The conformance suite for motion backends: ``run_conformance(MyMotion)``."""

from warehouse_core.conformance.suite import Report, run_conformance

__all__ = ["Report", "run_conformance"]
