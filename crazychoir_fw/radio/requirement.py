"""The radio layer is cflib's; a missing cflib is answered with the command that installs it."""

from crazychoir_fw.common.errors import MissingLibraryError

try:
    import cflib  # noqa: F401
except ImportError as error:
    raise MissingLibraryError(
        "the radio layer needs cflib, 0.1.32 or newer: run pip install 'crazychoir-fw[radio]'"
    ) from error
