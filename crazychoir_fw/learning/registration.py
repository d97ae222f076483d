"""Names of the environments, for `gymnasium.make` and `gymnasium.make_vec`."""

from __future__ import annotations

_PLACE = "crazychoir_fw.learning"
NAMES = ("Hover", "Track", "Gates", "Recover")


def register() -> None:
    """Register ``crazychoir/Hover-v0`` and the others, once.

    Up to version 1.3 Gymnasium calls this itself (entry point ``gymnasium.envs``), and would add the namespace.
    """
    from gymnasium.envs import registration

    if registration.current_namespace is not None:
        return
    for name in NAMES:
        known = f"crazychoir/{name}-v0"
        if known not in registration.registry:
            registration.register(
                id=known,
                entry_point=f"{_PLACE}.single_env:SingleEnv",
                vector_entry_point=f"{_PLACE}.vector_env:FlightVectorEnv",
                kwargs={"task": name},
            )


def register_as_plugin() -> None:
    """Register the names without their namespace, as Gymnasium's entry points do it up to version 1.3."""
    from gymnasium.envs import registration

    if registration.current_namespace is None:
        register()
        return
    for name in NAMES:
        registration.register(
            id=f"{name}-v0",
            entry_point=f"{_PLACE}.single_env:SingleEnv",
            vector_entry_point=f"{_PLACE}.vector_env:FlightVectorEnv",
            kwargs={"task": name},
        )
