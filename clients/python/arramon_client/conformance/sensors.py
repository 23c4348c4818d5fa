"""Checks of sensors: an observation has the data of the run's sensors, and nothing else."""

import math

from arramon_client.conformance.assertions import expect, expect_equal
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import Target
from arramon_client.transport.images import ImageDecoder


@check("sensors.asked", runs=2)
def asked(target: Target) -> None:
    """An observation has data for exactly the run's sensors; `opened` has labels if there is a segmentation."""
    everything = ("rgb", "depth", "segmentation", "pose")
    offered = [name for name in everything if name in target.split.sensors]
    for names in ([], offered):
        with target.play(target.create(sensors=names), image_size=target.smallest()) as stream:
            opened, started, seen = stream.begin()
        found = [name for name in everything if seen.HasField(name)]  # type: ignore[arg-type]
        expect_equal("the list of sensors in the observation", found, names)
        expect(not started.HasField("oracle"), "the episode came with the oracle, which the run did not ask for")
        is_labelled = bool(opened.labels)
        expect_equal("whether `opened` has labels", is_labelled, "segmentation" in names)


@check("sensors.oracle", runs=1)
def oracle(target: Target) -> None:
    """With the sensor "oracle", an episode starts with its start pose and one target per turn."""
    target.need_sensor("oracle")
    with target.play(target.create(sensors=["oracle", "pose"])) as stream:
        _, started, seen = stream.begin()
    expect(started.HasField("oracle"), "the episode came without the oracle, which the run requested")
    expect_equal("the number of targets", len(started.oracle.targets), 2)
    start, pose = started.oracle.start, seen.pose
    is_same = math.dist((start.x, start.z, start.heading), (pose.x, pose.z, pose.heading)) < 1e-3
    expect(is_same, f"the oracle's start is {start.x:g}, {start.z:g}, and the first pose {pose.x:g}, {pose.z:g}")


@check("sensors.segmentation", runs=1)
def segmentation(target: Target) -> None:
    """Every pixel of a segmentation is an index into the stream's labels, each of which has a kind."""
    target.need_sensor("segmentation")
    run = target.create(sensors=["segmentation"])
    with target.play(run, image_size=target.smallest()) as stream:
        opened, _, seen = stream.begin()
    expect(all(label.kind for label in opened.labels), "a label has no kind, expected a word such as 'road'")
    most = int(ImageDecoder().segmentation(seen.segmentation).max())
    expect(
        most < len(opened.labels), f"a pixel has the number {most}, expected less than {len(opened.labels)}, the labels"
    )


CHECKS = (asked, oracle, segmentation)
