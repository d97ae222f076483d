"""What agents send survives the way, and nothing else is read."""

import contextlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from msgspec.msgpack import Ext, decode, encode

from crazychoir_fw.common.errors import MessageError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance.frozen import SharedPose, frozen, handed_out
from crazychoir_fw.guidance.serialization import DEEPEST, DTYPES, LARGEST_BYTES, dumps, loads

DTYPE = st.sampled_from(sorted(DTYPES)).map(np.dtype)
ARRAYS = arrays.arrays(DTYPE, arrays.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=4))
VECTORS = st.none() | arrays.arrays(np.float64, st.sampled_from([(3,), (4,), (2, 3)]))
POSES = st.builds(Pose, VECTORS, VECTORS, VECTORS, VECTORS, st.none() | st.floats())
KEYS = (
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats(allow_nan=False) | st.text() | st.binary()
)
LEAVES = KEYS | st.floats() | ARRAYS | POSES
THINGS = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner, max_size=4) | st.lists(inner, max_size=4).map(tuple) | st.dictionaries(KEYS, inner, max_size=4)
    ),
    max_leaves=12,
)


def same(a, b):
    """Equal in value and type, NaN and sign of zero included."""
    if isinstance(a, Pose):
        return isinstance(b, Pose) and all(same(vars(a)[name], vars(b)[name]) for name in vars(a))
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return list(a) == list(b) and all(map(same, a.values(), b.values())) and all(map(same, a, b))
    return a == b or (a != a and b != b)


@given(THINGS)
def test_what_is_sent_arrives(thing):
    assert same(thing, loads(dumps(thing)))


@given(THINGS)
def test_without_bytes_the_same_arrives(thing):
    assert same(thing, handed_out(frozen(thing)))


@given(st.binary(max_size=200))
def test_random_bytes_are_read_or_refused(data):
    with contextlib.suppress(MessageError):
        loads(data)


@given(THINGS, st.data())
def test_damaged_messages_are_read_or_refused(thing, data):
    message = bytearray(dumps(thing))
    for _ in range(data.draw(st.integers(1, 4))):
        message[data.draw(st.integers(0, len(message) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(MessageError):
        loads(bytes(message))


@given(st.integers(0, 127), st.binary(max_size=60))
def test_extensions_of_any_kind_are_read_or_refused(code, body):
    with contextlib.suppress(MessageError):
        loads(encode(Ext(code, body)))


@pytest.mark.parametrize(
    "thing",
    [
        object(),
        {1, 2},
        1 + 2j,
        2**64,
        "\ud800",
        np.array([1 + 2j]),
        np.array(["text"]),
        np.array([object()]),
        {(1, 2): 3},
        [lambda: None],
        np.zeros((1,) * 9),
    ],
    ids=lambda thing: type(thing).__name__,
)
def test_what_may_not_be_sent_is_refused(thing):
    with pytest.raises(MessageError):
        dumps(thing)


@pytest.mark.parametrize("thing", [object(), {1, 2}, {(1, 2): 3}, [np.array([1j])]])
def test_without_bytes_the_same_is_refused(thing):
    with pytest.raises(MessageError):
        frozen(thing)


def nested(depth, make):
    thing = 1
    for _ in range(depth):
        thing = make(thing)
    return thing


@pytest.mark.parametrize("make", [lambda x: [x], lambda x: (x,), lambda x: {0: x}], ids=["list", "tuple", "dict"])
def test_depth_has_a_limit(make):
    deepest = nested(DEEPEST, make)
    assert same(deepest, loads(dumps(deepest)))
    assert same(deepest, frozen(deepest))
    for pack in (dumps, frozen):
        with pytest.raises(MessageError, match="too deep"):
            pack(nested(DEEPEST + 1, make))
    with pytest.raises(MessageError):
        loads(b"\x91" * 5000 + b"\x00")


@pytest.mark.parametrize(
    "data",
    [
        b"\xdd\xff\xff\xff\xff",  # four billion items
        b"\xd6\xff\x00\x00\x00\x01",  # a time stamp
        b"\x81\xd6\xff\x00\x00\x00\x01\x01",  # as a key
        b"\x81\x91\x01\x01",  # a list as a key
        b"\x81\xd4\x03\x90\x01",  # a tuple as a key
        b"\xd4\x03\x01",  # a tuple that is a number
        b"\xa1\xff",  # no text
        b"\x01\x02",  # two messages
        b"",
    ],
    ids=bytes.hex,
)
def test_what_nothing_writes_is_refused(data):
    with pytest.raises(MessageError):
        loads(data)


def test_tuples_within_tuples_are_refused_before_the_stack_ends():
    heads = [b"\x91" + encode(Ext(3, encode([])))]
    size = len(heads[0])
    while size < LARGEST_BYTES - 20:
        kind = b"\xc7" if size < 1 << 8 else b"\xc8" if size < 1 << 16 else b"\xc9"  # bytes of the length: 1, 2, 4
        length = size.to_bytes({b"\xc7": 1, b"\xc8": 2, b"\xc9": 4}[kind], "big")
        heads.append(b"\x91" + kind + length + b"\x03")
        size += len(heads[-1])
    data = b"".join(reversed(heads))[1:]
    assert decode(data, ext_hook=lambda code, content: len(content)) > LARGEST_BYTES - 40
    with pytest.raises(MessageError):
        loads(data)


def test_size_has_a_limit():
    with pytest.raises(MessageError, match="allowed: 100"):
        dumps(bytes(200), 100)
    with pytest.raises(MessageError, match="allowed: 100"):
        loads(bytes(200), 100)
    with pytest.raises(MessageError):
        dumps(np.zeros(200_000))


def test_an_array_that_claims_more_than_it_has_is_refused():
    for shape in ([1 << 40], [1 << 20, 1 << 20], [-1], [True], "ab", [3]):
        body = encode(["float64", shape, bytes(16)])
        with pytest.raises(MessageError):
            loads(encode(Ext(1, body)))


def test_nobody_can_change_what_another_holds():
    position, items = np.zeros(3), [1, np.zeros(2)]
    pose, things = frozen(Pose(position=position)), frozen(items)
    position[0] = items[1][0] = 5.0
    items.append(2)
    assert pose.position[0] == 0.0 and len(things) == 2 and things[1][0] == 0.0
    assert isinstance(pose, SharedPose)
    with pytest.raises(ValueError):
        pose.position[0] = 1.0
    with pytest.raises(AttributeError):
        pose.position = np.ones(3)
    mine, yours = handed_out(things), handed_out(things)
    mine.append(3)
    assert len(yours) == 2


def test_numpy_scalars_arrive_as_python_numbers():
    assert [type(one) for one in loads(dumps([np.float64(1.5), np.int8(3), np.bool_(True)]))] == [float, int, bool]
