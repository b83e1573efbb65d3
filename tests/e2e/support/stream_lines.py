"""Wrapper of stream_dump: the messages of a link as they arrive."""
import json
import subprocess
import threading
import time

HANG_LIMIT_S = 240


class StreamLines:
    def __init__(self, program, listen):
        self.messages = []
        self._process = subprocess.Popen([program, listen, str(HANG_LIMIT_S)], stdout=subprocess.PIPE, text=True)
        self.uri = self._process.stdout.readline().strip()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._process.stdout:
            self.messages.append(json.loads(line))

    def wait_for(self, what, wanted):
        """Returns the first message, past or future, for which wanted(message) is true."""
        end, seen = time.monotonic() + HANG_LIMIT_S, 0
        while time.monotonic() < end:
            while seen < len(self.messages):
                if wanted(self.messages[seen]):
                    return self.messages[seen]
                seen += 1
            time.sleep(0.001)
        raise AssertionError(f"waited in vain for {what}")

    def frame(self, epoch, sequence):
        return self.wait_for(f"frame {sequence} of {epoch}", lambda m: m["type"] == "PoseFrame" and
                             (m["epoch"], m["sequence"]) == (epoch, sequence))

    def end(self):
        """Waits for the goodbye of the stream and returns all messages."""
        assert self._process.wait(HANG_LIMIT_S) == 0
        self._reader.join()
        return self.messages
