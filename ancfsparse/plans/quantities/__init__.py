"""Quantities of interest and their tolerances."""
