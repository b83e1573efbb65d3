"""Child process that ends with its parent, even if the parent is killed."""
import collections
import os
import shutil
import signal
import subprocess
import threading
from typing import Any, Deque, IO, List, Mapping, Optional, Sequence

KEPT_LINES = 200
STOP_S = 10.0  # between SIGTERM and SIGKILL

# The shell becomes the program, so that both have one process id. Its guard waits for the end of a pipe whose other end
# this process holds: when this process dies, it ends the program. A guard, and not PR_SET_PDEATHSIG, which ends the
# program with the thread that started it. It removes the program's folder, too, which nobody else would.
_GUARDED = """
folder=$1
shift
exec 3<&0 </dev/null
{ exec <&3 3<&- >/dev/null 2>&1
  read -r word
  kill -TERM $$
  tenths=0
  while [ $tenths -lt 50 ]; do kill -0 $$ || break; sleep 0.1; tenths=$((tenths + 1)); done
  [ -z "$folder" ] || rm -rf -- "$folder"
  kill -KILL -$$
} &
exec "$@" 3<&-
"""


def _read(output: IO[str], lines: Deque[str], condition: threading.Condition, log: Optional[Any]) -> None:
    """Thread: keeps the last lines, so that the child never blocks on a full pipe. Copies them to log."""
    with output:
        for line in output:
            with condition:
                lines.append(line.rstrip("\n"))
                condition.notify_all()
            if log is not None:
                try:
                    log.write(line)
                    log.flush()
                except Exception:  # a closed or full log must not stop the reading
                    log = None


class GuardedProcess:
    """Child process in a session of its own, so that Ctrl-C reaches this process only."""

    def __init__(self, command: Sequence[str], environment: Optional[Mapping[str, str]], log: Optional[Any],
                 folder: str = "") -> None:
        """folder: removed when the process ends with this one, and by stop(); "": none."""
        self._folder = folder
        self._owner = os.getpid()
        reading, self._guard = os.pipe()
        try:
            self._process = subprocess.Popen(
                ["/bin/sh", "-c", _GUARDED, "fire3dv", folder, *command], stdin=reading, stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, env=environment, text=True, errors="replace", start_new_session=True)
        except BaseException:
            os.close(self._guard)
            raise
        finally:
            os.close(reading)
        self._lines: Deque[str] = collections.deque(maxlen=KEPT_LINES)
        self._condition = threading.Condition()
        assert self._process.stdout is not None
        self._reader = threading.Thread(target=_read, daemon=True, name="fire3dv output",
                                        args=(self._process.stdout, self._lines, self._condition, log))
        self._reader.start()

    @property
    def pid(self) -> int:
        return self._process.pid

    def lines(self) -> List[str]:
        """Returns the last lines that the process has written, at most KEPT_LINES."""
        with self._condition:
            return list(self._lines)

    def wait_for_output(self, timeout_s: float) -> None:
        """Returns after more output, the end of the process, or timeout_s."""
        with self._condition:
            self._condition.wait(timeout_s)

    def exit_status(self) -> Optional[int]:
        """Returns None while the process runs, its exit status, or the negative number of its signal."""
        status = self._process.poll() if os.getpid() == self._owner else None
        if status is not None:
            self._end_group()
            self._reader.join(STOP_S)  # the last lines
        return status

    def stop(self) -> None:
        """Ends the process: SIGTERM, after STOP_S SIGKILL. May be called repeatedly. No effect in a forked child."""
        if os.getpid() != self._owner:
            return
        try:
            if self._process.poll() is None:
                self._process.terminate()
                try:
                    self._process.wait(STOP_S)
                except subprocess.TimeoutExpired:
                    pass
        finally:  # also after Ctrl-C
            if self._process.poll() is None:
                self._process.kill()
                self._process.wait()
            self._end_group()
            if self._folder:
                shutil.rmtree(self._folder, ignore_errors=True)
        self._reader.join(STOP_S)

    def _end_group(self) -> None:
        """Ends the guard, and children that the process has left. The guard keeps the group's number from reuse."""
        guard, self._guard = self._guard, -1
        if guard < 0:
            return
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except OSError:  # the guard was killed
            pass
        os.close(guard)
