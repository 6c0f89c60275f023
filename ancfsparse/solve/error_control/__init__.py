"""Runs to an accuracy: candidates, Richardson extrapolation, step-size control."""
