"""The agents of a flight: their names and the addresses of their drones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from crazychoir_fw.common.errors import RangeError

AgentId = str | int
Uris = str | Sequence[str] | Mapping[AgentId, str]


def agent_name(agent_id: AgentId) -> str:
    """Return the name of an agent: ``agent_3`` for 3, any text as it is.

    Raises:
        RangeError: If it is neither.
    """
    if isinstance(agent_id, int) and not isinstance(agent_id, bool) and agent_id >= 0:
        return f"agent_{agent_id}"
    if isinstance(agent_id, str) and agent_id.strip():
        return agent_id
    raise RangeError(f"agent id is {agent_id!r}, allowed: a name, or a whole number from 0")


def agents_of(uris: Uris, agent_ids: Iterable[AgentId] | None = None) -> dict[str, str]:
    """Return the URI of each agent, by name.

    Args:
        uris: URIs in a list, or by agent.
        agent_ids: Agents of a list of URIs, in its order; 0, 1, … without them.

    Raises:
        RangeError: If their numbers differ, one comes twice, or a URI is none.
    """
    if isinstance(uris, Mapping):
        if agent_ids is not None:
            raise RangeError("agent_ids are given twice: uris already name the agents")
        pairs: list[tuple[AgentId, Any]] = list(uris.items())
    else:
        known = [uris] if isinstance(uris, str) else list(uris)
        ids = list(range(len(known))) if agent_ids is None else list(agent_ids)
        if len(ids) != len(known):
            raise RangeError(f"there are {len(known)} uris but {len(ids)} agent_ids")
        pairs = list(zip(ids, known, strict=True))
    if not pairs:
        raise RangeError("uris are empty, allowed: at least one drone")
    agents: dict[str, str] = {}
    for agent_id, uri in pairs:
        name = agent_name(agent_id)
        if not isinstance(uri, str) or "://" not in uri:
            raise RangeError(
                f"{name}: URI is {uri!r}, allowed for instance: udp://127.0.0.1:19850, radio://0/80/2M/E7E7E7E701"
            )
        if name in agents:
            raise RangeError(f"{name} comes twice in agent_ids")
        if uri in agents.values():
            raise RangeError(f"{name}: {uri} comes twice in uris")
        agents[name] = uri
    return agents
