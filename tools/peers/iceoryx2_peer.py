"""iceoryx2: a slice of bytes in shared memory, with an event that wakes the listener, as its examples do.

Large buffers: 64 messages for the subscriber in place of 2, and a sender that waits instead of overwriting.
"""

from __future__ import annotations

import ctypes
from pathlib import Path

import iceoryx2
import numpy as np

from peers.protocol import Job, Listener, await_ready, main, pictures, ready


def _services(job: Job) -> tuple[iceoryx2.Node, iceoryx2.PortFactoryPublishSubscribe, iceoryx2.PortFactoryEvent]:
    iceoryx2.set_log_level(iceoryx2.LogLevel.Error)
    node = iceoryx2.NodeBuilder.new().create(iceoryx2.ServiceType.Ipc)
    name = iceoryx2.ServiceName.new(f"peer/{job.number}")
    pictures_of = node.service_builder(name).publish_subscribe(iceoryx2.Slice[ctypes.c_uint8])
    if job.large:
        pictures_of = pictures_of.subscriber_max_buffer_size(64).enable_safe_overflow(value=False)
    return node, pictures_of.open_or_create(), node.service_builder(name).event().open_or_create()


def hear(job: Job, folder: Path) -> None:
    """Listen; the array is a view of the shared memory while the sample is held."""
    listener = Listener(job, folder)
    _node, images, events = _services(job)
    subscriber, wake = images.subscriber_builder().create(), events.listener_builder().create()
    ready(folder)
    while not listener.is_late:
        wake.timed_wait(iceoryx2.Duration.from_millis(100))
        while (sample := subscriber.receive()) is not None:
            listener.take(np.frombuffer(sample.payload().as_memory_view(), np.uint8).reshape(job.shape))
            sample.delete()
    listener.finish()


def send(job: Job, folder: Path) -> None:
    """Copy each picture into a loaned sample, and send that."""
    _node, images, events = _services(job)
    builder = images.publisher_builder().initial_max_slice_len(job.n_bytes)
    if job.large:
        builder = builder.backpressure_strategy(iceoryx2.BackpressureStrategy.RetryUntilDelivered)
    publisher, notifier = builder.create(), events.notifier_builder().create()
    await_ready(folder)
    for pixels in pictures(job, folder):
        sample = publisher.loan_slice_uninit(job.n_bytes)
        ctypes.memmove(sample.payload_ptr, pixels.ctypes.data, job.n_bytes)
        sample.assume_init().send()
        notifier.notify()


if __name__ == "__main__":
    main(hear=hear, send=send)
