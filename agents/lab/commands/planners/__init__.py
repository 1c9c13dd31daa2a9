"""Commands that run planners for several robots and measure them."""
