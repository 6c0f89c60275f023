"""The whole error of elements, mesh and step against its cost, beside peers."""
