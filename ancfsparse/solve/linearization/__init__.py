"""Linearized matrices M, C, K and Phi_q about a state; rigid-body modes."""
