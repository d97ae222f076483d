"""A swarm of points that fly to where their guidance sends them, for tests of tables and guidance."""

import numpy as np

from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import Graph, InProcessTransport, TimeVaryingCommunicator

STARTS = np.array([[1.0, 1.0], [0.0, 1.5], [-1.0, 1.0], [-1.0, -1.0], [0.0, -1.5], [1.0, -1.0]])
"""Starts of the original's example, in the order of its drones."""

STEP_S = 0.02


class TaskSwarm:
    """A table, and guidance of each drone, which moves at a constant speed straight to its goal."""

    def __init__(self, table, make, starts=STARTS, graph=None, speed=2.0, synchronous=True):
        count = len(starts)
        self.graph = Graph.binomial(6, 0.2, 3) if graph is None else graph
        self.now, self.speed, self.table = 0.0, speed, table
        transport = InProcessTransport()
        self.positions = np.column_stack([starts, np.zeros(count)])
        self.goals = self.positions.copy()
        self.events = []
        table.note = lambda kind, agent, details: self.events.append(
            {"time": self.now, "kind": kind, "drone": agent, "details": details}
        )
        self.guidance = []
        for i in range(count):
            communicator = TimeVaryingCommunicator(
                i, count, self.graph.in_neighbors(i), self.graph.out_neighbors(i), synchronous, transport=transport
            )
            self.guidance.append(make(i, communicator, self.positions[i]))
            self.guidance[i].connect(table)
        self.dead = set()

    def start(self, *drones):
        for i in drones or range(len(self.guidance)):
            self.guidance[i].set_pose(self.pose(i))
            self.guidance[i].start(self.now)
        self.table.start(self.now)

    def pose(self, i):
        return Pose(position=self.positions[i].copy(), velocity=np.zeros(3))

    def run(self, seconds, until=lambda: False):
        for _ in range(round(seconds / STEP_S)):
            self.step()
            if until():
                break

    def step(self):
        self.table.step(self.now)
        living = [i for i in range(len(self.guidance)) if i not in self.dead]
        for i in living:
            self.guidance[i].set_pose(self.pose(i))
            self.guidance[i].begin_round(self.now)
        for i in living:
            outputs = self.guidance[i].step(self.now)
            if outputs.trajectory:
                self.goals[i] = outputs.trajectory[-1].position
        way = self.goals - self.positions
        far = np.linalg.norm(way, axis=1)
        moved = np.minimum(1.0, self.speed * STEP_S / np.maximum(far, 1e-9))
        moved[list(self.dead)] = 0.0
        self.positions += way * moved[:, None]
        self.now += STEP_S

    def kinds(self, *kinds):
        return [event for event in self.events if event["kind"] in kinds]
