"""From a trained network to a firmware app: read it, know what it costs, write it as C."""

from crazychoir_fw.learning.policy.app import write_app
from crazychoir_fw.learning.policy.cost import Cost, cost_of
from crazychoir_fw.learning.policy.network import Layer, Policy
from crazychoir_fw.learning.policy.reading import read_policy

__all__ = ["Cost", "Layer", "Policy", "cost_of", "read_policy", "write_app"]
