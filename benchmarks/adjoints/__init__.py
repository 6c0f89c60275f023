"""Errors estimated by residuals weighted with adjoint solutions, a prototype."""
