"""HTTP requests of `crazychoir press` to a page of `crazychoir gui`."""

import http.client
import json
import urllib.error
import urllib.request
import uuid
from typing import Any

import typer

from crazychoir_fw.cli.console import BAD_INPUT, complain

_PATIENCE_S = 35.0


def answer_to(command: dict[str, Any], address: str, headers: dict[str, str]) -> str:
    """Return the sentence that the page answers a command with; exits if the page refuses, or there is none."""
    body = json.dumps({"id": uuid.uuid4().hex, "command": command}).encode()
    request = urllib.request.Request(f"{address.rstrip('/')}/api/command", body, headers)
    try:
        with urllib.request.urlopen(request, timeout=_PATIENCE_S) as response:
            answer = _text_of(response.read())
    except urllib.error.HTTPError as error:
        body = error.read()
        refusal = _text_of(body)
        if error.headers.get_content_type() == "text/plain":  # a client without access gets the reason as plain text
            refusal = body.decode(errors="replace").strip()[:300]
        complain(refusal or f"what answers at {address} is no page of crazychoir gui: status {error.code}")
        raise typer.Exit(1 if refusal else BAD_INPUT) from None
    except (OSError, ValueError, http.client.HTTPException) as error:
        complain(f"there is no page at {address}: {_reason(error)}; start one with crazychoir gui MISSION.yaml")
        raise typer.Exit(BAD_INPUT) from None
    if answer is None:
        complain(f"what answers at {address} is no page of crazychoir gui")
        raise typer.Exit(BAD_INPUT)
    return answer


def _text_of(body: bytes) -> str | None:
    """Return the sentence of an answer; None if the answer has another format."""
    try:
        text = json.loads(body)["text"]
    except (ValueError, KeyError, TypeError):
        return None
    return text if isinstance(text, str) else None


def _reason(error: Exception) -> str:
    """Return in words why there was no answer."""
    inner = error.reason if isinstance(error, urllib.error.URLError) else error
    if isinstance(inner, ConnectionRefusedError):
        return "nobody listens there"
    if isinstance(inner, TimeoutError):
        return f"no answer within {_PATIENCE_S:g} s"
    return getattr(inner, "strerror", None) or str(inner)
