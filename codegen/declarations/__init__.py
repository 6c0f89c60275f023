"""Terms that elements are declared with, and the kernels derived for them."""
