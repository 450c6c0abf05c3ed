"""``mamo view --live`` in a process of its own, as a user runs and ends it."""

import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from mamo_core.cli.viewing import ViewOrder, run_view
from mamo_core.errors import InputError
from mamo_core.recording import write_recording

MAMO = [sys.executable, "-c", "from mamo_core.cli.main import main; main()", "view"]


def test_it_serves_this_machine_alone_until_interrupted(panda, tmp_path):
    write_recording(tmp_path / "kept.npz", panda)
    command = [*MAMO, str(tmp_path / "kept.npz"), "--live", "--port", "0"]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **streams) as served:
        try:
            lines = [served.stdout.readline() for _ in range(2)]
            address = re.fullmatch(r"http://127\.0\.0\.1:(\d+) shows the plan; .*\n", lines[1])
            assert address, lines
            port = int(address[1])
            with socket.create_connection(("127.0.0.1", port), timeout=30) as page:
                page.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
                assert page.recv(100).startswith(b"HTTP/1.1 200")
            with pytest.raises(OSError, match="refused"):
                socket.create_connection(("127.0.0.2", port), timeout=30)
        finally:
            served.send_signal(signal.SIGINT)
            rest, complaints = served.communicate(timeout=300)
    assert served.returncode == 130
    assert rest == ""
    assert complaints.splitlines()[-1] == "interrupted"


@pytest.mark.parametrize(
    ("order", "as_json", "message"),
    [
        ({}, False, "nothing to show: give one or more of"),
        ({"png": Path("x.png"), "port": 0}, False, "--port 0: only --live serves"),
        ({"live": True}, True, "--json: --live ends when interrupted"),
        ({"html": Path("absent/x.html")}, False, "absent/x.html: no such folder 'absent'"),
    ],
)
def test_what_makes_no_sense_is_refused(order, as_json, message):
    with pytest.raises(InputError, match=message):
        run_view(ViewOrder("plan.json", **order), as_json=as_json)
