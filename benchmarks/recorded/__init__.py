"""Identification of a vehicle from recorded flights; `crazychoir_fw.comparison` reads and compares them."""
