"""Runs of isph as children of a process that has loaded its libraries, which takes most of a short run."""
import atexit
import os
import signal
import socket
import struct
import subprocess
import tempfile


class Starter:
    """A process of the program isph_starter; `how` are arguments of subprocess.Popen()."""

    def __init__(self, program, **how):
        self.program = os.path.abspath(program)
        self.socket, other = socket.socketpair()
        with other:
            self.process = subprocess.Popen([self.program, str(other.fileno())], stdin=subprocess.DEVNULL,
                                            pass_fds=[other.fileno()], **how)
        atexit.register(self.end)

    def end(self):
        self.socket.close()
        self.process.wait()

    def receive(self):
        """Returns the next number of the starter."""
        data = self.socket.recv(4, socket.MSG_WAITALL)
        assert len(data) == 4, f"{self.program} ended with status {self.process.wait()}"
        return struct.unpack("i", data)[0]

    def run(self, words, folder=".", environment=None, seconds=None):
        """Runs isph with the words; returns its status as subprocess does, standard output and standard error as bytes.

        The status is None after a timeout. `environment` holds what differs from the environment of the starter.
        """
        settings = [f"{name}={text}" for name, text in (environment or {}).items()]
        text = b"".join(os.fsencode(word) + b"\0" for word in [*settings, "", self.program, *words])
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            place = os.open(folder, os.O_RDONLY)
            socket.send_fds(self.socket, [struct.pack("i", len(text))], [place, out.fileno(), err.fileno()])
            os.close(place)
            self.socket.sendall(text)
            child = self.receive()
            self.socket.settimeout(seconds)
            late = False
            try:
                status = self.receive()
            except socket.timeout:
                late = True
                os.killpg(child, signal.SIGKILL)
                self.socket.settimeout(None)
                status = self.receive()
            self.socket.settimeout(None)
            out.seek(0)
            err.seek(0)
            return None if late else os.waitstatus_to_exitcode(status), out.read(), err.read()
