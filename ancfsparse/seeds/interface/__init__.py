"""Protocols of the compiled seeds."""
