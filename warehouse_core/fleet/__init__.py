"""Several robots in one warehouse, with orders, chargers and people."""

from warehouse_core.fleet.batch import FleetBatch
from warehouse_core.fleet.battery import Battery
from warehouse_core.fleet.env import FleetEnv
from warehouse_core.fleet.observation import FleetObservation
from warehouse_core.fleet.people import People
from warehouse_core.fleet.tally import FleetMeasures

__all__ = [
    "Battery",
    "FleetBatch",
    "FleetEnv",
    "FleetMeasures",
    "FleetObservation",
    "People",
]
