"""Several robots in one warehouse, with orders, chargers and people."""

from warehouse_core.batch.fleet_settings import Battery, People
from warehouse_core.batch.fleets import FleetBatch
from warehouse_core.batch.tally import FleetMeasures
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
