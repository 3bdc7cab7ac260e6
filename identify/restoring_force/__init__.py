"""Identification by the restoring force surface, section 3 of the paper."""
