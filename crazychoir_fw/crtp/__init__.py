"""The simulated radio: CRTP over UDP, so that the unmodified cflib flies simulated drones.

Imports nothing above `crazychoir_fw.simulation`.
"""
