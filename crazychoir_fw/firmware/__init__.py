"""The real firmware: a checkout compiled on this machine and flown as a provider."""
