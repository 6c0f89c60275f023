"""Rigid parts and corotated frames."""
