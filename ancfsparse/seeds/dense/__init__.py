"""Dense inverses of small matrices."""
