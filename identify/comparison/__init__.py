"""Where, and by how much, a fitted model fails."""
