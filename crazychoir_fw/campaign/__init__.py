"""Campaigns: many flights of one mission that differ as real ones do, and what they say together."""
