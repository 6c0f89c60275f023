"""A posteriori estimates of what a model neglects."""
