"""From a checkout of the real firmware, or a user's own C, to a provider library that the core loads.

| module | what it knows |
|---|---|
| `checkout` | where the checkout is, whether it is complete, which version |
| `setup_lists` | the lists of its bindings/setup.py, read and never run |
| `configuration`, `kconfig` | the configuration header of a platform |
| `levels` | how much of a checkout flies |
| `own_sources` | our own C that becomes part of a library |
| `checkout_files` | which files of a checkout take part |
| `recipe` | everything that a build depends on, as plain data |
| `toolchain`, `objects`, `probes`, `linking` | compile, ask, link |
| `cache`, `library` | what is kept, and in which form |
| `build` | all of it in order |
| `providers` | the word of a provider to its number in the core |

Nothing is written into a checkout and nothing in it is executed, except by the drones that fly it.
"""
