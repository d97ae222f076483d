"""What a policy costs on the drone, beside what there is: STM32F405, 168 MHz, 1 MB of flash, 192 KB of RAM."""

from __future__ import annotations

from dataclasses import dataclass

from crazychoir_fw.learning.policy.network import Policy

FLASH_BYTES = 1024 * 1024
RAM_BYTES = 192 * 1024
CLOCK_HZ = 168_000_000

_FLOAT = 4
_CODE_BYTES = 4096  # of the functions around the numbers, an upper bound
_CYCLES_PER_MULTIPLY_ADD = 8  # two loads, vmla.f32 and the loop, flash with wait states
_CYCLES_PER_TANH = 250  # newlib's tanhf


@dataclass(frozen=True)
class Cost:
    """Estimates from counts; the compiler of the firmware has the last word."""

    multiply_adds: int
    """Per action."""
    flash_bytes: int
    """Weights, normalization and code."""
    ram_bytes: int
    """Static buffers."""
    microseconds: float
    """Of processor time per action."""
    rate_hz: int
    """Actions per second."""

    @property
    def rows(self) -> dict[str, str]:
        """For a table."""
        return {
            "multiply-adds": f"{self.multiply_adds} per action, {self.rate_hz} actions/s",
            "flash": f"{self.flash_bytes / 1024:.1f} KB, {_share(self.flash_bytes, FLASH_BYTES)} of 1 MB",
            "RAM": f"{self.ram_bytes / 1024:.1f} KB, {_share(self.ram_bytes, RAM_BYTES)} of 192 KB",
            "time (estimate)": f"{self.microseconds:.0f} µs per action of the 1000 µs of a tick, "
            f"{self.microseconds * self.rate_hz / 1e4:.1f} % of 168 MHz",
        }

    @property
    def doubts(self) -> list[str]:
        """Sentences about what will not fit."""
        found = []
        if self.flash_bytes > FLASH_BYTES // 2:
            found.append("the weights take more than half of the flash, of which the firmware needs 250 to 400 KB")
        if self.ram_bytes > RAM_BYTES // 8:
            found.append("the buffers take more than an eighth of the RAM, which the firmware nearly fills")
        if self.microseconds > 500.0:
            found.append("an action takes more than half of a tick, which other loops need")
        return found


def _share(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f} %"


def cost_of(policy: Policy) -> Cost:
    """Return what a policy costs."""
    multiply_adds = sum(layer.weight.size for layer in policy.layers)
    constants = 2 * policy.observation.size + 4 * policy.action.size
    numbers = multiply_adds + constants + sum(layer.bias.size for layer in policy.layers)
    widest = max([policy.observation.size, *(len(layer.bias) for layer in policy.layers)])
    tanhs = sum(len(layer.bias) for layer in policy.layers if layer.activation == "tanh")
    cycles = multiply_adds * _CYCLES_PER_MULTIPLY_ADD + tanhs * _CYCLES_PER_TANH
    return Cost(
        multiply_adds=multiply_adds,
        flash_bytes=_FLOAT * numbers + _CODE_BYTES,
        ram_bytes=_FLOAT * (2 * widest + 24) + 152,  # and a setpoint_t
        microseconds=cycles / CLOCK_HZ * 1e6,
        rate_hz=policy.rate_hz,
    )
