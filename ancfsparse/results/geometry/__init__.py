"""Drawable geometry of a scene."""
