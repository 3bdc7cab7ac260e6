"""`station ports`: where a board may be."""

import click

from station.output import json_option, print_json, screen


@click.command("ports")
@json_option
def command(as_json: bool) -> None:
    """List the serial ports of this computer on which a board may be.

    A board on the network is named as socket://HOST:PORT.
    """
    from daq.ports import list_ports

    found = list_ports()
    if as_json:
        print_json({"ports": [{"name": p.name, "description": p.description} for p in found]})
        return
    if not found:
        screen().print("no serial port found; is the board plugged in?", markup=False)
    for port in found:
        screen().print(f"{port.name}  {port.description}", markup=False)
