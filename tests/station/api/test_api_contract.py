"""Shows that the contract that programs were written against changes only with its version.

The file beside the API is the contract; `contract_versions.txt` here has the digest of each version
there was.  Whoever changes an operation raises `API_VERSION`, writes the file again, and adds the
line that the test prints.
"""

import hashlib
import json
from importlib import resources
from pathlib import Path

import pytest

from station.api import API_VERSION, contract
from station.cli.main import build_app, run

COMMITTED = resources.files("station.api") / "openapi.json"
VERSIONS = Path(__file__).with_name("contract_versions.txt")


def digest_of(document):
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()[:16]


def known_versions():
    return dict(line.split() for line in VERSIONS.read_text().splitlines())


def test_the_committed_contract_is_that_of_the_code():
    assert json.loads(COMMITTED.read_text()) == contract(), (
        "raise API_VERSION, then `station api openapi --out station/api/openapi.json`"
    )


def test_the_contract_does_not_change_without_its_version():
    line = f"{API_VERSION} {digest_of(contract())}"
    known = known_versions()
    assert API_VERSION in known, f"a new version: add `{line}` to {VERSIONS.name}"
    assert known[API_VERSION] == line.split()[1], "it was changed: raise API_VERSION"
    assert list(known)[-1] == API_VERSION


def test_versions_only_rise():
    numbers = [tuple(map(int, version.split("."))) for version in known_versions()]
    assert numbers == sorted(set(numbers))


def test_the_command_prints_the_contract(capsys, tmp_path):
    assert run(build_app("api"), ["api", "openapi"]) == 0
    assert json.loads(capsys.readouterr().out) == contract()
    out = tmp_path / "openapi.json"
    assert run(build_app("api"), ["api", "openapi", "--out", str(out)]) == 0
    assert json.loads(out.read_text()) == contract()


@pytest.mark.parametrize("path", ["/v1/calibrations", "/v1/passes/{pass_id}/finish"])
def test_the_contract_tells_of_the_idempotency_key_of_a_post(path):
    parameters = contract()["paths"][path]["post"]["parameters"]
    assert "Idempotency-Key" in {each["name"] for each in parameters}


def test_a_refusal_is_a_problem_document_everywhere():
    for path, operations in contract()["paths"].items():
        for operation in operations.values():
            for status, response in operation["responses"].items():
                assert status != "422", path
                if status == "default":
                    assert list(response["content"]) == ["application/problem+json"]
