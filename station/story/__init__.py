"""The whole way from a recording to the results, in one readable place."""
