"""Figures of results: charts of measures and failure modes, and heat maps."""
