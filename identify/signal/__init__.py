"""Signal processing: filters, spectra, derivatives and oscillations of sampled records."""
