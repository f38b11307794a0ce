"""Shows on the whole service that a pass ends without its controller, though the API is killed
meanwhile, and takes the controller's count when it comes back."""

import httpx
import numpy as np
import pytest
from test_serve import Service, trigger, wait

from station.simulated import ArraySource, SimulatedCamera

ADDRESS = "127.31.0.2"
PATIENCE_S = 90.0


@pytest.fixture
def camera():
    source = ArraySource([np.full((200, 320), 40, np.uint8)])
    with SimulatedCamera(ADDRESS, source, serial="S1") as camera:
        yield camera


@pytest.fixture
def service(camera, tmp_path):
    service = Service(
        tmp_path,
        STATION_SENSORS=f'[{{"id": "left", "address": "{ADDRESS}"}}]',
        STATION_CONTROLLER__QUIET_S="4",
    )
    yield service.wait_until_ready()
    service.close()


def test_a_pass_that_its_controller_forgot_ends_though_the_api_dies_meanwhile(service, camera):
    headers = {"Authorization": f"Bearer {service.key}"}
    with httpx.Client(
        base_url=service.url, headers=headers, timeout=PATIENCE_S, trust_env=False
    ) as call:
        assert call.put("/v1/passes/p1", json={}).json()["state"] == "recording"
        trigger(camera, 3)
        service.kill_and_wait("api")
        wait(lambda: call.get("/v1/passes/p1").json()["state"] != "recording", "its end")
        body = call.get("/v1/passes/p1").json()
        assert (body["state"], body["ended_by"]) == ("recorded", "timeout")
        assert "no frame for 4 s (quiet_s); the last frame came at" in body["reason"]
        assert body["recordings"][0]["recorded"] == 3

        late = call.post("/v1/passes/p1/finish", json={"axles": 4})
        (recording,) = late.json()["recordings"]
        assert late.status_code == 200
        assert (recording["expected"], recording["lost"]) == (4, 1)
        assert call.put("/v1/passes/p2", json={}).status_code == 201
        assert call.post("/v1/passes/p2/finish", json={"axles": 0}).json()["state"] == "done"
        assert service.stop() == 0
