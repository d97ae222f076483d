"""Real flights beside simulated ones: readers of logs, and comparisons of controller, motors, plant and whole flight.

From the comparison that depends least on the plant to the one that depends on everything: `controller_replay`,
`motor_replay`, `prediction`, `whole_chain`.
"""
