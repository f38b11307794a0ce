"""What the solve of a rig is given: the points of all pictures, sorted by sensor and board."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.lens import normalised_of
from calib.sensor import LaserSensor
from calib.solving.observations import Observations
from calib.solving.rig.seen import SeenView
from calib.solving.rig.sheets import points_on_sheets
from calib.solving.rig.start import RigStart
from calib.solving.rig.turned import turned_view
from calib.solving.rig.unknowns import Poses, RigLayout, RigState, SensorPrior
from calib.solving.start import has_stripe
from calib.target import Target
from calib.views import View

# A board taken for exact still has dots: variances must be more than rounding.
_LEAST_SIGMA_BOARD_MM = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """The M pictures that one sensor took of one board, and their N dots.

    Attributes
    ----------
    sensor, board
        Indices.
    showing
        Shape (M,), index of the showing of each picture.
    views
        The pictures, numbered as the board is.
    observations
        Their points; `view` in it counts the pictures of this channel.
    dot
        Shape (N,), which of all boards' dots each one is.
    rays
        Normalised coordinates of the stripe points by the sensor as calibrated.
    stripe_in, on_sheet
        Of the stripe points, those of stripes long enough to be a line; and those of them that lie
        on a line in the plane of most others, with which a solve begins.
    """

    sensor: int
    board: int
    showing: IntArray
    views: tuple[View, ...]
    observations: Observations
    dot: IntArray
    rays: FloatArray
    stripe_in: BoolArray
    on_sheet: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class RigProblem:
    """All that is to be explained.

    Attributes
    ----------
    channels
        Of all sensors and boards that met.
    priors
        Of each sensor.
    layout
        The unknowns.
    dot_sigma_mm, first_dot
        Shape (D,), how far each dot of the boards may be off its place, along each axis; which is
        the first of each board.
    sensors, boards, showings
        Names, in order.
    """

    channels: tuple[Channel, ...]
    priors: tuple[SensorPrior, ...]
    layout: RigLayout
    dot_sigma_mm: FloatArray
    first_dot: tuple[int, ...]
    sensors: tuple[str, ...]
    boards: tuple[str, ...]
    showings: tuple[str, ...]

    def of_sensor(self, sensor: int) -> list[int]:
        """Return the indices of a sensor's channels."""
        return [index for index, each in enumerate(self.channels) if each.sensor == sensor]


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """What a problem is made of: sensors and boards by name, and how true the boards are."""

    sensors: Mapping[str, LaserSensor]
    boards: Mapping[str, Target]
    sigma_board_mm: Mapping[str, float]
    anchor: str

    def problem(self, views: Sequence[SeenView]) -> RigProblem:
        """Make the problem of these pictures; boards that none shows are left out."""
        sensors = tuple(self.sensors)
        boards = tuple(sorted({view.board for view in views}))
        showings = tuple(dict.fromkeys(view.showing for view in views))
        counts = [len(self.boards[name].points_mm) for name in boards]
        first_dot = np.cumsum([0, *counts])
        on_sheet = points_on_sheets(views)
        channels = [
            self._channel(
                [view for view in views if (view.sensor, view.board) == (sensor, board)],
                (sensors.index(sensor), boards.index(board)),
                showings,
                int(first_dot[boards.index(board)]),
                on_sheet,
            )
            for sensor, board in sorted({(view.sensor, view.board) for view in views})
        ]
        priors = tuple(SensorPrior.of(sensor) for sensor in self.sensors.values())
        sigma = [max(self.sigma_board_mm[name], _LEAST_SIGMA_BOARD_MM) for name in boards]
        return RigProblem(
            channels=tuple(channels),
            priors=priors,
            layout=RigLayout(
                tuple(prior.size for prior in priors),
                sensors.index(self.anchor),
                len(boards),
                len(showings),
            ),
            dot_sigma_mm=np.repeat(sigma, counts),
            first_dot=tuple(first_dot[:-1].tolist()),
            sensors=sensors,
            boards=boards,
            showings=showings,
        )

    def _channel(
        self,
        seen: Sequence[SeenView],
        at: tuple[int, int],
        showings: tuple[str, ...],
        first_dot: int,
        on_sheet: Mapping[tuple[str, str], BoolArray],
    ) -> Channel:
        target, sensor = self.boards[seen[0].board], self.sensors[seen[0].sensor]
        views = tuple(turned_view(each.view, target, each.quarters) for each in seen)
        observations = Observations.of(views, target)
        points = [view.points.row * target.cols + view.points.col for view in views]
        long_enough = np.array([has_stripe(view) for view in views])
        return Channel(
            sensor=at[0],
            board=at[1],
            showing=np.array([showings.index(each.showing) for each in seen], dtype=np.int64),
            views=views,
            observations=observations,
            dot=np.concatenate(points) + first_dot,
            rays=normalised_of(observations.stripe.seen_px, sensor.camera.parameters),
            stripe_in=long_enough[observations.stripe.view],
            on_sheet=np.concatenate([
                on_sheet.get((each.showing, each.sensor), _none(each.view)) for each in seen
            ]),
        )


def _none(view: View) -> BoolArray:
    return np.zeros(0 if view.stripe is None else len(view.stripe), dtype=bool)


def first_state(problem: RigProblem, start: RigStart) -> RigState:
    """Return the state where a solve begins, the sensors and boards as they were told to be."""
    first = start.target_from_board[problem.boards[0]]
    return RigState(
        own=tuple(np.zeros(prior.size) for prior in problem.priors),
        cameras=Poses.of([start.rig_from_camera[name] for name in problem.sensors]),
        boards=Poses.of([
            first.inverse() @ start.target_from_board[name] for name in problem.boards
        ]),
        targets=Poses.of([start.rig_from_target[name] @ first for name in problem.showings]),
        dot_shift_mm=np.zeros((len(problem.dot_sigma_mm), 3)),
    )
