"""Recordings in a bucket of a real server, which takes packages that the tests do without.

`pip install treadline[s3] moto[server]`, then `pytest -m slow tests/station/replay/test_s3.py`.
"""

import json
import os
import subprocess
import sys

import httpx
import pytest

from station.bench.replay_recordings import pictures_of_wheels, record_wheels, true_calibration

KEYS = {
    "AWS_ACCESS_KEY_ID": "archive",
    "AWS_SECRET_ACCESS_KEY": "secret",
    "AWS_DEFAULT_REGION": "eu-central-1",
}

pytestmark = pytest.mark.slow


@pytest.fixture
def endpoint(tmp_path, monkeypatch):
    """An S3 server with two recordings and something else in `s3://archive/2024`."""
    pytest.importorskip("s3fs", reason="s3fs is not installed: pip install treadline[s3]")
    moto = pytest.importorskip("moto.server", reason="no S3 server: pip install moto[server]")
    boto3 = pytest.importorskip("boto3")
    for name, value in KEYS.items():
        monkeypatch.setenv(name, value)
    server = moto.ThreadedMotoServer(ip_address="127.72.0.5", port=0, verbose=False)
    server.start()
    url = "http://{}:{}".format(*server.get_host_and_port())
    httpx.post(f"{url}/moto-api/reset")  # of all servers of a process the buckets are the same
    bucket = boto3.resource("s3", endpoint_url=url).Bucket("archive")
    bucket.create(CreateBucketConfiguration={"LocationConstraint": KEYS["AWS_DEFAULT_REGION"]})
    recording = record_wheels(tmp_path / "train.mcap", pictures_of_wheels(2), frames=4)
    for name in ("train1.mcap", "train2.mcap", "notes.txt"):
        bucket.upload_file(str(recording), f"2024/{name}")
    yield url
    server.stop()


@pytest.fixture
def replay(tmp_path):
    true_calibration().write(tmp_path / "calibration.json")

    def do(*arguments, **environment):
        command = [sys.executable, "-m", "station", "replay", *arguments]
        command += [f"--calibration={tmp_path / 'calibration.json'}"]
        told = os.environ | environment
        return subprocess.run(command, env=told, capture_output=True, text=True, check=False)

    return do


def test_a_bucket_is_measured_to_the_same_readings_as_the_file(endpoint, replay, tmp_path):
    there, here = tmp_path / "there.json", tmp_path / "here.json"
    by_name = {"FSSPEC_S3_ENDPOINT_URL": endpoint}
    assert replay("s3://archive/2024", f"--out={there}", **by_name).returncode == 0
    assert replay(str(tmp_path / "train.mcap"), f"--out={here}").returncode == 0
    found, own = (json.loads(path.read_bytes())["wheels"] for path in (there, here))
    assert {wheel["source"] for wheel in found} == {"train1.mcap", "train2.mcap"}
    assert [wheel | {"source": ""} for wheel in found] == 2 * [w | {"source": ""} for w in own]


def test_workers_fetch_from_it_and_a_second_run_finds_all_done(endpoint, replay, tmp_path):
    folder = tmp_path / "fsspec"
    folder.mkdir()
    (folder / "s3.json").write_text(json.dumps({"s3": {"endpoint_url": endpoint}}))
    by_file = {"FSSPEC_CONFIG_DIR": str(folder)}
    out = f"--out={tmp_path / 'parts'}"
    assert replay("s3://archive/2024", out, "--workers=2", **by_file).returncode == 0
    again = replay("s3://archive/2024", out, "--dry-run", "--json", **by_file)
    assert json.loads(again.stdout)["found_measured"] == 2


@pytest.mark.parametrize(
    ("url", "keys", "says"),
    [
        ("s3://archive/2025", {}, "no recording"),
        ("s3://archive/2024/none.mcap", {}, "not there"),
        ("s3://nobody/2024", {}, "not there"),
        ("s3://archive/2024", dict.fromkeys(KEYS, ""), "Unable to locate credentials"),
    ],
)
def test_what_is_not_there_is_one_line(endpoint, replay, tmp_path, url, keys, says):
    done = replay(url, f"--out={tmp_path / 'r.csv'}", FSSPEC_S3_ENDPOINT_URL=endpoint, **keys)
    assert done.returncode == 2
    assert says in done.stderr
    assert done.stderr.count("\n") == 1
