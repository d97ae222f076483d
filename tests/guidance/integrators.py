"""Single integrators that fly with the velocities that guidance asks for."""

import numpy as np

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import InProcessTransport, TimeVaryingCommunicator


class Integrators:
    """Drones that are where their references are."""

    def __init__(self, cls, graph, starts, dt=0.05, leaders=(), **options):
        self.position = np.array(starts, float)
        self.dt, self.now, self.graph = dt, 0.0, graph
        self.alive = set(range(graph.size))
        self.leaders = set(leaders)
        self.velocity = np.zeros_like(self.position)
        transport = InProcessTransport()
        self.agents = []
        for i in range(graph.size):
            into, out = graph.in_neighbors(i), graph.out_neighbors(i)
            communicator = TimeVaryingCommunicator(i, graph.size, into, out, transport=transport)
            role = {"is_leader": True} if i in self.leaders else {}
            agent = cls(i, communicator, update_frequency=1.0 / dt, init_pos=self.position[i], **role, **options)
            self.agents.append(agent)

    def press(self, button):
        for i in self.alive:
            self.agents[i].set_pose(Pose(position=self.position[i].copy(), velocity=np.zeros(3)))
            getattr(self.agents[i], button)(self.now)

    def kill(self, i):
        self.alive.discard(i)

    def step(self):
        up = [self.agents[i] for i in sorted(self.alive)]
        for agent in up:
            agent.set_pose(Pose(position=self.position[agent.agent_id].copy(), velocity=np.zeros(3)))
            agent.begin_round(self.now)
        for agent in up:
            over = agent.round_open and agent.is_complete(self.now)
            out = agent.finish_round(self.now) if over else agent.step(self.now)
            if out.reference is not None:
                self.position[agent.agent_id] = out.reference.position
                self.velocity[agent.agent_id] = out.reference.velocity
        self.now += self.dt

    def run(self, seconds):
        for _ in range(round(seconds / self.dt)):
            self.step()
        return self
