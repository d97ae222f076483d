"""Throws random, mutated and replayed datagrams at served drones.

    python benchmarks/fuzz_server.py --datagrams 5000000 --flood 1000000 --seed 1

Most go straight into a drone's services, between steps of its world, because that is fast. The others come by UDP, from
many addresses, to one drone of a server in another process, while a cflib client of the drone beside it logs.

What must hold: no exception; replies are packets; no number of the world stops being one; the memory does not grow; the
other client keeps its session; and whoever comes afterwards can connect. A failure ends the program with exit code 1
and prints the latest datagrams.
"""

from __future__ import annotations

import argparse
import json
import logging
import multiprocessing
import random
import socket
import struct
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

BURST = 100
"""Datagrams between two steps."""
ROUND = 2000
"""Datagrams until the world goes back to where it began, with its drone on the floor or in the air."""
MAX_GROWTH_MB = 40.0
"""Of memory, after the first tenth."""
LOG_PERIOD_MS = 10

# ---------------------------------------------------------------- what is thrown


def record_session() -> list[bytes]:
    """Return what cflib sends in a session that uses all of its ports."""
    import cflib.crtp
    from cflib.crazyflie import Crazyflie
    from cflib.crazyflie.log import LogConfig
    from cflib.crazyflie.mem import CompressedSegment, CompressedStart, MemoryElement
    from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

    from crazychoir_fw.simulation import DroneConfig, World

    recorded: list[bytes] = []
    world = World([DroneConfig("cf1")], visuals=False)
    world.wait_until_ready()
    with world.serve(port=0) as server:
        station = server._radios[0].station
        receive = station.receive
        station.receive = lambda datagram: (recorded.append(datagram), receive(datagram))[1]
        thread = threading.Thread(target=server.run)
        thread.start()
        cflib.crtp.init_drivers()
        with SyncCrazyflie(server.uris["cf1"], cf=Crazyflie()) as scf:
            cf = scf.cf
            scf.wait_for_params()
            block = LogConfig("place", LOG_PERIOD_MS)
            for axis in "xyz":
                block.add_variable(f"stateEstimate.{axis}", "float")
            cf.log.add_config(block)
            block.start()
            cf.param.set_value("stabilizer.controller", 2)
            for ask in (cf.param.persistent_store, cf.param.persistent_get_state, cf.param.persistent_clear):
                ask("ring.effect", lambda *_: None)
            cf.param.get_default_value("ring.effect", lambda *_: None)
            memory = cf.mem.get_mems(MemoryElement.TYPE_TRAJ)[0]
            memory.trajectory = [CompressedStart(0, 0, 0.5, 0), CompressedSegment(1.0, [0.1], [], [], [])]
            memory.write_data_sync()
            cf.supervisor.send_arming_request(True)
            high = cf.high_level_commander
            high.takeoff(0.5, 1.0)
            high.go_to(0.1, 0.0, 0.5, 0.0, 1.0)
            high.spiral(0.5, 0.1, 0.1, 0.0, 1.0)
            high.define_trajectory(1, 0, 1, type=high.TRAJECTORY_TYPE_POLY4D_COMPRESSED)
            high.start_trajectory(1)
            high.set_group_mask()
            high.land(0.0, 1.0)
            high.stop()
            low = cf.commander
            low.send_setpoint(0.0, 0.0, 0.0, 0)
            low.send_hover_setpoint(0.0, 0.0, 0.0, 0.4)
            low.send_position_setpoint(0.0, 0.0, 0.4, 0.0)
            low.send_velocity_world_setpoint(0.1, 0.0, 0.0, 0.0)
            low.send_zdistance_setpoint(0.0, 0.0, 0.0, 0.4)
            low.send_full_state_setpoint([0, 0, 0.4], [0, 0, 0], [0, 0, 0], [0, 0, 0, 1], 0, 0, 0)
            low.send_stop_setpoint()
            low.send_notify_setpoint_stop()
            cf.extpos.send_extpos(0.0, 0.0, 0.0)
            cf.extpos.send_extpose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
            cf.loc.send_short_lpp_packet(1, b"\x01abc")
            cf.loc.send_lh_persist_data_packet([0, 1], [0, 1])
            cf.supervisor.send_emergency_stop_watchdog()
            cf.appchannel.send_packet(b"\x01\x02\x03")
            cf.supervisor.send_crash_recovery_request()
            time.sleep(0.3)
            block.stop()
            block.delete()
            cf.supervisor.send_emergency_stop()
        server.stop()
        thread.join()
    return recorded


NUMBERS = [
    *(struct.pack("<f", value) for value in (0.0, -0.0, 1.0, -1e9, 3e38, float("inf"), float("-inf"), float("nan"))),
    *(struct.pack("<H", value) for value in (0, 1, 0x7FFF, 0x8000, 0xFFFF, 0x7C00, 0x7E00)),
    *(struct.pack("<I", value) for value in (0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)),
]
PORTS = (0, 2, 3, 4, 5, 6, 7, 8, 9, 13, 15)


class Thrower:
    """Makes datagrams, the same ones for a seed."""

    def __init__(self, recorded: list[bytes], seed: int) -> None:
        self._recorded = recorded
        # of hundreds of equal requests for items, few
        kinds: dict[bytes, list[bytes]] = {}
        for datagram in recorded:
            kinds.setdefault(datagram[:2], []).append(datagram)
        self._kinds = list(kinds.values())
        self._random = random.Random(seed)
        self._place = 0
        self._ways = (self._replayed, self._replayed, self._mutated, self._mutated, self._mutated, self._likely)

    def throw(self) -> bytes:
        choice = self._random.randrange(8)
        return self._ways[choice]() if choice < 6 else self._random_bytes()

    def _length(self) -> int:
        choice = self._random.random()
        return self._random.randrange(33 if choice < 0.9 else 80 if choice < 0.98 else 1501)

    def _random_bytes(self) -> bytes:
        return self._random.randbytes(self._length())

    def _one(self) -> bytes:
        return self._random.choice(self._random.choice(self._kinds))

    def _replayed(self) -> bytes:
        if self._random.random() < 0.5:
            return self._one()
        # in the order of the session, so that states are reached
        self._place = (self._place + 1) % len(self._recorded)
        return self._recorded[self._place]

    def _likely(self) -> bytes:
        """Return a header that there is, a command that there may be, and numbers that are at some edge."""
        r = self._random
        parts = [bytes((r.choice(PORTS) << 4 | r.randrange(16),)), bytes((r.randrange(16),))]
        for _ in range(r.randrange(8)):
            parts.append(r.choice(NUMBERS) if r.random() < 0.6 else r.randbytes(r.randrange(5)))
        return b"".join(parts)[: 31 if r.random() < 0.95 else None]

    def _mutated(self) -> bytes:
        r = self._random
        data = bytearray(self._one())
        for _ in range(1 + r.randrange(3)):
            place = r.randrange(len(data)) if data else 0
            choice = r.randrange(7)
            if choice == 0:
                data[place : place + 1] = r.randbytes(1)
            elif choice == 1:
                del data[place:]
            elif choice == 2:
                data += r.randbytes(r.randrange(1, 8))
            elif choice == 3:
                number = r.choice(NUMBERS)
                data[place : place + len(number)] = number
            elif choice == 4:
                data[place:] = self._one()[place:]
            elif choice == 5 and data:
                data[place] ^= 1 << r.randrange(8)
            elif choice == 6:
                del data[place : place + 1]
        return bytes(data)


# ---------------------------------------------------------------- straight into the services


def memory_mb(process: str = "self") -> float:
    """Return what a process holds (MB)."""
    with Path(f"/proc/{process}/statm").open() as file:
        return int(file.read().split()[1]) * 4096 / 1e6


class FailureError(Exception):
    """Something that must hold did not."""


def fuzz_services(recorded: list[bytes], datagrams: int, seed: int) -> dict[str, Any]:
    """Throw at the services of one drone."""
    from crazychoir_fw.crtp.packet import MAX_PAYLOAD
    from crazychoir_fw.crtp.station import Station
    from crazychoir_fw.simulation import DroneConfig, World

    thrower, dice = Thrower(recorded, seed), random.Random(seed)
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))], visuals=False, seed=seed)
    world.wait_until_ready()
    drone = world["cf1"]
    station = Station(world, drone)
    line = station.context
    on_floor = world.snapshot()
    drone.high_level_commander.takeoff(0.5, 1.0)
    world.run(2.0)
    in_air = world.snapshot()
    counts: Counter[str] = Counter()
    latest: deque[bytes] = deque(maxlen=3 * BURST)
    memory, slowest = [], 0.0
    began = time.perf_counter()
    for number in range(0, datagrams, BURST):
        if number % ROUND == 0:
            world.restore(in_air if number // ROUND % 2 else on_floor)
            counts["rounds"] += 1
            memory.append(memory_mb())
        try:
            for _ in range(BURST):
                datagram = thrower.throw()
                latest.append(datagram)
                for reply in station.receive(datagram):
                    counts["replies"] += 1
                    if not 1 <= len(reply) <= 1 + MAX_PAYLOAD:
                        raise FailureError(f"a reply of {len(reply)} bytes")
            before = time.perf_counter()
            line.carry_out()
            world.step(dice.randrange(12))
            slowest = max(slowest, time.perf_counter() - before)
            for datagram, _ in line.take_out():
                counts["sent"] += 1
                if not 1 <= len(datagram) <= 1 + MAX_PAYLOAD:
                    raise FailureError(f"a packet of {len(datagram)} bytes")
            if not (np.isfinite(world.data.qpos).all() and np.isfinite(world.data.qvel).all()):
                raise FailureError("a position or velocity is no number")
            counts["bursts in the air"] += drone.is_flying
            if drone.failure is not None:
                counts["stopped by the core"] += 1
                counts[drone.failure.split(": ")[1].split(" (")[0]] += 1
                world.restore(on_floor)
            if dice.random() < 0.01:
                station.end_session()
        except Exception as error:
            dump(latest)
            raise FailureError(f"datagram {number} of seed {seed}: {type(error).__name__}: {error}") from error
    early = memory[min(len(memory) - 1, max(1, len(memory) // 10))]
    growth = memory_mb() - early
    if growth > MAX_GROWTH_MB:
        raise FailureError(f"{growth:.0f} MB more than after a tenth of the datagrams")
    if not np.isfinite(world["cf2"].true_position).all() or world["cf2"].failure is not None:
        raise FailureError("the drone beside it did not stay what it was")
    return {
        "datagrams": datagrams,
        "seconds": time.perf_counter() - began,
        "memory_growth_mb": growth,
        "slowest_burst_ms": slowest * 1e3,
        **counts,
    }


def dump(latest: deque[bytes]) -> None:
    for datagram in latest:
        print("  ", datagram[:64].hex(" "), file=sys.stderr)


# ---------------------------------------------------------------- through sockets


def serve(pipe: Any) -> None:
    """Serve two drones until told to stop, and return what was counted and logged."""
    from crazychoir_fw.simulation import DroneConfig, World

    errors: list[str] = []
    handler = logging.Handler()
    handler.emit = lambda record: errors.append(record.getMessage())
    logging.getLogger("crazychoir_fw.crtp").addHandler(handler)
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))], visuals=False)
    world.wait_until_ready()
    with world.serve(port=0) as server:
        pipe.send(server.uris)
        threading.Thread(target=lambda: (pipe.recv(), server.stop()), daemon=True).start()
        server.run()
        figures = server.statistics()
    pipe.send({"errors": errors, "statistics": figures.as_dict()})


def listen(uri: str, pipe: Any) -> None:
    """Log 100 times a second until told to stop; return packets, gaps, and whether the link was lost."""
    import cflib.crtp
    from cflib.crazyflie import Crazyflie
    from cflib.crazyflie.log import LogConfig
    from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

    cflib.crtp.init_drivers()
    with SyncCrazyflie(uri, cf=Crazyflie()) as scf:
        stamps, lost = [], []
        scf.cf.connection_lost.add_callback(lambda *_: lost.append(True))
        block = LogConfig("place", LOG_PERIOD_MS)
        block.add_variable("stateEstimate.x", "float")
        scf.cf.log.add_config(block)
        block.data_received_cb.add_callback(lambda stamp, *_: stamps.append(stamp))
        block.start()
        while not stamps:
            time.sleep(0.01)
        pipe.send(None)
        pipe.recv()
        gaps = sum(int(step) // LOG_PERIOD_MS - 1 for step in np.diff(stamps))
        pipe.send({"packets": len(stamps), "lost": gaps, "link_lost": bool(lost)})


def addresses(count: int) -> Iterator[socket.socket]:
    """Yield sockets, of other hosts of the loopback net where there are such."""
    for number in range(count):
        opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        opened.setblocking(False)
        try:
            opened.bind((f"127.0.0.{2 + number % 250}", 0))
        except OSError:
            opened.bind(("127.0.0.1", 0))
        yield opened


def fuzz_sockets(recorded: list[bytes], datagrams: int, seed: int, per_second: float) -> dict[str, Any]:
    """Throw at one of two served drones, from many addresses."""
    context = multiprocessing.get_context("spawn")
    server_pipe, other = context.Pipe()
    server = context.Process(target=serve, args=(other,), daemon=True)
    server.start()
    uris = server_pipe.recv()
    client_pipe, other = context.Pipe()
    client = context.Process(target=listen, args=(uris["cf2"], other), daemon=True)
    client.start()
    client_pipe.recv()
    memory = memory_mb(str(server.pid))
    thrower, dice = Thrower(recorded, seed), random.Random(seed)
    target = ("127.0.0.1", int(uris["cf1"].rsplit(":", 1)[1]))
    began, blocked = time.perf_counter(), 0
    sockets = list(addresses(64))
    # the drone belongs to the first of them, and half of what comes is from it
    sockets[0].sendto(b"\xfd\x00", target)
    time.sleep(0.1)
    for number in range(datagrams):
        if number % 1000 == 0:
            # a new face, now and then
            sockets[dice.randrange(1, 64)].close()
            sockets = [opened if opened.fileno() >= 0 else next(addresses(1)) for opened in sockets]
        try:
            dice.choice(sockets[:1] if dice.random() < 0.5 else sockets).sendto(thrower.throw(), target)
        except OSError:
            blocked += 1
        if number % 100 == 0:
            time.sleep(max(0.0, began + number / per_second - time.perf_counter()))
    seconds = time.perf_counter() - began
    for opened in sockets:
        opened.close()
    growth = memory_mb(str(server.pid)) - memory
    if not server.is_alive():
        raise FailureError("the server is dead")
    greeting = ask_who_it_is(target)
    client_pipe.send(None)
    heard = client_pipe.recv()
    client.join(30.0)
    server_pipe.send(None)
    served = server_pipe.recv()
    server.join(30.0)
    figures = served["statistics"]
    # random bytes ask for the boot loader now and then, and are refused in words
    errors = [error for error in served["errors"] if "asked for the boot loader" not in error]
    if errors:
        raise FailureError(f"the server reported: {errors}")
    if heard["link_lost"]:
        raise FailureError("the other client lost its link")
    if not greeting:
        raise FailureError("the drone does not answer any more")
    return {
        "datagrams": datagrams,
        "seconds": seconds,
        "not_sent": blocked,
        "memory_growth_mb": growth,
        "other_client": heard,
        "flooded_drone": figures["drones"]["cf1"],
        "real_time_factor": figures["real_time_factor"],
        "worst_lag_ms": figures["worst_lag_s"] * 1e3,
        "cpu_share": figures["cpu_share"],
    }


def ask_who_it_is(target: tuple[str, int]) -> bool:
    """Connect as cflib does, once the drone is free; cflib asks once."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.settimeout(10.0)
        client.connect(target)
        client.send(b"\xfd\x00")
        try:
            return client.recv(64)[1:].startswith(b"Bitcraze Crazyflie")
        except TimeoutError:
            return False


# ---------------------------------------------------------------- both


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--datagrams", type=int, default=1_000_000, help="straight into the services")
    parser.add_argument("--flood", type=int, default=200_000, help="through sockets")
    parser.add_argument("--per-second", type=float, default=20_000.0, help="through sockets")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    result: dict[str, Any] = {}
    recorded = record_session()
    print(f"{len(recorded)} datagrams of a session recorded")
    works: dict[str, Callable[[], dict[str, Any]]] = {
        "services": lambda: fuzz_services(recorded, options.datagrams, options.seed),
        "sockets": lambda: fuzz_sockets(recorded, options.flood, options.seed, options.per_second),
    }
    for name, work in works.items():
        try:
            result[name] = work()
        except FailureError as failure:
            sys.exit(f"{name}: {failure}")
        print(name, json.dumps(result[name], indent=2))
    if options.json:
        options.json.write_text(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
