"""Actions of a window manager and a file manager through libX11: minimise, close, drop a file."""
import ctypes
import ctypes.util
import time
import urllib.parse

from image_reader import check

CLIENT_MESSAGE, SELECTION_NOTIFY, SELECTION_REQUEST = 33, 31, 30
REPLACE, CURRENT_TIME = 0, 0
NORMAL_STATE, ICONIC_STATE = 1, 3

Long, ULong, Int, Pointer = ctypes.c_long, ctypes.c_ulong, ctypes.c_int, ctypes.c_void_p


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", Int), ("serial", ULong), ("send_event", Int), ("display", Pointer), ("window", ULong),
                ("message_type", ULong), ("format", Int), ("data", Long * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [("type", Int), ("serial", ULong), ("send_event", Int), ("display", Pointer), ("owner", ULong),
                ("requestor", ULong), ("selection", ULong), ("target", ULong), ("property", ULong), ("time", ULong)]


class Selection(ctypes.Structure):
    _fields_ = [("type", Int), ("serial", ULong), ("send_event", Int), ("display", Pointer), ("requestor", ULong),
                ("selection", ULong), ("target", ULong), ("property", ULong), ("time", ULong)]


class Event(ctypes.Union):
    _fields_ = [("type", Int), ("client", ClientMessage), ("request", SelectionRequest), ("selection", Selection),
                ("padding", Long * 24)]


class X11:
    def __init__(self, display):
        self.x = ctypes.CDLL(ctypes.util.find_library("X11") or "libX11.so.6")
        self.x.XOpenDisplay.restype = Pointer
        self.x.XDefaultRootWindow.restype = self.x.XInternAtom.restype = self.x.XCreateSimpleWindow.restype = ULong
        self.display = Pointer(self.x.XOpenDisplay(display.encode()))
        check(self.display, f"no display {display}")
        self.root = ULong(self.x.XDefaultRootWindow(self.display))

    def end(self):
        self.x.XCloseDisplay(self.display)

    def atom(self, name):
        return self.x.XInternAtom(self.display, name.encode(), 0)

    def _send(self, window, message_type, data):
        event = Event()
        event.client = ClientMessage(CLIENT_MESSAGE, 0, 1, self.display, window, self.atom(message_type), 32,
                                     (Long * 5)(*data, *[0] * (5 - len(data))))
        self.x.XSendEvent(self.display, ULong(window), 0, Long(0), ctypes.byref(event))
        self.x.XFlush(self.display)

    def close(self, window):
        """Same as the close button of the window (WM_DELETE_WINDOW)."""
        self._send(window, "WM_PROTOCOLS", [self.atom("WM_DELETE_WINDOW"), CURRENT_TIME])

    def set_minimized(self, window, minimized):
        if minimized:
            self.x.XUnmapWindow(self.display, ULong(window))
        else:
            self.x.XMapWindow(self.display, ULong(window))
        state = (Long * 2)(ICONIC_STATE if minimized else NORMAL_STATE, 0)
        kind = ULong(self.atom("WM_STATE"))
        self.x.XChangeProperty(self.display, ULong(window), kind, kind, 32, REPLACE, state, 2)
        self.x.XFlush(self.display)

    def set_dpi(self, dpi):
        """Sets the resource that toolkits derive their scale from, as a desktop does."""
        name, string, text = (ULong(self.atom("RESOURCE_MANAGER")), ULong(self.atom("STRING")), f"Xft.dpi:\t{dpi}\n".encode())
        self.x.XChangeProperty(self.display, self.root, name, string, 8, REPLACE, text, len(text))
        self.x.XFlush(self.display)

    def drop(self, window, path, hang_s):
        """Drags a file onto the window and drops it there (XDND 5)."""
        source = self.x.XCreateSimpleWindow(self.display, self.root, 0, 0, 1, 1, 0, ULong(0), ULong(0))
        selection, uris = self.atom("XdndSelection"), self.atom("text/uri-list")
        self.x.XSetSelectionOwner(self.display, ULong(selection), ULong(source), ULong(CURRENT_TIME))
        self._send(window, "XdndEnter", [source, 5 << 24, uris])
        self._send(window, "XdndPosition", [source, 0, 20 << 16 | 20, CURRENT_TIME, self.atom("XdndActionCopy")])
        dropped, event, end = False, Event(), time.monotonic() + hang_s
        while time.monotonic() < end:
            if self.x.XPending(self.display) == 0:
                time.sleep(0.01)
                continue
            self.x.XNextEvent(self.display, ctypes.byref(event))
            if event.type == SELECTION_REQUEST:
                self._hand_over(event.request, f"file://{urllib.parse.quote(path)}\r\n".encode())
            elif event.type == CLIENT_MESSAGE and event.client.message_type == self.atom("XdndStatus") and not dropped:
                check(event.client.data[1] & 1, "the window takes no drop")
                self._send(window, "XdndDrop", [source, 0, CURRENT_TIME])
                dropped = True
            elif event.type == CLIENT_MESSAGE and event.client.message_type == self.atom("XdndFinished"):
                return
        check(False, f"the window did not take the drop within {hang_s} s")

    def _hand_over(self, wanted, data):
        self.x.XChangeProperty(self.display, ULong(wanted.requestor), ULong(wanted.property), ULong(wanted.target), 8,
                               REPLACE, data, len(data))
        event = Event()
        event.selection = Selection(SELECTION_NOTIFY, 0, 1, self.display, wanted.requestor, wanted.selection,
                                    wanted.target, wanted.property, wanted.time)
        self.x.XSendEvent(self.display, ULong(wanted.requestor), 0, Long(0), ctypes.byref(event))
        self.x.XFlush(self.display)
