"""What campaigns need beside the package."""

from crazychoir_fw.common.errors import MissingLibraryError


def require_library() -> None:
    """Refuse to begin without SciPy.

    Raises:
        MissingLibraryError: With the command that installs it.
    """
    try:
        import scipy  # noqa: F401
    except ImportError:
        raise MissingLibraryError("campaigns need SciPy: pip install 'crazychoir-fw[campaign]'") from None
