"""The Debian package: built by its one command, and lived with in a namespace of its own.

The namespace is this machine with a layer over its files that is thrown away.  Not shown: that
systemd itself starts the units (there is none here to ask), only what it would be told by them.
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
LAYER = """
mount -t tmpfs tmpfs "$1"
mkdir "$1"/upper "$1"/work "$1"/root
mount -t overlay overlay -o lowerdir=/,upperdir="$1"/upper,workdir="$1"/work "$1"/root
mount -t proc proc "$1"/root/proc
mount --bind /dev "$1"/root/dev
mount -t tmpfs tmpfs "$1"/root/tmp
mount -t tmpfs tmpfs "$1"/root/run
chmod 1777 "$1"/root/tmp
cp -r "$2"/. "$1"/root/run/
exec chroot "$1"/root /usr/bin/python3 /run/package_life.py /run/older.deb /run/newer.deb
"""


def why_no_layer():
    if os.geteuid() != 0:
        return "only root can lay a file system over this one"
    tried = subprocess.run(
        ["unshare", "--mount", "--pid", "--fork", "mount", "-t", "tmpfs", "tmpfs", "/mnt"],
        capture_output=True,
        check=False,
        timeout=30,
    )
    return None if tried.returncode == 0 else "this machine lets nobody make a namespace"


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    out = tmp_path_factory.mktemp("dist")
    built = subprocess.run(
        [ROOT / "deploy/package", out],
        env={**os.environ, "DEB_COMPRESSION": "1"},
        capture_output=True,
        text=True,
        timeout=280,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    return next(out.glob("*.deb"))


def newer_than(package, folder):
    """Return a later version, of which only what dpkg asks for is there: unpacking takes long."""
    tree = folder / "tree"
    tree.mkdir()
    subprocess.run(["dpkg-deb", "--control", package, tree / "DEBIAN"], check=True, timeout=60)
    control = tree / "DEBIAN" / "control"
    control.write_text(control.read_text().replace("Version: ", "Version: 9:"))
    for name in (tree / "DEBIAN" / "conffiles").read_text().split():
        (tree / name[1:]).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(next((ROOT / "deploy").rglob(Path(name).name)), tree / name[1:])
    for name in ("sysusers", "tmpfiles"):
        target = tree / f"usr/lib/{name}.d/treadline.conf"
        target.parent.mkdir(parents=True)
        shutil.copy(ROOT / f"deploy/debian/treadline.{name}", target)
    newer = folder / "newer.deb"
    build = ["dpkg-deb", "--build", "--root-owner-group", tree, newer]
    subprocess.run(build, check=True, capture_output=True, timeout=60)
    return newer


@pytest.fixture(scope="module")
def life(package, tmp_path_factory):
    """What was seen in the package's life."""
    reason = why_no_layer()
    if reason is not None:
        pytest.skip(reason)
    given, layer = tmp_path_factory.mktemp("given"), tmp_path_factory.mktemp("layer")
    shutil.copy(package, given / "older.deb")
    newer_than(package, given)
    shutil.copy(Path(__file__).with_name("package_life.py"), given)
    (given / "pictures").mkdir()
    cv2.imwrite(str(given / "pictures" / "1.png"), np.full((64, 96), 40, np.uint8))
    lived = subprocess.run(
        ["unshare", "--mount", "--pid", "--fork", "bash", "-euc", LAYER, "layer", layer, given],
        capture_output=True,
        text=True,
        timeout=280,
        check=False,
    )
    assert lived.returncode == 0, lived.stdout + lived.stderr
    return json.loads(lived.stdout.splitlines()[-1])


def test_the_package_brings_its_user_and_folders(life):
    assert life["owner"] == "treadline"
    assert life["modes"] == {
        "/var/lib/treadline": "0o750",
        "/var/lib/treadline/backups": "0o750",
        "/etc/treadline/credentials": "0o700",
        "/etc/treadline/station.toml": "0o640",
    }
    assert "systemctl enable --now treadline" in life["installing"]
    assert "fit to start a station" in life["example"]


def test_nothing_in_it_points_to_where_it_was_built(life):
    assert life["shebangs"] == ["#!/opt/treadline/bin/python"]


def test_its_units_are_sound_and_give_little_away(life):
    assert life["verify"] == ""
    # 1.4 measured; 10 is a service without any bounds, and systemd calls below 2 safe enough.
    assert life["exposure"] <= 1.5


def test_the_station_in_it_records_as_the_unit_starts_it(life):
    """As its user, no memory both writable and executable, telling that it is ready and alive."""
    assert life["used"]["page"] == "200"
    assert life["used"]["sensors"] == ["left"]
    assert life["ended"] == 0


def test_an_upgrade_leaves_a_way_back(life):
    assert len(life["backups"]) == 1
    assert life["backups"][0].startswith("before-9:")
    assert "is the station's store now" in life["restored"]


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
