"""Short names for the states of the supervisor."""

from crazychoir_fw._core import lib

BOOT = lib.supervisorStateNotInitialized
NOT_PASSED = lib.supervisorStatePreFlChecksNotPassed
PASSED = lib.supervisorStatePreFlChecksPassed
READY = lib.supervisorStateReadyToFly
FLYING = lib.supervisorStateFlying
LANDED = lib.supervisorStateLanded
RESET = lib.supervisorStateReset
WARNING = lib.supervisorStateWarningLevelOut
FREE_FALL = lib.supervisorStateExceptFreeFall
LOCKED = lib.supervisorStateLocked
CRASHED = lib.supervisorStateCrashed
