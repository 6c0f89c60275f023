"""Handles with coordinates: beams, meshes, rigid bodies, points."""
