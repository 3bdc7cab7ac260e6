"""The tabs of the Rerun viewer, one a file."""
