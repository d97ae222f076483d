"""Signals that end what a program does."""

import signal

import pytest

from crazychoir_fw.common.signals import held_signals, unwind_at_signals


def test_a_held_signal_is_delivered_afterwards():
    done = []
    with pytest.raises(KeyboardInterrupt):
        with held_signals():
            signal.raise_signal(signal.SIGINT)
            done.append("all of it")
        done.append("nothing more")
    assert done == ["all of it"]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_an_end_passes_code_that_catches_sys_exit(number):
    with pytest.raises(SystemExit) as ended, unwind_at_signals():
        try:
            signal.raise_signal(number)
        except (Exception, SystemExit):
            pytest.fail("a user's sys.exit and a signal are not the same")
    assert ended.value.code == 128 + number
