"""kill -9 of each process at random moments of a pass: what is lost, what is there twice."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from station.bench.service.kill_trials import Train, Trial, run_kills
from station.bench.service.station_process import Victim
from station.progress import Progress
from station.tables import Table, Value

_FEW, _ASKED = 3, 50


def bench_service_kills(
    progress: Progress,
    *,
    full: bool = False,
    kills: int | None = None,
    victims: Sequence[Victim] = tuple(Victim),
    train: Train | None = None,
    seed: int = 0,
) -> Table:
    """Kill each process of a running station, with a controller that calls blindly beside it.

    Parameters
    ----------
    progress
        Told where the bench is.
    full
        As often as is asked of a station: half an hour.
    kills
        Of each process, whatever `full` says.
    victims
        Which processes.
    train
        What goes by each time.
    seed
        Of the moments.
    """
    kills, train = kills or (_ASKED if full else _FEW), train or Train()
    trials = run_kills(progress, kills=kills, victims=victims, train=train, seed=seed)
    return table_of(trials, train)


def table_of(trials: Sequence[Trial], train: Train) -> Table:
    """Return what the kills came to, a row for each process."""
    victims = dict.fromkeys(trial.victim for trial in trials)
    rows = [_row([one for one in trials if one.victim is victim]) for victim in victims]
    return Table(
        "kill -9 of the station's processes in the middle of a pass",
        rows,
        (
            f"A train of {train.wheels} wheels each time, killed at a moment within the "
            f"{train.lasts_s:.1f} s from just before it was announced until it was measured; the "
            "controller says everything again until it is answered.  Lost: wheels of which no "
            "frame is in a file, and of those, the ones that the pass's account does not tell.  "
            "Readings are held against the same files measured again, each row by its frame.  "
            "Ready: from the kill until every part was ready again, s.",
            *_remarks(trials),
        ),
    )


def _row(trials: Sequence[Trial]) -> dict[str, Value]:
    states = Counter(trial.state for trial in trials)
    truths = [trial.truth for trial in trials]
    ready_s = [trial.ready_s for trial in trials]
    return {
        "killed": trials[0].victim.value,
        "times": len(trials),
        **{state: states[state] for state in ("done", "recovered", "failed")},
        "stuck": len(trials) - states["done"] - states["recovered"] - states["failed"],
        "frames lost": sum(truth.lost for truth in truths),
        "not said": sum(truth.unsaid for truth in truths),
        "files unsound": sum(truth.unsound for truth in truths),
        "readings missing": sum(truth.missing for truth in truths),
        "doubled": sum(truth.doubled for truth in truths),
        "differing": sum(truth.differing for truth in truths),
        "left over": sum(len(trial.left_over) for trial in trials),
        "next not whole": sum(not trial.next_whole for trial in trials),
        "HTTP 500": sum(trial.server_errors for trial in trials),
        "ready, median": float(np.median(ready_s)),
        "slowest": max(ready_s),
        "holds": all(trial.good for trial in trials),
    }


def _remarks(trials: Sequence[Trial]) -> list[str]:
    """Say of each pass that did not hold, or that failed, what happened."""
    return [
        f"{trial.victim} killed at {trial.after_s:.2f} s: {trial.state}"
        + "".join(f"; {each}" for each in (trial.reason, *trial.left_over) if each)
        + (f"; {trial.truth}" if not trial.good else "")
        for trial in trials
        if not trial.good or trial.state == "failed"
    ]
