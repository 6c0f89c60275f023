"""What secant pairs are worth: updates and memory lengths."""
