"""A drop-in for `cffirmware`, the Python module that Bitcraze builds from the firmware with SWIG.

    import crazychoir_fw.cffirmware as firm

The names are those of upstream's module, over our own implementation or, with CRAZYCHOIR_PROVIDER=bitcraze in the
environment or by ``over("bitcraze")``, over a checkout of the firmware. ``firm.provider`` says which.
docs/cffirmware.md is the manual.

| module | what it knows |
|---|---|
| `selection` | providers and platforms |
| `assembly` | all names over one provider |
| `structs`, `struct_base`, `members`, `arrays`, `vector_protocol` | C structs as Python classes |
| `function_table`, `functions` | C functions as Python functions |
| `additions`, `signatures`, `high_level_commander` | what is written in Python |
| `build`, `loading` | the extension module over a checkout |
| `shim` | the plain name `cffirmware` |
"""

from importlib.util import find_spec
from typing import Any

from crazychoir_fw.cffirmware.selection import chosen
from crazychoir_fw.cffirmware.selection import over as over


def __getattr__(name: str) -> Any:
    """Choose the provider when the first of its names is asked for, and keep all of them."""
    # the import system asks for submodules, too
    if (name.startswith("__") and name != "__all__") or find_spec(f"{__name__}.{name}") is not None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    firm = chosen()
    globals().update({known: getattr(firm, known) for known in firm.__all__}, __all__=["over", *firm.__all__])
    if name not in globals():
        raise AttributeError(f"module {__name__!r} over provider {firm.provider} has no attribute {name!r}")
    return globals()[name]


def __dir__() -> list[str]:
    return sorted({*globals(), *__getattr__("__all__")})
