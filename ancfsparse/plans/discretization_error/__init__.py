"""Richardson extrapolation in mesh and time, residual correction, sampling."""
