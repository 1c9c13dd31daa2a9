"""Several robots in one warehouse, with orders, chargers and people."""

from warehouse_core.batch.fleet.battery import Battery
from warehouse_core.batch.fleet.env import FleetBatch
from warehouse_core.batch.fleet.people import People
from warehouse_core.batch.fleet.tally import FleetMeasures
from warehouse_core.fleet.env import FleetEnv
from warehouse_core.fleet.observation import FleetObservation

__all__ = [
    "Battery",
    "FleetBatch",
    "FleetEnv",
    "FleetMeasures",
    "FleetObservation",
    "People",
]
