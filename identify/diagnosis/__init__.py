"""Which effect a model lacks, how sure that is, and its refinement."""
