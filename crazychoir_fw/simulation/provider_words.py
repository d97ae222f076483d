"""From the words by which drones ask for their providers to providers that are loaded."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from crazychoir_fw.onboard.core import platform_names
from crazychoir_fw.simulation.drone_config import DroneConfig

BUILTIN = "builtin"


def load_apps(drones: Sequence[DroneConfig]) -> Sequence[DroneConfig]:
    """Build and load the apps that drones carry; return the drones with what that decides about them.

    Raises:
        BuildError: If an app does not compile.
        CheckoutError: If there is no usable checkout for it.
        RangeError: If a drone asks for what its app does not bring.
    """
    if not any(drone.app for drone in drones):
        return drones
    # imported here, since only drones with apps need a compiler
    from crazychoir_fw.firmware.apps import carry

    return carry(drones)


def load_providers(words_and_platforms: Iterable[tuple[str, str]]) -> None:
    """Load every provider that drones ask for, as it is now: a checkout that has changed is built again.

    Args:
        words_and_platforms: Pairs such as ``("bitcraze", "cf21bl")``; pairs may repeat.

    Raises:
        UnknownNameError: If nothing is known under one of the words.
        CrazychoirError: If a provider cannot be built or loaded.
    """
    for word, platform in dict.fromkeys(words_and_platforms):
        # an unknown platform is refused by the builder of the world, which knows the drone's name
        if word != BUILTIN and platform in platform_names():
            # imported here, since only other providers need a compiler and a checkout
            from crazychoir_fw.firmware.providers import load

            load(word, platform)
