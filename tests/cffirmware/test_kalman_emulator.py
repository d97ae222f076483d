"""The filter as upstream's replay tools drive it (docs/reference/cffirmware-api.md#10.12, #10.13 and #13)."""

import math

import numpy as np
import pytest

ANCHORS = [(x, y, z) for z in (0, 3) for y in (0, 4) for x in (0, 4)]
TAG = (2.0, 2.0, 1.0)


class Emulator:
    """The filter's task: 1 kHz, prediction every 10 ms."""

    def __init__(self, firm, anchors, start_ms, std_dev):
        self.firm, self.anchors, self.std_dev = firm, anchors, std_dev
        self.now = start_ms
        self.next_prediction = start_ms + 10
        self.acc, self.gyro = firm.Axis3fSubSampler_t(), firm.Axis3fSubSampler_t()
        firm.axis3fSubSamplerInit(self.acc, 9.81)
        firm.axis3fSubSamplerInit(self.gyro, math.pi / 180)
        self.params, self.core = firm.kalmanCoreParams_t(), firm.kalmanCoreData_t()
        firm.kalmanCoreDefaultParams(self.params)
        self.filter = firm.OutlierFilterTdoaState_t()
        firm.outlierFilterTdoaReset(self.filter)
        firm.kalmanCoreInit(self.core, self.params, self.now)

    def step(self, samples):
        firm = self.firm
        if self.now > self.next_prediction:
            acc, gyro = firm.axis3fSubSamplerFinalize(self.acc), firm.axis3fSubSamplerFinalize(self.gyro)
            firm.kalmanCorePredict(self.core, self.params, acc, gyro, self.now, True)
            self.next_prediction += 10
        firm.kalmanCoreAddProcessNoise(self.core, self.params, self.now)
        while samples:
            time, kind, value = samples.pop(0)
            if time > self.now:
                break  # lost, as in upstream's tool
            self.fuse(kind, value)
        firm.kalmanCoreFinalize(self.core)
        self.now += 1
        state = firm.state_t()
        firm.kalmanCoreExternalizeState(self.core, state, firm.Axis3f())
        return state

    def fuse(self, kind, value):
        firm = self.firm
        if kind == "tdoa":
            firm.kalmanCoreUpdateWithTdoa(
                self.core, tdoa(firm, self.anchors, self.std_dev, *value), self.now, self.filter
            )
            return
        sample = firm.Axis3f()
        sample.x, sample.y, sample.z = value
        firm.axis3fSubSamplerAccumulate(self.acc if kind == "acc" else self.gyro, sample)


def tdoa(firm, anchors, std_dev, a, b, difference):
    made = firm.tdoaMeasurement_t()
    for member, anchor in (("anchorPositionA", anchors[a]), ("anchorPositionB", anchors[b])):
        position = firm.vec3_s()
        position.x, position.y, position.z = anchor
        setattr(made, member, position)
    made.anchorIdA, made.anchorIdB = a, b
    made.distanceDiff = difference
    made.stdDev = std_dev
    return made


def replay_samples(milliseconds):
    samples = []
    for now in range(milliseconds):
        samples += [(now, "acc", (0.0, 0.0, 1.0)), (now, "gyro", (0.0, 0.0, 0.0))]
        if now % 10 == 0:
            a = now // 10 % 8
            b = (a + 1) % 8
            samples.append((now, "tdoa", (a, b, math.dist(TAG, ANCHORS[b]) - math.dist(TAG, ANCHORS[a]))))
    return samples


def test_replay_of_tdoa_finds_the_tag(firm):
    samples = replay_samples(5000)
    emulator = Emulator(firm, ANCHORS, 0, 0.15)
    path = []
    while samples:
        state = emulator.step(samples)
        path.append((state.position.x, state.position.y, state.position.z))
    assert len(path) > 4000
    assert math.dist(path[-1], TAG) < 0.5


def start(firm):
    params, core = firm.kalmanCoreParams_t(), firm.kalmanCoreData_t()
    firm.kalmanCoreDefaultParams(params)
    firm.kalmanCoreInit(core, params, 0)
    return core


def position(firm, core):
    state = firm.state_t()
    firm.kalmanCoreExternalizeState(core, state, firm.Axis3f())
    return state.position.x, state.position.y, state.position.z


@pytest.fixture
def with_halves(firm):
    if not hasattr(firm, "kalmanCoreTdoaInnovation"):
        pytest.skip("this release has no halves of a TDoA update")
    return firm


def test_innovation_of_tdoa(with_halves):
    firm = with_halves
    core = start(firm)
    sample = tdoa(firm, [(1, 0, 0), (-1, 0, 0)], 0.15, 0, 1, 0.25)
    assert firm.kalmanCoreTdoaInnovation(core, sample) == pytest.approx(0.25, abs=1e-6)
    before = position(firm, core)
    firm.kalmanCoreUpdateWithTdoaUnfiltered(core, sample)
    assert position(firm, core) != before


def test_innovation_at_an_anchor_is_none(with_halves):
    firm = with_halves
    core = start(firm)
    sample = tdoa(firm, [(0, 0, 0), (2, 0, 0)], 0.15, 0, 1, 0.5)
    assert math.isnan(firm.kalmanCoreTdoaInnovation(core, sample))
    before = position(firm, core)
    firm.kalmanCoreUpdateWithTdoaUnfiltered(core, sample)
    assert position(firm, core) == before


def test_scalar_update_takes_a_sequence(firm):
    core = start(firm)
    firm.kalmanCoreScalarUpdate(core, [1.0] + [0.0] * 8, 1.0, 0.1)
    expected = core.P[0][0]
    assert position(firm, core)[0] == pytest.approx(1.0, abs=0.02)
    assert expected == pytest.approx(0.01, rel=0.01)
    with pytest.raises(ValueError, match="Hm has 8 numbers, 9 are needed"):
        firm.kalmanCoreScalarUpdate(core, [0.0] * 8, 1.0, 0.1)


def test_covariance_written_from_python_counts(firm):
    core = start(firm)
    firm.kalmanCoreScalarUpdate(core, [0.0] * 8 + [1.0], 0.0, 0.1)
    firm.kalmanCoreFinalize(core)
    core.P[0, 1] = 50.0  # only one half: the filter makes it symmetric again
    params = firm.kalmanCoreParams_t()
    firm.kalmanCoreDefaultParams(params)
    firm.kalmanCoreAddProcessNoise(core, params, 1)
    assert np.array_equal(core.P, core.P.T)
    assert core.P[0, 1] == 25.0


def test_prediction_without_parameters_uses_those_of_init(firm):
    acc, gyro = firm.Axis3f(), firm.Axis3f()
    acc.z = 9.81
    params = firm.kalmanCoreParams_t()
    firm.kalmanCoreDefaultParams(params)
    new, old = firm.kalmanCoreData_t(), firm.kalmanCoreData_t()
    for core in (new, old):
        firm.kalmanCoreInit(core, params, 0)
    firm.kalmanCorePredict(new, params, acc, gyro, 10, False)
    firm.kalmanCorePredict(old, acc, gyro, 10, False)
    assert np.array_equal(new.P, old.P)
    assert np.array_equal(new.S, old.S)
