"""The life of the package on a machine: installed, started, used, upgraded, gone back on, removed.

Runs on the machine that test_package.py makes, with Debian's Python and nothing else, and prints
what it saw as one JSON document.
"""

import json
import os
import pwd
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

HOME, DATA, CONFIG = Path("/opt/treadline"), Path("/var/lib/treadline"), Path("/etc/treadline")
STATION = "treadline.service"
CAMERA = "127.52.0.2"
ADMIN_KEY = "of the credential, longer than thirty-two letters"
SETTINGS = f"""
data_dir = "{DATA}"
port = 8080
[storage]
keep_free_gb = 0.1
[[sensors]]
id = "left"
address = "{CAMERA}"
trigger = "software"
"""


def run(*command, check=True, **more):
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False, **more)
    if check and done.returncode != 0:
        said = f"{done.stdout}{done.stderr}{journal('treadline*')}"
        raise SystemExit(f"{shlex.join(command)}: {done.returncode}\n{said}")
    return done


def systemctl(*arguments, **more):
    return run("systemctl", *arguments, **more).stdout.strip()


def journal(unit):
    command = ("journalctl", "--no-pager", "--output", "cat", "--unit", unit)
    return run(*command, check=False).stdout


USE = """
import json, sys, httpx
with httpx.Client(base_url=sys.argv[1], headers={"Authorization": f"Bearer {sys.argv[2]}"}) as call:
    place = "/v1/calibration-sessions/first"
    call.put(place, json={"sensor": "left", "target": "dots:7x8:12"}).raise_for_status()
    for _ in range(2):
        call.post(f"{place}/capture").raise_for_status()
    ended = call.post(f"{place}/finish").raise_for_status().json()
    print(json.dumps({"page": call.get("/login").status_code, "recordings": ended["recordings"]}))
"""


def use():
    """Have frames recorded by the station that systemd has started, with the key it was given."""
    url = systemctl("show", "--property", "StatusText", "--value", STATION).split()[2].rstrip(";")
    deadline_s = time.monotonic() + 60.0
    ready = {}
    while ready.get("capture left") != "ready" and time.monotonic() < deadline_s:
        time.sleep(0.1)
        ready = json.loads(run("curl", "--silent", f"{url}/readyz").stdout)["parts"]
    return json.loads(run(str(HOME / "bin/python"), "-c", USE, url, ADMIN_KEY).stdout)


def shebangs(folder):
    """Return the programs that the scripts of a folder are run by."""
    files = [path for path in folder.iterdir() if not path.is_symlink()]
    firsts = [path.read_bytes().split(b"\n", 1)[0] for path in files]
    return {line.decode() for line in firsts if line.startswith(b"#!")}


def installed(package):
    """What is there once it is installed."""
    seen = {"installing": run("dpkg", "--install", package).stdout}
    seen["owner"] = pwd.getpwuid(DATA.stat().st_uid).pw_name
    seen["modes"] = {
        str(path): oct(path.stat().st_mode & 0o777)
        for path in (DATA, DATA / "backups", CONFIG / "credentials", CONFIG / "station.toml")
    }
    seen["shebangs"] = sorted(shebangs(HOME / "bin"))
    units = sorted(str(path) for path in Path("/lib/systemd/system").glob("treadline*"))
    verified = run("systemd-analyze", "verify", "--man=no", *units, check=False)
    seen["verify"] = verified.stdout + verified.stderr
    secure = run("systemd-analyze", "security", "--offline=true", units[-1], check=False)
    seen["exposure"] = float(re.search(r"exposure level for \S+: ([\d.]+)", secure.stdout)[1])
    return seen


def served():
    """What the station does as systemd starts, backs up and stops it."""
    (CONFIG / "station.toml").write_text(SETTINGS)
    secret = CONFIG / "credentials" / "admin_key"
    secret.touch(mode=0o600)
    secret.write_text(ADMIN_KEY)
    simulated = ["station", "camera", "simulate", "--address", CAMERA, "--pictures"]
    camera = subprocess.Popen([*simulated, "/life/pictures"], stdout=subprocess.DEVNULL)
    systemctl("enable", "--now", STATION, "treadline-backup.timer")
    seen = {"used": use()}
    seen["timers"] = systemctl("is-active", "treadline-backup.timer")
    systemctl("start", "treadline-backup.service")
    seen["nightly"] = [path.name for path in (DATA / "backups").glob("store-*.backup")]
    systemctl("stop", STATION)
    seen["ended"] = systemctl("show", "--property", "Result", "--value", STATION)
    seen["said"] = journal(STATION)
    camera.terminate()
    return seen


def upgraded(package, newer):
    """What an upgrade does, one that cannot be backed up before, and the way back."""
    (CONFIG / "station.toml").write_text("data_dir = [")
    seen = {"unbacked": run("dpkg", "--install", newer, check=False).returncode}
    query = ("dpkg-query", "--show", "--showformat", "${Version} ${db:Status-Status}")
    seen["version"] = run(*query, "treadline").stdout
    (CONFIG / "station.toml").write_text(SETTINGS)
    seen["upgrading"] = run("dpkg", "--install", newer).stdout
    (backup,) = (DATA / "backups").glob("before-*.backup")
    seen["backup"] = str(backup)
    run("dpkg", "--install", package)
    # As the upgrade says it, by root, who types it.
    (command,) = re.findall(r"station restore .*", seen["upgrading"])
    seen["restored"] = run(*shlex.split(command)).stdout
    seen["owner of store"] = (DATA / "station.sqlite").owner()
    return seen


def removed():
    """What is left."""
    run("dpkg", "--remove", "treadline")
    places = (HOME, CONFIG, DATA)
    seen = {"after_remove": {str(path): path.exists() for path in places}}
    seen["purging"] = run("dpkg", "--purge", "treadline").stdout
    seen["after_purge"] = {str(path): path.exists() for path in places}
    seen["kept"] = sorted(path.name for path in DATA.iterdir())
    return seen


def main(package, newer):
    os.environ.setdefault("LANG", "C.UTF-8")
    seen = installed(package) | served() | upgraded(package, newer) | removed()
    print(json.dumps(seen))


if __name__ == "__main__":
    main(*sys.argv[1:])
