"""Shows that every line of a log is one JSON object, whoever wrote it."""

import json
import logging

import structlog

from station.serve import log_as


def test_lines_of_the_station_and_of_libraries_are_json_with_their_process(capfd):
    log_as("worker")
    structlog.get_logger().info("measured", wheels=8)
    logging.getLogger("some.library").warning('odd "value" of %s', "a\nb")
    logging.getLogger("some.library").info("too much detail")
    logging.getLogger("dbos").error("failed", exc_info=ValueError("inside"))
    ours, theirs, failed = map(json.loads, capfd.readouterr().err.splitlines())
    assert (ours["event"], ours["wheels"], ours["process"]) == ("measured", 8, "worker")
    assert theirs["event"] == 'odd "value" of a\nb'
    assert (theirs["logger"], theirs["process"]) == ("some.library", "worker")
    assert "ValueError: inside" in failed["exception"]
