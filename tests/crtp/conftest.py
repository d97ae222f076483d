"""What tests of the folders below share with these, and servers with clients."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))

from server_clients import Client, Talker

from crazychoir_fw.crtp import station as station_module
from crazychoir_fw.crtp.server import Server
from crazychoir_fw.simulation import DroneConfig, World


@pytest.fixture
def world():
    return World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))], seed=4, visuals=False)


@pytest.fixture
def open_server(world):
    """Return a started server with talkers, and options."""
    servers = []

    def start(**options):
        services = (*station_module.SERVICES, Talker)
        servers.append(Server(world, port=0, services=services, **options))
        servers[-1].start()
        return servers[-1]

    yield start
    for server in servers:
        server.close()


@pytest.fixture
def connect():
    clients = []

    def open_one(server, drone="cf1"):
        clients.append(Client(server.uris[drone]))
        return clients[-1]

    yield open_one
    for client in clients:
        client.socket.close()
