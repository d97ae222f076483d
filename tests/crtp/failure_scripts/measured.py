"""Echoes one by one and in bursts, then the memory that is there for tests."""

import struct
import sys
import threading

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.mem import MemoryElement
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie
from cflib.crazyflie.syncLogger import SyncLogger
from cflib.crtp.crtpstack import CRTPPacket, CRTPPort

PATIENCE_S = 30
BURST = 200  # what the socket of a client holds, and some room


def send_echo(link, number, size):
    packet = CRTPPacket()
    packet.set_header(CRTPPort.LINKCTRL, 0)
    packet.data = struct.pack("<I", number) * (size // 4)
    link.send_packet(packet)


def read_echo(link, size):
    packet = link.receive_packet(PATIENCE_S)
    assert packet is not None, "an echo is lost"
    assert (packet.port, packet.channel, len(packet.data)) == (CRTPPort.LINKCTRL, 0, size)
    return struct.unpack("<I", packet.data[:4])[0]


cflib.crtp.init_drivers()
for size in (4, 28):
    link = cflib.crtp.get_link_driver(sys.argv[1])
    for number in range(500):
        send_echo(link, number, size)
        assert read_echo(link, size) == number
    returned = []
    for start in range(0, 1000, BURST):
        for number in range(start, start + BURST):
            send_echo(link, number, size)
        returned += [read_echo(link, size) for _ in range(BURST)]
    assert returned == list(range(1000))
    link.close()
    print("echoes of", size, "bytes", len(returned))

with SyncCrazyflie(sys.argv[1], cf=Crazyflie(rw_cache=sys.argv[2])) as scf:
    (memory,) = scf.cf.mem.get_mems(MemoryElement.TYPE_MEMORY_TESTER)
    is_read, is_written = threading.Event(), threading.Event()
    memory.read_data(5, 1000, lambda memory: is_read.set())
    print("read", is_read.wait(PATIENCE_S), memory.readValidationSuccess)
    scf.cf.param.set_value("memTst.resetW", "1")
    memory.write_data(5, 1000, lambda memory, address: is_written.set())
    print("written", is_written.wait(PATIENCE_S))
    block = LogConfig("memtester", 100)
    block.add_variable("memTst.errCntW", "uint32_t")
    with SyncLogger(scf, block) as logger:
        print("errors", next(iter(logger))[1]["memTst.errCntW"])
