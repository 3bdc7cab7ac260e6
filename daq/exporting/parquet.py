"""Parquet: one column a channel, units and calibration in each field's metadata, facts in the table's."""

import pyarrow as pa
import pyarrow.parquet as pq

from daq.exporting.exported import Exported


def encode(exported: Exported) -> bytes:
    """Return the file: time, one column a channel, valid."""
    fields = [pa.field("time", pa.float64(), metadata={"unit": "s"})]
    fields += [
        pa.field(name, pa.float64(), metadata=exported.channel_facts(channel))
        for channel, name in zip(exported.recording.channels, exported.names, strict=True)
    ]
    fields.append(pa.field("valid", pa.bool_()))
    table = pa.table(
        [exported.time, *exported.samples, exported.recording.valid],
        schema=pa.schema(fields, metadata=exported.all_facts),
    )
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    return bytes(sink.getvalue().to_pybytes())
