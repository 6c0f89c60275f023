"""Cross-sections, torsion, material."""
