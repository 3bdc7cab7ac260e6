"""HDF5: one data set a channel with its unit and calibration as attributes, facts as attributes of the file."""

import io

import h5py

from daq.exporting.exported import Exported


def encode(exported: Exported) -> bytes:
    """Return the file: time, one data set a channel with time as its scale, valid."""
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file.attrs.update(exported.all_facts)
        time = file.create_dataset("time", data=exported.time)
        time.attrs["unit"] = "s"
        time.make_scale("time")
        file.create_dataset("valid", data=exported.recording.valid)
        for channel, name, values in zip(
            exported.recording.channels, exported.names, exported.samples, strict=True
        ):
            column = file.create_dataset(name, data=values)
            column.attrs.update(exported.channel_facts(channel))
            column.dims[0].attach_scale(time)
    return content.getvalue()
