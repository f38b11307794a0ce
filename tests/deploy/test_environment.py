"""What the two commands do where apt or pip fail, with stand-ins for both, and on a second run.

A real installation from nothing is made by every first run on a new machine, not here.
"""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NEEDED = ("bash", "cat", "cut", "dirname", "env", "grep", "id", "mktemp", "rm", "sha256sum", "tail",
          "xargs", "echo")  # fmt: skip


@pytest.fixture
def checkout(tmp_path):
    """A checkout of the files the set-up reads, and a PATH with nothing but stand-ins."""
    checkout = tmp_path / "checkout"
    (checkout / "deploy").mkdir(parents=True)
    for name in ("pyproject.toml", "requirements.lock"):
        shutil.copy(ROOT / name, checkout / name)
    for name in ("environment.sh", "test.lock"):
        shutil.copy(ROOT / "deploy" / name, checkout / "deploy" / name)
    bin_folder = tmp_path / "bin"
    bin_folder.mkdir()
    for name in NEEDED:
        (bin_folder / name).symlink_to(shutil.which(name))
    return checkout


def stand_in(path, script):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)


def prepare(checkout, what="run"):
    path = checkout.parent / "bin"
    return subprocess.run(
        ["bash", "-euo", "pipefail", "-c", f". deploy/environment.sh; prepare_environment {what}"],
        cwd=checkout,
        env={"PATH": str(path), "HOME": os.environ.get("HOME", "/"), "TMPDIR": str(checkout)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def said(done):
    assert all(line.startswith("deploy: ") for line in done.stderr.splitlines()), done.stderr
    return done.stderr.splitlines()[-1]


def all_debian_packages_are_there(checkout):
    stand_in(checkout.parent / "bin" / "dpkg-query", "printf installed")


def test_apt_that_reaches_no_mirror_is_one_clear_line(checkout):
    stand_in(checkout.parent / "bin" / "dpkg-query", "exit 1")
    # As the real one does, it fails to fetch and still answers 0 to `update`.
    stand_in(
        checkout.parent / "bin" / "apt-get",
        'echo "Err:1 http://deb.debian.org bookworm"; [ "$1" = update ]',
    )
    stand_in(checkout.parent / "bin" / "sudo", '"$@"')
    done = prepare(checkout)
    assert done.returncode == 2
    assert "apt could not install python3-venv" in said(done)
    assert "Err:1 http://deb.debian.org" in said(done)
    assert "check the network" in said(done)


def test_user_who_may_not_install_is_told_what_root_must_type(checkout):
    stand_in(checkout.parent / "bin" / "dpkg-query", "exit 1")
    stand_in(checkout.parent / "bin" / "apt-get", "exit 1")
    (checkout.parent / "bin" / "id").unlink()
    stand_in(checkout.parent / "bin" / "id", "echo 1000")
    done = prepare(checkout)
    assert done.returncode == 2
    assert "run as root once: apt-get install python3-venv python3-gi" in said(done)


def test_only_the_tests_need_a_database_server(checkout):
    absent = 'case "$*" in *postgresql) exit 1;; *) printf installed;; esac'
    stand_in(checkout.parent / "bin" / "dpkg-query", absent)
    stand_in(checkout / ".venv" / "bin" / "python", "")
    assert prepare(checkout, "run").returncode == 0
    (checkout.parent / "bin" / "id").unlink()
    stand_in(checkout.parent / "bin" / "id", "echo 1000")
    stand_in(checkout.parent / "bin" / "apt-get", "exit 1")
    done = prepare(checkout, "test")
    assert done.returncode == 2
    assert said(done).endswith("run as root once: apt-get install postgresql")


def test_pip_that_reaches_no_index_is_one_clear_line(checkout):
    all_debian_packages_are_there(checkout)
    stand_in(
        checkout / ".venv" / "bin" / "python", 'echo "ERROR: No matching distribution"; exit 1'
    )
    done = prepare(checkout)
    assert done.returncode == 2
    assert "pip could not install requirements.lock (ERROR: No matching distribution)" in said(done)
    assert not (checkout / ".venv" / "prepared-run").exists()


@pytest.fixture
def prepared(checkout):
    all_debian_packages_are_there(checkout)
    stand_in(checkout / ".venv" / "bin" / "python", "echo x >>pip-calls")
    stand_in(checkout / ".venv" / "bin" / "station", "")
    assert prepare(checkout, "test").returncode == 0
    (checkout / "pip-calls").unlink()
    return checkout


@pytest.mark.parametrize("what", ["test", "run"])
def test_environment_that_is_as_it_should_be_is_left_alone(prepared, what):
    done = prepare(prepared, what)
    assert (done.returncode, done.stderr) == (0, "")
    assert not (prepared / "pip-calls").exists()


def test_changed_lock_is_installed_anew(prepared):
    with (prepared / "deploy" / "test.lock").open("a") as lock:
        lock.write("# changed\n")
    assert "installing the Python packages of deploy/test.lock" in prepare(prepared, "test").stderr
    assert (prepared / "pip-calls").exists()
