"""The settings of measuring."""

from station.settings.section import Section


class MeasuringSettings(Section):
    """When wheels are measured."""

    while_recording: bool = True
    """Measure wheels while the train still passes; false: only once the pass is finished.  The
    readings are the same."""
