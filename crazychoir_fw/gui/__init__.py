"""The page: one flight in a thread of its own, and browsers that watch it, command it and draw for it.

`session.py` flies, `commands.py` says what may be asked of it, `server.py` serves the page and its endpoints.
"""
