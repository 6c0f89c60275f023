"""Explicit methods, their tableaus and the compiled explicit time loop."""
