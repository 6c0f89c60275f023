"""Nodal loads, moments, follower and user forces."""
