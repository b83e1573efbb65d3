"""A reverse proxy as web servers are configured: TLS ends here, the renderer is below a path. One request a connection."""
import re
import socket
import ssl
import threading


class LocalProxy:
    """Listens on this machine; a subclass serves each connection in _serve(connection), in a thread."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        self.listener.close()

    def _accept(self):
        while True:
            try:
                client, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(client,), daemon=True).start()


class ReverseProxy(LocalProxy):
    """Serves https://NAME:port/sim1/ for any NAME from `upstream`, "HOST:PORT"."""

    PATH = "/sim1"

    def __init__(self, certificate, key):
        self.upstream = None
        self.passes_host, self.passes_upgrade, self.strips_path = False, True, True
        self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self.context.load_cert_chain(certificate, key)
        super().__init__()

    def _serve(self, plain):
        try:
            with self.context.wrap_socket(plain, server_side=True) as client:
                head = b""
                while b"\r\n\r\n" not in head:
                    data = client.recv(1 << 16)
                    if not data:
                        return
                    head += data
                host, port = self.upstream.split(":")
                with socket.create_connection((host, int(port))) as server:
                    server.sendall(self._forwarded(head))
                    back = threading.Thread(target=self._pump, args=(server, client), daemon=True)
                    back.start()
                    self._pump(client, server)
                    back.join()
        except OSError:  # one side has left
            pass

    def _forwarded(self, head):
        lines = head.decode("latin-1").split("\r\n")
        method, target, version = lines[0].split(" ")
        if self.strips_path:
            target = re.sub(f"^{self.PATH}/?", "/", target)
        is_socket = any(line.lower().startswith("sec-websocket-key:") for line in lines)
        dropped = [] if self.passes_host else ["host"]
        if not (is_socket and self.passes_upgrade):
            dropped += ["connection", "upgrade"]
        fields = [line for line in lines[1:] if line.split(":")[0].lower() not in dropped]
        if not self.passes_host:
            fields.insert(0, f"Host: {self.upstream}")
        if "connection" in dropped:
            fields.insert(0, "Connection: close")
        return "\r\n".join([f"{method} {target} {version}", *fields]).encode("latin-1")

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
