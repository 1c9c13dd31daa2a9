"""HTML pages that play tracks in a browser."""

from warehouse_core.viz.player.page import player_frame, player_page, save_page

__all__ = ["player_frame", "player_page", "save_page"]
