"""A page that plays tracks in a browser."""

from warehouse_core.viz.player.page import player_page

__all__ = ["player_page"]
