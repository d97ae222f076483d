"""What is looked at before drones take off: one line each, good or not; `drones.py` asks those over the radio."""
