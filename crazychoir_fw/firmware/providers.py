"""The word of a provider, as worlds and missions say it, to its number in the core."""

from __future__ import annotations

import threading
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path

from crazychoir_fw.common.errors import UnknownNameError
from crazychoir_fw.firmware.build import Progress, build_provider
from crazychoir_fw.firmware.checkout import locate
from crazychoir_fw.firmware.levels import BITCRAZE, level_of

BUILTIN = "builtin"

_lock = threading.Lock()


def load(word: str, platform: str, checkout: Path | None = None, progress: Progress | None = None) -> int:
    """Return the number of the provider that a word means, built and loaded if need be.

    ``bitcraze`` is the firmware's checkout as it is at this moment, unless a library of that name was loaded by hand;
    ``bitcraze:modules``, ``bitcraze:stabilizer`` and ``bitcraze:all`` fly more of it (levels.py).
    Looking takes a fraction of a second, therefore ask once per flight and platform, not once per drone.

    Args:
        word: ``builtin``, ``bitcraze``, perhaps with a level, or the name of a loaded library.
        platform: Airframe, ``cf2`` or ``cf21bl``.
        checkout: Folder of the checkout; otherwise see `checkout.locate`.
        progress: Told how far a build is.

    Raises:
        UnknownNameError: If nothing is known under that word.
        CheckoutError: If there is no usable checkout.
        BuildError: If it does not build.
    """
    from crazychoir_fw.onboard import core

    if word == BUILTIN:
        return 0
    with _lock:
        loaded = core.find_provider(word, platform)
        if loaded is not None and not core.follows_checkout(loaded):
            return loaded
        level = level_of(word)
        if level is not None:
            library = build_provider(locate(checkout), platform, level=level, progress=progress)
            # under the word that was asked for: which level became of `all` is in its identity
            return core.load_library(replace(library, name=word), follows_checkout=True)
    known = sorted({BUILTIN, BITCRAZE, *core.providers()})
    near = get_close_matches(word[:64], known, n=1)
    hint = f" (did you mean '{near[0]}'?)" if near else ""
    raise UnknownNameError(f"no provider named '{word}' for {platform}, there are {', '.join(known)}{hint}")
