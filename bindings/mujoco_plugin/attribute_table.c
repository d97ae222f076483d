#include "mujoco_plugin/attribute_table.h"

#include "crazyflie.h"

#define CONFIG(member_) offsetof(cf_config_t, member_)

#define COUNT(name_, member_, highest_, doc_) \
  {.name   = name_,                           \
   .doc    = doc_,                            \
   .kind   = KIND_COUNT,                      \
   .offset = CONFIG(member_),                 \
   .low    = 0,                               \
   .high   = highest_}

#define NUMBER(name_, member_, lowest_, highest_, doc_) \
  {.name   = name_,                                     \
   .doc    = doc_,                                      \
   .kind   = KIND_NUMBER,                               \
   .offset = CONFIG(member_),                           \
   .low    = lowest_,                                   \
   .high   = highest_}

#define VECTOR(name_, member_, count_, highest_, doc_) \
  {.name   = name_,                                    \
   .doc    = doc_,                                     \
   .kind   = KIND_VECTOR,                              \
   .offset = CONFIG(member_),                          \
   .low    = -highest_,                                \
   .high   = highest_,                                 \
   .count  = count_}

// What goes wrong with single readings of a positioning system.
#define MISHAP(name_, member_, highest_, unit_)                                          \
  NUMBER(name_ "_dropout", member_.dropout, 0, 1, "probability that a reading is lost"), \
      NUMBER(name_ "_outlier", member_.outlier, 0, 1, "probability that it is far off"), \
      NUMBER(name_ "_outlier_size", member_.outlier_size, 0, highest_,                   \
             "how far off: a quarter of this to all of it [" unit_ "]")

// Times in which something is wrong.
#define SPELL(name_, member_, what_)                                        \
  NUMBER(name_ "_rate", member_.rate, 0, 100, "how often " what_ " [1/s]"), \
      NUMBER(name_ "_time", member_.time, 0, 100, "for how long, on average [s]")

// The same, and what it does to a pose.
#define SHIFT(name_, member_, what_)                                                         \
  SPELL(name_, member_.spell, what_),                                                        \
      NUMBER(name_ "_size", member_.size, 0, 10, "by how far the position is then off [m]"), \
      NUMBER(name_ "_angle", member_.angle, 0, 3.2, "by how much the attitude is off [rad]")

#define ANCHOR(i_) VECTOR("anchor" #i_, vehicle.loco.anchors[i_], 3, 1000, "loco: x y z [m]")

static const attribute_t ATTRIBUTES[] = {
    {.name    = "platform",
     .doc     = "airframe; chooses the defaults of everything else",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(platform),
     .words   = {"cf2", "cf21bl"},
     .numbers = {CF_PLATFORM_CF2, CF_PLATFORM_CF21BL}},
    {.name   = "vehicle",
     .doc    = "parameters of the vehicle that differ from the platform's, such as trim.torque",
     .kind   = KIND_PARAMETERS,
     .offset = CONFIG(vehicle)},
    {.name   = "provider",
     .doc    = "implementation of the onboard algorithms",
     .kind   = KIND_PROVIDER,
     .offset = CONFIG(provider)},
    {.name    = "controller",
     .doc     = "controller at boot",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(controller),
     .words   = {"auto", "pid", "mellinger", "indi", "brescianini", "lee", "out_of_tree"},
     .numbers = {ControllerTypeAutoSelect, ControllerTypePID, ControllerTypeMellinger,
                 ControllerTypeINDI, ControllerTypeBrescianini, ControllerTypeLee,
                 ControllerTypeOot}},
    {.name    = "estimator",
     .doc     = "state estimator at boot; auto: kalman, without positioning complementary",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(estimator),
     .words   = {"auto", "complementary", "kalman", "out_of_tree"},
     .numbers = {StateEstimatorTypeAutoSelect, StateEstimatorTypeComplementary,
                 StateEstimatorTypeKalman, StateEstimatorTypeOutOfTree}},
    {.name    = "positioning",
     .doc     = "what tells the drone where it is",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(vehicle.positioning),
     .words   = {"none", "mocap", "flow", "mocap_position", "lighthouse", "loco_twr", "loco_tdoa2",
                 "loco_tdoa3"},
     .numbers = {CF_POSITIONING_NONE, CF_POSITIONING_MOCAP, CF_POSITIONING_FLOW,
                 CF_POSITIONING_MOCAP_POSITION, CF_POSITIONING_LIGHTHOUSE, CF_POSITIONING_LOCO_TWR,
                 CF_POSITIONING_LOCO_TDOA2, CF_POSITIONING_LOCO_TDOA3}},
    COUNT("seed", seed, 4294967295.0, "of all noise; drones with equal seeds differ by their id"),
    COUNT("id", id, 4294967295.0, "number of the drone; default: its place in the model"),
    COUNT("radio_id", radio_id, 255,
          "low byte of the radio address; 0: counts from 1 as ids do from 0"),
    NUMBER("battery", vehicle.airframe.battery.initial_charge, 0, 1,
           "state of charge at the start, 1 = full"),
    NUMBER("supply_voltage", vehicle.airframe.battery.constant_voltage, 0, 20,
           "constant supply in place of a battery [V]; 0 = battery"),
    NUMBER("noise", vehicle.airframe.imu.noise_scale, 0, 100,
           "factor on the noise of the inertial sensors; 0 = ideal"),
    NUMBER("bias", vehicle.airframe.imu.bias_scale, 0, 10,
           "factor on the turn-on errors of the inertial sensors; 0 = ideal"),
    {.name    = "mocap_quality",
     .doc     = "how good the motion capture is; chooses the defaults of the mocap_ attributes",
     .kind    = KIND_QUALITY,
     .offset  = CONFIG(vehicle.mocap_quality),
     .words   = {"good", "typical", "poor"},
     .numbers = {CF_MOCAP_GOOD, CF_MOCAP_TYPICAL, CF_MOCAP_POOR}},
    COUNT("mocap_rate", vehicle.mocap.rate, 1000, "poses per second [Hz]; 0 = off"),
    COUNT("mocap_latency_ms", vehicle.mocap.latency_ms, 1000, "age of a pose on arrival [ms]"),
    NUMBER("mocap_noise", vehicle.mocap.position_noise, 0, 1,
           "standard deviation of a position [m]"),
    NUMBER("mocap_attitude_noise", vehicle.mocap.attitude_noise, 0, 1,
           "standard deviation of an attitude [rad]"),
    NUMBER("mocap_std", vehicle.mocap.position_std, 1e-6, 100,
           "deviation that the client tells the filter, locSrv.extPosStdDev [m]"),
    NUMBER("mocap_attitude_std", vehicle.mocap.attitude_std, 1e-6, 100,
           "the same of an attitude, locSrv.extQuatStdDev [rad]"),
    MISHAP("mocap", vehicle.mocap.mishap, 100, "m"),
    SPELL("mocap_gap", vehicle.mocap.gap, "the drone is out of sight"),
    SHIFT("mocap_jump", vehicle.mocap.jump, "a marker is hidden"),
    SHIFT("mocap_swap", vehicle.mocap.swap, "markers are confused"),
    SPELL("mocap_busy", vehicle.mocap.busy, "the radio is busy"),
    COUNT("mocap_busy_ms", vehicle.mocap.busy_ms, 1000,
          "poses are then later, by up to so much [ms]"),
    NUMBER("baro_noise", vehicle.barometer.noise_scale, 0, 100,
           "factor on noise and drift of the barometer; 0 = ideal"),
    NUMBER("altitude", vehicle.barometer.altitude, 0, 9000,
           "of the floor above sea level, for the barometer [m]"),
    NUMBER("range_noise", vehicle.flow_deck.range_noise_scale, 0, 100,
           "factor on the noise of ranges by flow deck, z-ranger and multi-ranger; 0 = ideal"),
    MISHAP("range", vehicle.flow_deck.range_mishap, 10, "m"),
    NUMBER("flow_noise", vehicle.flow_deck.flow_noise, 0, 100,
           "flow deck: standard deviation of the flow [counts]"),
    MISHAP("flow", vehicle.flow_deck.flow_mishap, 1000, "counts"),
    {.name    = "multiranger",
     .doc     = "deck that measures ranges to the front, back, left, right and up",
     .kind    = KIND_SWITCH,
     .offset  = CONFIG(vehicle.rangers.has_multiranger),
     .words   = {"off", "on"},
     .numbers = {0, 1}},
    {.name    = "zranger",
     .doc     = "deck that measures the range down; the flow deck carries one anyway",
     .kind    = KIND_SWITCH,
     .offset  = CONFIG(vehicle.rangers.has_zranger),
     .words   = {"off", "on"},
     .numbers = {0, 1}},
    VECTOR("base_station1", vehicle.lighthouse.stations[0], 6, 1000,
           "lighthouse: x y z, and x y z of what it looks at [m]"),
    VECTOR("base_station2", vehicle.lighthouse.stations[1], 6, 1000, "the other one"),
    COUNT("lighthouse_rate", vehicle.lighthouse.rate, 100, "turns of the rotors [Hz]; 0 = off"),
    NUMBER("lighthouse_noise", vehicle.lighthouse.noise, 0, 1,
           "standard deviation of a sweep angle [rad]"),
    NUMBER("lighthouse_calibration_error", vehicle.lighthouse.calibration_error, 0, 0.1,
           "standard deviation of what the calibration misses [rad]"),
    NUMBER("lighthouse_position_error", vehicle.lighthouse.position_error, 0, 10,
           "standard deviation of the error in the geometry, per axis [m]"),
    NUMBER("lighthouse_attitude_error", vehicle.lighthouse.attitude_error, 0, 1,
           "the same of the attitude [rad]"),
    MISHAP("lighthouse", vehicle.lighthouse.mishap, 3, "rad"),
    ANCHOR(0),
    ANCHOR(1),
    ANCHOR(2),
    ANCHOR(3),
    ANCHOR(4),
    ANCHOR(5),
    ANCHOR(6),
    ANCHOR(7),
    COUNT("twr_rate", vehicle.loco.twr_rate, 1000, "loco: ranges per second [Hz]; 0 = off"),
    COUNT("tdoa_rate", vehicle.loco.tdoa_rate, 1000,
          "loco: packets per second of all anchors [Hz]; 0 = off"),
    NUMBER("loco_noise", vehicle.loco.noise, 0, 100, "standard deviation of one arrival [m]"),
    NUMBER("loco_bias", vehicle.loco.bias, 0, 100,
           "standard deviation of the constant error of an anchor [m]"),
    MISHAP("loco", vehicle.loco.mishap, 100, "m"),
    {.name    = "loco_2d",
     .doc     = "the loco driver keeps the height in place of estimating it",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(loco_is_planar),
     .words   = {"off", "on"},
     .numbers = {0, 1}},
    NUMBER("loco_height", loco_height, 0, 100, "then: the height [m]"),
    {.name    = "isolated",
     .doc     = "the drone and others pass through, feel and see nothing of each other",
     .kind    = KIND_SWITCH,
     .offset  = CONFIG(is_isolated),
     .words   = {"off", "on"},
     .numbers = {0, 1}},
    {.name    = "drag",
     .doc     = "form of the rotor drag",
     .kind    = KIND_CHOICE,
     .offset  = CONFIG(vehicle.airframe.aerodynamics.form),
     .words   = {"none", "linear", "rotor"},
     .numbers = {CF_DRAG_NONE, CF_DRAG_LINEAR, CF_DRAG_ROTORS}},
    {.name    = "flight_moment",
     .doc     = "the moment that lifts the leading edge in forward flight",
     .kind    = KIND_SWITCH,
     .offset  = CONFIG(vehicle.airframe.aerodynamics.has_flight_moment),
     .words   = {"off", "on"},
     .numbers = {0, 1}},
    NUMBER("body_drag", vehicle.airframe.aerodynamics.body_drag, 0, 1,
           "quadratic drag of the body [N s^2/m^2]"),
    {.name   = "motor_time_constant",
     .doc    = "first-order lag of the rotor speed, up and down [s]",
     .kind   = KIND_NUMBER,
     .offset = CONFIG(vehicle.airframe.rotors.time_constant_up),
     .low    = 0.001,
     .high   = 1,
     .count  = 2},
    {.name = "motor_ctrl",
     .doc  = "class of the Python plugin that flies the drone in a World; see motor_ctrl.md",
     .kind = KIND_REMARK},
    {.name = "motor_ctrl_properties",
     .doc  = "what that class is told: words of the form key=value",
     .kind = KIND_REMARK},
};

#define COUNT_OF_ATTRIBUTES (int)(sizeof ATTRIBUTES / sizeof ATTRIBUTES[0])

const attribute_t *cf_attribute(int i) {
  return i >= 0 && i < COUNT_OF_ATTRIBUTES ? &ATTRIBUTES[i] : NULL;
}
