"""The Python face of the core: structs, variables, vehicles, trajectories in the memory of a drone."""
