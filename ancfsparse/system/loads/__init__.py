"""Load amplitudes and generalized forces."""
