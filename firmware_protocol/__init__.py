"""The wire shared with the board's firmware: bytes to messages and back, with no port, thread or clock."""

from firmware_protocol.decoder import Decoder as Decoder, Statistics as Statistics
from firmware_protocol.frame import Frame as Frame, encode as encode
from firmware_protocol.layout import TYPE_OF as TYPE_OF
from firmware_protocol.messages import (
    NO_CHANNEL as NO_CHANNEL,
    NO_SAMPLE as NO_SAMPLE,
    PROTOCOL_MAJOR as PROTOCOL_MAJOR,
    PROTOCOL_MINOR as PROTOCOL_MINOR,
    Ack as Ack,
    ChannelDescription as ChannelDescription,
    Clock as Clock,
    Config as Config,
    Data as Data,
    Describe as Describe,
    End as End,
    Event as Event,
    EventKind as EventKind,
    Heartbeat as Heartbeat,
    Hello as Hello,
    HelloRequest as HelloRequest,
    Hold as Hold,
    Holder as Holder,
    HolderReason as HolderReason,
    HolderState as HolderState,
    Log as Log,
    Message as Message,
    Nack as Nack,
    NackCode as NackCode,
    OtherVersion as OtherVersion,
    Release as Release,
    Resend as Resend,
    ResetCause as ResetCause,
    SampleFormat as SampleFormat,
    Start as Start,
    Stop as Stop,
    TimeSync as TimeSync,
)
