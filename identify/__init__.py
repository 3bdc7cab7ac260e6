"""Arrays in, frozen results out: the identification and diagnosis of free decays."""
