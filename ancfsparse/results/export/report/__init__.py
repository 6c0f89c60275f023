"""Reports: one self-contained web page with the moving scene, graphs and tables of a run."""
