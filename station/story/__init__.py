"""The whole analysis from a recording to the results, in one readable place."""
