"""Processes of a session, of which none may be left."""

from pathlib import Path


def of_session(number):
    """Return the processes of a session that run: number and command line of each."""
    found = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            state, _, _, session = (entry / "stat").read_text().rpartition(")")[2].split()[:4]
            command = (entry / "cmdline").read_bytes()[:200]
        except OSError:
            continue
        if int(session) == number and state != "Z":
            found[int(entry.name)] = command
    return found
