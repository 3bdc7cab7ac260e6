"""MCAP: one message a sample in JSON on the topic /samples, facts as metadata records."""

import io
import json

from mcap.writer import Writer

from daq.exporting.exported import Exported

TOPIC = "/samples"


def encode(exported: Exported) -> bytes:
    """Return the log; times are ns since the first sample, a reading that was lost is null."""
    recording = exported.recording
    numbers = {"type": ["number", "null"]}
    schema = {
        "type": "object",
        "properties": {"time": {"type": "number", "description": "s"}}
        | {
            name: numbers | {"description": channel.unit}
            for channel, name in zip(recording.channels, exported.names, strict=True)
        },
    }
    content = io.BytesIO()
    writer = Writer(content)
    writer.start(profile="", library="free-decay-station")
    kind = writer.register_schema("free_decay.Sample", "jsonschema", json.dumps(schema).encode())
    topic = writer.register_channel(TOPIC, "json", kind)
    columns = [row.tolist() for row in exported.samples]
    for i, time in enumerate(exported.time.tolist()):
        values = {n: None if c[i] != c[i] else c[i] for n, c in zip(exported.names, columns, strict=True)}
        stamp = round(i * 1e9 / recording.rate)
        data = json.dumps({"time": time, **values}).encode()
        writer.add_message(topic, log_time=stamp, publish_time=stamp, data=data, sequence=i)
    writer.add_metadata("recording", exported.all_facts)
    for channel, name in zip(recording.channels, exported.names, strict=True):
        writer.add_metadata(name, exported.channel_facts(channel))
    writer.finish()
    return content.getvalue()
