"""A station behind nginx, which reads deploy/proxy/nginx.conf as it is, but for its places."""

import contextlib
import json
import os
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import time
from pathlib import Path

import httpx

ROOT = Path(__file__).resolve().parents[2]
STATION = Path(sys.executable).with_name("station")
NGINX = shutil.which("nginx", path=f"{os.environ.get('PATH', '')}:/usr/sbin")
PATIENCE_S = 60.0
NAME = "station.example"
STATION_AT, PROXY_AT, CALLER_AT = "127.73.0.2", "127.73.0.3", "127.73.0.4"
SETTINGS = f"""
data_dir = "data"
host = "{STATION_AT}"
port = 0
[web]
proxies = ["{STATION_AT}", "127.0.0.1"]
upload_mb = 2
[storage]
keep_free_gb = 0.1
[[sensors]]
id = "left"
address = "127.73.0.9"
"""
# What Debian's own /etc/nginx/nginx.conf puts around a site, with places of the test's.
AROUND = """
daemon off;
master_process off;
pid nginx.pid;
events {{}}
http {{
    sendfile on;
    tcp_nopush on;
    gzip on;
    access_log off;
    client_body_temp_path temporary;
    proxy_temp_path temporary;
    fastcgi_temp_path temporary;
    uwsgi_temp_path temporary;
    scgi_temp_path temporary;
    include {site};
}}
"""


@contextlib.contextmanager
def a_station(folder):
    """Run `station serve`; yield its port and the process id of its worker."""
    (folder / "station.toml").write_text(SETTINGS)
    with (
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as told,
        (folder / "log").open("w") as log,
    ):
        told.bind(str(folder / "notify"))
        told.settimeout(PATIENCE_S)
        clean = {k: v for k, v in os.environ.items() if not k.startswith("STATION_")}
        process = subprocess.Popen(
            [STATION, "serve", "--config", folder / "station.toml", "--json"],
            env=clean | {"NOTIFY_SOCKET": str(folder / "notify"), "TMPDIR": str(folder)},
            stdout=subprocess.DEVNULL,
            stderr=log,
        )
        try:
            line = ""
            while not line.startswith("STATUS=serving at "):
                line = told.recv(4096).decode()
            yield int(line.split()[2].rstrip(";").rpartition(":")[2]), _worker(folder / "log")
        finally:
            process.kill()  # its processes end with it; an end in order is no question of the proxy
            process.wait(PATIENCE_S)


def _worker(log):
    whole = log.read_text().rpartition("\n")[0].splitlines()  # a line may be on its way
    lines = [json.loads(line) for line in whole if line.startswith("{")]
    return next(each["pid"] for each in lines if each.get("child") == "worker")


def make_certificate(folder):
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
        + ["-nodes", "-days", "2", "-subj", f"/CN={NAME}", "-addext", f"subjectAltName=DNS:{NAME}"]
        + ["-keyout", folder / "station.key", "-out", folder / "station.pem"],
        check=True,
        capture_output=True,
    )


def free_ports(count):
    with contextlib.ExitStack() as held:
        sockets = [held.enter_context(socket.create_server((PROXY_AT, 0))) for _ in range(count)]
        return [each.getsockname()[1] for each in sockets]


class Proxy:
    """nginx as it would run on the station's host, and calls of it."""

    def __init__(self, folder, station_port):
        self.tls_port, self.plain_port = free_ports(2)
        make_certificate(folder)
        (folder / "temporary").mkdir()
        site = (ROOT / "deploy/proxy/nginx.conf").read_text()
        for place, of_the_test in {
            "/etc/ssl/treadline/": f"{folder}/",
            "listen [::]:": "#",
            "listen 443": f"listen {PROXY_AT}:{self.tls_port}",
            "listen 80": f"listen {PROXY_AT}:{self.plain_port}",
            "http://127.0.0.1:8080": f"http://{STATION_AT}:{station_port}",
        }.items():
            assert place in site
            site = site.replace(place, of_the_test)
        (folder / "site.conf").write_text(site)
        (folder / "nginx.conf").write_text(AROUND.format(site=folder / "site.conf"))
        self._log = folder / "error.log"
        self._trusting = ssl.create_default_context(cafile=folder / "station.pem")
        self._process = subprocess.Popen(
            [NGINX, "-p", folder, "-c", folder / "nginx.conf", "-e", self._log], cwd=folder
        )
        self._await_listening()

    def _await_listening(self):
        deadline_s = time.monotonic() + PATIENCE_S
        while True:
            with contextlib.suppress(ConnectionRefusedError):
                return socket.create_connection((PROXY_AT, self.plain_port)).close()
            assert self._process.poll() is None, self._log.read_text()
            assert time.monotonic() < deadline_s, "nginx does not listen"
            time.sleep(0.02)

    def client(self, key=None, host=NAME):
        """Return a client of the station by its name, as a machine beside it calls."""
        said = {} if key is None else {"Authorization": f"Bearer {key}"}
        client = httpx.Client(
            base_url=f"https://{PROXY_AT}:{self.tls_port}",
            headers={"Host": host} | said,
            transport=httpx.HTTPTransport(verify=self._trusting, local_address=CALLER_AT),
            timeout=PATIENCE_S,
        )
        # The certificate is of the name, not of the address that the test calls.
        client.event_hooks["request"] = [lambda r: r.extensions.update(sni_hostname=host)]
        return client

    def plainly(self, method, path, host=NAME):
        url = f"http://{PROXY_AT}:{self.plain_port}{path}"
        return httpx.request(method, url, headers={"Host": host}, trust_env=False)

    def close(self):
        self._process.send_signal(signal.SIGTERM)
        self._process.wait(PATIENCE_S)
