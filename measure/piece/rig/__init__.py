"""One reference piece in the sheets of several sensors: is their rig true, and where they stand."""

from measure.piece.rig.check import judge_piece_on_rig
from measure.piece.rig.found import RigFromPiece, RigMotion
from measure.piece.rig.solve import rig_from_piece

__all__ = ["RigFromPiece", "RigMotion", "judge_piece_on_rig", "rig_from_piece"]
