"""A million steps: memory, energy, and what fails when."""
