"""Measured runs from measurement.toml and data files of many formats."""
