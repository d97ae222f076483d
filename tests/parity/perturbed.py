"""A side that is wrong by a known amount from a known call on."""

import itertools

from crazychoir_fw.parity.side import Side


class PerturbedSide(Side):
    """The builtin provider, with one function whose output is changed."""

    def __init__(self, function, change, **options):
        """Wrap a function: after each call, `change(number of the call, arguments, result)` gives the result."""
        super().__init__(**options)
        original, calls = self.functions[function], itertools.count()

        def wrapped(*arguments):
            result = original(*arguments)
            return change(next(calls), arguments, result)

        self.functions[function] = wrapped
