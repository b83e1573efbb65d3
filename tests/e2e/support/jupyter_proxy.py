"""A stand-in for jupyter-server-proxy behind a hub, by its documents and source: /user/NAME/proxy/PORT/PATH becomes /PATH of PORT.
The headers of the browser are passed on, Host and the offered extensions among them. The two sides of a WebSocket shake hands apart,
and an extension that the server accepts is an error, as in Tornado's client. One request a connection."""
import base64
import hashlib
import os
import re
import socket
import threading

from reverse_proxy import LocalProxy

MAGIC = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"


def read_head(connection):
    """Lines of a request or answer, and the bytes that came behind it; None: the other side has left."""
    data = b""
    while b"\r\n\r\n" not in data:
        more = connection.recv(1 << 16)
        if not more:
            return None, b""
        data += more
    head, _, rest = data.partition(b"\r\n\r\n")
    return head.decode("latin-1").split("\r\n"), rest


def fields_of(lines):
    return {name.strip().lower(): value.strip() for name, _, value in (line.partition(":") for line in lines[1:])}


class JupyterProxy(LocalProxy):
    PATH = re.compile(r"^(/user/[^/]+/proxy/(\d+))(/.*)$")

    def __init__(self):
        self.errors = []
        super().__init__()

    def _serve(self, client):
        try:
            with client:
                lines, rest = read_head(client)
                if lines is None:
                    return
                method, target, _ = lines[0].split(" ")
                prefix, port, path = self.PATH.match(target).groups()
                fields = fields_of(lines)
                passed = {name: value for name, value in fields.items() if name not in ("connection", "upgrade", "sec-websocket-key")}
                passed |= {"x-forwarded-context": prefix, "x-proxycontextpath": prefix, "x-forwarded-prefix": prefix}
                with socket.create_connection(("127.0.0.1", int(port))) as server:
                    if "sec-websocket-key" in fields:
                        self._relay(client, server, fields, passed, path, rest)
                    else:
                        self._send(server, f"{method} {path} HTTP/1.1", passed | {"connection": "close"})
                        self._pump(server, client)
        except OSError:  # one side has left
            pass

    @staticmethod
    def _send(connection, first, fields):
        connection.sendall("\r\n".join([first, *(f"{name}: {value}" for name, value in fields.items()), "", ""]).encode("latin-1"))

    def _relay(self, client, server, fields, passed, path, rest):
        key = base64.b64encode(os.urandom(16)).decode()
        self._send(server, f"GET {path} HTTP/1.1",
                   passed | {"connection": "Upgrade", "upgrade": "websocket", "sec-websocket-key": key, "sec-websocket-version": "13"})
        answer, behind = read_head(server)
        status = answer[0].split(" ")[1]
        if status != "101":
            self.errors.append(" ".join([*answer, behind.decode("latin-1")]))
            self._send(client, "HTTP/1.1 500 Internal Server Error", {"connection": "close"})
            return
        if "sec-websocket-extensions" in fields_of(answer):
            self.errors.append("unsupported extension")
            return
        accept = base64.b64encode(hashlib.sha1(fields["sec-websocket-key"].encode() + MAGIC).digest()).decode()
        self._send(client, "HTTP/1.1 101 Switching Protocols",
                   {"upgrade": "websocket", "connection": "Upgrade", "sec-websocket-accept": accept})
        client.sendall(behind)
        server.sendall(rest)
        back = threading.Thread(target=self._pump, args=(server, client), daemon=True)
        back.start()
        self._pump(client, server)
        back.join()

    @staticmethod
    def _pump(source, sink):
        try:
            while data := source.recv(1 << 16):
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
