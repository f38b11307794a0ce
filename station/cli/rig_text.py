"""A rig as lines for people."""

import numpy as np

from station.documents import RigDocument


def text_of_rig(document: RigDocument) -> str:
    """Return how the sensors stand, how surely, and what was left out."""
    rig = document.to_rig()
    base = rig[document.anchor].rig_from_camera
    lines = [f"rig {document.rig}, {document.side} side, {document.method}, {document.software}"]
    for each in rig.sensors:
        if each.name == document.anchor:
            lines.append(f"{each.name}: the anchor")
            continue
        pose = base.inverse() @ each.rig_from_camera
        x, y, z = pose.translation_mm
        turn = float(np.degrees(np.linalg.norm(pose.rotation_vector)))
        sigma = np.sqrt(np.diag(rig.covariance)[rig.columns(each.name)[-3:]])
        lines.append(
            f"{each.name}: at ({x:.3f}, {y:.3f}, {z:.3f}) mm before {document.anchor}'s camera, "
            f"turned by {turn:.3f} degrees; sigma {np.linalg.norm(sigma):.4f} mm"
        )
    if document.survey is None:
        lines.append("no place beside the track: it cannot measure wheels")
    rms = document.rms
    if rms is not None:
        lines.append(f"rms dots {rms.dots_px:.3f} px, stripe {rms.stripe_px:.3f} px")
    lines += [
        f"{name} {gate.value:.4g} (limit {gate.limit:g}) {'passed' if gate.passed else 'FAILED'}"
        for name, gate in document.quality.items()
    ]
    lines += [f"left out {name}: {reason}" for name, reason in document.left_out.items()]
    lines += [f"warning: {warning}" for warning in document.warnings]
    return "\n".join(lines)
