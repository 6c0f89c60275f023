"""Charts, pictures and films by matplotlib and PyVista."""
