"""The wait for subscribers before the first block, with a made-up publisher and clock."""

from __future__ import annotations

from dataclasses import dataclass

from dcrb_ros.messages.topics import SENSOR, VIBRATION, Topic
from dcrb_ros.nodes.subscriber_wait import SETTLING_TIME, SubscriberWait


@dataclass
class Publisher:
    count: int = 0
    acknowledged: bool = True

    def subscribers(self, topic: Topic) -> int:
        assert topic is VIBRATION
        return self.count

    def delivered(self, topic: Topic) -> bool:
        assert topic is SENSOR
        return self.acknowledged


@dataclass
class Clock:
    time: float = 100.0

    def __call__(self) -> float:
        return self.time


def made(listeners: int, timeout: float = 30.0) -> tuple[SubscriberWait, Publisher, Clock]:
    publisher, clock = Publisher(), Clock()
    return SubscriberWait(publisher, listeners, timeout, clock), publisher, clock


def test_it_ends_when_enough_subscribers_have_joined_and_settled() -> None:
    wait, publisher, clock = made(2)
    for count in (0, 1, 2):
        publisher.count = count
        clock.time += SETTLING_TIME
        assert not wait.over()
    clock.time += 0.5 * SETTLING_TIME
    assert not wait.over()
    clock.time += 0.5 * SETTLING_TIME
    assert wait.over()
    assert wait.missing == ""


def test_another_subscriber_prolongs_it() -> None:
    wait, publisher, clock = made(1)
    publisher.count = 1
    assert not wait.over()
    publisher.count = 2
    clock.time += SETTLING_TIME
    assert not wait.over()
    clock.time += SETTLING_TIME
    assert wait.over()


def test_it_lasts_until_the_subscribers_know_the_publisher() -> None:
    wait, publisher, clock = made(1)
    publisher.count, publisher.acknowledged = 1, False
    wait.over()
    clock.time += 10.0 * SETTLING_TIME
    assert not wait.over()
    publisher.acknowledged = True
    assert wait.over()


def test_it_is_given_up_after_its_longest_time_and_says_so() -> None:
    wait, publisher, clock = made(3, 5.0)
    publisher.count = 1
    assert not wait.over()
    clock.time += 4.9
    assert not wait.over()
    clock.time += 0.1
    assert wait.over()
    assert wait.missing.startswith("1 of 3 subscribers to outer_ring/vibration have joined within 5 s")
