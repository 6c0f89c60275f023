"""Supports and joints of points: each lowers itself to coordinates and equations."""
