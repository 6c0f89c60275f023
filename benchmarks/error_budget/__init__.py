"""How much of the error is due to the mesh, the step and the iteration."""
