"""The next release: which hypotheses remain, and what to record to distinguish them."""
