"""PARAM_* and LOG_* of compiled code are parameters and log variables of the drone."""

import pytest

from crazychoir_fw._core import lib

OOT = lib.ControllerTypeOot
READ_VARIABLES, PRINT = 11, 12


@pytest.fixture
def drone(app):
    drone = app.drone()
    assert app.controller_init(drone.block, OOT) == lib.CF_OK
    return drone


def rows(copy, kind, group):
    return {name: (number, flags) for found, name, number, flags, _ in copy.variables(kind) if found == group}


def test_parameters_with_types_and_flags(app):
    assert rows(app, "parameters", "testApp") == {
        "mode": (lib.CF_TYPE_UINT8, 0),
        "refuse": (lib.CF_TYPE_UINT8, 0),
        "selected": (lib.CF_TYPE_UINT32, lib.CF_CORE | lib.CF_READ_ONLY),
    }
    # neither a constant nor 64 bits are a parameter of a drone
    assert rows(app, "parameters", "counters") == {
        "gain": (lib.CF_TYPE_FLOAT, lib.CF_CORE | lib.CF_PERSISTENT),
        "odd": (lib.CF_TYPE_INT8, 0),
        "something_else": (lib.CF_TYPE_UINT32, lib.CF_CORE),  # expanded, as on the vehicle
    }


def test_logs_with_types_and_flags(app):
    # half precision is a form to read in; debug variables are there unless the configuration names them
    assert rows(app, "logs", "counters") == {
        "calls": (lib.CF_TYPE_UINT32, 0),
        "ccm": (lib.CF_TYPE_UINT32, lib.CF_CORE),
        "computed": (lib.CF_TYPE_FLOAT, lib.CF_CORE),
        "byte": (lib.CF_TYPE_INT8, 0),
        "gainChanges": (lib.CF_TYPE_UINT32, 0),
        "a_macro": (lib.CF_TYPE_FLOAT, lib.CF_CORE),
        "debug": (lib.CF_TYPE_FLOAT, 0),
    }


@pytest.mark.parametrize("kind", ["parameters", "logs"])
def test_names_are_unique_and_those_of_the_provider_are_all_there(app, plain_library, open_library, kind):
    names = [row[:2] for row in app.variables(kind)]
    assert len(set(names)) == len(names)
    builtin = open_library(plain_library).variables(kind)
    assert [row[:4] for row in app.variables(kind)[: len(builtin)]] == [row[:4] for row in builtin]


def test_offsets_lead_to_the_values(app, fly, drone):
    assert app.get(drone, "parameters", "counters.gain") == 0.5
    assert app.get(drone, "parameters", "counters.odd") == 5
    assert app.get(drone, "parameters", "pid_rate.roll_kp") == 250.0
    assert app.get(drone, "parameters", "testApp.selected") == 1
    for _ in range(3):
        fly(app, drone)
    assert app.get(drone, "logs", "counters.calls") == 3
    assert app.get(drone, "logs", "counters.ccm") == 6
    assert app.get(drone, "parameters", "counters.odd") == 8


def test_written_parameters_act(app, fly, drone):
    other = app.drone()
    app.controller_init(other.block, OOT)
    app.set(drone, "counters.gain", 100.0)
    assert fly(app, drone)[1] == 106.25
    assert fly(app, other)[1] == 6.75


def test_callbacks_are_run(app, drone):
    assert app.get(drone, "logs", "counters.gainChanges") == 0
    app.set(drone, "counters.gain", 2.0)
    app.set(drone, "counters.odd", 2)
    app.set(drone, "pid_rate.roll_kp", 2.0)
    assert app.get(drone, "logs", "counters.gainChanges") == 1


def test_computed_logs_are_refreshed(app, fly, drone):
    app.kalman_init(drone.block, 1234)
    for _ in range(3):
        fly(app, drone)
    assert app.get(drone, "logs", "counters.computed") == 0.0
    app.refresh_logs(drone.block)
    assert app.get(drone, "logs", "counters.computed") == 0.5 * 10 + 1234
    assert app.get(drone, "logs", "counters.byte") == -3


def test_a_library_without_macros_has_the_tables_of_the_provider_alone(open_library, plain_library, host):
    copy = open_library(plain_library)
    tables = host.ffi.new("cf_variables_t[]", lib.CF_PROVIDER_MAX_TABLES)
    assert len(copy.tables("parameters")) == host.builtin.parameters(tables, len(tables))
    assert len(copy.tables("logs")) == host.builtin.logs(tables, len(tables))


def test_more_tables_than_room_are_counted_and_not_written(app, host):
    tables = host.ffi.new("cf_variables_t[]", 3)
    assert app.parameters(tables, 2) == len(app.tables("parameters"))
    assert tables[2].count == 0 and tables[1].count > 0


# --------------------------------------------------------------------------------- variables by id


def test_code_reads_and_writes_variables_of_its_drone(app, fly, drone):
    fly(app, drone)
    app.kalman_init(drone.block, 1000)
    app.set(drone, "testApp.mode", READ_VARIABLES)
    drone.host.height, drone.host.selector = 1.5, 3
    # height; 0.5 * 10 + 1000, computed at that moment; roll_kp; selector
    assert fly(app, drone) == (1.5, 1005.0, 250.0, 3.0)
    assert app.host.failures == 0
    assert app.get(drone, "parameters", "counters.gain") == 0.75
    assert app.get(drone, "logs", "counters.gainChanges") == 1
    assert app.get(drone, "parameters", "pid_rate.roll_kp") == 123.0
    assert drone.host.selector == 5


def test_ids_stay_good_in_another_copy_and_for_another_drone(open_library, app_library, fly):
    one, other = open_library(app_library), open_library(app_library)
    drones = [one.drone() for _ in range(2)]
    for n, drone in enumerate(drones):
        one.controller_init(drone.block, OOT)
        one.set(drone, "testApp.mode", READ_VARIABLES)
        drone.host.height = n + 0.5
        fly(one, drone)
        drone.host.height += 10
    assert [fly(other, drone)[0] for drone in drones] == [10.5, 11.5]


# ----------------------------------------------------------------------------------------- services


def test_console_and_time(app, fly, drone):
    app.set(drone, "testApp.mode", PRINT)
    app.kalman_add_process_noise(drone.block, 4321)
    fly(app, drone, step=7)
    assert app.host.console == "TESTAPP: step 7 at 4321 ms, 4321000 us\n"
    assert app.host.drone == drone.block


def test_every_drone_has_its_own_time(app, fly, drone):
    other = app.drone()
    app.controller_init(other.block, OOT)
    for now, each in ((10, drone), (20, other)):
        app.set(each, "testApp.mode", PRINT)
        app.kalman_add_process_noise(each.block, now)
    fly(app, drone)
    fly(app, other)
    assert "at 10 ms" in app.host.console.splitlines()[0] and "at 20 ms" in app.host.console.splitlines()[1]
