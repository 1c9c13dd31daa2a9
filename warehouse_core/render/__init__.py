"""Pictures as arrays of pixels, by NumPy alone."""
