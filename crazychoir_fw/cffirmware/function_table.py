"""Every C function of the module: parameters and meaning.

The types are those of the provider's declarations. ``p[8]`` is an array of 8 numbers that C reads, ``p[8]&`` one that
it writes, too; lengths may be computed from other parameters. Meters, seconds, radians and float32, unless said
otherwise.
"""

import re
from typing import NamedTuple


class Parameter(NamedTuple):
    """One parameter of a C function."""

    name: str
    length: str | None
    """How many numbers an array has, as an expression of other parameters; None: it is no array."""
    is_written: bool


class Function(NamedTuple):
    """A C function."""

    name: str
    parameters: tuple[Parameter, ...]
    meaning: str


_TABLE = """
fsqr(x) x squared.
radians(degrees) Degrees to radians.
degrees(radians) Radians to degrees.
clamp(value, min, max) The value, limited to [min, max].
fcloseulps(a, b, ulps) Whether a and b are at most so many floats apart.
normalize_radians(radians) The angle wrapped to [-pi, pi].
shortest_signed_angle_radians(start, goal) The turn from start to goal the short way round.

mkvec(x, y, z) A vector of three numbers.
vrepeat(x) A vector of three equal numbers.
vzero() The zero vector.
vbasis(i) The unit vector of axis 0, 1 or 2.
vscl(s, v) s times v.
vneg(v) Minus v.
vdiv(v, s) v times 1/s.
vadd(a, b) a + b.
vsub(a, b) a - b.
vadd3(a, b, c) (a + b) + c.
vadd4(a, b, c, d) (a + b) + (c + d).
vsub2(a, b, c) (a - b) - c.
vdot(a, b) Inner product.
vcross(a, b) Cross product.
vmag2(v) Squared length.
vmag(v) Length.
vdist2(a, b) Squared distance.
vdist(a, b) Distance.
vnormalize(v) v divided by its length; NaN for the zero vector.
vclampnorm(v, maxnorm) v, shortened to a length of at most maxnorm.
vprojectunit(a, b_unit) The part of a along a unit vector.
vorthunit(a, b_unit) The part of a orthogonal to a unit vector.
veltmul(a, b) Element by element: a times b.
veltdiv(a, b) Element by element: a divided by b.
veltrecip(a) Element by element: 1 divided by a.
vabs(v) Element by element: absolute value.
vmin(a, b) Element by element: the smaller one.
vmax(a, b) Element by element: the larger one.
vclamp(v, lower, upper) Element by element: limited to [lower, upper].
vclampabs(v, abs_upper) Element by element: limited to [-abs_upper, abs_upper].
vmaxelt(v) Largest element.
vminelt(v) Smallest element.
vnorm1(v) Sum of the absolute values.
veq(a, b) Whether all elements are equal.
vneq(a, b) Whether some elements differ.
veqepsilon(a, b, epsilon) Whether all elements differ by less than epsilon.
vless(a, b) Whether a < b in all elements.
vleq(a, b) Whether a <= b in all elements.
vgreater(a, b) Whether a > b in all elements.
vgeq(a, b) Whether a >= b in all elements.
visnan(v) Whether an element is not a number.
vload(d[3]) A vector from three doubles.
vstore(v, d[3]&) Writes a vector to three doubles.
vloadf(f[3]) A vector from three floats.
vstoref(v, f[3]&) Writes a vector to three floats.
vindex(v, i) Element i.

mzero() The zero matrix.
mdiag(a, b, c) A diagonal matrix.
meyescl(a) a times the identity.
meye() The identity.
mcolumns(a, b, c) A matrix from its columns.
mrows(a, b, c) A matrix from its rows.
mcrossmat(v) The matrix whose product with x is v cross x.
mcolumn(m, col) A column as a vector.
mrow(m, row) A row as a vector.
mtranspose(m) The transpose.
mscl(s, m) s times m.
mneg(m) Minus m.
madd(a, b) a + b.
msub(a, b) a - b.
madd3(a, b, c) (a + b) + c.
mvmul(m, v) Matrix times vector.
mmul(a, b) Matrix product.
maddridge(m, d) m + d times the identity.
misnan(m) Whether an element is not a number.
set_block33_rowmaj(block[2 * stride + 3]&, stride, m) Writes m into a larger matrix with rows of length stride.
maxisangle(axis_unit, angle) Rotation about a unit axis.
mrotx(angle) Rotation about x.
mroty(angle) Rotation about y.
mrotz(angle) Rotation about z.

mkquat(x, y, z, w) A quaternion, scalar last.
quatvw(v, w) A quaternion from its vector part and its scalar.
qeye() The identity.
qaxisangle(axis, angle) Rotation about an axis.
qvectovec(a, b) The smallest rotation that turns unit vector a into b.
rpy2quat(rpy) From roll, pitch and yaw, all right-handed.
rpy2quat_small(rpy) The same to first order.
mat2quat(m) From a rotation matrix.
quat2rpy(q) Roll, pitch and yaw, all right-handed.
quat2axis(q) Axis of the rotation.
quat2angle(q) Angle of the rotation.
quatimagpart(q) Vector part.
quat2rotmat(q) Rotation matrix.
qvrot(q, v) v, rotated by q.
qqmul(q, p) The rotation that turns by p first, then by q.
qinv(q) The inverse of a unit quaternion.
qneg(q) Minus q, the same rotation.
qposreal(q) The one of q and -q with a positive scalar.
qdot(a, b) Inner product.
qanglebetween(a, b) Angle between two rotations.
qeq(a, b) Whether all elements are equal.
qnormalize(q) q divided by its length.
quat_gyro_update(q, gyro, dt) q, turned by body rates [rad/s] for dt [s], to first order.
qnlerp(a, b, t) From a (t = 0) to b (t = 1) along the normalized straight line.
qslerp(a, b, t) From a (t = 0) to b (t = 1) at constant speed.
qload(d[4]) A quaternion from four doubles x, y, z, w.
qstore(q, d[4]&) Writes a quaternion to four doubles.
qloadf(f[4]) A quaternion from four floats x, y, z, w.
qstoref(q, f[4]&) Writes a quaternion to four floats.

vprojecthalfspace(x, a_unit, b) The closest point with a_unit . point <= b.
vinpolytope(v, A[3 * n], b[n], n, tolerance) Whether A v <= b, but for the tolerance.
rayintersectpolytope(origin, direction, A[3 * n], b[n], n, active_row[1]&) How many directions lead from the origin \
to the border of A x <= b; active_row (or None) is told the row that is hit.
vprojectpolytope(v, A[3 * n], b[n], work[3 * n]&, n, tolerance, maxiters) Nearly the closest point with A x <= b; \
work is scratch memory, or None.

polyval(p[8], t) The polynomial with coefficients p, ascending, at t.
polylinear(p[8]&, duration, x0, x1) Makes p a straight line from x0 to x1.
polybezier(p[8]&, duration, x[dim], dim) Makes p the Bezier curve with dim control points.
poly5(p[8]&, T, x0, dx0, ddx0, xf, dxf, ddxf) Makes p the quintic with these values and derivatives at 0 and T.
polyscale(p[8]&, s) Multiplies p by s.
polyder(p[8]&) Makes p its derivative.
polystretchtime(p[8]&, s) Makes p take s times as long.
polyreflect(p[8]&) Makes p(t) p(-t).
poly4d_zero(duration) A piece that stays at zero.
poly4d_linear(duration, p0, p1, yaw0, yaw1) A piece along a straight line.
poly4d_scale(p, x, y, z, yaw) Multiplies the four polynomials.
poly4d_shift(p, x, y, z, yaw) Adds to the four polynomials.
poly4d_shift_vec(p, pos, yaw) Adds to the four polynomials.
poly4d_stretchtime(p, s) Makes the piece take s times as long.
polyder4d(p) Makes the four polynomials their derivatives.
poly4d_max_accel_approx(p) Roughly the largest acceleration [m/s^2].
poly4d_eval(p, t) Position, derivatives, body rates and yaw at t.
traj_eval_zero() At rest in the origin.
traj_eval_invalid() No evaluation: all NaN.
is_traj_eval_valid(ev) Whether an evaluation is one.
piecewise_duration(pp) Sum of the durations times the time scale.
piecewise_plan_5th_order(pp, duration, p0, y0, v0, dy0, a0, p1, y1, v1, dy1, a1) Makes piece 0 all of the \
trajectory: of degree 5, between two states of position, yaw, velocity, yaw rate and acceleration.
piecewise_plan_7th_order_no_jerk(pp, duration, p0, y0, v0, dy0, a0, p1, y1, v1, dy1, a1) The same of degree 7, \
without jerk at both ends.
piecewise_eval(traj, t) The trajectory at t, counted as t_begin is.
piecewise_eval_reversed(traj, t) The trajectory flown backwards.
piecewise_is_finished(traj, t) Whether t is behind the end.
piecewise_compressed_eval(traj, t) The compressed trajectory at t.
piecewise_compressed_duration(traj) Duration of a compressed trajectory.
piecewise_compressed_is_finished(traj, t) Whether t is behind the end of a compressed trajectory.

plan_init(p) Starts idle, without a plan.
plan_stop(p) Becomes idle: motors off.
plan_is_stopped(p) Whether idle.
plan_disable(p) Gives up control.
plan_is_disabled(p) Whether control was given up.
plan_is_finished(p, t) Whether t is behind the end of the plan.
plan_current_goal(p, t) The goal at t; invalid while stopped or disabled.
plan_takeoff(p, curr_pos, curr_yaw, hover_height, hover_yaw, duration, t) Plans a rise from rest; 1 unless idle.
plan_land(p, curr_pos, curr_yaw, hover_height, hover_yaw, duration, t) Plans a landing from rest; 1 while landing.
plan_go_to(p, relative, linear, hover_pos, hover_yaw, duration, t) Plans a flight from the present goal to a \
position and yaw, smooth or at constant speed.
plan_go_to_from(p, curr_eval, relative, linear, hover_pos, hover_yaw, duration, t) Plans a flight from curr_eval.
plan_spiral(p, sideways, clockwise, spiral_angle, radius0, radiusF, ascent, duration, t) Plans a spiral from the \
present goal.
plan_spiral_from(p, curr_eval, sideways, clockwise, spiral_angle, radius0, radiusF, ascent, duration, t) Plans a \
spiral from curr_eval.
plan_start_trajectory(p, trajectory, reversed, relative, relative_yaw, start_from, start_yaw) Follows a trajectory, \
which says when it begins.
plan_start_compressed_trajectory(p, trajectory, relative, start_from) Follows a compressed trajectory.

controllerPidInit() Initializes the one PID controller. A second call leaves attitude and rate loops as they are.
controllerPidTest() Whether it is initialized.
controllerPid(control, setpoint, sensors, state, stabilizerStep) Runs the PID controller at a step of the 1 kHz \
loop: position every 10th, attitude every 2nd.
controllerMellingerInit(self) Writes default gains, and forgets.
controllerMellingerTest(self) True.
controllerMellinger(self, control, setpoint, sensors, state, stabilizerStep) Runs the controller at a step of the 1 \
kHz loop, every 2nd.
controllerBrescianiniInit() Selects the one controller of Brescianini.
controllerBrescianiniTest() True.
controllerBrescianini(control, setpoint, sensors, state, stabilizerStep) Runs the controller at a step of the 1 kHz \
loop, position and attitude every 10th.
controllerLeeInit(self) Writes default gains, and forgets.
controllerLeeReset(self) Forgets both integrals.
controllerLee(self, control, setpoint, sensors, state, stabilizerStep) Runs the controller at a step of the 1 kHz \
loop, every 2nd.

powerDistributionInit() Does nothing on a quadrotor.
powerDistributionTest() True.
powerDistribution(control, motorThrustUncapped) Mixes the output of a controller into four thrusts [counts].
powerDistributionCap(motorThrustUncapped, motorPwm) Fits four thrusts into 16 bits; returns whether that took \
something away.
powerDistributionMotorType(id) 1: every motor drives a rotor.
powerDistributionStopRatio(id) 0: the duty that stops a motor.
powerDistributionGetIdleThrust() Lowest duty of a running motor [counts].
powerDistributionGetMaxThrust() Largest thrust of all motors together [N].

collisionAvoidanceUpdateSetpointCore(params, collisionState, nOthers, otherPositions[3 * nOthers], workspace[7 * \
(nOthers + 6)]&, setpoint, sensorData, state) Bends a setpoint away from nOthers drones at x, y, z, x, ...; \
workspace is scratch memory, or None.

axis3fSubSamplerInit(s, conversionFactor) Starts empty.
axis3fSubSamplerAccumulate(s, sample) Adds one sample.
axis3fSubSamplerFinalize(s) The converted mean since the latest call, a view into s.
outlierFilterTdoaReset(s) Starts open and empty.
outlierFilterTdoaValidateIntegrator(s, tdoa, error, nowMs) Whether to use a sample with this innovation [m].

kalmanCoreDefaultParams(params) Writes the default parameters.
kalmanCoreInit(core, params, nowMs) Starts the filter at the initial position and yaw of the parameters.
kalmanCorePredict(core, params, acc, gyro, nowMs, quadIsFlying) Advances to nowMs with mean acc [m/s^2] and gyro \
[rad/s].
kalmanCoreAddProcessNoise(core, params, nowMs) Adds the noise of the time since the latest call.
kalmanCoreFinalize(core) Moves the attitude error into the attitude; whether there was anything to do.
kalmanCoreExternalizeState(core, state, acc) Writes the estimate; acc is the latest sample [g].
kalmanCoreDecoupleXY(core) Forgets x, y and their velocities.
kalmanCoreScalarUpdate(core, Hm[9], error, stdMeasNoise) Fuses one number: measured minus predicted, and its \
derivative Hm.
kalmanCoreUpdateWithPKE(core, Hm[9], Km[9], P_w_m[81], error) Ends a robust update.
kalmanCoreUpdateWithBaro(core, params, baroAsl, quadIsFlying) Fuses a height above sea level.
kalmanCoreUpdateWithTdoa(core, tdoa, nowMs, outlierFilterState) Fuses a difference of distances.
kalmanCoreTdoaInnovation(core, tdoa) Measured minus predicted; NaN at an anchor.
kalmanCoreUpdateWithTdoaUnfiltered(core, tdoa) Fuses a difference of distances, whatever it is.
kalmanCoreUpdateWithPosition(core, xyz) Fuses a position.
kalmanCoreUpdateWithPose(core, pose) Fuses a pose.
kalmanCoreUpdateWithDistance(core, d) Fuses a distance to an anchor.
kalmanCoreUpdateWithTof(core, tof) Fuses a distance to the floor.
kalmanCoreUpdateWithFlow(core, flow, gyro) Fuses optical flow; gyro is the latest sample [deg/s].
kalmanCoreUpdateWithAbsoluteHeight(core, height) Fuses a height.
kalmanCoreUpdateWithYawError(core, error) Fuses a yaw error.

lpf2pInit(lpfData, sample_freq, cutoff_freq) Starts a second-order low-pass for two frequencies [Hz].
lpf2pSetCutoffFreq(lpfData, sample_freq, cutoff_freq) The same.
lpf2pApply(lpfData, sample) Filters one sample.
lpf2pReset(lpfData, sample) Sets the memory as if the sample had been there for ever.
"""

_EXTRA_TEXT = """
normalize_radians shortest_signed_angle_radians piecewise_compressed_eval piecewise_compressed_duration
piecewise_compressed_is_finished kalmanCoreTdoaInnovation kalmanCoreUpdateWithTdoaUnfiltered
kalmanCoreUpdateWithPosition kalmanCoreUpdateWithPose kalmanCoreUpdateWithDistance kalmanCoreUpdateWithTof
kalmanCoreUpdateWithFlow kalmanCoreUpdateWithAbsoluteHeight kalmanCoreUpdateWithYawError lpf2pInit
lpf2pSetCutoffFreq lpf2pApply lpf2pReset
"""
EXTRA = frozenset(_EXTRA_TEXT.split())
"""Functions that upstream's module does not have, or not in every release."""

_LINE = re.compile(r"(\w+)\(((?:[^()]|\([^()]*\))*)\) (.+)")
_PARAMETER = re.compile(r"(\w+)(?:\[(.+)\](&)?)?")


def _parameter(text: str) -> Parameter:
    name, length, written = _PARAMETER.fullmatch(text.strip()).groups()  # type: ignore[union-attr]
    return Parameter(name, length, written is not None)


def _function(line: str) -> Function:
    name, parameters, meaning = _LINE.fullmatch(line).groups()  # type: ignore[union-attr]
    return Function(name, tuple(map(_parameter, parameters.split(","))) if parameters else (), meaning)


FUNCTIONS = tuple(_function(line) for line in _TABLE.splitlines() if line)
