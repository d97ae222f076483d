"""Programs that fly one drone each, as the per-drone plugins of a simulator do: `MotorCtrl` and its family."""

from crazychoir_fw.simulation.motor_ctrl.commands import MotorCtrlFPQR, MotorCtrlFRPY, MotorCtrlVel, MotorCtrlXYZ
from crazychoir_fw.simulation.motor_ctrl.motor_ctrl import MotorCtrl

__all__ = ["MotorCtrl", "MotorCtrlFPQR", "MotorCtrlFRPY", "MotorCtrlVel", "MotorCtrlXYZ"]
