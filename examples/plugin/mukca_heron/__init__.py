"""Reads the Heron, an arm that does not exist, for mukca."""
