"""Seconds against the error of the steps, beside peers."""
