"""Plans: the cheapest model, mesh, step and method that give a quantity to an error."""
