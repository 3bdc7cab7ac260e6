"""What is kept: one typed document for each result."""
