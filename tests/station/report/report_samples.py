"""A calibration as the command leaves it, and one written by hand with known deviations."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from station.documents import CalibrationDocument

TARGET = "dots:7x8:12:d=6"
SLASH = "\N{DIVISION SLASH}"  # a file's name can hold no other
HOSTILE = f"<{SLASH}style><script>alert(1)<{SLASH}script><img src=x> & \"two\" 'one'.png"
WITHOUT_TARGET = f"<b>no target<{SLASH}b>.png"
DOTS = 56


@dataclass(frozen=True)
class Kept:
    """calibration.json, points.csv, report.html, and the folder of pictures they are from."""

    document: CalibrationDocument
    points_csv: str
    page: str
    folder: Path


def save(path, picture):
    # cv2.imwrite refuses some names that a file system does not.
    path.write_bytes(cv2.imencode(path.suffix, picture)[1].tobytes())


def noise(rng):
    return rng.integers(0, 255, (1088, 2048), dtype=np.uint8)


def by_hand(kept, deviations_px, *, stripe=40):
    """Return document and points.csv of pictures whose points deviate along v by known amounts.

    Every second point deviates up, the others down: a picture's RMS is its amount.
    """
    names = [f"pose{place}.png" for place in range(len(deviations_px))]
    lines = ["image,kind,row,col,u,v,sigma_u,sigma_v,u_corrected,v_corrected,used,reason"]
    for name, deviation_px in zip(names, deviations_px, strict=True):
        for i in range(DOTS + stripe):
            place = f"dot,{i // 8},{i % 8}" if i < DOTS else "stripe,,"
            u, v = 300.0 + 15.0 * i, 200.0 + 90.0 * (i % 8)
            seen = v + (deviation_px if i % 2 else -deviation_px)
            lines.append(f"{name},{place},{u},{seen},0.1,0.1,{u},{v},1,")
    pose = kept.document.poses[0]
    whole_px = float(np.sqrt(np.mean(np.square(deviations_px))))
    document = kept.document.model_copy(
        update={
            "poses": tuple(pose.model_copy(update={"image": name}) for name in names),
            "rms": kept.document.rms.model_copy(
                update={"dots_px": whole_px, "stripe_px": whole_px}
            ),
            "left_out": {},
            "warnings": (),
        }
    )
    return document, "\n".join(lines) + "\n"
