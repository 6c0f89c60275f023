"""Construction of checked beams and meshes from arguments."""
