"""The documents that are kept: one typed document for each result."""
