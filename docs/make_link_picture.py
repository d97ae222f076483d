"""Draw `images/radio_budget.png`: how late setpoints come, estimated and simulated, by the number of drones."""

import random
from pathlib import Path

import matplotlib.pyplot as plt

from crazychoir_fw.crtp.link_model import Direction, RadioConfig, SimulatedRadios
from crazychoir_fw.crtp.link_model.budget import LogBlock, budget

RADIO = RadioConfig(drones=["*"])
STREAMS = ((10, 10), (50, 10), (50, 100))  # setpoints and log packets of each drone [Hz]
PING, SECONDS = 10, 10


def simulate(drones: int, setpoints: float, logs: float) -> float:
    """Return the 95 % latency of what goes to the drones (ms)."""
    dice = random.Random(1)
    packets = []
    for number in range(drones):
        streams = ((setpoints, Direction.UP, 18), (PING, Direction.UP, 10), (PING, Direction.DOWN, 10))
        for rate, direction, size in (*streams, (logs, Direction.DOWN, 31)):
            begin = dice.random() / rate
            packets += [(begin + k / rate, f"cf{number}", direction, bytes(size)) for k in range(SECONDS * rate)]
    link = SimulatedRadios([RADIO], [f"cf{number}" for number in range(drones)])
    for now, drone, direction, datagram in sorted(packets, key=lambda packet: packet[0]):
        link.send(now, drone, direction, datagram, direction is Direction.DOWN)
    link.arrivals(SECONDS)
    late = [drone["up"]["latency_p95_ms"] for drone in link.statistics()["drones"].values()]
    return sum(late) / drones


def main() -> None:
    """Draw."""
    figure, axes = plt.subplots(figsize=(7.0, 3.6), layout="constrained")
    for color, (setpoints, logs) in zip(("C0", "C1", "C2"), STREAMS, strict=True):
        counts = range(1, 41)
        estimates = [budget(RADIO, count, setpoints, logs=[LogBlock(logs)]) for count in counts]
        fitting = [(row.drones, row.up_p95_ms) for row in estimates if row.verdict != "too much"]
        label = f"setpoints {setpoints} Hz, logs {logs} Hz"
        axes.plot(*zip(*fitting, strict=True), color=color, label=label)
        points = [count for count in (1, 2, 4, 6, 8, 10, 12, 15, 20, 25, 30, 35, 40) if count <= fitting[-1][0]]
        axes.plot(points, [simulate(count, setpoints, logs) for count in points], "o", color=color, markersize=4)
        if fitting[-1][0] < 40:
            axes.annotate(
                "too much", fitting[-1], (-4, 6), textcoords="offset points", color=color, fontsize=9, ha="right"
            )
    axes.set(xlabel="drones on one Crazyradio (2M)", ylabel="95 % of packets arrive within (ms)", xlim=(0, 41))
    axes.set_ylim(0, None)
    axes.grid(alpha=0.3)
    axes.legend(title="lines: budget, dots: simulated")
    figure.savefig(Path(__file__).parent / "images" / "radio_budget.png", dpi=110)


if __name__ == "__main__":
    main()
