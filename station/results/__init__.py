"""The documents that are kept, one for each result: typed where they are read again, else plain."""
