"""Orders: their definition, sources, files, and progress during an episode."""

from warehouse_core.orders.files import load_orders, save_orders
from warehouse_core.orders.order import Order, OrderQueue, OrderStream

__all__ = ["Order", "OrderQueue", "OrderStream", "load_orders", "save_orders"]
