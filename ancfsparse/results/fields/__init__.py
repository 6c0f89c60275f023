"""Energy balance, section forces, joint forces, rigid-body motion."""
