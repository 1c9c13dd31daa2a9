"""Orders: what they are, where they come from, files of them, and what becomes of them."""

from warehouse_core.orders.files import load_orders, save_orders
from warehouse_core.orders.order import Order, OrderQueue, OrderStream

__all__ = ["Order", "OrderQueue", "OrderStream", "load_orders", "save_orders"]
