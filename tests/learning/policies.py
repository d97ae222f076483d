"""Networks with random weights, for tests that need no torch."""

import numpy as np

from crazychoir_fw.learning import Observation, ThrustRates
from crazychoir_fw.learning.policy import Layer, Policy

ALL = (
    *("position_error", "velocity_error", "reference_acceleration", "position", "velocity", "rotation"),
    *("rates", "specific_force", "action"),
)


def network(observation=None, action=None, hidden=(32, 24), activations=("tanh", "relu"), gain=0.1, **options):
    observation, action = observation or Observation(), action or ThrustRates()
    rng = np.random.default_rng(7)
    sizes = [observation.size, *hidden, action.size]
    kinds = [*activations[: len(hidden)], "none"]
    layers = [
        Layer(
            ((gain if n == len(kinds) - 1 else 1.0) * rng.standard_normal((b, a)) / np.sqrt(a)).astype(np.float32),
            (0.1 * gain * rng.standard_normal(b)).astype(np.float32),
            kind,
        )
        for n, (a, b, kind) in enumerate(zip(sizes, sizes[1:], kinds, strict=False))
    ]
    mean = rng.uniform(-0.3, 0.3, observation.size).astype(np.float32)
    factor = rng.uniform(0.3, 2.0, observation.size).astype(np.float32)
    return Policy(layers, observation, action, mean=mean, factor=factor, **options)
