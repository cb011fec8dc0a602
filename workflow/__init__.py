"""Runs: stages with keys, stored products, processes, progress; files compared and diagnosed; changed rig files."""
