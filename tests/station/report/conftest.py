import numpy as np
import pytest
from report_samples import HOSTILE, TARGET, WITHOUT_TARGET, Kept, noise, save

from calib import Target
from station.cli.main import build_app, run
from station.documents import CalibrationDocument
from station.scenes import Light, paper_sensor, target_scenes


@pytest.fixture(scope="session")
def kept(tmp_path_factory):
    """What `station calibrate --report` leaves of four poses and a picture without a target."""
    base = tmp_path_factory.mktemp("report")
    folder = base / "pictures"
    folder.mkdir()
    rng = np.random.default_rng(11)
    # Five pictures are looked at in this process: no time goes into starting others.
    lights = [Light.GOOD, Light.DIM, Light.CROSSING, Light.GOOD]
    names = [HOSTILE, *(f"pose{place}.png" for place in range(1, 4))]
    scenes = target_scenes(rng, paper_sensor(), Target.parse(TARGET), lights)
    for name, scene in zip(names, scenes, strict=True):
        save(folder / name, scene.render(rng))
    save(folder / WITHOUT_TARGET, noise(rng))
    out, points, page = (base / name for name in ("c.json", "p.csv", "r.html"))
    code = run(
        build_app("calibrate"),
        ["calibrate", str(folder), "--target", TARGET, "--out", str(out),
         "--points", str(points), "--report", str(page)],
    )  # fmt: skip
    # Four poses may know the sheet too badly for its gate: the report is written all the same.
    assert code in {0, 1}
    return Kept(CalibrationDocument.read(out), points.read_text(), page.read_text(), folder)
