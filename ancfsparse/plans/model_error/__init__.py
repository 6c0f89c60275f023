"""A posteriori estimates of modelling errors."""
