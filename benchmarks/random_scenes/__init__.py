"""Runs to an accuracy on scenes drawn at random, compared with fixed steps."""
