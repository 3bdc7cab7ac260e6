"""What Rerun shows, one tab a file."""
