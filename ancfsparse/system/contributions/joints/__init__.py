"""Constraint equations, joint coordinates, sliding joints."""
