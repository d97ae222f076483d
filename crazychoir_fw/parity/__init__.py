"""Parity: how far two providers differ, function by function and flight by flight."""
