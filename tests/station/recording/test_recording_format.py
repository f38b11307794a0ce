"""A recording as others see it: opened with `mcap` and `protobuf` alone, with none of our code."""

import json

import numpy as np
from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from mcap.reader import NonSeekingReader, make_reader
from recording_samples import CALIBRATION, START_NS, make_recording

from calib import CameraModel
from station.recording import CameraNumbers, RecordingWriter


def test_plain_mcap_reader_gives_every_picture_back(tmp_path, rng):
    pictures = make_recording(tmp_path / "a.mcap", rng)
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        found = list(reader.iter_messages(topics="/left/image"))
        assert reader.get_summary().statistics.message_count == len(pictures) + 1
    for number, (pixels, (schema, channel, message)) in enumerate(
        zip(pictures, found, strict=True), 1
    ):
        image = RawImage.FromString(message.data)
        assert (schema.name, schema.encoding) == ("foxglove.RawImage", "protobuf")
        assert channel.message_encoding == "protobuf"
        assert message.sequence == number
        assert image.timestamp.ToNanoseconds() == message.publish_time
        assert message.log_time == message.publish_time + 5_000_000
        assert (image.encoding, image.frame_id, image.step) == ("mono8", "left", image.width)
        assert image.data == pixels.tobytes()


def test_sequential_reader_believes_all_checksums(tmp_path, rng):
    pictures = make_recording(tmp_path / "a.mcap", rng)
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = NonSeekingReader(file, validate_crcs=True)
        assert len(list(reader.iter_messages(log_time_order=False))) == len(pictures) + 1


def test_schema_in_the_file_decodes_the_pictures(tmp_path, rng):
    pictures = make_recording(tmp_path / "a.mcap", rng, count=1)
    with (tmp_path / "a.mcap").open("rb") as file:
        schema, _, message = next(make_reader(file).iter_messages(topics="/left/image"))
    pool = descriptor_pool.DescriptorPool()
    for description in FileDescriptorSet.FromString(schema.data).file:
        pool.Add(description)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))
    assert kind.FromString(message.data).data == pictures[0].tobytes()


def test_events_are_json_of_a_schema(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng, count=1)
    with (tmp_path / "a.mcap").open("rb") as file:
        schema, channel, message = next(make_reader(file).iter_messages(topics="/left/events"))
    assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
    event = json.loads(message.data)
    assert set(event) == set(json.loads(schema.data)["required"])
    assert (event["kind"], event["detail"], message.log_time) == ("started", "a pass", START_NS)


def test_metadata_and_calibration_are_found_by_name(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng, count=1)
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file)
        (attachment,) = reader.iter_attachments()
        (metadata,) = reader.iter_metadata()
    assert (attachment.name, attachment.media_type) == ("calibration.json", "application/json")
    assert attachment.data == CALIBRATION
    assert metadata.metadata["exposure_us"] == "250.0"


def test_camera_model_is_a_foxglove_calibration(tmp_path):
    parameters = np.array([2315.8, 2312.4, 1004.9, 555.3, -0.1267, 0.1204, 1e-4, 2e-4, 0.0])
    camera = CameraModel.from_parameters(parameters, width=2048, height=1088)
    with RecordingWriter(tmp_path / "a.mcap") as writer:
        writer.write_calibration("left", CameraNumbers(2048, 1088, *parameters.tolist()))
    with (tmp_path / "a.mcap").open("rb") as file:
        _, _, message = next(make_reader(file).iter_messages(topics="/left/calibration"))
    found = CameraCalibration.FromString(message.data)
    assert (found.frame_id, found.width, found.height) == ("left", 2048, 1088)
    np.testing.assert_array_equal(np.reshape(found.K, (3, 3)), camera.matrix)
    np.testing.assert_array_equal(found.D, camera.distortion)


def test_no_picture_shares_a_chunk_with_anything(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng)
    with (tmp_path / "a.mcap").open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert len(chunks) == 6
    assert all(chunk.compression == "" for chunk in chunks)
