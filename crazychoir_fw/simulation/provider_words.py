"""From the word by which a drone asks for its provider to a provider that is loaded."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Iterable

from crazychoir_fw.core import find_provider, platform_names, providers
from crazychoir_fw.errors import UnknownNameError

_BUILDERS = "crazychoir_fw.firmware.providers"
"""The module that builds or finds a provider library by its word: ``load(word, platform)``."""


def load_providers(words_and_platforms: Iterable[tuple[str, str]]) -> None:
    """Load every provider that drones ask for and that is not loaded yet.

    Args:
        words_and_platforms: Pairs such as ``("bitcraze", "cf21bl")``; pairs may repeat.

    Raises:
        UnknownNameError: If a provider is neither loaded nor can be loaded by its word.
        CrazychoirError: If building or loading one fails.
    """
    for word, platform in dict.fromkeys(words_and_platforms):
        # an unknown platform is refused by the builder of the world, which knows the drone's name
        if platform in platform_names() and find_provider(word, platform) is None:
            _load(word, platform)


def _load(word: str, platform: str) -> None:
    # compilers and checkouts are for those who ask for them
    if importlib.util.find_spec(_BUILDERS.rpartition(".")[0]) and importlib.util.find_spec(_BUILDERS):
        importlib.import_module(_BUILDERS).load(word, platform)
    if find_provider(word, platform) is None:
        raise UnknownNameError(f"provider is '{word}', allowed: {', '.join(providers())}")
