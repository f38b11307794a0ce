"""Shows how styles and scripts are sent, and that what is not ours is what it says it is."""

import fnmatch
import gzip
import hashlib
import tomllib
from pathlib import Path

import pytest

import station.page
from station.page.assets import Assets

ROOT = Path(station.page.__file__).parent
VENDOR = ROOT / "static" / "vendor"
ASSETS = Assets.read()


def test_a_file_is_sent_packed_or_plain_and_kept_for_good(paged):
    assets = paged.app.state.shell.assets
    for accepted, packed in (("gzip, br", True), ("identity", False)):
        with paged.client(**{"Accept-Encoding": accepted}) as stranger:
            reply = stranger.get(assets.address("page.css"))
        assert reply.status_code == 200
        assert reply.content == (ROOT / "static" / "page.css").read_bytes()
        assert (reply.headers.get("Content-Encoding") == "gzip") == packed
        assert reply.headers["Vary"] == "Accept-Encoding"
        assert "immutable" in reply.headers["Cache-Control"]
        assert reply.headers["X-Content-Type-Options"] == "nosniff"


@pytest.mark.parametrize(
    "name",
    [
        "../page/login.py",
        "%2e%2e/login.py",
        "..%2f..%2fserve/web.py",
        "/etc/passwd",
        "%2fetc%2fpasswd",
        "vendor",
        "vendor/",
        "",
        "templates/layout.html",
        "page.css%00",
        "nothing.js",
    ],
)
def test_nothing_but_the_files_of_the_pages_is_sent(paged, name):
    with paged.client() as stranger:
        for digest in (paged.app.state.shell.assets.digest, "0" * 16, "..", "%2e%2e"):
            reply = stranger.get(f"/static/{digest}/{name}")
            assert reply.status_code in {401, 404}, (digest, name)


def test_an_address_of_another_version_is_no_file_of_this_one(paged):
    with paged.client() as stranger:
        assert stranger.get("/static/0123456789abcdef/page.css").status_code == 404


def test_every_file_unpacks_to_itself():
    for name, asset in ASSETS.files.items():
        assert gzip.decompress(asset.packed) == asset.plain, name
        assert ASSETS.address(name) == f"/static/{ASSETS.digest}/{name}"
    with pytest.raises(KeyError, match=r"nothing\.js"):
        ASSETS.address("nothing.js")


def vendored():
    return tomllib.loads((VENDOR / "VENDORED.toml").read_text())["file"]


def test_what_is_not_ours_is_unchanged_and_listed_with_its_licence():
    listed = {each["name"]: each for each in vendored()}
    for name, each in listed.items():
        assert hashlib.sha256((VENDOR / name).read_bytes()).hexdigest() == each["sha256"], name
        assert each["integrity"].startswith("sha512-")
        assert {"package", "version", "licence"} <= each.keys()
    licences = {path.name for path in VENDOR.glob("*LICENSE*")}
    others = {path.name for path in VENDOR.iterdir()} - licences - {"VENDORED.toml"}
    assert others == listed.keys()
    first_parts = {each["name"].partition(".")[0] for each in listed.values()}
    assert {name.partition("-")[0] for name in licences} == first_parts


def test_the_distribution_has_every_file_of_the_pages():
    settings = tomllib.loads((ROOT.parents[1] / "pyproject.toml").read_text())
    kept = settings["tool"]["setuptools"]["package-data"]["*"]
    served = {"static", "templates", "texts"}
    files = [path for path in ROOT.rglob("*") if path.is_file() and served & {*path.parts}]
    assert len(files) > 20
    for path in files:
        assert any(fnmatch.fnmatch(path.name, pattern) for pattern in kept), path
