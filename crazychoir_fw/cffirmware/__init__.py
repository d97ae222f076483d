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

from crazychoir_fw.cffirmware import selection as _selection
from crazychoir_fw.cffirmware.selection import over

_chosen = _selection.chosen()
globals().update({_name: getattr(_chosen, _name) for _name in _chosen.__all__})

__all__ = ["over", *_chosen.__all__]
