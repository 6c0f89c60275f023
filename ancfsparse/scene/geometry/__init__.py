"""Curves by arc length, catenary, section frames."""
