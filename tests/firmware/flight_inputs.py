"""What drones are asked in tests: inputs of controllers and estimators, trajectories."""

import numpy as np

from crazychoir_fw._core import ffi, lib

DISABLE, ABS, VELOCITY = lib.modeDisable, lib.modeAbs, lib.modeVelocity
UP = np.array([0.0, 0.0, 1.0])

START = ffi.new("cf_plan_start_t *", {"pos": (0.1, -0.2, 0.3), "vel": (0.1, 0.0, 0.0), "yaw": 0.4})
GOAL = ffi.new("struct vec *", (1.0, 0.5, 1.2))[0]

SWEEPS = {
    "sensor": ffi.new("vec3d *", (0.015, 0.0075, 0.0)),
    "origin": ffi.new("vec3d *", (-2.0, 1.0, 2.0)),
    "turn": ffi.new("mat3d *", ((1, 0, 0), (0, 1, 0), (0, 0, 1))),
    "calibration": ffi.new("lighthouseCalibrationSweep_t *", {"phase": 0.01, "tilt": -0.02, "gibmag": 0.003}),
}


def random_inputs(rng):
    """Return setpoint, sensors and estimate as they come in flight, and now and then as they should not."""

    def xyz(size):
        return dict(zip("xyz", rng.normal(0, size, 3).tolist(), strict=True))

    def rpy(size):
        return dict(zip(("roll", "pitch", "yaw"), rng.normal(0, size, 3).tolist(), strict=True))

    q = rng.normal(0, 1, 4) + np.array([0, 0, 0, 3])
    q = dict(zip("xyzw", (q / np.linalg.norm(q)).tolist(), strict=True))
    names = ("x", "y", "z", "roll", "pitch", "yaw", "quat")
    setpoint = {
        "mode": dict(zip(names, rng.choice([DISABLE, ABS, VELOCITY], 7).tolist(), strict=True)),
        "attitude": rpy(20),
        "attitudeRate": rpy(100),
        "attitudeQuaternion": q,
        "thrust": float(rng.choice([0, 500, 30000, 65535])),
        "position": xyz(1),
        "velocity": xyz(0.5),
        "acceleration": xyz(1),
        "jerk": xyz(1),
        "velocity_body": bool(rng.integers(2)),
    }
    estimate = {
        "attitude": rpy(20),
        "attitudeQuaternion": q,
        "position": xyz(1),
        "velocity": xyz(0.5),
        "acc": xyz(0.1),
    }
    sensors = {"gyro": {"axis": rng.normal(0, 50, 3).tolist()}, "acc": {"axis": rng.normal(0, 1, 3).tolist()}}
    return (
        ffi.new("setpoint_t *", setpoint),
        ffi.new("sensorData_t *", sensors),
        ffi.new("state_t *", estimate),
    )


def random_measurement(rng):
    """Return one measurement of any type, near a drone that hovers at (0, 0, 1)."""
    near = (UP + rng.normal(0, 0.02, 3)).tolist()
    anchors = [dict(zip("xyz", rng.uniform(-3, 3, 3).tolist(), strict=True)) for _ in range(2)]
    kinds = {
        lib.MeasurementTypeTDOA: {
            "tdoa": {"anchorPositions": anchors, "distanceDiff": rng.normal(0, 0.5), "stdDev": 0.15}
        },
        lib.MeasurementTypePosition: {"position": {"pos": near, "stdDev": 0.01}},
        lib.MeasurementTypePose: {
            "pose": {"pos": near, "quat": {"z": 0.05, "w": 0.99}, "stdDevPos": 0.01, "stdDevQuat": 0.0045}
        },
        lib.MeasurementTypeDistance: {
            "distance": {"pos": list(anchors[0].values()), "distance": rng.uniform(1, 4), "stdDev": 0.25}
        },
        lib.MeasurementTypeTOF: {"tof": {"distance": near[2], "stdDev": 0.01, "coneHalfAngle": 0.1309}},
        lib.MeasurementTypeAbsoluteHeight: {"height": {"height": near[2], "stdDev": 0.02}},
        lib.MeasurementTypeFlow: {
            "flow": {"dpixel": rng.normal(0, 5, 2).tolist(), "stdDevX": 2.0, "stdDevY": 2.0, "dt": 0.01}
        },
        lib.MeasurementTypeYawError: {"yawError": {"yawError": rng.normal(0, 0.02), "stdDev": 0.01}},
        lib.MeasurementTypeSweepAngle: {
            "sweepAngle": {
                "sensorPos": SWEEPS["sensor"],
                "rotorPos": SWEEPS["origin"],
                "rotorRot": SWEEPS["turn"],
                "rotorRotInv": SWEEPS["turn"],
                "t": 0.5236 * float(rng.choice([-1, 1])),
                "measuredSweepAngle": -0.4636 + rng.normal(0, 0.3),
                "stdDev": 0.0005,
                "calib": SWEEPS["calibration"],
                "calibrationMeasurementModel": ffi.addressof(lib, "lighthouseCalibrationMeasurementModelLh2"),
            }
        },
        lib.MeasurementTypeGyroscope: {"gyroscope": {"gyro": {"axis": near}}},
        lib.MeasurementTypeBarometer: {"barometer": {"baro": {"asl": 100.0}}},
    }
    kind = int(rng.choice(list(kinds)))
    return ffi.new("measurement_t *", {"type": kind, "data": kinds[kind]})


def pieces_of(rng, count):
    """Return the memory with `count` random pieces from 132 bytes on."""
    memory = ffi.new("uint8_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES)
    pieces = ffi.cast("float *", memory + 132)
    for i in range(count):
        values = rng.normal(0, 0.3, 33)
        values[32] = 0.7 + 0.1 * i
        for k, value in enumerate(values.tolist()):
            pieces[33 * i + k] = value
    return memory
