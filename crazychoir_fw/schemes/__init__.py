"""Guidance that optimizes: each scheme combines distributed optimization with guidance, one file each."""
