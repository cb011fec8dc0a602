"""Diagnosis from stated values, where no curve was measured."""
