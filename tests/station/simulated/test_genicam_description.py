"""The GenICam description tells clients of the registers there are, with their rules.

That a client can read it is shown where Aravis does.
"""

from importlib import resources
from xml.etree import ElementTree

import pytest

from station.simulated import registers as reg

SPACE = "{http://www.genicam.org/GenApi/Version_1_1}"
REGISTER_NODES = ("IntReg", "MaskedIntReg", "FloatReg", "StringReg")
ROOT = ElementTree.fromstring(
    resources.files("station.simulated").joinpath("genicam.xml").read_bytes()
)
NODES = {node.get("Name"): node for node in ROOT if node.get("Name")}


def text(node, tag):
    found = node.find(SPACE + tag)
    return None if found is None else found.text


def register_nodes():
    for tag in REGISTER_NODES:
        yield from ROOT.iter(SPACE + tag)


def test_every_register_described_exists_with_that_length_and_access():
    known = {register.address: register for register in reg.REGISTERS}
    for node in register_nodes():
        register = known[int(text(node, "Address"), 16)]
        length = int(text(node, "Length"))
        pair = known.get(register.address + 4)
        whole = register.length if length == register.length else register.length + pair.length
        assert length == whole, node.get("Name")
        assert (text(node, "AccessMode") == "RW") == register.writable, node.get("Name")


def test_every_feature_register_is_described():
    described = {int(text(node, "Address"), 16) for node in register_nodes()}
    own = {register.address for register in reg.REGISTERS if register.address >= 0xA000}
    assert own <= described


def test_every_name_referred_to_exists():
    for element in ROOT.iter():
        tag = element.tag.removeprefix(SPACE)
        if tag.startswith("p") and tag != "pPort":
            assert element.text in NODES, element.text


@pytest.mark.parametrize(
    "name", ["AcquisitionFrameRate", "ExposureTime", "Gain", "GevHeartbeatTimeout"]
)
def test_the_bounds_told_are_those_kept(name):
    node = NODES[name]
    low, high = float(text(node, "Min")), float(text(node, "Max"))
    address = int(text(NODES[text(node, "pValue")], "Address"), 16)
    allows = next(r.allows for r in reg.REGISTERS if r.address == address)
    assert allows(low)
    assert allows(high)
    assert not allows(low - 0.01)
    assert not allows(high + 0.01)


def test_every_choice_told_is_taken_and_no_other():
    for node in ROOT.iter(SPACE + "Enumeration"):
        values = {int(text(entry, "Value")) for entry in node.iter(SPACE + "EnumEntry")}
        address = int(text(NODES[text(node, "pValue")], "Address"), 16)
        allows = next(r.allows for r in reg.REGISTERS if r.address == address)
        assert all(allows(value) for value in values)
        assert not allows(max(values) + 1)


def test_no_two_registers_overlap():
    taken = set()
    for register in reg.REGISTERS:
        places = set(range(register.address, register.address + register.length))
        assert not places & taken
        taken |= places
