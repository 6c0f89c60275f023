"""Cost per element and step, and memory, against size, beside the roofline."""
