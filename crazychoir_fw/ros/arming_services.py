"""Services that a drone on the floor needs, in its namespace: ``arm`` (`std_srvs/SetBool`), ``reboot`` (`Trigger`).

The host serves them where there is onboard software. The page calls them, and `crazychoir ros arm` from a terminal.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from crazychoir_fw.common.errors import CrazychoirError, StateError, UnknownNameError
from crazychoir_fw.flight.access import reboot_all

if TYPE_CHECKING:
    from crazychoir_fw.flight.access import Access
    from crazychoir_fw.flight.agent import Agent

ARM, REBOOT = "arm", "reboot"
TYPES: dict[str, Any] = {ARM: SetBool, REBOOT: Trigger}
_FIND_S = 5.0  # [s], wall, for the first service to be found
_SETTLE_S = 0.3  # [s], wall, without a further one, after which all are found
_ANSWER_S = 10.0  # [s], wall


def serve_arming_services(node: Any, agents: Sequence[Agent], access: Access) -> None:
    """Serve ``arm`` and ``reboot`` of every drone, if they have onboard software.

    Args:
        node: The `LayerNode` that serves them.
        agents: The drones.
        access: Arms and reboots drones of the backend.
    """
    if not access.has_software:
        return

    def serve(agent: Agent, name: str, work: Callable[[Any], str]) -> None:
        def answer(request: Any, response: Any) -> Any:
            try:
                response.success, response.message = True, work(request)
            except CrazychoirError as error:
                response.success, response.message = False, str(error)
            return response

        node.create_service(TYPES[name], node.topic_of(agent.index, name), answer)

    def arm(agent: Agent, is_armed: bool) -> str:
        access.arm(agent.index, is_armed)
        return "armed" if is_armed else "disarmed"

    for agent in agents:
        serve(agent, ARM, lambda request, agent=agent: arm(agent, request.data))
        serve(agent, REBOOT, lambda request, agent=agent: reboot_all([agent], access))


def served_on(node: Node, name: str) -> list[str]:
    """Return the services ``arm`` or ``reboot`` that a node has found, by their full names."""
    wanted = f"std_srvs/srv/{TYPES[name].__name__}"
    found = node.get_service_names_and_types()
    return sorted(service for service, types in found if service.endswith(f"/{name}") and wanted in types)


def ask_for(node: Node, service: str, name: str, is_armed: bool, spin: Callable[[], None]) -> str:
    """Call the service ``arm`` or ``reboot`` of a drone; returns the message of its response.

    Args:
        node: Node that creates the client.
        service: Full name of the service.
        name: ``arm`` or ``reboot``.
        is_armed: Value of the request ``arm``: True arms, False disarms.
        spin: Spins the node once.

    Raises:
        StateError: If no response comes before the timeout, or the server refuses the request.
    """
    client = node.create_client(TYPES[name], service)
    try:
        request = SetBool.Request(data=is_armed) if name == ARM else Trigger.Request()
        end = time.monotonic() + _ANSWER_S
        while not client.service_is_ready() and time.monotonic() < end:
            spin()
        asked = client.call_async(request)
        while not asked.done() and time.monotonic() < end:
            spin()
        if not asked.done():
            raise StateError(f"{service}: no answer within {_ANSWER_S:g} s")
        answer = asked.result()
        if not answer.success:
            raise StateError(answer.message)
        return str(answer.message)
    finally:
        node.destroy_client(client)


def request_once(name: str, is_armed: bool, drones: Sequence[str], domain: int | None = None) -> dict[str, str]:
    """Arm, disarm or reboot from a process that has no nodes otherwise; returns the answers by namespace.

    Args:
        name: ``arm`` or ``reboot``.
        is_armed: Value of the request ``arm``: True arms, False disarms.
        drones: Namespaces, such as ``agent_0``; all that are found if empty.
        domain: ROS domain; None is that of ``ROS_DOMAIN_ID``.

    Raises:
        StateError: If no node serves it, or a drone refuses; all other drones are still called.
        UnknownNameError: If a drone is not among those found.
    """
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    try:
        node = Node("care", context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)

        def spin() -> None:
            executor.spin_once(timeout_sec=0.02)

        found = _found(node, name, spin)
        chosen = list(drones) or list(found)
        for drone in chosen:
            if drone not in found:
                raise UnknownNameError(f"there is no drone '{drone}', allowed: {', '.join(found)}")
        answers, problems = {}, []
        for drone in chosen:
            try:
                answers[drone] = ask_for(node, found[drone], name, is_armed, spin)
            except StateError as error:
                problems.append(f"{drone}: {error}")
        if problems:
            raise StateError("; ".join(problems))
        return answers
    finally:
        rclpy.try_shutdown(context=context)


def _found(node: Node, name: str, spin: Callable[[], None]) -> dict[str, str]:
    """Return the services found, by namespace; discovery of a swarm takes several rounds."""
    begin = since = time.monotonic()
    found: list[str] = []
    while time.monotonic() - begin < _FIND_S and not (found and time.monotonic() - since > _SETTLE_S):
        spin()
        if (now := served_on(node, name)) != found:
            found, since = now, time.monotonic()
    if not found:
        raise StateError(f"nobody serves '{name}' on this ROS domain: point masses have no onboard software")
    return {service.strip("/").rpartition("/")[0]: service for service in found}
