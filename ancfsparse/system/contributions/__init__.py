"""Terms of the equations of motion: elements, masses, loads, constraints, force elements."""
