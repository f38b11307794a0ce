"""Whether the sensor still tells the truth: a reference piece of known profile in its sheet."""

from measure.piece.certified import Piece
from measure.piece.check import judge_piece
from measure.piece.face import PieceFace
from measure.piece.place import PiecePlace
from measure.piece.verdict import PieceDeviation, PieceJudgement, PieceReading, PieceVerdict

__all__ = [
    "Piece",
    "PieceDeviation",
    "PieceFace",
    "PieceJudgement",
    "PiecePlace",
    "PieceReading",
    "PieceVerdict",
    "judge_piece",
]
