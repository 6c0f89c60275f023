"""Methods of `Scene` that add bodies, joints and loads."""
