"""Diagnosis: which effect a model lacks, how sure that is, and how to refine the model."""
