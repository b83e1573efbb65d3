"""Client of the X display through libX11 and libXtst: windows, pixels, keys and mouse, and the actions of a window
manager and a file manager.

It runs in the test's own process: a test looks at the screen often, and a program for each look takes most of its time.
"""
import ctypes
import ctypes.util
import re
import time
import urllib.parse

from image_reader import check

CLIENT_MESSAGE, SELECTION_NOTIFY, SELECTION_REQUEST = 33, 31, 30
REPLACE, CURRENT_TIME = 0, 0
NORMAL_STATE, ICONIC_STATE = 1, 3
IS_VIEWABLE, Z_PIXMAP = 2, 2
KEY_NAMES = {"ctrl": "Control_L", "shift": "Shift_L", "alt": "Alt_L"}
PACE_S = 0.012  # between two events: a program reads no two of them as one

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


class WindowAttributes(ctypes.Structure):
    _fields_ = [("x", Int), ("y", Int), ("width", Int), ("height", Int), ("border_width", Int), ("depth", Int), ("visual", Pointer),
                ("root", ULong), ("window_class", Int), ("bit_gravity", Int), ("win_gravity", Int), ("backing_store", Int),
                ("backing_planes", ULong), ("backing_pixel", ULong), ("save_under", Int), ("colormap", ULong),
                ("map_installed", Int), ("map_state", Int), ("padding", Long * 8)]


class Image(ctypes.Structure):
    """The first members of an XImage."""
    _fields_ = [("width", Int), ("height", Int), ("xoffset", Int), ("format", Int), ("data", Pointer), ("byte_order", Int),
                ("bitmap_unit", Int), ("bitmap_bit_order", Int), ("bitmap_pad", Int), ("depth", Int), ("bytes_per_line", Int),
                ("bits_per_pixel", Int)]


# A window may close between two requests: the request fails, and the test goes on.
ignore_error = ctypes.CFUNCTYPE(Int, Pointer, Pointer)(lambda display, error: 0)


class X11:
    def __init__(self, display):
        self.x = ctypes.CDLL(ctypes.util.find_library("X11") or "libX11.so.6")
        self.test = ctypes.CDLL(ctypes.util.find_library("Xtst") or "libXtst.so.6")
        self.x.XOpenDisplay.restype = Pointer
        self.x.XDefaultRootWindow.restype = self.x.XInternAtom.restype = self.x.XCreateSimpleWindow.restype = ULong
        self.x.XStringToKeysym.restype = ULong
        self.x.XGetImage.restype = ctypes.POINTER(Image)
        self.x.XSetErrorHandler(ignore_error)
        self.display = Pointer(self.x.XOpenDisplay(display.encode()))
        check(self.display, f"no display {display}")
        self.root = ULong(self.x.XDefaultRootWindow(self.display))

    def windows(self, name):
        """Visible windows whose title matches the pattern."""
        root, parent, count = ULong(), ULong(), ctypes.c_uint()
        children = ctypes.POINTER(ULong)()
        self.x.XQueryTree(self.display, self.root, ctypes.byref(root), ctypes.byref(parent), ctypes.byref(children), ctypes.byref(count))
        found = [window for window in children[:count.value] if self.is_visible(window) and re.search(name, self.title(window))]
        if children:
            self.x.XFree(children)
        return found

    def title(self, window):
        text = ctypes.c_char_p()
        if not self.x.XFetchName(self.display, ULong(window), ctypes.byref(text)) or text.value is None:
            return ""
        title = text.value.decode(errors="replace")
        self.x.XFree(text)
        return title

    def is_visible(self, window):
        attributes = WindowAttributes()
        return bool(self.x.XGetWindowAttributes(self.display, ULong(window), ctypes.byref(attributes))) \
            and attributes.map_state == IS_VIEWABLE

    def area(self, window):
        """Position on the screen, width and height."""
        attributes, x, y, child = WindowAttributes(), Int(), Int(), ULong()
        check(self.x.XGetWindowAttributes(self.display, ULong(window), ctypes.byref(attributes)) and self.x.XTranslateCoordinates(
            self.display, ULong(window), self.root, 0, 0, ctypes.byref(x), ctypes.byref(y), ctypes.byref(child)), "the window is gone")
        return x.value, y.value, attributes.width, attributes.height

    def pixels(self, x, y, width, height):
        """Rows of the screen, 3 bytes a pixel: red, green, blue."""
        image = self.x.XGetImage(self.display, self.root, x, y, width, height, ULong(2**32 - 1), Z_PIXMAP)
        check(image, f"no screenshot of {width}x{height} at {x}, {y}")
        stride, bits = image.contents.bytes_per_line, image.contents.bits_per_pixel
        data = ctypes.string_at(image.contents.data, stride * height)
        self.x.XDestroyImage(image)
        check(bits == 32 and stride == 4 * width, f"the screen has {bits} bits a pixel")
        colors = bytearray(3 * width * height)
        for channel in range(3):
            colors[channel::3] = data[2 - channel::4]
        return [bytes(colors[3 * width * row:3 * width * (row + 1)]) for row in range(height)]

    def _sent(self):
        self.x.XSync(self.display, 0)
        time.sleep(PACE_S)

    def _key_code(self, name):
        symbol = self.x.XStringToKeysym(KEY_NAMES.get(name, name).encode())
        check(symbol, f"no key is called {name}")
        return self.x.XKeysymToKeycode(self.display, ULong(symbol))

    def key(self, name, pressed):
        self.test.XTestFakeKeyEvent(self.display, self._key_code(name), int(pressed), ULong(0))
        self._sent()

    def button(self, number, pressed):
        self.test.XTestFakeButtonEvent(self.display, number, int(pressed), ULong(0))
        self._sent()

    def move(self, window, x, y):
        left, top, _, _ = self.area(window)
        self.test.XTestFakeMotionEvent(self.display, -1, left + x, top + y, ULong(0))
        self._sent()

    def resize(self, window, width, height):
        self.x.XResizeWindow(self.display, ULong(window), width, height)
        self.x.XSync(self.display, 0)

    def place(self, window, x, y):
        self.x.XMoveWindow(self.display, ULong(window), x, y)
        self.x.XSync(self.display, 0)

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
