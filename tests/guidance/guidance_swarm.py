"""Double integrators that fly what guidance asks for, and the formations of the examples."""

import numpy as np

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import (
    BearingFormation,
    Graph,
    GuidanceGroup,
    InProcessTransport,
    TimeVaryingCommunicator,
)

SQUARE = np.array([(-0.7, -0.7, 1.0), (0.7, -0.7, 1.0), (0.7, 0.7, 1.0), (-0.7, 0.7, 1.0)])
SQUARE_GRAPH = Graph.undirected(4, [(0, 1), (0, 3), (1, 2), (1, 3), (2, 3)])
SQUARE_STARTS = np.array([(-0.7, -0.7, 1.0), (0.7, -0.7, 1.0), (0.1, 0.1, 1.0), (-0.6, 0.3, 1.0)])

LETTER_S = np.array(
    [
        (0.5001, 0.6667, 0.5),
        (-0.4999, -0.6666, 0.5),
        (0.0, -0.0001, 0.5),
        (0.5, -0.3334, 0.5),
        (0.4999, -0.6667, 0.5),
        (0.1669, -0.9997, 0.5),
        (-0.1664, -0.9998, 0.5),
        (-0.4997, 0.3317, 0.5),
        (-0.4995, 0.6665, 0.5),
        (-0.1664, 0.9987, 0.5),
        (0.1669, 0.9986, 0.5),
    ]
)
_S_EDGES = (
    "0-1 0-2 0-3 0-4 0-8 1-2 1-3 1-4 1-7 2-3 2-4 3-4 3-5 3-6 3-10 4-5 4-9 4-10 5-6 5-8 5-9 5-10 6-7 6-8 6-9 6-10 "
    "7-8 7-9 7-10 8-9 9-10"
)
LETTER_S_GRAPH = Graph.undirected(11, [tuple(map(int, edge.split("-"))) for edge in _S_EDGES.split()])

GRID = np.array([(x, y, 1.0) for y in np.linspace(-3.0, 3.0, 5) for x in np.linspace(-3.75, 3.75, 6)])


def grid_graph(seed=379):
    """99 edges at random; of this seed, the smallest eigenvalue is about that of the original's graph."""
    pairs = [(i, j) for i in range(30) for j in range(i)]
    chosen = np.random.default_rng(seed).choice(len(pairs), 99, replace=False)
    return Graph.undirected(30, [pairs[k] for k in chosen])


class Swarm:
    """Followers are double integrators, leaders stay where they are put."""

    def __init__(
        self, formation, graph, starts, leaders=(0, 1), seed=0, noise=(0.0, 0.0), transport=None, dt=0.02, **options
    ):
        self.graph, self.formation = graph, formation
        self.transport = InProcessTransport() if transport is None else transport
        self.leaders = set(leaders)
        self.position = np.array(starts, dtype=float)
        self.velocity = np.zeros_like(self.position)
        self.bias = np.zeros_like(self.position)
        self.noise, self.dt = noise, dt
        self.group = None
        self.dice = np.random.default_rng(seed)
        self.step_number = 0
        self.alive = set(range(graph.size))
        self.events = []
        self.inputs = np.zeros_like(self.position)
        self.outputs = {}
        self.options = options
        self.agents = [self.make(i) for i in range(graph.size)]

    def make(self, i, **options):
        communicator = TimeVaryingCommunicator(
            i,
            self.graph.size,
            self.graph.in_neighbors(i),
            self.graph.out_neighbors(i),
            transport=self.transport,
            differentiated_topics=False,
        )
        return BearingFormation(
            i,
            communicator,
            is_leader=i in self.leaders,
            formation=self.formation,
            init_pos=self.position[i],
            on_lost=lambda agent, neighbor, now: self.events.append(("lost", agent, neighbor, now)),
            on_rejoined=lambda agent, neighbor, now: self.events.append(("rejoined", agent, neighbor, now)),
            **{**self.options, **options},
        )

    @property
    def now(self):
        return self.step_number * self.dt

    def press(self, button):
        for i in sorted(self.alive):
            getattr(self.agents[i], button)(self.now)

    def kill(self, i):
        self.alive.discard(i)
        self.agents[i].communicator.close()

    def measure(self):
        p = self.position + self.noise[0] * self.dice.standard_normal(self.position.shape)
        v = self.velocity + self.noise[1] * self.dice.standard_normal(self.position.shape)
        p.flags.writeable = v.flags.writeable = False  # read-only: agents need no copies
        for i in self.alive:
            self.agents[i].set_pose(Pose(position=p[i], velocity=v[i], time=self.now))

    def decide(self):
        up = [self.agents[i] for i in sorted(self.alive)]
        if self.group is None or self.group.agents != up:
            self.group = GuidanceGroup(up)
        return {agent.agent_id: out for agent, out in zip(up, self.group.step(self.now), strict=True)}

    def step(self):
        self.measure()
        for i, out in self.decide().items():
            self.outputs[i] = out
            self.inputs[i] = 0.0 if out.reference is None else out.reference.acceleration
        for i in set(range(self.graph.size)) - self.alive:
            self.inputs[i] = 0.0
        followers = [i for i in sorted(self.alive) if i not in self.leaders]
        acceleration = self.inputs[followers] + self.bias[followers]
        self.position[followers] += self.velocity[followers] * self.dt + 0.5 * acceleration * self.dt**2
        self.velocity[followers] += acceleration * self.dt
        self.step_number += 1

    def run(self, seconds):
        for _ in range(round(seconds / self.dt)):
            self.step()
        return self
