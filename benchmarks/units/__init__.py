"""The same scenes in several systems of units and at several magnitudes of load."""
