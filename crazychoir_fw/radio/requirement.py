"""The radio layer is cflib's; a missing cflib is answered with the command that installs it."""

try:
    import cflib  # noqa: F401
except ImportError as error:
    raise ImportError(
        "the radio layer needs cflib, 0.1.32 or newer: pip install 'crazychoir-fw[radio]'", name="cflib"
    ) from error
