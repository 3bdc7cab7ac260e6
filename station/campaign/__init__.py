"""Many sessions as one campaign: spread over workers, kept one by one, and looked at together."""
