"""The Debian package: built by its one command, and lived with on a machine of its own.

The machine is this one with a layer over its files that is thrown away, and systemd as its first
process.  Not shown: its watchdog, which would have to be waited for, and a real night.
"""

import json
import os
import shutil
import subprocess
from pathlib import Path

import cv2
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MACHINE = Path(__file__).with_name("machine.sh")
OWN_SPACES = ["unshare", "--mount", "--pid", "--net", "--uts", "--ipc", "--cgroup", "--fork"]
TRY = (
    "mount -t tmpfs tmpfs /mnt && mkdir /mnt/c && mount -t cgroup2 cgroup2 /mnt/c"
    " && mkdir /mnt/c/treadline-try && rmdir /mnt/c/treadline-try"
)


def why_no_machine():
    if os.geteuid() != 0:
        return "only root can lay a file system over this one"
    if not Path("/lib/systemd/systemd").exists():
        return "Debian's systemd is not here"
    tried = subprocess.run(
        [*OWN_SPACES, "bash", "-c", TRY], capture_output=True, check=False, timeout=30
    )
    return None if tried.returncode == 0 else "this machine lets nobody make another in it"


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    out = tmp_path_factory.mktemp("dist")
    environment = {**os.environ, "DEB_COMPRESSION": "1"}
    # With it nothing is compiled that should not be; whoever builds it has none.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    built = subprocess.run(
        [ROOT / "deploy/package", out],
        env=environment,
        capture_output=True,
        text=True,
        timeout=560,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    return next(out.glob("*.deb"))


def newer_than(package, folder):
    """Return a later version, of which only what dpkg asks for is there: unpacking takes long.

    The station in it says of everything that it was done.
    """
    tree = folder / "tree"
    tree.mkdir()
    subprocess.run(["dpkg-deb", "--control", package, tree / "DEBIAN"], check=True, timeout=240)
    control = tree / "DEBIAN" / "control"
    control.write_text(control.read_text().replace("Version: ", "Version: 9:"))
    for name in (tree / "DEBIAN" / "conffiles").read_text().split():
        (tree / name[1:]).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(next((ROOT / "deploy").rglob(Path(name).name)), tree / name[1:])
    for name in ("sysusers", "tmpfiles"):
        target = tree / f"usr/lib/{name}.d/treadline.conf"
        target.parent.mkdir(parents=True)
        shutil.copy(ROOT / f"deploy/debian/treadline.{name}", target)
    station = tree / "opt/treadline/bin/station"
    station.parent.mkdir(parents=True)
    station.symlink_to("/bin/true")
    newer = folder / "newer.deb"
    build = ["dpkg-deb", "--build", "--root-owner-group", tree, newer]
    subprocess.run(build, check=True, capture_output=True, timeout=240)
    return newer


@pytest.fixture(scope="module")
def life(package, tmp_path_factory):
    """What was seen in the package's life."""
    reason = why_no_machine()
    if reason is not None:
        pytest.skip(reason)
    folder, layer = tmp_path_factory.mktemp("life"), tmp_path_factory.mktemp("layer")
    newer = newer_than(package, folder)
    (folder / "older.deb").hardlink_to(package)
    shutil.copy(Path(__file__).with_name("package_life.py"), folder)
    (folder / "pictures").mkdir()
    cv2.imwrite(str(folder / "pictures" / "1.png"), np.full((64, 96), 40, np.uint8))
    command = [
        "/usr/bin/python3",
        "/life/package_life.py",
        "/life/older.deb",
        f"/life/{newer.name}",
    ]
    lived = subprocess.run(
        ["unshare", "--mount", "bash", MACHINE, layer, folder, *command],
        capture_output=True,
        text=True,
        timeout=560,
        check=False,
    )
    out = (folder / "out").read_text() if (folder / "out").exists() else ""
    assert lived.returncode == 0, lived.stdout + lived.stderr + out
    return json.loads(out.splitlines()[-1])


def test_one_command_builds_it(package):
    """First, and alone: building takes as long as the life of it."""
    assert package.name.startswith("treadline_")


def test_the_package_brings_its_user_and_folders(life):
    assert life["owner"] == "treadline"
    assert life["modes"] == {
        "/var/lib/treadline": "0o750",
        "/var/lib/treadline/backups": "0o750",
        "/etc/treadline/credentials": "0o711",
        "/etc/treadline/station.toml": "0o640",
    }
    assert "systemctl enable --now treadline" in life["installing"]


def test_nothing_in_it_points_to_where_it_was_built(life):
    assert life["shebangs"] == ["#!/opt/treadline/bin/python"]


def test_its_units_are_sound_and_give_little_away(life):
    assert life["verify"] == ""
    # 1.4 measured; 10 is a service without any bounds, and systemd calls below 2 safe enough.
    assert life["exposure"] <= 1.5


def test_the_station_in_it_records_as_systemd_starts_it(life):
    """As its user, in all the bounds of its unit, ready when systemd has heard so."""
    assert life["used"]["page"] == 200
    ((recorded, lost),) = [(each["recorded"], each["lost"]) for each in life["used"]["recordings"]]
    assert (recorded, lost) == (2, 0)


def test_it_is_stopped_in_order(life):
    assert life["ended"] == "success"
    told = [json.loads(line) for line in life["said"].splitlines() if line.startswith("{")]
    ends = [each["child"] for each in told if each["event"] == "stopped"]
    assert ends == ["api", "worker", "capture left"]
    assert told[-1]["event"] == "station stopped"


def test_the_key_of_a_credential_is_good_and_no_other_is_made(life):
    assert "first-admin-key" not in life["kept"]
    assert "admin key" not in life["said"]


def test_it_is_backed_up_at_night(life):
    assert life["timers"] == "active"
    assert len(life["nightly"]) == 1


def test_an_upgrade_whose_backup_fails_changes_nothing(life):
    assert life["unbacked"] != 0
    assert life["version"].endswith(" installed")
    assert not life["version"].startswith("9:")


def test_an_upgrade_leaves_a_way_back(life):
    assert Path(life["backup"]).name.startswith("before-9:")
    assert life["backup"] in life["upgrading"]
    assert "is the station's store now" in life["restored"]
    assert life["owner of store"] == "treadline"


def test_removing_it_leaves_settings_and_all_that_was_recorded(life):
    assert life["after_remove"] == {
        "/opt/treadline": False,
        "/etc/treadline": True,
        "/var/lib/treadline": True,
    }


def test_even_a_purge_leaves_what_was_recorded(life):
    assert life["after_purge"] == {
        "/opt/treadline": False,
        "/etc/treadline": False,
        "/var/lib/treadline": True,
    }
    assert {"station.sqlite", "backups"} <= set(life["kept"])
    assert "recordings and readings stay" in life["purging"]
