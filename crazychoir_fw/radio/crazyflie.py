"""cflib's Crazyflie, with an end of the link that neither hangs nor stops motors."""

from __future__ import annotations

import threading

from crazychoir_fw.common.errors import MissingLibraryError

try:
    from cflib.crazyflie import Crazyflie
except ImportError as error:
    raise MissingLibraryError(
        "the radio layer needs cflib, 0.1.32 or newer: run pip install 'crazychoir-fw[radio]'"
    ) from error


class LinkedCrazyflie(Crazyflie):
    """One connection to one drone. It is used once: a lost link needs a new object.

    It differs from its parent where a link ends (found by reading release 0.1.34):

    - Errors of a link are handled by a thread of their own. The parent handles them in whatever thread met them: when
      that is the one that pings, it waits for itself, `connection_lost` is never called, and the lock around
      `send_packet` stays taken, so that the next sender hangs.
    - `drop_link` closes without a last setpoint. The parent's `close_link` always sends zero thrust, which stops the
      motors of a drone that hovers by itself, and which keeps the next program from using the planner on board.
    """

    _is_broken = False

    def _link_error_cb(self, errmsg: str) -> None:
        if self._is_broken:  # every packet that is sent meanwhile meets the same error
            return
        self._is_broken = True
        threading.Thread(
            target=super()._link_error_cb, args=(errmsg,), name=f"radio-broken-{self.link_uri}", daemon=True
        ).start()

    def drop_link(self) -> None:
        """Close the link without sending anything; takes up to 1 s."""
        self._is_broken = True
        link, self.link = self.link, None
        if link is not None:
            link.close()
        self.close_link()
