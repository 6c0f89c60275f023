"""Loads, and the base of force elements attached to points."""
