"""Live view of a renderer (fire3dv --serve) inside a notebook."""
from __future__ import annotations

import html
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Union
from urllib.parse import urlsplit

from .errors import ArgumentError, ErrorCode

if TYPE_CHECKING:
    from .renderer import Renderer

FRAGMENT = re.compile(r"[0-9a-f]{32}(&(view|camera|node)=[\w.,%~!*'()-]*)*", re.ASCII)


@dataclass(frozen=True)
class LiveView:
    """A frame with the page of a live view. Notebooks show it as the value of a cell."""

    address: str = ""  #: of the page, without the token
    token: str = ""  #: and the camera and the selection, if the link has them
    height: int = 480

    def __repr__(self) -> str:  # without the token: texts of objects end up in logs
        return f"LiveView({self.address!r}, height={self.height})"

    def _repr_html_(self) -> str:
        source = html.escape(f"{self.address}?embed=1#{self.token}")
        return (f'<iframe src="{source}" width="100%" height="{self.height}" style="border: 0" '
                'referrerpolicy="no-referrer"></iframe>')


def show(view: Union[str, Renderer], height: int = 480) -> LiveView:
    """Shows a live view in a notebook.

    view: a Renderer that was started with serve=True, or a link that `fire3dv --serve` printed, or the address of its
    page, which has the camera and the selected node. A link through a proxy keeps its path, such as
    https://hub/user/me/proxy/8080/#TOKEN. height: pixels. Of a Renderer, its view link is shown, which looks only;
    show(renderer.control_link) operates it, too.

    The notebook must be open in a browser that reaches the link's address, and come from localhost itself or from the
    same host. A saved notebook contains the link: use the view link, and clear the output before handing it on.
    """
    link = view if isinstance(view, str) else getattr(view, "view_link", "")
    try:
        parts = urlsplit(link)
    except (AttributeError, TypeError, ValueError):  # no text, or an address that cannot be read
        parts = urlsplit("")
    if parts.scheme not in ("http", "https") or not parts.hostname or not FRAGMENT.fullmatch(parts.fragment):
        raise ArgumentError(ErrorCode.ARGUMENT, "show() needs a Renderer that was started with serve=True, or a link that "
                            "fire3dv --serve printed, such as http://127.0.0.1:8080/# with 32 digits")
    if not isinstance(height, int) or not 1 <= height <= 10000:
        raise ArgumentError(ErrorCode.ARGUMENT, f"height is {height!r}; it must be from 1 to 10000 pixels")
    return LiveView(f"{parts.scheme}://{parts.netloc}{parts.path or '/'}", parts.fragment, height)
