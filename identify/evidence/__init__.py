"""Evidence: what is believed before a recording is seen, and what the readings then say for each effect."""
