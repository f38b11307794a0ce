"""Whether the sensor still tells the truth: a reference piece of known profile in its sheet."""

from measure.piece.certified import Piece
from measure.piece.check import judge_piece
from measure.piece.face import PieceFace
from measure.piece.place import PiecePlace
from measure.piece.rig import RigFromPiece, RigMotion, judge_piece_on_rig, rig_from_piece
from measure.piece.verdict import (
    PieceDeviation,
    PieceJudgement,
    PiecePower,
    PieceReading,
    PieceVerdict,
)

__all__ = [
    "Piece",
    "PieceDeviation",
    "PieceFace",
    "PieceJudgement",
    "PiecePlace",
    "PiecePower",
    "PieceReading",
    "PieceVerdict",
    "RigFromPiece",
    "RigMotion",
    "judge_piece",
    "judge_piece_on_rig",
    "rig_from_piece",
]
