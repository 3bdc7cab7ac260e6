"""The wire shared with the board's firmware: bytes to messages and back, with no port, thread or clock."""
