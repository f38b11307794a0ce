"""The registers of the simulated camera: where each stands, how long it is, what it takes.

Up to 0x9FFF they are the bootstrap registers of GigE Vision 1.2; the camera's own features
follow. ``genicam.xml`` tells clients the same in the words of SFNC; a test holds the two together.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum

from station.simulated.gvsp import MONO8

MIN_REGION_PX = 16
MIN_FRAME_RATE_HZ, MAX_FRAME_RATE_HZ = 0.1, 2000.0
MIN_EXPOSURE_US, MAX_EXPOSURE_US = 10.0, 1_000_000.0
DEFAULT_EXPOSURE_US = 10_000.0
MAX_GAIN_DB = 24.0
MAX_BLACK_LEVEL = 64.0
TEMPERATURE_C = 42.5
MAX_TRIGGER_DELAY_US, MAX_DEBOUNCE_US = 1_000_000.0, 100_000.0
MIN_PACKET_BYTES, MAX_PACKET_BYTES = 576, 16_384
DEFAULT_PACKET_BYTES = 1500
MIN_HEARTBEAT_MS, DEFAULT_HEARTBEAT_MS = 500, 3000
TICKS_PER_SECOND = 1_000_000_000

SCPS_FIRE_TEST_PACKET = 0x8000_0000
SCPS_SIZE_MASK = 0xFFFF
TIMESTAMP_LATCH = 2

XML_ADDRESS = 0x1_0000
Limit = Callable[[float], bool]


class Kind(Enum):
    """How a register's bytes are read."""

    UINT32 = 4
    FLOAT64 = 8
    TEXT = 0


class Privilege(IntEnum):
    """Values of CCP, the control channel privilege."""

    OPEN = 0
    EXCLUSIVE = 1
    CONTROL = 2


class AcquisitionMode(IntEnum):
    """How many pictures an acquisition takes."""

    CONTINUOUS = 0
    SINGLE_FRAME = 1
    MULTI_FRAME = 2


class TriggerSource(IntEnum):
    """Where triggers come from."""

    SOFTWARE = 0
    LINE1 = 1


def _anything(_value: float) -> bool:
    return True


def _between(low: float, high: float, step: int = 0) -> Limit:
    """Allow values from low to high, and only whole steps from low where one is given."""
    return lambda value: low <= value <= high and (step == 0 or (value - low) % step == 0)


def _one_of(*allowed: int) -> Limit:
    return lambda value: value in allowed


_boolean = _one_of(0, 1)


@dataclass(frozen=True, slots=True)
class Register:
    """One register.

    Attributes
    ----------
    writable
        Clients may write it.
    frames_layout
        It decides how large a picture or a packet is: fixed while pictures are taken.
    allows
        Whether a number is in range; what depends on other registers is checked elsewhere.
    """

    address: int
    kind: Kind = Kind.UINT32
    length: int = 4
    writable: bool = False
    frames_layout: bool = False
    allows: Limit = _anything


def _own(address: int, allows: Limit = _anything, *, frames_layout: bool = False) -> Register:
    return Register(address, writable=True, frames_layout=frames_layout, allows=allows)


def _text(address: int, length: int, *, writable: bool = False) -> Register:
    return Register(address, Kind.TEXT, length, writable)


def _real(address: int, allows: Limit) -> Register:
    return Register(address, Kind.FLOAT64, 8, writable=True, allows=allows)


VERSION = Register(0x0000)
DEVICE_MODE = Register(0x0004)
MAC_HIGH = Register(0x0008)
MAC_LOW = Register(0x000C)
IP_CONFIG_SUPPORTED = Register(0x0010)
IP_CONFIG_CURRENT = Register(0x0014)
CURRENT_IP = Register(0x0024)
CURRENT_SUBNET = Register(0x0034)
CURRENT_GATEWAY = Register(0x0044)
VENDOR_NAME = _text(0x0048, 32)
MODEL_NAME = _text(0x0068, 32)
DEVICE_VERSION = _text(0x0088, 32)
MANUFACTURER_INFO = _text(0x00A8, 48)
SERIAL_NUMBER = _text(0x00D8, 16)
USER_NAME = _text(0x00E8, 16, writable=True)
FIRST_URL = _text(0x0200, 512)
SECOND_URL = _text(0x0400, 512)
NETWORK_INTERFACES = Register(0x0600)
MESSAGE_CHANNELS = Register(0x0900)
STREAM_CHANNELS = Register(0x0904)
GVCP_CAPABILITY = Register(0x0934)
HEARTBEAT_TIMEOUT = _own(0x0938, _between(MIN_HEARTBEAT_MS, 600_000))
TICK_FREQUENCY_HIGH = Register(0x093C)
TICK_FREQUENCY_LOW = Register(0x0940)
TIMESTAMP_CONTROL = _own(0x0944, _one_of(0, TIMESTAMP_LATCH))
TIMESTAMP_HIGH = Register(0x0948)
TIMESTAMP_LOW = Register(0x094C)
CONTROL_PRIVILEGE = _own(0x0A00, _one_of(0, 1, 2, 3))
STREAM_PORT = _own(0x0D00, _between(0, 0xFFFF))
STREAM_PACKET_SIZE = _own(0x0D04, frames_layout=True)
STREAM_PACKET_DELAY = _own(0x0D08, _between(0, 10_000_000))
STREAM_ADDRESS = _own(0x0D18)
STREAM_SOURCE_PORT = Register(0x0D1C)

WIDTH_MAX = Register(0xA000)
HEIGHT_MAX = Register(0xA004)
WIDTH = _own(0xA008, frames_layout=True)
HEIGHT = _own(0xA00C, frames_layout=True)
OFFSET_X = _own(0xA010, frames_layout=True)
OFFSET_Y = _own(0xA014, frames_layout=True)
PIXEL_FORMAT = _own(0xA018, _one_of(MONO8), frames_layout=True)
PAYLOAD_SIZE = Register(0xA01C)
ACQUISITION_MODE = _own(0xA100, _one_of(*AcquisitionMode))
ACQUISITION_FRAME_COUNT = _own(0xA104, _between(1, 65_535))
ACQUISITION_START = _own(0xA108, _boolean)
ACQUISITION_STOP = _own(0xA10C, _boolean)
FRAME_RATE_ENABLE = _own(0xA110, _boolean)
FRAME_RATE = _real(0xA118, _between(MIN_FRAME_RATE_HZ, MAX_FRAME_RATE_HZ))
TRIGGER_SELECTOR = _own(0xA120, _one_of(0))
TRIGGER_MODE = _own(0xA124, _boolean)
TRIGGER_SOURCE = _own(0xA128, _one_of(*TriggerSource))
TRIGGER_ACTIVATION = _own(0xA12C, _one_of(0, 1))
TRIGGER_SOFTWARE = _own(0xA130, _boolean)
EXPOSURE_MODE = _own(0xA134, _one_of(0))
EXPOSURE_TIME = _real(0xA138, _between(MIN_EXPOSURE_US, MAX_EXPOSURE_US))
GAIN = _real(0xA140, _between(0.0, MAX_GAIN_DB))
BLACK_LEVEL = _real(0xA148, _between(0.0, MAX_BLACK_LEVEL))
TRIGGER_DELAY = _real(0xA150, _between(0.0, MAX_TRIGGER_DELAY_US))
LINE_DEBOUNCER = _real(0xA158, _between(0.0, MAX_DEBOUNCE_US))
LINE_SELECTOR = _own(0xA160, _one_of(0))
USER_OUTPUT_SELECTOR = _own(0xA164, _one_of(0))
USER_OUTPUT = _own(0xA168, _boolean)
DEVICE_TEMPERATURE = Register(0xA170, Kind.FLOAT64, 8)
TL_PARAMS_LOCKED = _own(0xA200, _boolean)

REGISTERS: tuple[Register, ...] = tuple(
    value for value in dict(vars()).values() if isinstance(value, Register)
)
COMMANDS = frozenset({ACQUISITION_START, ACQUISITION_STOP, TRIGGER_SOFTWARE, TIMESTAMP_CONTROL})
"""Writing one does something; it reads 0 again at once: done."""
