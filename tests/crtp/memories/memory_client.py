"""A client that asks for memories."""

from cflib_client import Client

from crazychoir_fw.crtp.station import Station


class MemoryClient(Client):
    """The real client at the station of a drone: `read` brings answers, `carry_out` lets the simulation do its part."""

    def __init__(self, world, drone):
        super().__init__(Station(world, drone))
        self.world, self.drone = world, drone

    @property
    def mem(self):
        return self.cf.mem

    def connect(self):
        """Have the client ask for all memories, as it does when it connects."""
        done = []
        self.mem.refresh(lambda: done.append(True))
        self.read()
        assert done
        return self

    def memory(self, type):
        """Return the one memory of a type."""
        (memory,) = self.mem.get_mems(type)
        return memory

    def call(self, function, *arguments, **named):
        """Call an asynchronous method whose last argument is a callback, and return what that is called with."""
        answers = []
        function(*arguments, lambda *values: answers.append(values), **named)
        self.read()
        (answer,) = answers
        return answer

    def carry_out(self):
        """Let the simulation do what waits, and the client hear of it."""
        self.station.context.carry_out()
        self.read()
