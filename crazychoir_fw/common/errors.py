"""The errors of the package: one base, and beside it the built-in that a user would catch."""


class CrazychoirError(Exception):
    """Base of every error that this package raises on purpose; its text is one sentence for people."""

    def __str__(self) -> str:
        # KeyError would show the repr of its argument, with quotes around the sentence
        return str(self.args[0]) if self.args else ""


class RangeError(CrazychoirError, ValueError):
    """A value is outside its allowed range; the text names object, key, value and range."""


class UnknownNameError(CrazychoirError, KeyError):
    """Nothing is known under that name; the text suggests the nearest one."""


class StateError(CrazychoirError, RuntimeError):
    """The request is not possible in the present state, for instance a take-off of a locked drone."""


class MissingLibraryError(StateError, ImportError):
    """What was asked for needs a library that is not installed; the text has the command that installs it."""


class RadioError(CrazychoirError, ConnectionError):
    """A drone is not reached, or no longer, over the radio; the text names drone and URI."""


class MissionError(CrazychoirError, ValueError):
    """A mission file cannot be flown; the text names file, key, value and what is allowed."""


class CheckoutError(CrazychoirError):
    """There is no usable checkout of the firmware; the text names the folder and the command that repairs it."""


class BuildError(CrazychoirError):
    """A provider library could not be built."""


class CompileError(BuildError):
    """Sources do not compile; the text is what the compiler printed, after one line that counts the files."""


class LinkError(BuildError):
    """Objects do not fit together; the text names the symbols and the objects that need them."""


class MessageError(CrazychoirError, ValueError):
    """Data is none that agents may send each other; the text says what is wrong with it."""
