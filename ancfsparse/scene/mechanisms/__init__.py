"""Joints between two bodies and couplings of joint coordinates."""
