"""Choice of method, elements, mesh and step; confirmation."""
