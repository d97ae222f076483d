"""A program of yours that flies one drone: ten lines."""

from crazychoir_fw.simulation import MotorCtrlVel


class Bounce(MotorCtrlVel):
    """Flies up and down between two heights, as its properties say."""

    rate_hz = 50

    def init(self, drone, properties):
        """Read the properties."""
        self.low, self.high = float(properties.get("low", 0.3)), float(properties.get("high", 0.8))
        self.climb = 0.4

    def step(self):
        """Turn round at the heights."""
        height = self.position[2]
        if height > self.high or height < self.low:
            self.climb = -0.4 if height > self.high else 0.4
        self.command(0.0, 0.0, self.climb)
