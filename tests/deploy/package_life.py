"""The life of the package on a machine: installed, started, used, upgraded, gone back on, removed.

Runs inside the namespace that test_package.py makes, with Debian's Python and nothing else, and
prints what it saw as one JSON document.
"""

import ctypes
import json
import os
import pwd
import re
import shlex
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

HOME, DATA, CONFIG = Path("/opt/treadline"), Path("/var/lib/treadline"), Path("/etc/treadline")
CAMERA = "127.52.0.2"
PR_SET_MDWE, MDWE_REFUSE_EXEC_GAIN = 65, 1
SETTINGS = f"""
data_dir = "{DATA}"
port = 0
[[sensors]]
id = "left"
address = "{CAMERA}"
trigger = "software"
"""


def run(*command, check=True, **more):
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, **more)
    if check and done.returncode != 0:
        raise SystemExit(f"{shlex.join(command)}: {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def as_station(*arguments, **more):
    return run("runuser", "-u", "treadline", "--", "station", *arguments, **more)


def unit_says(unit, name):
    text = Path("/lib/systemd/system", unit).read_text()
    return [line.partition("=")[2] for line in text.splitlines() if line.startswith(f"{name}=")]


class Service:
    """`ExecStart` of the unit, as its user, hardened as far as a namespace lets one."""

    def __init__(self):
        self.path = "/run/notify"
        self.listening = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.listening.bind(self.path)
        os.chmod(self.path, 0o777)
        self.listening.settimeout(60.0)
        user = pwd.getpwnam("treadline")
        environment = {"PATH": "/usr/bin:/bin", "NOTIFY_SOCKET": self.path, "LANG": "C.UTF-8",
                       "WATCHDOG_USEC": "3000000"}  # fmt: skip
        self.process = subprocess.Popen(
            shlex.split(unit_says("treadline.service", "ExecStart")[0]),
            env=environment,
            cwd="/",
            user=user.pw_uid,
            group=user.pw_gid,
            umask=0o027,
            stdout=subprocess.PIPE,
            stderr=open("/run/station.log", "a"),  # noqa: SIM115  the process's until its end
            text=True,
            preexec_fn=forbid_writable_code,  # before the exec, as systemd does it
        )
        self.told = []

    def await_told(self, line):
        while line not in self.told:
            self.told += self.listening.recv(4096).decode().splitlines()

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        self.await_told("STOPPING=1")
        code = self.process.wait(60)
        self.listening.close()
        Path(self.path).unlink()
        return code


def forbid_writable_code():
    """`MemoryDenyWriteExecute=yes`."""
    ctypes.CDLL(None).prctl(PR_SET_MDWE, MDWE_REFUSE_EXEC_GAIN, 0, 0, 0)


USE = """
import json, sys
from station.client import StationClient
with StationClient.connect(sys.argv[1], sys.argv[2]) as station:
    station.arm_pass("first")
    ended = station.finish_pass("first", triggers={"left": 0}, axles=0)
    print(json.dumps([recording["sensor"] for recording in ended["recordings"]]))
"""


def use(service):
    """Have a pass recorded over the network, with the first key."""
    service.await_told("READY=1")
    url = next(each.split()[2].rstrip(";") for each in statuses(service))
    for _ in range(300):
        ready = run("curl", "--silent", f"{url}/readyz", check=False).stdout
        if ready and json.loads(ready)["parts"].get("capture left") == "ready":
            break
        time.sleep(0.1)
    key = (DATA / "first-admin-key").read_text().strip()
    page = run("curl", "--silent", "--write-out", "%{http_code}", "--output", "/dev/null",
               f"{url}/login").stdout  # fmt: skip
    used = run(str(HOME / "bin/python"), "-c", USE, url, key)
    return {"page": page, "sensors": json.loads(used.stdout)}


def statuses(service):
    while not any(line.startswith("STATUS=") for line in service.told):
        service.told += service.listening.recv(4096).decode().splitlines()
    return [line for line in service.told if line.startswith("STATUS=")]


def shebangs(folder):
    """Return the programs that the scripts of a folder are run by."""
    files = [path for path in folder.iterdir() if not path.is_symlink()]
    firsts = [path.read_bytes().split(b"\n", 1)[0] for path in files]
    return {line.decode() for line in firsts if line.startswith(b"#!")}


def main(package, newer):
    seen = {"installing": run("dpkg", "--install", package).stdout}
    seen["owner"] = pwd.getpwuid(DATA.stat().st_uid).pw_name
    seen["modes"] = {
        str(path): oct(path.stat().st_mode & 0o777)
        for path in (DATA, DATA / "backups", CONFIG / "credentials", CONFIG / "station.toml")
    }
    seen["shebangs"] = sorted(shebangs(HOME / "bin"))
    seen["example"] = as_station("config", "check", "--config", str(CONFIG / "station.toml")).stdout
    units = sorted(str(path) for path in Path("/lib/systemd/system").glob("treadline*"))
    verified = run("systemd-analyze", "verify", "--man=no", *units, check=False)
    seen["verify"] = verified.stdout + verified.stderr
    secure = run("systemd-analyze", "security", "--offline=true", units[-1], check=False)
    seen["exposure"] = float(re.search(r"exposure level for \S+: ([\d.]+)", secure.stdout)[1])
    (CONFIG / "station.toml").write_text(SETTINGS)
    camera = subprocess.Popen(
        ["station", "camera", "simulate", "--address", CAMERA, "--pictures", "/run/pictures"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    service = Service()
    seen["used"] = use(service)
    service.await_told("WATCHDOG=1")
    seen["ended"] = service.end()
    camera.terminate()
    seen["upgrading"] = run("dpkg", "--install", newer).stdout
    backups = list((DATA / "backups").glob("before-*.backup"))
    seen["backups"] = [path.name for path in backups]
    seen["back"] = run("dpkg", "--install", package).stdout
    seen["restored"] = as_station(
        "restore", str(backups[0]), "--config", str(CONFIG / "station.toml")
    ).stdout
    run("dpkg", "--remove", "treadline")
    seen["after_remove"] = {str(path): path.exists() for path in (HOME, CONFIG, DATA)}
    seen["purging"] = run("dpkg", "--purge", "treadline").stdout
    seen["after_purge"] = {str(path): path.exists() for path in (HOME, CONFIG, DATA)}
    seen["kept"] = sorted(path.name for path in DATA.iterdir())
    print(json.dumps(seen))


if __name__ == "__main__":
    main(*sys.argv[1:])
