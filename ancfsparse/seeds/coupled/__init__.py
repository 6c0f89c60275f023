"""Seeds of matrices whose pattern follows the contacts of elements."""
