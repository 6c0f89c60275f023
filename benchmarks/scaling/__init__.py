"""Time, memory and iterations against the size of chains, nets and lattices."""
