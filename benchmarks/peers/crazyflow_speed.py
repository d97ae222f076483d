"""How fast crazyflow is on this machine, for `swarm_scale.py --crazyflow PYTHON`, which starts this with that Python.

crazyflow (JAX, controller and dynamics, no estimator and no commander, 500 Hz) gets a fresh setpoint for every drone
every 10 ms, as clients of a swarm send them. Each line on standard input is a number of simulated seconds; the answer
is one line with the time that they took (s).

Prerequisite: `pip install crazyflow` into an environment of its own, because it pins other versions of what we use.
"""

from __future__ import annotations

import sys
import time

import jax
import numpy as np
from crazyflow import Control
from crazyflow.sim import Sim

FREQUENCY = 500  # [Hz] of the simulation
COMMAND_PERIOD = 0.01  # [s]
HEIGHT = 1.0  # [m]
SPACING = 0.5  # [m]


def hovering(count: int) -> tuple[Sim, np.ndarray]:
    """Return a world of drones and the setpoints that keep them at their places."""
    sim = Sim(n_worlds=1, n_drones=count, control=Control.state, freq=FREQUENCY)
    sim.reset()
    side = int(np.ceil(np.sqrt(count)))
    places = np.array([(i % side * SPACING, i // side * SPACING, HEIGHT) for i in range(count)], np.float32)
    sim.data = sim.data.replace(states=sim.data.states.replace(pos=jax.numpy.asarray(places)[None]))
    setpoints = np.zeros((1, count, 16), np.float32)  # position, velocity, acceleration, quaternion xyzw, rates
    setpoints[0, :, :3] = places
    setpoints[..., 12] = 1.0
    return sim, setpoints


def fly(sim: Sim, setpoints: np.ndarray, seconds: float) -> None:
    """Simulate, with a fresh setpoint every 10 ms."""
    for _ in range(max(1, round(seconds / COMMAND_PERIOD))):
        setpoints[..., 0] += 1e-6
        sim.state_control(jax.numpy.asarray(setpoints))
        sim.step(round(FREQUENCY * COMMAND_PERIOD))
    jax.block_until_ready(sim.data.states.pos)


def main() -> None:
    """Answer lines until there are no more."""
    sim, setpoints = hovering(int(sys.argv[1]))
    fly(sim, setpoints, 1.0)  # compiles
    positions = np.asarray(sim.data.states.pos)
    if not np.allclose(positions, setpoints[..., :3], atol=0.3):
        raise SystemExit("crazyflow's drones do not hover: the benchmark would measure nothing")
    print("ready", flush=True)
    for line in sys.stdin:
        start = time.perf_counter()
        fly(sim, setpoints, float(line))
        print(time.perf_counter() - start, flush=True)


if __name__ == "__main__":
    main()
