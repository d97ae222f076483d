"""Loading the extension module of a checkout, each time with variables of its own."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

from crazychoir_fw.cffirmware.build import MODULE
from crazychoir_fw.common.errors import LinkError


def load(path: Path) -> tuple[Any, Any]:
    """Return ffi and functions of one more copy of a module.

    A copy of the file is another library for the dynamic loader, so that what its C keeps at file scope is not shared.

    Raises:
        LinkError: If the sources of the checkout leave symbols undefined.
    """
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        shutil.copyfile(path, copy)
        loader = importlib.machinery.ExtensionFileLoader(MODULE, str(copy))
        specification = importlib.util.spec_from_file_location(MODULE, copy, loader=loader)
        assert specification is not None
        try:
            module = importlib.util.module_from_spec(specification)
            loader.exec_module(module)
        except ImportError as error:
            if symbol := re.search(r"undefined symbol: (\w+)", str(error)):
                raise LinkError(f"undefined symbol {symbol[1]}, needed by sources of the checkout") from None
            raise
    return module.ffi, module.lib
