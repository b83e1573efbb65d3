"""NumPy test of the Python package: all kinds of arrays arrive with equal numbers, contiguous float32 without a copy.
Shapes with a matching size but a wrong meaning are refused.

python_arrays_test.py STREAM_DUMP
"""
import copy
import pickle
import sys

import numpy as np

import fire3dv
from fire3dv._numbers import Numbers
from stream_lines import StreamLines


def refused(call, text):
    try:
        call()
    except fire3dv.ArgumentError as error:
        assert text in str(error), error
        return
    raise AssertionError(f"nothing was raised, expected: {text}")


base = np.arange(24, dtype=np.float32).reshape(2, 3, 4)
read_only = base.copy()
read_only.setflags(write=False)
for taken_as_it_lies in (base, read_only, base.reshape(2, 12), base.reshape(24), memoryview(base)):
    numbers = Numbers(taken_as_it_lies, (3, 4), "poses")
    assert numbers.rows == 2 and numbers.address == np.asarray(taken_as_it_lies).ctypes.data, type(taken_as_it_lies)

wide = np.zeros((2, 4, 4), np.float32)
wide[:, :3] = base
square = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
square[:, :3] = base
arrays = [base, read_only, base.astype(np.float64), base.astype(np.int16), base.astype(">f4"), np.asfortranarray(base),
          wide[:, :3], np.repeat(base, 2, axis=0)[::2], base.tolist(), list(base), base.ravel(), memoryview(base),
          memoryview(np.asfortranarray(base)), square, square.tolist(), list(square), memoryview(square), square.astype(int),
          np.asfortranarray(square)]
lines = StreamLines(sys.argv[1], "tcp://127.0.0.1:0")
with fire3dv.Stream(lines.uri, "arrays") as stream:
    stream.describe(["a", "b"])
    while not stream.poll().renderers:
        pass
    epoch = stream.poll().epoch
    for i, array in enumerate(arrays):
        sequence = stream.publish(i, array)
        assert sequence == i + 1 == stream.sequence
        assert lines.frame(epoch, sequence)["poses"] == base.reshape(2, 12).tolist(), i
    stream.publish_some(8, np.arange(2), base)  # the first frame contains all nodes
    for indices in (np.array([1]), np.array([1], np.uint32), np.array([1], np.uint8), [1], [np.int64(1)]):
        sequence = stream.publish_some(9, indices, base[:1])
        assert lines.frame(epoch, sequence)["poses"][-1] == base[0].ravel().tolist()

    refused(lambda: stream.publish(0, np.zeros((3, 4, 4), np.float32)), "[0]: the last row of the 4x4 matrix is [0.0, 0.0")
    refused(lambda: stream.publish(0, square.transpose(0, 2, 1)), "is the matrix transposed?")
    refused(lambda: stream.publish(0, square.transpose(0, 2, 1).tolist()), "is the matrix transposed?")
    refused(lambda: stream.publish(0, square[:1]), "stream_from_body has 1 poses; describe() named 2 nodes")
    refused(lambda: stream.publish(0, np.zeros((4, 6, 2), np.float32)), "(4, 6, 2)")  # 48 numbers, as for four poses
    for scaled, text in ((2 * np.eye(4), "[0]: the last row"), (2 * np.eye(3, 4), "parent_from_camera scales axis X by 2"),
                         (np.eye(3, 4) * [1, 0, 1, 1], "scales axis Y by 0"), (base, "parent_from_camera has 2 poses"),
                         (np.full((3, 4), np.nan), "parent_from_camera[0] row 0 column 0 is NaN")):
        refused(lambda: stream.request_image(8, 8, fx=8, parent_from_camera=scaled), text)
    refused(lambda: stream.publish(0, np.zeros((2, 4, 3), np.float32)), "(2, 4, 3)")
    refused(lambda: stream.publish(0, np.zeros(23, np.float32)), "23 numbers")
    refused(lambda: stream.publish(0, np.zeros((2, 3, 4), np.complex64)), "complex64")
    refused(lambda: stream.publish(0, np.zeros((2, 3, 4), object)), "object")
    refused(lambda: stream.publish(0, np.full((2, 3, 4), 1e300)), "infinity")
    refused(lambda: stream.publish(0, ["poses"] * 24), "must hold numbers")
    refused(lambda: stream.publish(0, None), "must hold numbers")
    refused(lambda: stream.publish(1 << 70, base), "sim_time_ns")
    refused(lambda: stream.publish(0.5, base), "sim_time_ns is 0.5")
    refused(lambda: stream.publish_some(0, np.array([-1]), base[:1]), "node_indices")
    refused(lambda: stream.publish_some(0, np.array([0.5]), base[:1]), "node_indices")
    refused(lambda: stream.publish_some(0, [1 << 32], base[:1]), "node_indices")
    refused(lambda: stream.describe("ab"), "node_names is one str")
    refused(lambda: stream.describe([b"a"]), "node_names[0] is of type bytes")
    refused(lambda: stream.set_light("a", fire3dv.POINT, intensity="much"), "intensity")
    refused(lambda: stream.set_light("a", fire3dv.POINT, color_rgb=(1, 1)), "color_rgb has 2 numbers")
    refused(lambda: stream.add_node("a", asset_glb="glTF"), "asset_glb")
lines.end()
for call in (stream.poll, lambda: stream.publish(0, base), lambda: stream.describe([])):
    try:
        call()
        raise AssertionError("a closed stream was used")
    except fire3dv.StateError as error:
        assert "closed" in str(error) and error.code == fire3dv.ERROR_STATE
        for other in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
            assert (type(other), other.code, str(other)) == (type(error), error.code, str(error))
stream.close()  # close() is idempotent
print("ok")
