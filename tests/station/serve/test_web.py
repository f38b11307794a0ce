"""Shows the API over TLS, and a certificate that could not be shown refused; and the first key."""

import os
import socket
import ssl
import stat
import subprocess
import threading
import time

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from station.errors import InputUnusable
from station.operations import DataLayout
from station.serve.certificate import ensure_tls_usable
from station.serve.first_key import ensure_first_key
from station.serve.listening import url_of
from station.serve.readiness import missing_parts
from station.serve.web import server_config
from station.settings import StationSettings, TlsSettings, load_settings
from station.store import Store, migrate
from station.store.callers import keys_of, revoke_key

PATIENCE_S = 60.0


def make_certificate(folder, name):
    key, certificate = folder / f"{name}.key", folder / f"{name}.pem"
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
        + ["-nodes", "-days", "2", "-subj", "/CN=station", "-addext", "subjectAltName=IP:127.0.0.1"]
        + ["-keyout", key, "-out", certificate],
        check=True,
        capture_output=True,
    )
    return TlsSettings(certificate=certificate, key=key)


@pytest.fixture(scope="module")
def tls(tmp_path_factory):
    return make_certificate(tmp_path_factory.mktemp("tls"), "station")


@pytest.fixture
def ready_over_tls(tls, tmp_path):
    """Serve an app that says what `/readyz` of a station says; return its URL."""
    app = FastAPI()

    @app.get("/readyz")
    def readiness():
        return {"parts": {"store": "ready", "worker": "not running"}}

    settings = StationSettings(
        data_dir=tmp_path, sensors=[{"id": "left", "address": "127.0.0.2"}], tls=tls
    )
    server = uvicorn.Server(server_config(app, settings))
    with socket.create_server(("127.0.0.1", 0)) as listening:
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
        thread.start()
        began_s = time.monotonic()
        while not server.started:
            assert time.monotonic() - began_s < PATIENCE_S
            time.sleep(0.01)
        yield url_of(listening, tls)
        server.should_exit = True
        thread.join(PATIENCE_S)


def test_the_api_shows_its_certificate_and_speaks_no_plain_http(ready_over_tls, tls):
    assert ready_over_tls.startswith("https://127.0.0.1:")
    trusting = ssl.create_default_context(cafile=tls.certificate)
    place, patient = f"{ready_over_tls}/readyz", {"timeout": PATIENCE_S, "trust_env": False}
    assert httpx.get(place, verify=trusting, **patient).status_code == 200
    with pytest.raises(httpx.TransportError):
        httpx.get(place.replace("https", "http"), **patient)


def test_the_supervisor_sees_over_tls_what_is_not_ready(ready_over_tls):
    assert missing_parts(ready_over_tls) == {"worker": "not running"}


def test_a_good_certificate_and_none_are_let_through(tls):
    ensure_tls_usable(tls)
    ensure_tls_usable(None)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"certificate": "nowhere.pem"}, "certificate .*nowhere.pem: cannot be read"),
        ({"key": "nowhere.key"}, "key .*nowhere.key: cannot be read"),
        ({"key": "other.key"}, "key values mismatch"),
        ({"key": "locked.key"}, "give a certificate and the key that belongs to it"),
        ({"certificate": "text.pem"}, "give a certificate and the key that belongs to it"),
    ],
)
def test_a_certificate_that_could_not_be_shown_is_one_line(tls, tmp_path, change, says):
    make_certificate(tmp_path, "other")
    (tmp_path / "text.pem").write_text("no certificate")
    subprocess.run(
        ["openssl", "ec", "-in", tls.key, "-aes128", "-passout", "pass:x"]
        + ["-out", tmp_path / "locked.key"],
        check=True,
        capture_output=True,
    )
    changed = {what: tmp_path / name for what, name in change.items()}
    with pytest.raises(InputUnusable, match=says) as refusal:
        ensure_tls_usable(tls.model_copy(update=changed))
    assert "\n" not in str(refusal.value)


def test_paths_of_certificate_and_key_count_from_the_settings_file(tmp_path):
    settings = tmp_path / "station.toml"
    settings.write_text(
        'data_dir = "data"\n[tls]\ncertificate = "tls/a.pem"\nkey = "/etc/b.key"\n'
        '[web]\nproxies = ["10.0.0.0/24"]\n[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'
    )
    found = load_settings(settings).tls
    assert str(found.certificate) == f"{tmp_path}/tls/a.pem"
    assert str(found.key) == "/etc/b.key"


def test_a_proxy_that_is_everybody_is_refused(tmp_path):
    settings = tmp_path / "station.toml"
    settings.write_text(
        'data_dir = "data"\n[web]\nproxies = ["0.0.0.0/0"]\n'
        '[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'
    )
    with pytest.raises(InputUnusable, match="every address"):
        load_settings(settings)


@pytest.fixture
def layout(tmp_path):
    layout = DataLayout(tmp_path)
    migrate(layout.store_url)
    return layout


def test_the_first_key_is_told_a_person_once_and_never_again(layout):
    said = []
    for _ in range(2):
        ensure_first_key(layout, said.append, to_a_person=True)
    (line,) = said
    assert line.startswith("admin key, shown this once: tl_")
    assert not (layout.root / "first-admin-key").exists()


def test_the_first_key_goes_into_a_file_of_this_user_where_a_log_would_keep_it(layout):
    said = []
    before = os.umask(0)
    try:
        ensure_first_key(layout, said.append, to_a_person=False)
    finally:
        os.umask(before)
    file = layout.root / "first-admin-key"
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    (line,) = said
    assert str(file) in line
    assert file.read_text().strip().split("_")[2] not in line


def test_no_key_is_made_again_where_all_were_taken_back(layout):
    said = []
    ensure_first_key(layout, said.append, to_a_person=True)
    store = Store.open(layout.store_url)
    with store.change() as session:
        (key,) = keys_of(session)
        revoke_key(session, key.id, at=key.created_at)
    store.close()
    ensure_first_key(layout, said.append, to_a_person=True)
    assert len(said) == 1
