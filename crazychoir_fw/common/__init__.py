"""What every layer may use: errors, messages, units of time, attitudes, files that are replaced as a whole."""
