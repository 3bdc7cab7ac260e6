"""Identification by the wavelet envelope, section 2 of the paper."""
