"""Diagnosis: the verdict on a record with its explanation, the ladder, and a guided test."""
